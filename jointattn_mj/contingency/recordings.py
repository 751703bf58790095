"""Reads observations from a CSV or Parquet file: a row a step, a column a variable, labels of any kind."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any, Literal

import numpy as np

from jointattn_mj.contingency.series import joint
from jointattn_mj.errors import SeriesError

Missing = Literal["error", "break"]
"""What a missing value does: it is an ``error``, or it ends the recording there, and the next row begins another."""

_WHOLE = re.compile(r"-?(0|[1-9]\d*)")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


@dataclass(frozen=True)
class Recordings:
    """Variables as series of codes, and what the codes are called."""

    columns: dict[str, list[np.ndarray]]
    """Codes by variable, recording by recording."""
    labels: dict[str, tuple[str, ...]]
    """Label of each code by variable: numbers ascending, other labels in the order of the alphabet."""
    groups: list[int]
    """Which recording each of the series' arrays belongs to: pieces of one that was cut have the same number."""
    rows: int
    """Rows of the file."""
    cut: int = 0
    """Rows with missing values, at which recordings were cut."""
    alone: int = 0
    """Rows without missing values that take part in no transition, as nothing stands before or after them."""

    @property
    def transitions(self) -> int:
        """Steps that have a next one."""
        return sum(len(part) - 1 for part in next(iter(self.columns.values())))

    def joined(self, names: Sequence[str]) -> tuple[list[np.ndarray], tuple[str, ...]]:
        """Several variables taken as one, and the labels of the combinations that occur; one is taken as it is."""
        if len(names) == 1:
            return self.columns[names[0]], self.labels[names[0]]
        codes = joint(*(self.columns[name] for name in names))
        parts = codes if isinstance(codes, list) else [codes]
        first = np.unique(np.concatenate(parts), return_index=True)[1]
        single = [np.concatenate(self.columns[name])[first] for name in names]
        combinations = zip(
            *(np.array(self.labels[name])[at] for name, at in zip(names, single, strict=True)), strict=True
        )
        return parts, tuple(" & ".join(combination) for combination in combinations)

    def notes(self) -> tuple[str, ...]:
        """What a reader should know about rows that could not be used as they are."""
        notes = []
        if self.cut:
            notes.append(f"{self.cut} of {self.rows} rows have missing values; recordings were cut there")
        if self.alone:
            notes.append(f"{self.alone} rows have nothing before or after them and take part in no transition")
        return tuple(notes)


def read_recordings(
    path: Path | str, columns: Sequence[str], recording: str | None = None, missing: Missing = "error"
) -> Recordings:
    """Read ``columns`` of a CSV file with a header, separated by commas, semicolons or tabs, as the header is; or of a
    Parquet file, whose name ends with .parquet.

    Rows with the same value of the column ``recording`` are one recording, in their order in the file. Labels lose
    blanks around them; 1.0 is the same as 1. What pyarrow takes as missing is missing: nothing, NA, NaN, null and such.

    Raises:
        SeriesError: No such file or column, nothing in it, missing values, numbers with fractions, or no transition.
    """
    wanted = list(dict.fromkeys([*columns, *([recording] if recording is not None else [])]))
    table = _read(Path(path), wanted)
    rows = table.num_rows
    if rows < 2:
        raise SeriesError(f"{path} has {rows or 'no'} row{'s' * (rows != 1)} below its header; at least 2 are needed")
    coded = {name: _coded(table.column(i), name) for i, name in enumerate(wanted)}
    absent = np.zeros(rows, bool)
    for name in wanted:
        gaps = coded[name][0] < 0
        if gaps.any() and (missing == "error" or name == recording):
            hint = "" if name == recording else "; fill them in, or cut recordings there with --missing break"
            raise SeriesError(
                f"column {name!r} of {path} has {int(gaps.sum())} missing values, the first in data row "
                f"{int(np.argmax(gaps)) + 1}{hint}"
            )
        absent |= gaps
    pieces = _pieces(absent, None if recording is None else coded[recording][0])
    kept = [piece for piece in pieces if len(piece) > 1]
    if not kept:
        raise SeriesError(f"{path} has no two rows in one recording, so nothing follows anything")
    return Recordings(
        {name: [coded[name][0][piece] for piece in kept] for name in columns},
        {name: coded[name][1] for name in columns},
        [0 if recording is None else int(coded[recording][0][piece[0]]) for piece in kept],
        rows,
        int(absent.sum()),
        sum(len(piece) == 1 for piece in pieces),
    )


