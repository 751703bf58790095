"""Opens files of any kind as coded events or as a table of steps; what a file holds counts, not its name."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar

from jointattn_mj.errors import SeriesError
from jointattn_mj.io.progress import count
from jointattn_mj.options import Real
from jointattn_mj.recordings.event_layout import EventLayout
from jointattn_mj.recordings.event_tables import read_event_table
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.formats import Format, datavyu, elan, event_layout, plain
from jointattn_mj.recordings.table_files import TableFile, TableOptions, arrow_file, open_table, read_bytes
from jointattn_mj.recordings.text_files import as_utf8
from jointattn_mj.recordings.times import TimeUnit

SUFFIXES = {
    ".csv", ".tsv", ".tab", ".txt", ".dat", ".eaf", ".opf", ".xlsx", ".xlsb", ".xls", ".ods", ".parquet", ".pq",
}  # fmt: skip
"""Files of a folder that are read."""


@dataclass(frozen=True, kw_only=True)
class SourceOptions(TableOptions):
    """What a file of coded interaction is, and how it is written."""

    format: Format = "auto"
    """What a file is: found from what it holds, a table with a row for every step, any table of events, or what a
    coding program writes."""
    rows_are_steps: bool = False
    """Take rows as steps although columns such as onset and offset look like a list of events."""
    recording: str | None = None
    """Column that tells independent recordings apart: no step leads from one into another. Without it each file is one
    recording, or as its coding program says."""
    missing_values: tuple[str, ...] = ()
    """Values that stand for none, such as . - -99, beside nothing, NA, NaN, null and the like."""
    time_unit: TimeUnit = "auto"
    """Unit of an event table's times that are plain numbers: as its header says, s, ms, or frames."""
    rate: Annotated[float, Real("(0, 1e6]")] | None = None
    """Frames a second, where times are frames or end in frames, such as 00:01:02:12."""
    tier_columns: tuple[str, ...] = ()
    """Columns of an event table that together name the tier, such as Subject Behavior; by default as is usual."""
    code_columns: tuple[str, ...] = ()
    """Columns of an event table that together are the code, such as Behavior; by default as is usual."""

    ADVANCED: ClassVar[Sequence[str]] = ("rows_are_steps", "time_unit", "rate", "tier_columns", "code_columns")

    @property
    def of_events(self) -> bool:
        """Whether files are said to be of events."""
        return self.format not in ("auto", "steps")

    @property
    def of_steps(self) -> bool:
        """Whether files are said to have a row for every step."""
        return self.format == "steps" or self.rows_are_steps


def files_of(path: Path) -> tuple[list[Path], list[str]]:
    """The file, or those of a folder that may be recordings, and which ones of the folder are left out.

    Raises:
        SeriesError: There is none.
    """
    try:
        if not path.is_dir():
            return [path], []
        inside = sorted(file for file in path.iterdir() if file.is_file() and not file.name.startswith((".", "~$")))
    except (OSError, ValueError) as error:
        raise SeriesError(f"cannot read {str(path)[:200]!r}: {getattr(error, 'strerror', None) or error}") from error
    files = [file for file in inside if file.suffix.lower() in SUFFIXES]
    others = [file.name for file in inside if file not in files]
    if not files:
        raise SeriesError(f"cannot read the folder {path}: it has no file that ends in {', '.join(sorted(SUFFIXES))}")
    more = ", ..." if len(others) > 3 else ""
    left_out = [
        f"{count(len(others), 'file')} of {path} left out, by their names no recordings: {', '.join(others[:3])}{more}"
    ]
    return files, left_out if others else []


def open_source(
    path: Path, options: SourceOptions, wanted: Sequence[str] | None, sampled: bool, about: Sequence[str] = ()
) -> Events | TableFile:
    """Open a file.

    Args:
        path: The file.
        options: How it is read.
        wanted: Columns or tiers that are asked for; None: all.
        sampled: Whether it is to be sampled to steps, so that it must be of events.
        about: Columns that say what each recording is, which a table of events may have.

    Returns:
        The events, or the table of steps.

    Raises:
        SeriesError: It cannot be read, or it is of events where steps are needed, or of steps where events are.
    """
    data = read_bytes(path)
    special = None
    if elan.is_elan(data):
        special = elan.read_elan(data, path, options.missing_values)
    else:
        spreadsheet = datavyu.spreadsheet(data, path) if data.startswith(b"PK\x03\x04") else data
        if spreadsheet is not None and datavyu.is_datavyu(spreadsheet):
            text = as_utf8(spreadsheet, path, options.encoding).decode()
            special = datavyu.read_datavyu(text, path, options.missing_values)
    if special is not None:
        if options.format in ("boris", "interact", "observer"):
            raise SeriesError(f"{path} is a file of ELAN or Datavyu; `format='{options.format}'` does not fit it")
        if options.of_steps:
            raise SeriesError(f"{path} is of events; it has no rows that could be steps")
        if options.recording is not None:
            raise SeriesError(f"{path} has no column {options.recording!r}: a file of its kind is one recording")
        return special

    def of_events(names: Sequence[str]) -> bool:
        return event_layout(names, options.format) is not None

    if wanted is not None and not sampled:
        table = open_table(data, path, options, set(wanted).issubset)
        if not options.of_steps and not set(wanted) <= set(table.header):
            events = open_table(data, path, options, of_events)
            table = events if of_events(events.header) or events.named_in is not None else table
    else:
        table = open_table(data, path, options, any if options.of_steps else of_events)
    return open_table_as(table, data, options, wanted, sampled, about)


