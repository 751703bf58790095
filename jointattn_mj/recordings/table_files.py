"""Tables in text, Parquet and Excel files, as dictionary-encoded text. What a file holds says what it is."""

import csv
import io
import os
import re
import stat
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import islice
from pathlib import Path
from typing import Annotated, Any, ClassVar

from jointattn_mj.errors import SeriesError
from jointattn_mj.io.former_names import present_name
from jointattn_mj.options import Checked, Whole, warn_renamed
from jointattn_mj.recordings.excel_files import STARTS, clock, sheet_rows
from jointattn_mj.recordings.text_files import SEARCHED_LINES, SNIFFED_ROWS, TextLayout, are_above, as_utf8, layout

_SHOWN = 20


@dataclass(frozen=True, kw_only=True)
class TableOptions(Checked):
    """How a table is found in its file."""

    encoding: str | None = None
    """Encoding of a text file, such as cp1252; UTF-8 where nothing is said, or what its byte order mark says."""
    skip_rows: Annotated[int, Whole("[0, 1e9]")] = 0
    """Lines above the header to leave out; lines that are no part of the table are found."""
    delimiter: str | None = None
    """What separates columns in a text file, one character or "tab"; by default comma, semicolon, tab or |."""
    sheet: str | None = None
    """Sheet of an Excel workbook; by default the only one, or all that have the same header."""
    columns: tuple[str, ...] = ()
    """Names of the columns of a table without a header, such as tier onset offset code; - leaves a column out."""

    ADVANCED: ClassVar[Sequence[str]] = ("skip_rows", "delimiter", "sheet", "columns")


@dataclass(frozen=True)
class TableFile:
    """A table in a file, of which columns are read when they are asked for."""

    path: Path
    header: tuple[str, ...]
    """Names of the columns; blanks around and within them are single ones."""
    head: tuple[tuple[str, ...], ...]
    """The first rows as text, the header among them; empty where the file tells its header apart, as Parquet does."""
    read: Callable[[Sequence[int]], Any]
    """Gives columns by their locations as a pyarrow table of dictionary-encoded text, named by their numbers."""
    named_in: int | None = None
    """Line, from 0 on, that has the names that were looked for, below lines that may be rows of the table."""

    @property
    def hint(self) -> str:
        """What to do where the names stand further down."""
        return (
            "" if self.named_in is None else f". Line {self.named_in + 1} names them: say `skip_rows={self.named_in}`"
        )

    def columns(self, locations: Sequence[int]) -> Any:
        """Columns by their locations as a pyarrow table of dictionary-encoded text, in their order.

        Raises:
            SeriesError: They cannot be read.
        """
        import pyarrow as pa

        different = list(dict.fromkeys(locations))
        try:
            table = self.read(different)
        except (pa.ArrowException, UnicodeDecodeError, OSError) as error:
            trouble = re.sub(r"Row #(\d+)", r"data row \1", " ".join(str(error).split()))
            raise SeriesError(f"{self.path} is no table that can be read: {trouble[:300]}") from error
        return table.select([different.index(location) for location in locations])

    def locations(self, wanted: Sequence[str]) -> list[int]:
        """Where columns stand.

        Raises:
            SeriesError: There is no such column, or two.
        """
        meant = [_present(single_blanks(name), self.header) for name in wanted]
        for name in meant:
            if self.header.count(name) == 0:
                close = get_close_matches(name, self.header, 1)
                hint = f"; did you mean {close[0]!r}?" if close else ""
                raise SeriesError(
                    f"{self.path} has no column {name!r}; its columns are: {_shown(self.header)}{hint}{self.hint}"
                )
            if self.header.count(name) > 1:
                raise SeriesError(f"{self.path} has {self.header.count(name)} columns {name!r}; names must differ")
        return [self.header.index(name) for name in meant]


def open_table(
    data: bytes,
    path: Path,
    options: TableOptions,
    heads: Callable[[Sequence[str]], bool] = lambda names: True,
) -> TableFile:
    """Find the table in a file.

    Args:
        data: The whole file.
        path: The file, for messages.
        options: How it is written.
        heads: Whether names are those of a header that is looked for.

    Raises:
        SeriesError: Nothing that can be read.
    """
    if data.startswith(b"PAR1"):
        return _parquet(data, path)
    if data.startswith(STARTS):
        return _workbook(sheet_rows(data, path, options.sheet), path, options, heads)
    return _text(as_utf8(data, path, options.encoding), path, options, heads)


