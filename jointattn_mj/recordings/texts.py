"""Columns of text as numbers of few different texts."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Union

import numpy as np


@dataclass(frozen=True, eq=False)
class Texts:
    """A column of text, of which each row has the number of its text."""

    numbers: np.ndarray
    """int64 (rows,); -1 where there is none."""
    names: list[str]
    """The different texts; none is empty."""

    @classmethod
    def of(cls, column: Union["Texts", Sequence[str | None]]) -> "Texts":
        """A column from its texts; None where there is none."""
        if isinstance(column, Texts):
            return column
        number: dict[str, int] = {}
        numbers = [-1 if text is None else number.setdefault(text, len(number)) for text in column]
        return cls(np.array(numbers, np.int64), list(number))

    @classmethod
    def numbered(cls, numbers: np.ndarray, names: Sequence[str]) -> "Texts":
        """A column from numbers of texts, of which some may be equal or empty; -1 stands for none."""
        number: dict[str, int] = {}
        same = [number.setdefault(name, len(number)) if name else -1 for name in names]
        return cls(np.array([*same, -1], np.int64)[numbers], list(number))

    @classmethod
    def joined(cls, columns: Sequence["Texts"], between: str) -> "Texts":
        """Texts of several columns together; those without one are left out."""
        if len(columns) == 1:
            return columns[0]
        key = np.zeros(len(columns[0]), np.int64)
        for column in columns:
            key = np.unique(key * (len(column.names) + 1) + column.numbers + 1, return_inverse=True)[1]
        first = np.unique(key, return_index=True)[1]
        names = [between.join(text for column in columns if (text := column.at(int(row)))) for row in first]
        return cls.numbered(key, names)

    @classmethod
    def stacked(cls, columns: Sequence["Texts"]) -> "Texts":
        """Columns below one another."""
        names = [name for column in columns for name in column.names]
        start = np.cumsum([0, *(len(column.names) for column in columns)])
        numbers = [
            np.where(column.numbers < 0, -1, column.numbers + first)
            for column, first in zip(columns, start[:-1], strict=True)
        ]
        return cls.numbered(np.concatenate(numbers), names)

    def __len__(self) -> int:
        return len(self.numbers)

    def at(self, row: int) -> str:
        """The text of a row; empty where there is none."""
        number = self.numbers[row]
        return self.names[number] if number >= 0 else ""

    def take(self, rows: np.ndarray) -> "Texts":
        """Some rows."""
        return Texts(self.numbers[rows], self.names)

    def with_default(self, text: str) -> "Texts":
        """The same with ``text`` where there is none."""
        return Texts.numbered(np.where(self.numbers < 0, len(self.names), self.numbers), [*self.names, text])

    def among(self, names: Sequence[str]) -> np.ndarray:
        """Numbers (rows,) of the texts in another list, which has them all."""
        number = {name: i for i, name in enumerate(names)}
        numbers: np.ndarray = np.array([*(number.get(name, -1) for name in self.names), -1], np.int64)[self.numbers]
        return numbers
