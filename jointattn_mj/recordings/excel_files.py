"""Tables in Excel and OpenDocument workbooks, as the text that the same table would have in a CSV file."""

import datetime as dt
import io
from pathlib import Path
from typing import Any

from jointattn_mj.errors import SeriesError
from jointattn_mj.io.extras import extra

STARTS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
"""How workbooks begin: .xlsx, .xlsb and .ods are zip archives, .xls is not."""


def sheet_rows(data: bytes, path: Path, sheet: str | None = None) -> list[list[str]]:
    """Rows of a workbook, all equally long, from the first that is not blank to the last.

    Args:
        data: The whole file.
        path: The file, for messages.
        sheet: Name of the sheet; None: the only one that is not blank, or several that have the same header.

    Raises:
        ExtraError: The extra ``excel`` is not installed.
        SeriesError: No workbook that can be read, no such sheet, or several that could be meant.
    """
    calamine = extra("excel", "python_calamine")
    try:
        book = calamine.CalamineWorkbook.from_filelike(io.BytesIO(data))
        names = list(book.sheet_names)
        if sheet is not None and sheet not in names:
            raise SeriesError(f"{path} has no sheet {sheet!r}; there are {', '.join(names)}")
        tables = {name: _rows(book, name) for name in names if sheet in (None, name)}
    except (SeriesError, KeyboardInterrupt, SystemExit, MemoryError):
        raise
    except BaseException as error:  # a panic in compiled code is no Exception
        raise SeriesError(f"{path} is no workbook that can be read: {' '.join(str(error).split())[:200]}") from error
    tables = {name: rows for name, rows in tables.items() if rows}
    if not tables:
        raise SeriesError(f"{path} is empty; expected a header and rows below it")
    first, *others = tables.values()
    if any(rows[0] != first[0] for rows in others):
        raise SeriesError(
            f"{path} has several sheets; say which one is meant: `sheet={next(iter(tables))!r}`, for example"
        )
    rows = [*first, *(row for other in others for row in other[1:])]
    width = max(map(len, rows))
    return [row + [""] * (width - len(row)) for row in rows]


def _rows(book: Any, name: str) -> list[list[str]]:
    rows = [[_text(cell) for cell in row] for row in book.get_sheet_by_name(name).to_python(skip_empty_area=True)]
    while rows and not any(cell.strip() for cell in rows[-1]):
        rows.pop()
    return rows


def _text(cell: Any) -> str:
    """A cell as a CSV file has it: 1 for 1.0, true for TRUE, a time as a clock."""
    if isinstance(cell, str):
        return cell
    if isinstance(cell, bool):
        return str(cell).lower()
    if isinstance(cell, float):
        return str(int(cell)) if cell == int(cell) and abs(cell) < 1e15 else repr(cell)
    if isinstance(cell, dt.timedelta):
        return clock(cell.total_seconds())
    if isinstance(cell, dt.time):
        return clock(cell.hour * 3600 + cell.minute * 60 + cell.second + cell.microsecond / 1e6)
    return str(cell)


def clock(seconds: float) -> str:
    """Write a time as hours, minutes and seconds: 62.5 is ``00:01:02.500000``."""
    whole = round(abs(seconds) * 1e6)
    minutes, rest = divmod(whole, 60_000_000)
    return f"{'-' * (seconds < 0)}{minutes // 60:02d}:{minutes % 60:02d}:{rest // 1_000_000:02d}.{rest % 1_000_000:06d}"
