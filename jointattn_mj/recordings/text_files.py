"""Text files of unknown origin: their encoding, the line with the header, and what separates the columns."""

import csv
import io
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
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
    b"PK\x03\x04": "a zip archive",
    b"\x1f\x8b": "a gzip archive",
    b"%PDF": "a PDF file",
    b"ARROW1": "an Arrow file",
    b"SQLite format 3": "a database",
}
"""How common files that are no text begin."""
DELIMITERS = ",;\t|"
SNIFFED_ROWS = 20
SEARCHED_LINES = 100
"""Lines among which a header further down is looked for."""
_HEAD_BYTES = 1 << 20
_BLANK = re.compile(r'[\s",;|]*')
"""A line without a cell that has something in it."""
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
    header_at: int = 0
    """Character at which the header begins."""
    named_in: int | None = None
    """Line, from 0 on, that has the names that were looked for, below lines that may be rows of the table."""


def as_utf8(data: bytes, path: Path, encoding: str | None = None) -> bytes:
    """The text of a file as UTF-8 without a byte order mark; ``encoding`` is told, or taken from the mark.

    Args:
        data: The whole file.
        path: Of the file, for messages.
        encoding: As told by the caller; None takes it from the file's byte order mark.

    Raises:
        SeriesError: No text, or text in another encoding.
    """
    chosen = encoding or next((name for mark, name in MARKS if data.startswith(mark)), None)
    chosen = chosen or _unmarked(data)
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


def _unmarked(data: bytes) -> str | None:
    """UTF-16 without a byte order mark: every second byte of western text is NUL."""
    sample = data[: _HEAD_BYTES & ~1]
    nul = sample[::2].count(0), sample[1::2].count(0)
    if len(data) % 2 or max(nul) < len(sample) / 8 or min(nul) * 8 > max(nul):
        return None
    return "utf-16-le" if nul[1] > nul[0] else "utf-16-be"


def _refuse_binary(data: bytes, path: Path) -> None:
    for start, kind in KINDS.items():
        if data.startswith(start):
            raise SeriesError(f"{path} is {kind}, not text; save the table as CSV")
    match = _CONTROL.search(data)
    if match is not None:
        raise SeriesError(f"{path} is no text file (byte 0x{match.group()[0]:02X} at {match.start()})")


def layout(
    data: bytes,
    path: Path,
    skip_rows: int = 0,
    delimiter: str | None = None,
    heads: Callable[[Sequence[str]], bool] = lambda names: True,
) -> TextLayout:
    """Find the header of UTF-8 text, and the delimiter that it and the next rows agree on.

    A line ``sep=;``, as Excel writes it, may stand above the header, and so may blank lines, and others with another
    number of columns, or which a blank line parts from the header.

    Args:
        data: The text.
        path: The file, for messages.
        skip_rows: Lines to leave out.
        delimiter: What separates columns; None: found.
        heads: Whether names are those of a header that is looked for. If none is, the first line is the header.

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
    start = lines.tell() if told else start
    skipped, start = _blank_lines(lines, start)
    first = _layout_at(text, start, path, told[1] if told else delimiter)
    if heads(first.header):
        return first
    above: list[str] = []
    lines.seek(start)
    for _ in range(SEARCHED_LINES):
        at = lines.tell()
        line = lines.readline()
        if not line:
            break
        if above and line.strip():
            candidate = _layout_at(text, at, path, told[1] if told else delimiter)
            if heads(candidate.header):
                rows = [_cells(line, candidate.delimiter) for line in above]
                return (
                    candidate
                    if are_above(rows, candidate.header)
                    else replace(first, named_in=skip_rows + skipped + len(above))
                )
        above.append(line)
    return first


def _blank_lines(lines: io.StringIO, start: int) -> tuple[int, int]:
    """How many blank lines stand at ``start``, and where the next one begins; none if nothing else comes."""
    lines.seek(start)
    for skipped in range(SEARCHED_LINES):
        at = lines.tell()
        line = lines.readline()
        if not line:
            break
        if not _BLANK.fullmatch(line):
            return skipped, at
    return 0, start


def _layout_at(text: str, start: int, path: Path, delimiter: str | None) -> TextLayout:
    lines = io.StringIO(text, newline="")
    lines.seek(start)
    mark = delimiter or _delimiter(text[start:])
    try:
        header = next(csv.reader(lines, delimiter=mark), [])
    except (csv.Error, ValueError, TypeError) as error:
        raise SeriesError(f"{path} has no header that can be read: {error}") from error
    if not any(name.strip() for name in header) and start == 0:
        raise SeriesError(f"{path} is empty; expected a header and a row for every step, or for every event")
    return TextLayout(mark, header, len(text[: lines.tell()].encode()), start)


def are_above(rows: Sequence[Sequence[str]], header: Sequence[str]) -> bool:
    """Whether rows above a header are none of its table.

    They have another number of cells, or a name and a value each, or a blank row is between.
    """
    if not any(cell.strip() for cell in rows[-1]):
        return True
    named_values = _width(header) > 2 and all(_width(row) <= 2 for row in rows)
    return named_values or all(len(row) != len(header) for row in rows)


def _width(row: Sequence[str]) -> int:
    """Number of cells up to the last that is not blank."""
    return max((i + 1 for i, cell in enumerate(row) if cell.strip()), default=0)


def _cells(line: str, delimiter: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=delimiter), [])
    except csv.Error:  # more in a cell than Python takes
        return []


def _delimiter(text: str) -> str:
    """The one by which the first rows are all as long as the header; among several, the most frequent."""

    def fits(mark: str) -> tuple[bool, int]:
        widths: list[int] = []
        whole = True
        try:
            for row in islice(csv.reader(io.StringIO(text, newline=""), delimiter=mark, strict=True), SNIFFED_ROWS):
                widths += [len(row)] if row else []
        except csv.Error:
            whole = False
        width = widths[0] if widths else 0
        return whole and width > 1 and len(set(widths)) == 1, width

    return max(DELIMITERS, key=fits)
