"""Figures of a benchmark: medians over its blocks with their quartiles, beside those measured before."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from jointattn_mj.io.files import write_whole

QUARTILES = "quartiles"
"""Key of the file under which the quartiles stand."""
FORMER = Path(__file__).parents[2] / "experiments" / "benchmark.json"
INSTALLED = Path(__file__).parents[1] / "experiments" / "benchmark.json"
"""Where the committed figures lie: in the checkout, or as the wheel carries them."""


class Figures:
    """Figures by name, in the order in which they were added.

    Attributes:
        values: Medians; words for what is no number; None for what could not be measured.
        quartiles: A quarter of the blocks lie below the first and above the second; of figures with several blocks.
    """

    def __init__(self) -> None:
        self.values: dict[str, float | str | None] = {}
        self.quartiles: dict[str, tuple[float, float]] = {}

    def add(self, name: str, blocks: np.ndarray | list[float] | float | str | None) -> None:
        """Add a figure: its value in each block (n,), or the figure itself."""
        if blocks is None or isinstance(blocks, str):
            self.values[name] = blocks
            return
        measured = np.atleast_1d(np.asarray(blocks, float))
        self.values[name] = float(np.median(measured))
        if len(measured) > 1:
            low, high = np.percentile(measured, (25, 75)).tolist()
            self.quartiles[name] = low, high

    def merge(self, other: "Figures") -> None:
        """Add the figures of another benchmark."""
        self.values |= other.values
        self.quartiles |= other.quartiles

    def text(self, before: Mapping[str, Any]) -> str:
        """A table to read: name, median, quartiles, and what was measured before.

        Args:
            before: Earlier figures by name, as ``committed`` gives them.
        """
        rows = [("", "now", "quartiles", "committed")]
        for name, value in self.values.items():
            low, high = self.quartiles.get(name, (None, None))
            spread = "" if low is None else f"{low:.3g} to {high:.3g}"
            rows.append((name, _shown(value), spread, _shown(before[name]) if name in before else "-"))
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
        return "\n".join(line.rstrip() for line in lines)

    def write(self, path: Path) -> None:
        """Write all as JSON, whole or not at all.

        Raises:
            OutputError: The file cannot be written.
        """
        text = json.dumps(self.values | {QUARTILES: self.quartiles}, indent=1) + "\n"
        write_whole(path, lambda temporary: temporary.write_text(text))

    @classmethod
    def read(cls, path: Path) -> "Figures":
        """Read the figures that ``write`` has written to ``path``."""
        figures = cls()
        figures.values = json.loads(path.read_text("utf-8"))
        figures.quartiles = {name: (low, high) for name, (low, high) in figures.values.pop(QUARTILES).items()}  # type: ignore[union-attr]
        return figures


def committed() -> dict[str, Any]:
    """The figures that were measured before the present version; none where they are not there."""
    for path in (FORMER, INSTALLED):
        if path.exists():
            figures: dict[str, Any] = json.loads(path.read_text("utf-8"))
            return figures
    return {}


def _shown(value: float | str | None) -> str:
    if value is None:
        return "not installed"
    return value.partition(" (")[0] if isinstance(value, str) else f"{value:.3g}"