def arrow_file(table: Any, path: Path) -> TableFile:
    """A ``pyarrow.Table`` as a table file."""
    names = tuple(single_blanks(str(name)) for name in table.column_names)

    def read(locations: Sequence[int]) -> Any:
        return _as_text([table.column(i) for i in locations], [names[i] for i in locations])

    return TableFile(path, names, (), read)


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


def single_blanks(name: str) -> str:
    """A name with single blanks in it and none around."""
    return " ".join(name.split())


def _text(data: bytes, path: Path, options: TableOptions, heads: Callable[[Sequence[str]], bool]) -> TableFile:
    def known(names: Sequence[str]) -> bool:
        return bool(options.columns) or heads([single_blanks(name) for name in names])

    outline = layout(data, path, options.skip_rows, _delimiter(options), known)
    lines = io.StringIO(data[: 1 << 20].decode(errors="ignore"), newline="")
    lines.seek(outline.header_at)
    try:
        head = tuple(tuple(row) for row in islice(csv.reader(lines, delimiter=outline.delimiter), SNIFFED_ROWS))
    except csv.Error as error:
        raise SeriesError(f"{path} is no table that can be read: {error}") from error
    start = outline.start
    if options.columns:
        outline = _named(outline, path, options)
        start = len(lines.getvalue()[: outline.header_at].encode())
    names = tuple(single_blanks(name) for name in outline.header)
    return TableFile(
        path,
        names,
        head,
        lambda locations: _read_text(data, start, outline, path, locations),
        outline.named_in,
    )


def _named(outline: TextLayout, path: Path, options: TableOptions) -> TextLayout:
    """The layout of a table without a header, with the names that are told."""
    if len(outline.header) != len(options.columns):
        raise SeriesError(
            f"{path} has {len(outline.header)} columns, and `columns` names {len(options.columns)} (- leaves one out)"
        )
    return TextLayout(outline.delimiter, list(options.columns), outline.start, outline.header_at)


def _delimiter(options: TableOptions) -> str | None:
    mark = {"tab": "\t", "\\t": "\t", "space": " "}.get(options.delimiter or "", options.delimiter)
    if mark is not None and (len(mark) != 1 or mark in '\r\n"' or not mark.isascii()):
        raise SeriesError(f'the delimiter must be one character, or "tab"; got {options.delimiter!r}')
    return mark


def _read_text(data: bytes, start: int, outline: TextLayout, path: Path, locations: Sequence[int]) -> Any:
    import pyarrow as pa
    from pyarrow import csv

    end = len(data)
    while end > start and data[end - 1] in b"\r\n":
        end -= 1
    names = [str(location) for location in locations]
    if end == start:
        return pa.table({name: pa.array([], pa.string()).dictionary_encode() for name in names})
    text = pa.dictionary(pa.int32(), pa.string())
    body = pa.py_buffer(data).slice(start, end - start)
    options = {
        "read_options": csv.ReadOptions(use_threads=False, column_names=[str(i) for i in range(len(outline.header))]),
        "parse_options": csv.ParseOptions(
            delimiter=outline.delimiter, ignore_empty_lines=False, newlines_in_values=True
        ),
    }
    every = [str(i) for i in range(len(outline.header))]

    def read(columns: list[str]) -> Any:
        convert = csv.ConvertOptions(
            include_columns=columns, column_types=dict.fromkeys(columns, text), strings_can_be_null=False
        )
        return csv.read_csv(pa.BufferReader(body), convert_options=convert, **options)

    columns = read(names)
    if data.find(b'"', start) >= 0 and columns.num_rows < _lines(data, start, end):
        _refuse_open_quotes(read(every), outline, path)
    return columns


def _lines(data: bytes, start: int, end: int) -> int:
    return (data.count(b"\n", start, end) or data.count(b"\r", start, end)) + 1


