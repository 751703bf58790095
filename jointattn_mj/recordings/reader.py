"""Reads observations from a CSV or Parquet file: a row a step, a column a variable, labels of any kind."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np

from jointattn_mj.errors import SeriesError
from jointattn_mj.options import Checked, Whole, shown
from jointattn_mj.recordings.labels import coded
from jointattn_mj.recordings.steps import Recordings, pieces
from jointattn_mj.recordings.table_files import read_columns

Missing = Literal["error", "break"]
"""What a missing value does: it is an ``error``, or it ends the recording there, and the next row begins another."""


@dataclass(frozen=True, kw_only=True)
class ReadOptions(Checked):
    """How a file of observations is read."""

    recording: str | None = None
    """Column that tells independent recordings apart: no step leads from one into another."""
    missing: Missing = "error"
    """What a missing value does: an error, or a break in the recording."""
    encoding: str | None = None
    """Encoding of a text file, such as cp1252; UTF-8 where nothing is said, or what its byte order mark says."""
    skip_rows: Annotated[int, Whole("[0, 1e9]")] = 0
    """Lines above the header to leave out."""
    rows_are_steps: bool = False
    """Take rows as steps although columns such as onset and offset look like a list of events."""

    def read(self, path: Path | str, columns: str | Sequence[str]) -> Recordings:
        """The columns as :func:`read_recordings` reads them with these options."""
        if not isinstance(path, (str, os.PathLike)):
            raise SeriesError(f"expected the path of a file; got {type(path).__name__}")
        names = [columns] if isinstance(columns, str) else list(dict.fromkeys(columns))
        if not names or not all(isinstance(name, str) for name in names):
            raise SeriesError(f"expected the name of a column, or several; got {shown(columns)}")
        return _read(Path(path), names, self)


def read_recordings(
    path: Path | str,
    columns: str | Sequence[str],
    recording: str | None = None,
    missing: Missing = "error",
    *,
    encoding: str | None = None,
    skip_rows: int = 0,
    rows_are_steps: bool = False,
) -> Recordings:
    """Read columns of a text or Parquet file as series of codes, for the estimators of ``contingency``.

    A text file has a header, and columns separated by commas, semicolons or tabs. What the file holds counts, not its
    name. Labels lose blanks around them; 1.0 and 1,0 are the same as 1. Nothing, NA, NaN, null and such are missing.

    Args:
        path: The file, with a row a step.
        columns: Names of the variables to read, or one name.
        recording: Column that tells independent recordings apart: rows with the same value are one, in their order.
        missing: What a missing value does: ``"error"``, or ``"break"``, which cuts the recording there.
        encoding: Encoding of a text file, such as ``"cp1252"``; by default UTF-8, or what its byte order mark says.
        skip_rows: Lines above the header to leave out.
        rows_are_steps: Take rows as steps although columns such as onset and offset look like a list of events.

    Returns:
        Codes by variable, recording by recording, and the label of each code.

    Raises:
        SeriesError: No such file or column, nothing in it, another encoding, missing values, numbers with fractions,
            a list of events, or no transition.

    Examples:
        >>> from pathlib import Path
        >>> from jointattn_mj import read_recordings
        >>> _ = Path("gaze.csv").write_text("gaze,toy\\nleft,no\\nright,no\\nleft,yes\\n")
        >>> recordings = read_recordings("gaze.csv", ["gaze", "toy"])
        >>> recordings.columns["gaze"], recordings.labels["gaze"]
        ([array([0, 1, 0])], ('left', 'right'))
    """
    options = ReadOptions(
        recording=recording, missing=missing, encoding=encoding, skip_rows=skip_rows, rows_are_steps=rows_are_steps
    )
    return options.read(path, columns)


def _read(path: Path, columns: list[str], options: ReadOptions) -> Recordings:
    recording = options.recording
    wanted = list(dict.fromkeys([*columns, *([recording] if recording is not None else [])]))
    table = read_columns(path, wanted, options.encoding, options.skip_rows, options.rows_are_steps)
    rows = table.num_rows
    if rows < 2:
        raise SeriesError(f"{path} has {rows or 'no'} row{'s' * (rows != 1)} below its header; at least 2 are needed")
    codes = {name: coded(table.column(i), name) for i, name in enumerate(wanted) if name in columns}
    marks = None if recording is None else coded(table.column(wanted.index(recording)), recording, identifies=True)[0]
    absent = np.zeros(rows, bool)
    for name in wanted:
        gaps = (marks if marks is not None and name == recording else codes[name][0]) < 0
        if gaps.any() and (options.missing == "error" or name == recording):
            hint = "" if name == recording else "; fill them in, or cut recordings there with --missing break"
            raise SeriesError(
                f"column {name!r} of {path} has {int(gaps.sum())} missing values, the first in data row "
                f"{int(np.argmax(gaps)) + 1}{hint}"
            )
        absent |= gaps
    stretches = pieces(absent, marks)
    kept = [piece for piece in stretches if len(piece) > 1]
    if not kept:
        raise SeriesError(f"{path} has no two rows in one recording, so nothing follows anything")
    return Recordings(
        {name: [codes[name][0][piece] for piece in kept] for name in columns},
        {name: codes[name][1] for name in columns},
        [0 if marks is None else int(marks[piece[0]]) for piece in kept],
        rows,
        int(absent.sum()),
        sum(len(piece) == 1 for piece in stretches),
    )
