"""A row for every frame of a video, as Parquet; however long the video, memory holds a minute of it.

The file is written under another name and put in place when it is closed.
"""

import os
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from jointattn_mj.errors import OutputError
from jointattn_mj.footage.reader import RATE
from jointattn_mj.footage.watcher import Watcher
from jointattn_mj.recording.columns import described

RECENT = 10 * RATE
"""Rows that can always be looked back at."""
BLOCK = 60 * RATE
"""Rows that are written at a time."""
FRAME = {
    "time_s": "time in the video; frames are a thirtieth of a second apart",
    "picture": "picture of the video that the frame shows, counted from 0",
    "fresh": "another one than in the frame before; what is perceived holds while a picture is shown",
    "attended": "candidate that is fixated, or was last while attention shifts",
    "head_moves": "attention shifts: as long as the robot's head would turn, interest does not change",
    "face_fit": "normalised cross-correlation of the face's best view, -1..1",
}
PER_CANDIDATE = ("saliency", "motion", "interest", "seen", "moves", "x_px", "y_px")
_KINDS = {
    "picture": pa.int32(),
    "fresh": pa.bool_(),
    "head_moves": pa.bool_(),
    "seen": pa.bool_(),
    "moves": pa.bool_(),
}


class PerceptLog:
    """The table of percepts, growing; places are pixels of the robot's picture."""

    def __init__(self, path: Path, candidates: tuple[str, ...]):
        """``candidates``: names of the objects and, last, the face.

        Raises:
            OutputError: The file cannot be written.
        """
        self.path, self.candidates = path, candidates
        self.frames = 0
        names: list[tuple[str, int | None]] = [(name, None) for name in FRAME if name != "time_s"]
        names += [(name, k) for name in PER_CANDIDATE for k in range(len(candidates))]
        self._index = {name: index for index, name in enumerate(names)}
        self._values = np.full((RECENT + BLOCK, len(names)), np.nan)
        self._filled = self._written = 0  # of the rows above
        self._temporary = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
        try:
            self._writer = pq.ParquetWriter(self._temporary, self._table(0, 0).schema, compression="zstd")
        except OSError as error:
            raise self._trouble(error) from error

    def add(self, watcher: Watcher, picture: int, fresh: bool) -> None:
        """Write down what the watcher made of this frame.

        Raises:
            OutputError: The file cannot be written.
        """
        if self._filled == len(self._values):
            self._write()
            self._values[:RECENT] = self._values[-RECENT:]
            self._filled = self._written = RECENT
        attention, percept, fix = watcher.attention, watcher.percept, watcher.perceiver.fix
        if percept is None:
            raise ValueError("a watcher that has seen nothing has nothing to write down")
        attended = np.nan if watcher.attended is None else watcher.attended
        row = (picture, fresh, attended, watcher.goal is not None, fix.score)
        self._values[self._filled] = np.concatenate(
            [row, attention.saliency, attention.motion, attention.interest, percept.seen, percept.moves, *percept.px.T]
        )
        self._filled += 1
        self.frames += 1

    def column(self, name: str, candidate: int | None = None) -> np.ndarray:
        """Values of a column in the last frames, at least ``RECENT`` where there were so many."""
        return self._values[: self._filled, self._index[name, candidate]]

    def close(self) -> None:
        """Write the rest and put the file in place.

        Raises:
            OutputError: It cannot be written.
        """
        try:
            self._write()
            self._writer.close()
            os.replace(self._temporary, self.path)
        except OSError as error:
            raise self._trouble(error) from error
        finally:
            self._temporary.unlink(missing_ok=True)

    def _write(self) -> None:
        try:
            self._writer.write_table(self._table(self._written, self._filled))
        except OSError as error:
            raise self._trouble(error) from error
        self._written = self._filled

    def _table(self, start: int, stop: int) -> pa.Table:
        times = (self.frames - self._filled + np.arange(start, stop)) / RATE
        columns: dict[str, pa.Array] = {"time_s": pa.array(times)}
        for (name, candidate), index in self._index.items():
            label = name if candidate is None else f"{self.candidates[candidate]}_{name}"
            columns[label] = self._array(name, self._values[start:stop, index])
        return described(pa.table(columns), FRAME, self.candidates)

    def _array(self, name: str, values: np.ndarray) -> pa.Array:
        missing = np.isnan(values)
        if name == "attended":
            numbers = pa.array(np.where(missing, 0, values).astype(np.int8), mask=missing)
            return pa.DictionaryArray.from_arrays(numbers, pa.array(self.candidates))
        if name in _KINDS:
            return pa.array(values.astype(np.int32)).cast(_KINDS[name])
        return pa.array(values.astype(np.float32), mask=missing)

    def _trouble(self, error: OSError) -> OutputError:
        return OutputError(f"cannot write {self.path}: {error.strerror or error}; free space or choose another --out")