def _refuse_open_quotes(table: Any, outline: TextLayout, path: Path) -> None:
    """Refuse a table in which a value holds whole rows, as a quotation mark was opened and not closed."""
    for name, column in zip(outline.header, table.columns, strict=True):
        for value in column.unify_dictionaries().chunk(0).dictionary.to_pylist() if column.num_chunks else ():
            lines = re.split(r"\r\n|\n|\r", value)
            whole = len(outline.header) - 1
            if any(line.count(outline.delimiter) >= max(whole, 1) for line in lines[1:-1]) or (
                len(lines) > 1
                and lines[0].count(outline.delimiter) + lines[-1].count(outline.delimiter) >= max(whole, 1)
            ):
                raise SeriesError(
                    f"{path} has a quotation mark in column {name!r} that swallows rows, before "
                    f"{' '.join(value.split())[:40]!r}; close it, or write two for one"
                )


def _workbook(
    rows: list[list[str]], path: Path, options: TableOptions, heads: Callable[[Sequence[str]], bool]
) -> TableFile:
    import pyarrow as pa

    rows = rows[options.skip_rows :]
    if not rows:
        raise SeriesError(f"{path} has no header below the {options.skip_rows} rows that `skip_rows` leaves out")
    at = next((i for i, row in enumerate(rows[:SEARCHED_LINES]) if heads([single_blanks(cell) for cell in row])), 0)
    named_in = options.skip_rows + at if at and not are_above(rows[:at], rows[at]) else None
    at = 0 if named_in is not None else at
    if options.columns:
        at = 0
        if len(rows[0]) != len(options.columns):
            raise SeriesError(f"{path} has {len(rows[0])} columns, and `columns` names {len(options.columns)}")
    header = tuple(map(single_blanks, options.columns or rows[at]))
    body = rows[0 if options.columns else at + 1 :]

    def read(locations: Sequence[int]) -> Any:
        columns = [pa.array([row[i] for row in body], pa.string()).dictionary_encode() for i in locations]
        return pa.table(columns, names=[str(i) for i in locations])

    return TableFile(path, header, tuple(tuple(row) for row in rows[at : at + SNIFFED_ROWS]), read, named_in)


def _parquet(data: bytes, path: Path) -> TableFile:
    import pyarrow as pa
    from pyarrow import parquet

    try:
        source = parquet.ParquetFile(pa.BufferReader(data))
    except (pa.ArrowException, OSError) as error:
        raise SeriesError(
            f"{path} is no Parquet file that can be read: {' '.join(str(error).split())[:300]}"
        ) from error
    header = source.schema_arrow.names

    def read(locations: Sequence[int]) -> Any:
        names = [header[i] for i in locations]
        columns = source.read(columns=names, use_threads=False).select(names).columns
        return _as_text(columns, names)

    return TableFile(path, tuple(map(single_blanks, header)), (), read)


def _as_text(columns: Sequence[Any], names: Sequence[str]) -> Any:
    """Arrow columns as dictionary-encoded text."""
    import pyarrow as pa
    from pyarrow import compute

    texts = []
    for name, column in zip(names, columns, strict=True):
        if pa.types.is_floating(column.type) and compute.any(compute.is_inf(column)).as_py():
            raise SeriesError(f"column {name!r} holds infinite numbers; give each value a label, or leave it missing")
        if pa.types.is_duration(column.type):
            lengths = column.cast(pa.duration("us"), safe=False).cast(pa.int64()).to_pylist()
            column = pa.chunked_array(
                [pa.array([None if us is None else clock(us / 1e6) for us in lengths], pa.string())]
            )
        text = column.cast(pa.string())
        texts.append(text if pa.types.is_dictionary(text.type) else text.dictionary_encode())
    return pa.table(texts, names=[str(i) for i in range(len(texts))])


def _present(name: str, names: Sequence[str]) -> str:
    """The name of a column as it is in the file, where it was asked for by the name that it had in the last version."""
    present = present_name(name)
    if name in names or present not in names:
        return name
    warn_renamed(f"column {name!r}", repr(present))
    return present


def _shown(names: Sequence[str]) -> str:
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return ", ".join(name if len(name) <= 60 else f"{name[:57]}..." for name in names[:_SHOWN]) + more