def open_table_as(
    table: TableFile,
    data: bytes | None,
    options: SourceOptions,
    wanted: Sequence[str] | None,
    sampled: bool,
    about: Sequence[str] = (),
) -> Events | TableFile:
    """Take a table as events or as steps (see :func:`open_source`); ``data`` is the whole file, if there is one.

    Args:
        table: The file's header and rows.
        data: The whole file, if there is one.
        options: How the file is read.
        wanted: Variables that are asked for; None for all.
        sampled: Whether events are going to be sampled at steps.
        about: Columns that say what each recording is, which a table of events may have.
    """
    if options.of_steps:
        if sampled:
            raise SeriesError(f"{table.path} is said to have a row for every step; leave `step` out")
        return table
    not_codes = {options.recording, *about}
    layout = event_layout(["" if name in not_codes else name for name in table.header], options.format)
    named = wanted is not None and set(wanted) <= set(table.header)
    if layout is None and data is not None and not (options.columns or named):
        names = plain.names_without_header(table.head)
        if names is not None:
            table = open_table(data, table.path, replace(options, columns=tuple(names)))
            layout = event_layout(table.header)
    if layout is None:
        if sampled or options.of_events:
            raise SeriesError(
                f"{table.path} has no columns that say when events begin and end, such as onset and offset; its "
                f"columns are: {', '.join(table.header)[:200]}. Name them with `columns`, or, if rows are steps, leave "
                f"`step` and `format` out{table.hint}"
            )
        return table
    if wanted is not None and not sampled:
        raise SeriesError(_no_steps(table, layout))
    return read_event_table(
        table,
        _as_told(layout, table, options),
        table.path.stem,
        options.time_unit,
        options.rate,
        options.missing_values,
        {name: table.locations([name])[0] for name in about if name in table.header},
    )


def open_frame(
    frame: Any, options: SourceOptions, wanted: Sequence[str] | None, sampled: bool, about: Sequence[str] = ()
) -> Events | TableFile:
    """Open a table of pandas, polars or pyarrow (see :func:`open_source`).

    Args:
        frame: The table.
        options: How it is read.
        wanted: Variables that are asked for; None for all.
        sampled: Whether events are going to be sampled at steps.
        about: Columns that say what each recording is, which a table of events may have.

    Raises:
        SeriesError: As ``open_source``, or it is no table.
    """
    import pyarrow as pa

    try:
        if isinstance(frame, pa.Table):
            table = frame
        elif hasattr(frame, "to_arrow"):
            table = frame.to_arrow()
        else:
            named = [name for name in frame.index.names if name is not None and name not in frame.columns]
            table = pa.Table.from_pandas(frame.reset_index(named) if named else frame, preserve_index=False)
    except (pa.ArrowException, TypeError, ValueError, AttributeError) as error:
        raise SeriesError(
            f"expected a path, or a table of pandas, polars or pyarrow; got {type(frame).__name__}"
        ) from error
    return open_table_as(arrow_file(table, Path("table")), None, options, wanted, sampled, about)


def _no_steps(table: TableFile, layout: EventLayout) -> str:
    track = layout.tracks[0]
    end = track.offset if track.offset is not None else track.duration if track.duration is not None else track.kind
    names = " and ".join(repr(table.header[i]) for i in (track.onset, end) if i is not None)
    return (
        f"{table.path} lists events, as its columns {names} say: a row is no step, and the next row is no answer to "
        "it. Sample the events to steps of one length, such as `step=0.1` (seconds); or, if rows are steps, say "
        "`rows_are_steps=True`"
    )


def _as_told(layout: EventLayout, table: TableFile, options: SourceOptions) -> EventLayout:
    """The layout with the columns that the options name."""
    if options.recording is not None:
        layout = replace(layout, recording=tuple(table.locations([options.recording])), level=None)
    if not (options.tier_columns or options.code_columns):
        return layout
    tier, code = (tuple(table.locations(names)) for names in (options.tier_columns, options.code_columns))
    if len({track.onset for track in layout.tracks}) > 1:
        tracks = tuple(track for track in layout.tracks if set(track.code) <= set(code))
        if tier or len(tracks) < len(code):
            raise SeriesError(
                f"{table.path} has tiers side by side: leave `tier_columns` out, and choose `code_columns` among "
                f"{', '.join(track.name for track in layout.tracks)}"
            )
        return replace(layout, tracks=tracks)
    first = layout.tracks[0]
    if not code:
        others = [track for track in layout.tracks if not set(track.code) & set(tier)]
        if len(others) > 1:
            raise SeriesError(f"{table.path} has several columns that may be the code; name one with `code_columns`")
        code = others[0].code if others else first.code
    name = " ".join(table.header[i] for i in code)
    return replace(layout, tracks=(replace(first, tier=tier or first.tier, code=code, name=name, alone=True),))
