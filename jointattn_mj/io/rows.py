"""Rows of numbers that are only ever appended: the log of a run, whose memory does not grow with it.

A store keeps its rows in memory until it is attached to a run's folder. From then on full buffers go to the end of a
file there, and a checkpoint holds what waits in the buffer, the number of rows in the file, and their checksum. What a
process wrote after its last checkpoint is cut off when that is gone on from. The file is the same however often a run
was stopped.
"""

import json
import os
import re
import shutil
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from jointattn_mj.errors import CheckpointError, OutputError
from jointattn_mj.guards.restored import check_array, check_whole

BUFFER_BYTES = 1 << 16
"""Rows that wait in memory take at most so much, or are one row."""
PART_BYTES = 1 << 20
"""What is read at a time where everything is gone through."""
MOST_COLUMNS, MOST_STORED = 1 << 24, 1 << 40
"""Columns and rows that a checkpoint may speak of."""


def log_folder(out: Path) -> Path:
    """Where a run with results in ``out`` keeps its rows until it has ended."""
    return out / "log"


def forget_log(out: Path) -> None:
    """Delete the rows of a run whose results are complete."""
    shutil.rmtree(log_folder(out), ignore_errors=True)


def summary_of_ended(out: Path) -> dict[str, Any] | None:
    """What a run in ``out`` has left if its results are complete; its log, where a kill has spared it, goes.

    Raises:
        CheckpointError: The summary cannot be read.
    """
    path = out / "summary.json"
    try:
        summary: dict[str, Any] = json.loads(path.read_text("utf-8"))
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise CheckpointError(f"this run has ended, and {path} cannot be read ({error}); begin it anew") from error
    forget_log(out)
    return summary


def spans(total: int, rows: int) -> Iterator[tuple[int, int]]:
    """First row and end of each part of ``rows`` rows, the last one shorter; one empty part where there are none."""
    for first in range(0, max(total, 1), rows):
        yield first, min(first + rows, total)


