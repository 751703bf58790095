"""The table of percepts of a video, percepts.parquet: one row a frame.

Memory holds some seconds of it. Rows are kept in the log of the run (see ``io.rows``), and become a Parquet file when
the run ends or is stopped.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa

from jointattn_mj.footage.reader import RATE
from jointattn_mj.footage.watcher import Watcher
from jointattn_mj.gaze_following.columns import described
from jointattn_mj.io.parquet import write_parts
from jointattn_mj.io.rows import RowStore, log_folder

RECENT = 10 * RATE
"""Least number of recent rows in memory, if there are so many."""
BLOCK = 60 * RATE
"""Rows of a row group of the file; the first group has ``RECENT`` more."""
FRAME = {
    "time_s": "time in the video; frames are a thirtieth of a second apart",
    "image": "number of the video's image that the frame shows, from 0",
    "fresh": "the image is another one than in the frame before; if not, the percept is that of the frame before",
    "attended": "candidate that is fixated; while attention shifts, the last one fixated",
    "head_moves": "attention shifts; for as long as the robot's head would turn, interest does not change",
    "face_fit": "score of the face, 0..1; with the detector templates, its correlation with the best view, -1..1",
}
PER_CANDIDATE = ("saliency", "motion", "interest", "visible", "moves", "x_px", "y_px")
_KINDS = {
    "image": pa.int32(),
    "fresh": pa.bool_(),
    "head_moves": pa.bool_(),
    "visible": pa.bool_(),
    "moves": pa.bool_(),
}


class PerceptLog:
    """The table of percepts so far; locations are pixels of the robot's image.

    Attributes:
        candidates: Names of the objects and, last, the face.
        rows: All rows, for a checkpoint.
    """

    def __init__(self, out: Path, candidates: tuple[str, ...], rows: RowStore | None = None):
        """Make an empty table, or go on with the rows of a checkpoint.

        Args:
            out: Folder of the run.
            candidates: Names of the objects and, last, the face.
            rows: Rows of a checkpoint.

        Raises:
            OutputError: The log cannot be written.
            CheckpointError: The log lacks rows of the checkpoint.
        """
        self.candidates = candidates
        names: list[tuple[str, int | None]] = [(name, None) for name in FRAME if name != "time_s"]
        names += [(name, k) for name in PER_CANDIDATE for k in range(len(candidates))]
        self._index = {name: index for index, name in enumerate(names)}
        self.rows = RowStore("percepts", np.float64, len(names)) if rows is None else rows
        self.rows.attach(log_folder(out))
        recent = self.rows.read(max(0, self.frames - RECENT))
        self._recent = np.full((2 * RECENT, len(names)), np.nan)
        self._recent[: len(recent)] = recent
        self._filled = len(recent)

    @property
    def frames(self) -> int:
        """Rows so far."""
        return len(self.rows)

    def add(self, watcher: Watcher, image: int, fresh: bool) -> None:
        """Add the row of a frame.

        Args:
            watcher: Has perceived the frame.
            image: Number of the video's image.
            fresh: Whether that is another one than in the frame before.

        Raises:
            OutputError: The log cannot be written.
        """
        attention, percept, fix = watcher.attention, watcher.percept, watcher.perceiver.fix
        if percept is None:
            raise ValueError("the watcher has perceived no frame yet")
        attended = np.nan if watcher.attended is None else watcher.attended
        frame = (image, fresh, attended, watcher.goal is not None, fix.score)
        interest = (attention.saliency, attention.motion, attention.interest)
        row = np.concatenate([frame, *interest, percept.visible, percept.moves, *percept.px.T])
        self.rows.append(row)
        if self._filled == len(self._recent):
            self._recent[:RECENT] = self._recent[RECENT:]
            self._filled = RECENT
        self._recent[self._filled] = row
        self._filled += 1

    def column(self, name: str, candidate: int | None = None) -> np.ndarray:
        """Values (frames,) of a column in the last frames, at least ``RECENT`` where there were so many."""
        return self._recent[: self._filled, self._index[name, candidate]]

    def write(self, path: Path, start_s: float = 0.0) -> None:
        """Write all rows as a Parquet file.

        Args:
            path: The file.
            start_s: Time of the first frame, s.

        Raises:
            OutputError: It cannot be written.
        """
        write_parts(path, self._parts(start_s))

    def _parts(self, start_s: float) -> Iterator[pa.Table]:
        first = 0
        while first < self.frames or first == 0:
            last = min(self.frames, first + BLOCK if first else RECENT + BLOCK)
            yield self._table(first, self.rows.read(first, last), start_s)
            first = max(last, 1)

    def _table(self, first: int, values: np.ndarray, start_s: float) -> pa.Table:
        columns: dict[str, pa.Array] = {"time_s": pa.array(start_s + np.arange(first, first + len(values)) / RATE)}
        for (name, candidate), index in self._index.items():
            label = name if candidate is None else f"{self.candidates[candidate]}_{name}"
            columns[label] = self._array(name, values[:, index])
        return described(pa.table(columns), FRAME, self.candidates)

    def _array(self, name: str, values: np.ndarray) -> pa.Array:
        missing = np.isnan(values)
        if name == "attended":
            numbers = pa.array(np.where(missing, 0, values).astype(np.int8), mask=missing)
            return pa.DictionaryArray.from_arrays(numbers, pa.array(self.candidates))
        if name in _KINDS:
            return pa.array(values.astype(np.int32)).cast(_KINDS[name])
        return pa.array(values.astype(np.float32), mask=missing)
