"""From a table of events, whose columns are known, to events."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from jointattn_mj.errors import SeriesError
from jointattn_mj.options import shown
from jointattn_mj.recordings.event_layout import EventLayout, Track
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.labels import missing_labels, ordered
from jointattn_mj.recordings.table_files import TableFile
from jointattn_mj.recordings.tier_codes import dictionary
from jointattn_mj.recordings.times import TimeUnit, has_fraction, seconds, unit_of

START, STOP, POINT = {"start", "state start", "begin"}, {"stop", "state stop", "end"}, {"point", "state point", "event"}
"""What the kind of a row is called."""
POINTS = POINT | {"point event"}
PARTS = "|"
"""Stands between the parts of a code that several columns make."""


@dataclass
class _Rows:
    """Events as they are gathered."""

    tier: list[str]
    code: list[str | None]
    onset: list[float]
    offset: list[float]
    recording: list[str]


class _Columns:
    """Columns of a table, each with its different texts, blanks around them left out."""

    def __init__(self, table: TableFile, locations: Collection[int], missing: Collection[str]):
        self.table, self._missing = table, missing
        different = sorted(set(locations))
        columns = table.columns(different)
        self.rows: int = columns.num_rows
        self._columns = {i: dictionary(column) for i, column in zip(different, columns.columns, strict=True)}

    def texts(self, location: int) -> list[str]:
        """The texts of a column (rows,), blank where missing."""
        numbers, names = self._columns[location]
        stripped = [name.strip() for name in names]
        none = missing_labels(stripped, self._missing)
        present = ["" if name in none else name for name in stripped] + [""]
        return [present[number] for number in numbers.tolist()]

    def unit(self, location: int, unit: TimeUnit, layout: EventLayout) -> TimeUnit:
        """Unit of a column of times: as is said, its header, or the kind of table."""
        told: tuple[TimeUnit, ...] = unit, unit_of(self.table.header[location]), layout.unit
        return next((one for one in told if one != "auto"), "auto")

    def has_fractions(self, location: int) -> bool:
        """Whether a column has numbers that are not whole."""
        return any(map(has_fraction, self._columns[location][1]))

    def times(self, location: int, unit: TimeUnit, rate: float | None) -> np.ndarray:
        """Seconds (rows,) of a column of times, NaN where missing."""
        header = self.table.header[location]
        numbers, names = self._columns[location]
        none = missing_labels([name.strip() for name in names], self._missing)
        present = [name for name in names if name.strip() not in none]
        meaning = seconds(present, unit, rate, f"column {header!r} of {self.table.path}")
        values = np.array([meaning.get(name, np.nan) for name in names] + [np.nan])
        times: np.ndarray = values[numbers]
        return times

    def joined(self, locations: Sequence[int], between: str) -> list[str]:
        """Texts (rows,) of several columns together, blank ones left out."""
        if len(locations) == 1:
            return self.texts(locations[0])
        parts = [self.texts(location) for location in locations]
        return [between.join(filter(None, row)) for row in zip(*parts, strict=True)] if parts else [""] * self.rows


def read_event_table(
    table: TableFile,
    layout: EventLayout,
    name: str,
    unit: TimeUnit = "auto",
    rate: float | None = None,
    missing: Collection[str] = (),
) -> Events:
    """Read the events of a table.

    Args:
        table: The table.
        layout: What its columns are.
        name: What the recording is called where no column tells it.
        unit: Unit of times that are plain numbers.
        rate: Frames a second, where times are frames or end in them.
        missing: Texts that stand for no code, beside the usual ones.

    Raises:
        SeriesError: Times that cannot be read, an event without an end, or no events.
    """
    tracks = layout.tracks
    used = {i for one in tracks for i in (one.onset, one.offset, one.duration, one.kind, *one.code, *one.tier)}
    wanted = {i for i in (*used, *layout.recording, layout.level) if i is not None}
    columns = _Columns(table, wanted, missing)
    recordings, kept = _recordings(columns, layout, name)
    rows = _Rows([], [], [], [], [])
    when = {i for one in tracks for i in (one.onset, one.offset, one.duration) if i is not None}
    units = {i: columns.unit(i, unit, layout) for i in when}
    if any(units[i] == "auto" and columns.has_fractions(i) for i in when):
        units = {i: "s" if one == "auto" else one for i, one in units.items()}
    times = {i: columns.times(i, units[i], rate) for i in when}
    for track in tracks:
        _gather(rows, columns, track, times, recordings, kept)
    if not rows.tier:
        raise SeriesError(f"{table.path} has no events below its header")
    tiers = dict.fromkeys(one.name for one in tracks if not one.tier)
    try:
        return Events.of(
            rows.tier,
            _same_numbers(rows.tier, rows.code),
            rows.onset,
            rows.offset,
            rows.recording,
            tiers={one: tuple(tiers) for one in dict.fromkeys(rows.recording)},
            resolution=1 / rate if rate and {"frames", "auto"} & set(units.values()) else 0.001,
        )
    except SeriesError as error:
        raise SeriesError(f"{table.path}: {error}") from error


def _recordings(columns: _Columns, layout: EventLayout, name: str) -> tuple[list[str], list[bool]]:
    """The recording of each row, and which rows are events."""
    kept = [True] * columns.rows
    if layout.level is None:
        texts = columns.joined(layout.recording, " ") if layout.recording else [name] * columns.rows
        return [text or name for text in texts], kept
    level = columns.texts(layout.level)
    group, part, recordings = 0, 0, []
    for row, text in enumerate(level):
        kept[row] = text in ("3", "3.0")
        group, part = (group + 1, 0) if text == "1" else (group, part + 1 if text == "2" else part)
        recordings.append(f"{name} {group}.{part}" if group or part else name)
    return recordings, kept


def _gather(
    rows: _Rows,
    columns: _Columns,
    track: Track,
    times: Mapping[int, np.ndarray],
    recordings: Sequence[str],
    kept: Sequence[bool],
) -> None:
    """Add the events of one track."""
    codes = columns.joined(track.code, PARTS)
    tiers = columns.joined(track.tier, ".") if track.tier else None
    onset = times[track.onset]
    offset, duration = (
        np.full(columns.rows, np.nan) if location is None else times[location]
        for location in (track.offset, track.duration)
    )
    offset = np.where(np.isnan(offset), onset + duration, offset)
    kinds = None if track.kind is None else [text.casefold() for text in columns.texts(track.kind)]
    path = columns.table.path
    running: dict[tuple[str, str, str], tuple[int, float]] = {}
    for row, (begins, ends) in enumerate(zip(onset.tolist(), offset.tolist(), strict=True)):
        code = codes[row]
        if not kept[row] or not (code or track.alone) or (begins != begins and ends != ends and not code):
            continue
        if begins != begins:
            raise SeriesError(f"{path} has no onset for {shown(code)} in data row {row + 1}")
        tier = track.name if tiers is None else f"{tiers[row]}{track.name if track.name.startswith('.') else ''}"
        tier = tier or track.name
        if kinds is not None:
            ended = _paired(running, kinds[row], (recordings[row], tier, code), row, begins, ends, path)
            if ended is None:
                continue
            begins, ends = ended
        if ends != ends:
            raise SeriesError(
                f"{path} does not say when {shown(code)} ends in data row {row + 1}; a point event has its onset as "
                "its offset"
            )
        rows.tier.append(tier)
        rows.code.append(code or None)
        rows.onset.append(begins)
        rows.offset.append(ends)
        rows.recording.append(recordings[row])
    if running:
        (recording, tier, code), (row, _) = next(iter(running.items()))
        raise SeriesError(
            f"{path} does not say when {shown(code)} on {tier!r} of {recording!r} stops that starts in data row "
            f"{row + 1}; add where it stops"
        )


def _paired(
    running: dict[tuple[str, str, str], tuple[int, float]],
    kind: str,
    what: tuple[str, str, str],
    row: int,
    time: float,
    end: float,
    path: object,
) -> tuple[float, float] | None:
    """When an event begins and ends, where this row ends it or tells all."""
    if kind in POINTS:
        return time, time
    if kind in START:
        if what in running:
            raise SeriesError(
                f"{path} starts {shown(what[2])} twice, in data rows {running[what][0] + 1} and {row + 1}"
            )
        running[what] = row, time
        return None
    if kind in STOP:
        if what not in running:
            raise SeriesError(
                f"{path} stops {shown(what[2])} on {what[1]!r} in data row {row + 1}, and never starts it"
            )
        return running.pop(what)[1], time
    raise SeriesError(f"{path} has an event of kind {shown(kind)} in data row {row + 1}; expected start, stop or point")


def _same_numbers(tiers: Sequence[str], codes: Sequence[str | None]) -> list[str | None]:
    """Codes in which 1.0 and 1,0 are the same as 1, as in a table of steps."""
    by_tier: dict[str, set[str]] = {}
    for tier, code in zip(tiers, codes, strict=True):
        if code is not None:
            by_tier.setdefault(tier, set()).add(code)
    same = {tier: ordered(known, tier, fractions=True) for tier, known in by_tier.items()}
    return [None if code is None else same[tier][code] for tier, code in zip(tiers, codes, strict=True)]
