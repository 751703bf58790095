"""The tables of a result: columns by name, which become pandas or polars by one call."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from jointattn_mj.errors import OutputError
from jointattn_mj.io.extras import extra
from jointattn_mj.io.parquet import write_parquet
from jointattn_mj.options import check_argument, meant, warn_of_old

WIDTH = 100
"""Characters of a table's repr."""


@dataclass(frozen=True, eq=False, repr=False)
class Table:
    """A table that does not change, kept in Arrow's columns.

    ``table["column"]`` is a NumPy array, ``len(table)`` the number of rows, ``"column" in table`` asks for a column,
    iterating gives the names of the columns. Two tables are equal if their names and values are; missing values and
    NaN equal themselves.

    Attributes:
        arrow: The same table as ``pyarrow.Table``; its schema says what each column means.

    Examples:
        >>> import pyarrow
        >>> from jointattn_mj.io.table import Table
        >>> table = Table(pyarrow.table({"time_s": [0.0, 0.5], "name": ["red", None]}))
        >>> table
        Table(2 rows, 2 columns: time_s, name)
        >>> table["time_s"]
        array([0. , 0.5])
    """

    arrow: pa.Table

    def __post_init__(self) -> None:
        """Check what it is made of.

        Raises:
            ConfigError: It is no table of pyarrow.
        """
        check_argument("arrow", self.arrow, pa.Table, "a pyarrow.Table, such as pyarrow.table({...})")

    @classmethod
    def read(cls, path: Path, new_names: Mapping[str, str] | Callable[[str], str] | None = None) -> "Table":
        """Read a Parquet file.

        Args:
            path: The file.
            new_names: Names of columns as an earlier version wrote them, and what they are called now; or what makes
                the name of today from any. Old names in the file are told of by a ``RenamedWarning``.

        Returns:
            The table, its columns by their names of today.

        Raises:
            OutputError: There is no such file, or it is no Parquet file.

        Examples:
            >>> import pyarrow
            >>> from pathlib import Path
            >>> from jointattn_mj.io.table import Table
            >>> Table(pyarrow.table({"turn": [1, 2]})).write(Path("old.parquet"))
            >>> Table.read(Path("old.parquet")).columns
            ('turn',)
        """
        try:
            arrow = pq.read_table(path)
        except FileNotFoundError as error:
            raise OutputError(f"there is no table at {path}; give the folder of a finished run") from error
        except (OSError, pa.ArrowException) as error:
            said = " ".join(str(error).split())  # pyarrow ends lines
            raise OutputError(f"cannot read the table {path} ({said}); give the folder of a finished run") from error
        if new_names is None:
            return cls(arrow)
        names = [new_names(name) if callable(new_names) else new_names.get(name, name) for name in arrow.column_names]
        old = [f"{now} ({before})" for before, now in zip(arrow.column_names, names, strict=True) if before != now]
        if old:
            warn_of_old(f"{path} has columns by old names, read by their new ones: {', '.join(old)}")
        return cls(arrow.rename_columns(names))

    def write(self, path: Path) -> None:
        """Write a Parquet file, whole or not at all.

        Args:
            path: The file; one that is there is replaced.

        Raises:
            OutputError: The file cannot be written.

        Examples:
            >>> import pyarrow
            >>> from pathlib import Path
            >>> from jointattn_mj.io.table import Table
            >>> table = Table(pyarrow.table({"time_s": [0.0, 0.5]}))
            >>> table.write(Path("times.parquet"))
            >>> Table.read(Path("times.parquet")) == table
            True
        """
        write_parquet(path, self.arrow)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(self.arrow.column_names)

    def describe(self, column: str) -> str:
        """Say what a column means.

        Args:
            column: Name of a column.

        Returns:
            The meaning, with its unit; empty where its writer has not said so.

        Raises:
            KeyError: There is no such column.

        Examples:
            >>> from jointattn_mj import Session
            >>> Session(minutes=0.1, perception="state").run().frames.describe("attended")
            'candidate that the robot fixates; while its head turns, the last one fixated'
        """
        self._check(column)
        metadata: dict[bytes, bytes] = self.arrow.field(column).metadata or {}
        return metadata.get(b"description", b"").decode()

    def to_pandas(self) -> Any:
        """Give the table as ``pandas.DataFrame``.

        Returns:
            The data frame, with the same columns.

        Raises:
            ExtraError: The package pandas is not installed.

        Examples:
            >>> import pyarrow
            >>> from jointattn_mj.io.table import Table
            >>> Table(pyarrow.table({"time_s": [0.0, 0.5]})).to_pandas().shape
            (2, 1)
        """
        extra("tables", "pandas")
        return self.arrow.to_pandas()

    def to_polars(self) -> Any:
        """Give the table as ``polars.DataFrame``.

        Returns:
            The data frame, with the same columns.

        Raises:
            ExtraError: The package polars is not installed.

        Examples:
            >>> import pyarrow
            >>> from jointattn_mj.io.table import Table
            >>> Table(pyarrow.table({"time_s": [0.0, 0.5]})).to_polars().shape  # doctest: +SKIP
            (2, 1)
        """
        return extra("tables", "polars").from_arrow(self.arrow)

    def __getitem__(self, column: str) -> np.ndarray:
        """Values (rows,) of a column: missing numbers are NaN, other missing values None in an array of objects.

        Raises:
            KeyError: There is no such column.
        """
        self._check(column)
        values: np.ndarray = _decoded(self.arrow[column]).to_numpy()
        return values

    def __contains__(self, column: object) -> bool:
        return column in self.arrow.column_names

    def __iter__(self) -> Iterator[str]:
        return iter(self.arrow.column_names)

    def __len__(self) -> int:
        return int(self.arrow.num_rows)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Table):
            return NotImplemented
        return (
            self.columns == other.columns
            and len(self) == len(other)
            and all(_same(_decoded(self.arrow[name]), _decoded(other.arrow[name])) for name in self)
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        start = f"Table({len(self)} rows, {len(self.columns)} columns: "
        names, room = ", ".join(self.columns), WIDTH - len(start) - 1
        return f"{start}{names if len(names) <= room else names[: room - 3] + '...'})"

    def _check(self, column: str) -> None:
        if column not in self:
            raise KeyError(f"no column {column!r}{meant(column, self.columns)}; there are {', '.join(self.columns)}")


def _decoded(values: pa.ChunkedArray) -> pa.ChunkedArray:
    """Words in place of numbers of words."""
    return values.cast(values.type.value_type) if pa.types.is_dictionary(values.type) else values


def _same(column: pa.ChunkedArray, other: pa.ChunkedArray) -> bool:
    if column.equals(other):
        return True
    if not (pa.types.is_floating(column.type) and column.type == other.type):
        return False
    missing = column.is_null().equals(other.is_null())
    return missing and np.array_equal(column.to_numpy(), other.to_numpy(), equal_nan=True)
