"""From tables with a row for every step to series of codes."""

from collections.abc import Collection, Sequence
from typing import Any, Literal

import numpy as np

from jointattn_mj.errors import SeriesError
from jointattn_mj.recordings.labels import coded
from jointattn_mj.recordings.sampling import Missing
from jointattn_mj.recordings.steps import Recordings, pieces
from jointattn_mj.recordings.table_files import TableFile

Fractions = Literal["error", "names"]


def read_steps(
    tables: Sequence[TableFile],
    columns: Sequence[str] | None,
    recording: str | None,
    missing: Missing,
    missing_values: Collection[str] = (),
    fractions: Fractions = "error",
    remarks: Sequence[str] = (),
) -> Recordings:
    """Read columns of tables of steps; each table is a recording, or several by a column.

    Args:
        tables: The tables.
        columns: Names of the variables; None: all but ``recording``.
        recording: Column that tells recordings apart.
        missing: What a missing value does: ``"error"``, or ``"break"``, which cuts the recording there.
        missing_values: Values that are missing, beside the usual ones.
        fractions: Whether numbers with fractions are names like others.
        remarks: What else a reader should know.

    Raises:
        SeriesError: No such column, missing values, numbers with fractions, or no two rows in one recording.
    """
    if columns is None:
        columns = [name for name in tables[0].header if name and name != recording]
    wanted = list(dict.fromkeys([*columns, *([recording] if recording is not None else [])]))
    table, first_rows = _together(tables, wanted)
    path = tables[0].path if len(tables) == 1 else tables[0].path.parent
    rows = table.num_rows
    if rows < 2:
        raise SeriesError(f"{path} has {rows or 'no'} row{'s' * (rows != 1)} below its header; at least 2 are needed")
    codes = {
        name: coded(table.column(i), name, missing=missing_values, fractions=fractions == "names")
        for i, name in enumerate(wanted)
        if name in columns
    }
    marks, names = None, tuple(table.path.stem for table in tables)
    if recording is not None:
        marks, names = coded(table.column(wanted.index(recording)), recording, True, missing_values)
    elif len(tables) > 1:
        marks = np.searchsorted(first_rows, np.arange(rows), "right") - 1
    absent = np.zeros(rows, bool)
    for name in wanted:
        gaps = (marks if marks is not None and name == recording else codes[name][0]) < 0
        if gaps.any() and (missing == "error" or name == recording):
            hint = "" if name == recording else "; fill them in, or cut recordings there with `missing='break'`"
            raise SeriesError(
                f"column {name!r} of {path} has {int(gaps.sum())} missing values, the first in data row "
                f"{int(np.argmax(gaps)) + 1}{hint}"
            )
        absent |= gaps
    if recording is not None and len(tables) > 1 and marks is not None:
        _refuse_parted(marks, first_rows, names)
    stretches = pieces(absent, marks)
    kept = [piece for piece in stretches if len(piece) > 1]
    if not kept:
        raise SeriesError(f"{path} has no two rows in one recording, so nothing follows anything")
    whole = len(kept) == 1 and len(kept[0]) == rows
    return Recordings(
        {name: [codes[name][0] if whole else codes[name][0][piece] for piece in kept] for name in columns},
        {name: codes[name][1] for name in columns},
        [0 if marks is None else int(marks[piece[0]]) for piece in kept],
        rows,
        int(absent.sum()),
        sum(len(piece) == 1 for piece in stretches),
        names,
        remarks=tuple(remarks),
    )


def _together(tables: Sequence[TableFile], wanted: Sequence[str]) -> tuple[Any, np.ndarray]:
    """The columns of all tables below one another, and the first row of each."""
    import pyarrow as pa

    parts = [table.columns(table.locations(wanted)) for table in tables]
    parts = [part.rename_columns([str(i) for i in range(len(wanted))]) for part in parts]
    first = np.cumsum([0, *(part.num_rows for part in parts[:-1])])
    return parts[0] if len(parts) == 1 else pa.concat_tables(parts), first


def _refuse_parted(marks: np.ndarray, first_rows: np.ndarray, names: Sequence[str]) -> None:
    """Refuse a recording of which rows stand in several files, whose order nothing tells."""
    files = np.searchsorted(first_rows, np.arange(len(marks)), "right") - 1
    for mark, name in enumerate(names):
        if len(np.unique(files[marks == mark])) > 1:
            raise SeriesError(f"recording {name!r} stands in several files; give recordings different names")
