"""Columns of CSV and Parquet files, as text that is encoded by a dictionary. What a file holds says what it is."""

import os
import re
import stat
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from jointattn_mj.errors import SeriesError
from jointattn_mj.io.former_columns import present_name
from jointattn_mj.options import warn_renamed
from jointattn_mj.recordings.text_files import as_utf8, layout, line_of_header

EVENTS = (
    ("onset", "offset"),
    ("onset", "duration"),
    ("begin", "end"),
    ("begin time", "duration"),
    ("start", "stop"),
    ("start", "end"),
    ("start", "duration"),
    ("start time", "duration"),
)
"""What two columns are called, apart from what is the same in both, where each row is an event of some length."""
_SHOWN = 20


def read_columns(
    path: Path, wanted: Sequence[str], encoding: str | None = None, skip_rows: int = 0, rows_are_steps: bool = False
) -> Any:
    """The columns ``wanted`` (different names) as a pyarrow table of dictionary-encoded text, in their order.

    Raises:
        SeriesError: No such file or column, or nothing that can be read.
    """
    import pyarrow as pa  # here, so that measures of arrays do without it

    data = read_bytes(path)
    try:
        if data.startswith(b"PAR1"):
            return _read_parquet(data, path, wanted, rows_are_steps)
        return _read_csv(as_utf8(data, path, encoding), path, wanted, skip_rows, rows_are_steps)
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        kind = "Parquet" if data.startswith(b"PAR1") else "CSV"
        trouble = re.sub(r"Row #(\d+)", r"data row \1", " ".join(str(error).split()))
        raise SeriesError(f"{path} is no {kind} file that can be read: {trouble[:300]}") from error


def read_bytes(path: Path) -> bytes:
    """Everything in a file, or from a pipe.

    Raises:
        SeriesError: No such file, or something that is no file.
    """
    try:
        with path.open("rb") as file:
            mode = os.fstat(file.fileno()).st_mode
            content = file.read() if stat.S_ISREG(mode) or stat.S_ISFIFO(mode) else None
    except OSError as error:
        raise SeriesError(f"cannot read {path}: {error.strerror or error}") from error
    except ValueError as error:  # a NUL in the name
        raise SeriesError(f"cannot read {str(path)!r}: {error}") from error
    if content is None:
        raise SeriesError(f"cannot read {path}: it is a device, not a file")
    return content


def _read_csv(data: bytes, path: Path, wanted: Sequence[str], skip_rows: int, rows_are_steps: bool) -> Any:
    import pyarrow as pa
    from pyarrow import csv

    table = layout(data, path, skip_rows)
    try:
        locations = [str(location) for location in _locations(table.header, wanted, path, rows_are_steps)]
    except SeriesError as error:
        line = line_of_header(data, wanted)
        if line is None or line <= skip_rows:
            raise
        raise SeriesError(f"{error}. Line {line + 1} names them: say `skip_rows={line}`") from error
    body = data[table.start :].rstrip(b"\r\n") + b"\n"
    if not body.strip(b"\r\n"):
        return pa.table({name: pa.array([], pa.string()).dictionary_encode() for name in wanted})
    text = pa.dictionary(pa.int32(), pa.string())
    columns = csv.read_csv(
        pa.BufferReader(body),
        read_options=csv.ReadOptions(use_threads=False, column_names=[str(i) for i in range(len(table.header))]),
        parse_options=csv.ParseOptions(delimiter=table.delimiter, ignore_empty_lines=False, newlines_in_values=True),
        convert_options=csv.ConvertOptions(
            include_columns=locations, column_types=dict.fromkeys(locations, text), strings_can_be_null=False
        ),
    )
    return columns.rename_columns(list(wanted))


def _read_parquet(data: bytes, path: Path, wanted: Sequence[str], rows_are_steps: bool) -> Any:
    import pyarrow as pa
    from pyarrow import compute, parquet

    source = parquet.ParquetFile(pa.BufferReader(data))
    header = source.schema_arrow.names
    names = [header[location] for location in _locations(header, wanted, path, rows_are_steps)]
    columns = source.read(columns=names, use_threads=False).select(names).columns
    for name, column in zip(wanted, columns, strict=True):
        if pa.types.is_floating(column.type) and compute.any(compute.is_inf(column)).as_py():
            raise SeriesError(f"column {name!r} holds infinite numbers; give each value a label, or leave it missing")
    return pa.table([column.cast(pa.string()).dictionary_encode() for column in columns], names=list(wanted))


def _locations(header: Sequence[str], wanted: Sequence[str], path: Path, rows_are_steps: bool) -> list[int]:
    """Where the wanted columns stand; blanks around their names do not count."""
    names = [" ".join(name.split()) for name in header]
    meant = [_present(" ".join(name.split()), names) for name in wanted]
    for name in meant:
        if names.count(name) == 0:
            close = get_close_matches(name, names, 1)
            hint = f"; did you mean {close[0]!r}?" if close else ""
            raise SeriesError(f"{path} has no column {name!r}; its columns are: {_shown(names)}{hint}")
        if names.count(name) > 1:
            raise SeriesError(f"{path} has {names.count(name)} columns {name!r}; names must differ")
    events = None if rows_are_steps else _event_columns(names)
    if events is not None:
        raise SeriesError(
            f"{path} lists events, as its columns {events[0]!r} and {events[1]!r} say: a row is no step, and the next "
            "row is no answer to it. Sample the events first, with a row for every 0.1 s or so; or, if rows are steps "
            "of one length, say `rows_are_steps=True`"
        )
    return [names.index(name) for name in meant]


def _present(name: str, names: Sequence[str]) -> str:
    """The name of a column as it is in the file, where it was asked for by the name that it had in the last version."""
    present = present_name(name)
    if name in names or present not in names:
        return name
    warn_renamed(f"column {name!r}", repr(present))
    return present


def _event_columns(names: Sequence[str]) -> tuple[str, str] | None:
    """Two columns that say when an event begins and when it ends, or how long it is."""
    spelt = {name.casefold(): name for name in names}
    for first, last in EVENTS:
        for name in spelt:
            other = name.replace(first, last)
            if other != name and other in spelt:
                return spelt[name], spelt[other]
    return None


def _shown(names: Sequence[str]) -> str:
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return ", ".join(name if len(name) <= 60 else f"{name[:57]}..." for name in names[:_SHOWN]) + more
