"""Log of every event's contingency; a row grows wider with each module that is made."""

from pathlib import Path

import numpy as np

from jointattn_mj.io.rows import RowStore


class ContingencyLog:
    """Rows with the measure of each event, one every ``every`` steps; ``len`` gives their number.

    The values are kept in one store for each number of events that there has been.
    """

    def __init__(self, every: int, events: int):
        """An empty log.

        Args:
            every: Steps from one row to the next.
            events: Number of events at the beginning.
        """
        self.every = every
        self._stages = [RowStore("contingency_1", np.float64, events)]

    def __len__(self) -> int:
        """Number of rows so far."""
        return sum(len(stage) for stage in self._stages)

    @property
    def events(self) -> int:
        """Number of events in the last rows."""
        return self._stages[-1].columns

    @property
    def dtype(self) -> np.dtype:
        """Type of the numbers."""
        return self._stages[-1].dtype

    def widen(self, events: int) -> None:
        """From now on a row has ``events`` values."""
        self._stages.append(self._stages[-1].beside(f"contingency_{len(self._stages) + 1}", events))

    def free(self) -> np.ndarray:
        """See ``RowStore``."""
        return self._stages[-1].free()

    def fill(self, rows: int) -> None:
        """See ``RowStore``."""
        self._stages[-1].fill(rows)

    def n_steps(self, first: int = 0, last: int | None = None) -> np.ndarray:
        """(last - first,) steps done when the rows from ``first`` to before ``last`` were written."""
        return (np.arange(first, len(self) if last is None else last) + 1) * self.every

    def values(self, first: int = 0, last: int | None = None) -> np.ndarray:
        """(last - first, events) rows from ``first`` to before ``last``; NaN before an event existed."""
        last = len(self) if last is None else last
        values = np.full((last - first, self.events), np.nan)
        begin = 0
        for stage in self._stages:
            start, end = max(first, begin), min(last, begin + len(stage))
            if start < end:
                part = stage.read(start - begin, end - begin)
                values[start - first : end - first, : part.shape[1]] = part
            begin += len(stage)
        return values

    def attach(self, folder: Path) -> None:
        """See ``RowStore``."""
        for stage in self._stages:
            stage.attach(folder)

    def recall(self, folder: Path) -> None:
        """See ``RowStore``."""
        for stage in self._stages:
            stage.recall(folder)
