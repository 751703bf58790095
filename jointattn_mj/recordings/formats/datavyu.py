"""Datavyu's spreadsheets as text: in an .opf archive, or exported as .csv.

A column with one code is a tier of its name; with several, each is a tier such as ``infant.look``. Datavyu's other
export, side by side, is a table of events.
"""

import csv
import io
import re
import zipfile
from collections.abc import Collection, Iterator
from pathlib import Path

from jointattn_mj.errors import SeriesError
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.labels import missing_labels
from jointattn_mj.recordings.times import seconds

MEMBER = "db"
"""File in an .opf archive that has the spreadsheet."""
_COLUMN = re.compile(r"(.+?) \((MATRIX|TEXT|NOMINAL|PREDICATE),[^)]*\)-?(.*)")
_CELL = re.compile(r"(\d+:\d\d:\d\d:\d{3}),(\d+:\d\d:\d\d:\d{3}),(.*)", re.DOTALL)
_MOST_BYTES = 1 << 28


def is_datavyu(data: bytes) -> bool:
    """Whether a file holds the text of a spreadsheet."""
    return re.match(rb"(\xef\xbb\xbf)?#\d\s*[\r\n]", data) is not None and re.search(rb" \([A-Z]+,", data) is not None


def spreadsheet(data: bytes, path: Path) -> bytes | None:
    """The spreadsheet in an archive; None where it has none that can be read.

    Raises:
        SeriesError: It is too large.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if MEMBER not in archive.namelist():
                return None
            if archive.getinfo(MEMBER).file_size > _MOST_BYTES:
                raise SeriesError(f"{path} has a spreadsheet of more than {_MOST_BYTES:,} bytes")
            return archive.read(MEMBER)
    except SeriesError:
        raise
    except Exception:  # a damaged archive makes many; it may be a workbook
        return None


def read_datavyu(text: str, path: Path, missing: Collection[str] = ()) -> Events:
    """Read a spreadsheet.

    Args:
        text: The spreadsheet.
        path: The file, for messages; without its suffix it names the recording.
        missing: Values that stand for no code, beside the usual ones.

    Raises:
        SeriesError: A line cannot be read, a cell ends before it begins, or there are no cells.
    """
    tiers: dict[str, None] = {}
    rows: list[tuple[str, str, str, str]] = []
    names: list[str] = []
    for number, line in _lines(text):
        column, cell = _COLUMN.fullmatch(line), _CELL.fullmatch(line)
        if cell is not None and names:
            onset, offset, values = cell.groups()
            codes = _codes(values)
            if len(codes) == len(names) + 1 and not codes[-1]:  # a comma ends the list
                codes.pop()
            if len(codes) != len(names):
                raise SeriesError(f"{path} has a cell with {len(codes)} codes in line {number}; expected {len(names)}")
            rows += [
                (name, code, onset, offset) for name, code in zip(names, codes, strict=True) if code or len(names) == 1
            ]
        elif column is not None:
            codes = [part.partition("|")[0].strip() for part in column[3].split(",") if part.strip()]
            names = [f"{column[1]}.{code}" for code in codes] if len(codes) > 1 else [column[1]]
            tiers.update(dict.fromkeys(names))
        else:
            raise SeriesError(f"{path} has neither a column nor a cell in line {number}: {line[:60]!r}")
    if not rows:
        raise SeriesError(f"{path} has no cells")
    written = sorted({time for row in rows for time in row[2:]})
    times = dict(zip(written, seconds(written, "ms", None, str(path)).tolist(), strict=True))
    none = missing_labels({code for _, code, _, _ in rows}, missing)
    try:
        return Events.of(
            [row[0] for row in rows],
            [None if row[1] in none else row[1] for row in rows],
            [times[row[2]] for row in rows],
            [times[row[3]] for row in rows],
            path.stem,
            tiers={path.stem: tuple(tiers)},
        )
    except SeriesError as error:
        raise SeriesError(f"{path}: {error}") from error


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """Lines below the version, a cell whose codes go over several lines as one."""
    whole, first = "", 0
    for number, line in enumerate(text.removeprefix("\ufeff").splitlines(), 1):
        if not whole and (not line.strip() or (number == 1 and line.startswith("#"))):
            continue
        whole, first = (f"{whole}\n{line}", first) if whole else (line, number)
        cell = _CELL.fullmatch(whole)
        if cell is None or whole.rstrip().endswith(")"):
            yield first, whole.rstrip()
            whole = ""
    if whole:
        yield first, whole


def _codes(values: str) -> list[str]:
    """Codes of a cell: in brackets, parted by commas, with a backslash before one that is meant; or bare text."""
    inside = values.strip()
    if inside.startswith("(") and inside.endswith(")"):
        inside = inside[1:-1]
    return [code.strip() for code in next(csv.reader([inside.replace("\n", " ")], escapechar="\\"), [""])] or [""]