class RowStore:
    """Rows of ``columns`` numbers of one kind, (rows, columns).

    ``len`` counts them. Pickling stores all rows of a store in memory, and of one with a file those that are not in it.
    """

    def __init__(self, name: str, kind: DTypeLike, columns: int):
        """``name`` is that of the file; ``kind`` is the numbers' NumPy type."""
        self.name = name
        self._buffer = np.empty((_room(np.dtype(kind), columns), columns), kind)
        self._filled = 0
        self._full: list[np.ndarray] = []  # buffers before this one, without a file
        self._stored = self._checksum = 0  # rows before the buffer; CRC-32 of those in the file
        self._path: Path | None = None

    def __len__(self) -> int:
        """Rows so far."""
        return self._stored + self._filled

    @property
    def columns(self) -> int:
        """Numbers in a row."""
        return self._buffer.shape[1]

    @property
    def dtype(self) -> np.dtype:
        """Type of the numbers."""
        return self._buffer.dtype

    def beside(self, name: str, columns: int) -> "RowStore":
        """A new store of such numbers, in the same folder if this one has a file."""
        store = RowStore(name, self._buffer.dtype, columns)
        if self._path is not None:
            store.attach(self._path.parent)
        return store

    def free(self) -> np.ndarray:
        """Room (n, columns) for the next rows, at least one; ``fill`` says how many of them have been written.

        Raises:
            OutputError: The file cannot be written.
        """
        if self._filled == len(self._buffer):
            self._empty_buffer()
        return self._buffer[self._filled :]

    def fill(self, rows: int) -> None:
        """Take in the first ``rows`` rows of what ``free`` gave."""
        if not 0 <= rows <= len(self._buffer) - self._filled:
            raise ValueError(f"{len(self._buffer) - self._filled} rows are free in {self.name}; got {rows}")
        self._filled += rows

    def append(self, row: Any) -> None:
        """Add one row (columns,).

        Raises:
            OutputError: The file cannot be written.
        """
        self.free()[0] = row
        self.fill(1)

    def read(self, first: int = 0, last: int | None = None) -> np.ndarray:
        """A copy (last - first, columns) of the rows from ``first`` to before ``last``, by default to the end.

        Raises:
            CheckpointError: They are in a file that is not attached, or no longer whole.
        """
        last = len(self) if last is None else last
        if not 0 <= first <= last <= len(self):
            raise IndexError(f"{self.name} has {len(self)} rows; got {first} to {last}")
        rows = np.empty((last - first, self.columns), self._buffer.dtype)
        stored = max(min(last, self._stored) - first, 0)
        if stored:
            self._read_stored(first, rows[:stored])
        rows[stored:] = self._buffer[max(first - self._stored, 0) : max(last - self._stored, 0)]
        return rows

    def column(self, number: int, first: int = 0, last: int | None = None) -> np.ndarray:
        """Values (last - first,) of a column.

        Args:
            number: Of the column.
            first: First row.
            last: Row before which it ends; by default all that there are.
        """
        last = len(self) if last is None else last
        values = np.empty(last - first, self._buffer.dtype)
        for start, end in spans(last - first, max(1, PART_BYTES // self._row_bytes)):
            values[start:end] = self.read(first + start, first + end)[:, number]
        return values

    def attach(self, folder: Path) -> None:
        """Keep the rows in a file in ``folder`` from now on; a store from a checkpoint goes on with the file it had.

        Raises:
            CheckpointError: The file has not got the rows that the checkpoint refers to.
            OutputError: The file cannot be written.
        """
        path = folder / f"{self.name}.rows"
        full, self._full = self._full, []
        if full:
            self._stored = 0
        self._verify(path)
        if self._stored:
            try:
                os.truncate(path, self._stored * self._row_bytes)
            except OSError as error:
                raise _cannot_write(path, error) from error
        self._path = path
        for buffer in full:
            self._write(buffer)

    def recall(self, folder: Path) -> None:
        """Take the rows that a checkpoint refers to back into memory; the file in ``folder`` stays as it is.

        Raises:
            CheckpointError: The file has not got them.
        """
        path = folder / f"{self.name}.rows"
        self._verify(path)
        self._path = path
        full = [self.read(first, last) for first, last in spans(self._stored, len(self._buffer)) if first < last]
        self._path, self._full, self._checksum = None, full, 0

    @property
    def _row_bytes(self) -> int:
        return self._buffer.itemsize * self.columns

    def _empty_buffer(self) -> None:
        if self._path is not None:
            self._write(self._buffer)
        elif self._stored == len(self._full) * len(self._buffer):
            self._full.append(self._buffer)
            self._stored += len(self._buffer)
            self._buffer = np.empty_like(self._buffer)
        else:
            raise self._not_attached()
        self._filled = 0

    def _write(self, rows: np.ndarray) -> None:
        """Put rows behind the others in the file, which is made for the first ones; what a failed attempt or another
        run has left there is overwritten."""
        assert self._path is not None
        try:
            self._path.parent.mkdir(exist_ok=True)
            with self._path.open("r+b" if self._stored else "wb") as file:
                file.seek(self._stored * self._row_bytes)
                file.write(rows.data)
        except OSError as error:
            raise _cannot_write(self._path, error) from error
        self._checksum = zlib.crc32(rows.data, self._checksum)
        self._stored += len(rows)

    def _read_stored(self, first: int, rows: np.ndarray) -> None:
        """Fill ``rows`` with those from ``first`` on, all of which lie before the buffer."""
        if self._path is not None:
            with self._path.open("rb") as file:
                file.seek(first * self._row_bytes)
                if file.readinto(rows.data) != rows.nbytes:
                    raise _not_whole(self._path)
            return
        if not self._full:
            raise self._not_attached()
        size, done = len(self._buffer), 0
        while done < len(rows):
            number, row = divmod(first + done, size)
            part = self._full[number][row : row + len(rows) - done]
            rows[done : done + len(part)] = part
            done += len(part)

    def _verify(self, path: Path) -> None:
        """That the file begins with the rows that were stored."""
        left, checksum = self._stored * self._row_bytes, 0
        if not left:
            return
        try:
            with path.open("rb") as file:
                while left and (part := file.read(min(left, PART_BYTES))):
                    left, checksum = left - len(part), zlib.crc32(part, checksum)
        except OSError as error:
            raise CheckpointError(f"cannot read {path}, which its checkpoint needs: {error.strerror}") from error
        if left or checksum != self._checksum:
            raise _not_whole(path)

    def _not_attached(self) -> CheckpointError:
        return CheckpointError(f"the rows of {self.name} are in the folder of a run; attach it, or resume that run")

    def __getstate__(self) -> dict[str, Any]:
        """Arrays and plain values; nothing of where the file is."""
        return {
            "name": self.name,
            "shape": self._buffer.shape,
            "kind": self._buffer.dtype.str,
            "waiting": self._buffer[: self._filled].copy(),
            "full": list(self._full),
            "stored": self._stored,
            "checksum": self._checksum,
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Raises ValueError where the state is none that ``__getstate__`` gives: it may come from somebody else."""
        name, kind, waiting, full = state["name"], np.dtype(state["kind"]), state["waiting"], list(state["full"])
        room, columns = state["shape"]
        check_whole("columns", columns, 1, MOST_COLUMNS)
        if not re.fullmatch(r"\w+", name) or kind.kind not in "iuf" or room != _room(kind, columns):
            raise ValueError(f"{name!r} with buffers of {room} x {columns} {kind} is no store of rows")
        check_array("waiting", waiting, (min(len(waiting), room), columns), kind)
        for buffer in full:
            check_array("full", buffer, (room, columns), kind)
        check_whole("stored", state["stored"], 0, MOST_STORED)
        check_whole("checksum", state["checksum"], 0, 2**32 - 1)
        if full and state["stored"] != room * len(full):
            raise ValueError(f"{name} has not got the {state['stored']} rows that it says")
        self.name, self._path, self._full = name, None, full
        self._buffer, self._filled = np.empty((room, columns), kind), len(waiting)
        self._buffer[: self._filled] = waiting
        self._stored, self._checksum = state["stored"], state["checksum"]


def _room(kind: np.dtype, columns: int) -> int:
    """Rows of a buffer."""
    return max(1, BUFFER_BYTES // (columns * kind.itemsize))


def _not_whole(path: Path) -> CheckpointError:
    return CheckpointError(f"{path} is damaged, or shorter than its checkpoint says; begin anew in another folder")


def _cannot_write(path: Path, error: OSError) -> OutputError:
    return OutputError(f"cannot write {path}: {error.strerror or error}; free space or choose another folder")
