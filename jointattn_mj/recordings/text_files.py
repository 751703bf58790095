"""Text files of unknown origin: their encoding, the line with the header, and what separates the columns."""

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from jointattn_mj.errors import SeriesError

MARKS = (
    (b"\xef\xbb\xbf", "utf-8-sig"),
    (b"\xff\xfe\0\0", "utf-32"),
    (b"\0\0\xfe\xff", "utf-32"),
    (b"\xff\xfe", "utf-16"),
    (b"\xfe\xff", "utf-16"),
)
"""Byte order marks, with which a file tells its encoding; the longer ones first."""
KINDS = {
    b"PK\x03\x04": "an Excel workbook or a zip archive",
    b"\xd0\xcf\x11\xe0": "an Excel workbook",
    b"\x1f\x8b": "a gzip archive",
    b"%PDF": "a PDF file",
    b"ARROW1": "an Arrow file",
    b"SQLite format 3": "a database",
}
"""How common files that are no text begin."""
DELIMITERS = ",;\t"
SNIFFED_ROWS = 20
SEARCHED_LINES = 100
"""Lines among which a header further down is looked for."""
_HEAD_BYTES = 1 << 20
_SEPARATOR = re.compile(r'"?sep=(.)"?\s*')
_CONTROL = re.compile(rb"[\0-\x08\x0e-\x19\x1b-\x1f]")


@dataclass(frozen=True)
class TextLayout:
    """How a table stands in its text."""

    delimiter: str
    header: list[str]
    """Names of the columns, as written."""
    start: int
    """Byte at which the first row below the header begins."""


def as_utf8(data: bytes, path: Path, encoding: str | None = None) -> bytes:
    """The text of a file as UTF-8 without a byte order mark; ``encoding`` is told, or taken from the mark.

    Raises:
        SeriesError: No text, or text in another encoding.
    """
    chosen = encoding or next((name for mark, name in MARKS if data.startswith(mark)), None)
    if chosen is None:
        _refuse_binary(data, path)
        try:
            data.decode()
            return data
        except UnicodeDecodeError as error:
            line = data.count(b"\n", 0, error.start) + 1
            raise SeriesError(
                f"{path} is not in UTF-8 (byte 0x{data[error.start]:02X} in line {line}); say how it was written, such "
                "as `encoding='cp1252'` for a file from Windows in a western language"
            ) from error
    try:
        text = data.decode(chosen).removeprefix("\ufeff")
        written = text.encode()
    except LookupError as error:
        raise SeriesError(f"encoding must be one that Python knows, such as cp1252; got {chosen!r}") from error
    except ValueError as error:
        raise SeriesError(f"{path} is no text in the encoding {chosen}: {error}") from error
    if "\0" in text:
        raise SeriesError(f"{path} is no text in the encoding {chosen}; it holds NUL characters")
    return written


def _refuse_binary(data: bytes, path: Path) -> None:
    for start, kind in KINDS.items():
        if data.startswith(start):
            raise SeriesError(f"{path} is {kind}, not text; save the table as CSV")
    found = _CONTROL.search(data)
    if found is not None:
        hint = "; for UTF-16 without a mark say `encoding='utf-16-le'`" if found.group() == b"\0" else ""
        raise SeriesError(f"{path} is no text file (byte 0x{found.group()[0]:02X} at {found.start()}){hint}")


def layout(data: bytes, path: Path, skip_rows: int = 0) -> TextLayout:
    """Find the header of UTF-8 text below ``skip_rows`` lines, and the delimiter that it and the next rows agree on.

    A line ``sep=;``, as Excel writes it, may stand above the header.

    Raises:
        SeriesError: The text ends before a header, or its header cannot be read.
    """
    text = data[:_HEAD_BYTES].decode(errors="ignore")
    lines = io.StringIO(text, newline="")
    for _ in range(skip_rows):
        if not lines.readline():
            raise SeriesError(f"{path} has no header below the {skip_rows} rows that `skip_rows` leaves out")
    start = lines.tell()
    told = _SEPARATOR.fullmatch(lines.readline())
    if told is None:
        lines.seek(start)
    delimiter = told[1] if told else _delimiter(text[start:])
    try:
        header = next(csv.reader(lines, delimiter=delimiter), [])
    except (csv.Error, ValueError, TypeError) as error:
        raise SeriesError(f"{path} has no header that can be read: {error}") from error
    if not any(name.strip() for name in header):
        above = f" below {skip_rows} rows" if skip_rows else ""
        raise SeriesError(f"{path} is empty{above}; expected a header and a row for every step")
    return TextLayout(delimiter, header, len(text[: lines.tell()].encode()))


def line_of_header(data: bytes, names: Sequence[str]) -> int | None:
    """Number, from 0 on, of the first line in which all ``names`` stand as columns."""
    lines = io.StringIO(data[:_HEAD_BYTES].decode(errors="ignore"), newline="")
    for number, line in enumerate(islice(lines, SEARCHED_LINES)):
        for delimiter in DELIMITERS:
            row = next(csv.reader([line], delimiter=delimiter), [])
            if set(names) <= {cell.strip() for cell in row}:
                return number
    return None


def _delimiter(text: str) -> str:
    """The one by which the first rows are all as long as the header; among several, the most frequent."""

    def fits(mark: str) -> tuple[bool, int]:
        widths, whole = [], True
        try:
            reader = csv.reader(io.StringIO(text, newline=""), delimiter=mark, strict=True)
            widths = [len(row) for row in islice(reader, SNIFFED_ROWS) if row]
        except csv.Error:
            whole = False
        width = widths[0] if widths else 0
        return whole and width > 1 and len(set(widths)) == 1, width

    return max(DELIMITERS, key=fits)