def _read(path: Path, wanted: list[str]) -> Any:
    """The wanted columns as a table of dictionary-encoded text."""
    import pyarrow as pa  # here, so that measures of arrays do without it
    from pyarrow import csv

    if path.suffix == ".parquet":
        return _read_parquet(path, wanted)
    try:
        parse = csv.ParseOptions(delimiter=_delimiter(path), ignore_empty_lines=False, newlines_in_values=True)
        try:
            header = csv.open_csv(path, parse_options=_lenient(csv, parse)).schema.names
        except pa.ArrowInvalid as error:
            if "mpty CSV" in str(error):
                raise SeriesError(f"{path} is empty; expected a header and a row for every step") from error
            raise
        found = _found(header, wanted, path)
        text = pa.dictionary(pa.int32(), pa.string())
        table = csv.read_csv(
            path,
            read_options=csv.ReadOptions(use_threads=False),  # errors then name the row
            parse_options=parse,
            convert_options=csv.ConvertOptions(
                include_columns=found, column_types=dict.fromkeys(found, text), strings_can_be_null=True
            ),
        )
    except pa.ArrowInvalid as error:
        raise SeriesError(f"{path} is no CSV file that can be read: {' '.join(str(error).split())}") from error
    except OSError as error:
        raise SeriesError(f"cannot read {path}: {error.strerror or error}") from error
    return table.slice(0, table.num_rows - min(_blank_lines_at_the_end(path), table.num_rows))


def _read_parquet(path: Path, wanted: list[str]) -> Any:
    import pyarrow as pa
    from pyarrow import parquet

    try:
        with path.open("rb") as file:
            found = _found(parquet.read_schema(file).names, wanted, path)
            columns = [
                column.cast(pa.string()) for column in parquet.read_table(file, columns=found).select(found).columns
            ]
    except (pa.ArrowInvalid, pa.ArrowNotImplementedError) as error:
        raise SeriesError(f"{path} is no Parquet file that can be read: {' '.join(str(error).split())}") from error
    except OSError as error:
        raise SeriesError(f"cannot read {path}: {error.strerror or error}") from error
    return pa.table([column.dictionary_encode() for column in columns], names=found)


def _lenient(csv: Any, parse: Any) -> Any:
    """The same, for the header only: rows of another length are complained about later."""
    return csv.ParseOptions(delimiter=parse.delimiter, newlines_in_values=True, invalid_row_handler=lambda row: "skip")


def _delimiter(path: Path) -> str:
    """The most frequent one of the header."""
    with path.open("rb") as file:
        header = file.readline()
    return max(",;\t", key=lambda mark: header.count(mark.encode()))


def _found(header: list[str], wanted: list[str], path: Path) -> list[str]:
    """Names as the file spells them, with the blanks around them."""
    stripped = [name.strip() for name in header]
    for name in wanted:
        if stripped.count(name) == 0:
            raise SeriesError(f"{path} has no column {name!r}; its columns are: {', '.join(stripped)}")
        if stripped.count(name) > 1:
            raise SeriesError(f"{path} has {stripped.count(name)} columns {name!r}; names must differ")
    return [header[stripped.index(name)] for name in wanted]


def _blank_lines_at_the_end(path: Path) -> int:
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - 4096))
        tail = file.read()
    return max(0, tail[len(tail.rstrip(b"\r\n")) :].count(b"\n") - 1)


def _coded(column: Any, name: str) -> tuple[np.ndarray, tuple[str, ...]]:
    """Codes (rows,), -1 where missing, and their labels."""
    array = column.unify_dictionaries().combine_chunks()
    if hasattr(array, "num_chunks"):  # some versions keep the wrapper
        array = array.chunk(0)
    indices = array.indices.fill_null(-1).to_numpy(zero_copy_only=False).astype(np.int64)
    written = [label.strip() for label in array.dictionary.to_pylist()]
    labels = _ordered({label for label in written if label}, name)
    number = {label: i for i, label in enumerate(dict.fromkeys(labels.values()))}
    codes = np.array([number[labels[label]] if label else -1 for label in written] + [-1], np.int64)
    return codes[indices], tuple(number)


def _ordered(labels: set[str], name: str) -> dict[str, str]:
    """From labels as written to labels as they count, in order."""
    if not labels or not all(_WHOLE.fullmatch(label) for label in labels):
        if not all(_NUMBER.fullmatch(label) for label in labels) or any(re.match(r"[+-]?0\d", one) for one in labels):
            return {label: label for label in sorted(labels)}
        numbers = {label: Decimal(label) for label in labels}
        for label in sorted(labels):
            if numbers[label] != numbers[label].to_integral_value():
                raise SeriesError(
                    f"column {name!r} holds numbers with fractions, such as {label}; sort them into bins first, "
                    "and give each bin a label"
                )
        return {label: str(int(numbers[label])) for label in sorted(labels, key=numbers.__getitem__)}
    return {label: label for label in sorted(labels, key=int)}


def _pieces(absent: np.ndarray, recording: np.ndarray | None) -> list[np.ndarray]:
    """Row numbers of each stretch without gaps in one recording."""
    order = np.arange(len(absent)) if recording is None else np.argsort(recording, kind="stable")
    breaks = np.zeros(len(absent), bool)
    breaks[1:] = absent[order][1:] != absent[order][:-1]
    if recording is not None:
        breaks[1:] |= np.diff(recording[order]) != 0
    pieces = np.split(order, np.flatnonzero(breaks))
    return [piece for piece in pieces if not absent[piece[0]]]
