"""The table of frames of a session before a person, frames.parquet: one row a frame."""

from collections.abc import Iterator

import numpy as np
import pyarrow as pa

from jointattn_mj.footage.sessions.truth import NO_OBJECT
from jointattn_mj.footage.sessions.world import WideWorld
from jointattn_mj.gaze_following.agent import GazeFollower
from jointattn_mj.gaze_following.columns import CANDIDATE, FRAME, described
from jointattn_mj.io.rows import RowStore, spans

NOT_AN_OBJECT = "none"
"""Target of a person who looks at none of the objects."""
MEANINGS = {
    **{name: FRAME[name] for name in ("attended", "head_moves", "rendered", "perceived", "landed", "iterations")},
    "time_s": "time by the clock of the video, or since the camera was opened",
    "image": "number of the wide image that the frame shows, from 0",
    "target": "where the person looks, as coded: an object, or none of them; missing where it is not known",
    "pan_deg": "robot's head, pan",
    "tilt_deg": "robot's head, tilt",
}
_PER_FRAME = (
    "time_s", "image", "target", "attended", "head_moves", "rendered", "perceived", "landed", "iterations", "pan_deg",
    "tilt_deg",
)  # fmt: skip
_PER_CANDIDATE = ("saliency", "motion", "interest", "visible", "moves", "x_px", "y_px")
_BOOL = ("head_moves", "rendered", "perceived", "landed", "visible", "moves")
_WHOLE = ("image", "iterations")


class WideFrames:
    """One row a frame, float64; what a frame has no value for is NaN.

    Attributes:
        candidates: Names of the objects and, last, the face.
    """

    def __init__(self, objects: tuple[str, ...]):
        """Make an empty table; ``objects``: their names."""
        self.candidates = (*objects, "face")
        names: list[tuple[str, int | None]] = [(name, None) for name in _PER_FRAME]
        names += [(name, k) for name in _PER_CANDIDATE for k in range(len(self.candidates))]
        self._index = {name: index for index, name in enumerate(names)}
        self.rows = RowStore("frames", np.float64, len(names))

    def __repr__(self) -> str:
        """In one line: its length and its candidates."""
        return f"WideFrames({self.frames} frames; {', '.join(self.candidates)})"

    @property
    def frames(self) -> int:
        """Frames so far."""
        return len(self.rows)

    @property
    def index(self) -> dict[tuple[str, int | None], int]:
        """Number of the column of each name, and of each candidate where it has one."""
        return self._index

    def add(self, world: WideWorld, robot: GazeFollower, rendered: bool, head: np.ndarray) -> None:
        """Add the row of this frame.

        Args:
            world: What is seen.
            robot: The agent, after it has acted.
            rendered: Whether an image of the robot was cut out.
            head: Direction of the robot's head (2,), rad.

        Raises:
            OutputError: The file that the table is kept in cannot be written.
        """
        percept, attention, target = robot.percept, robot.attention, world.looks_at()
        row = self.rows.free()[0]
        row[: len(_PER_FRAME)] = (
            world.wide_frame.time_s,
            world.wide_frame.number,
            np.nan if target < NO_OBJECT else target,
            np.nan if robot.attended is None else robot.attended,
            robot.shift is not None,
            rendered,
            percept is not None,
            robot.landed is not None,
            robot.iterations,
            *np.degrees(head),
        )
        perceived = np.full((4, len(self.candidates)), np.nan)
        if percept is not None:
            perceived[0], perceived[1], perceived[2:] = percept.visible, percept.moves, percept.px.T
        values = (attention.saliency, attention.motion, attention.interest, *perceived)
        row[len(_PER_FRAME) :] = np.concatenate(values)
        self.rows.fill(1)

    def column(self, name: str, candidate: int | None = None) -> np.ndarray:
        """Values (frames,) of a column so far; a column of candidates needs the candidate's number."""
        return self.rows.column(self._index[name, candidate])

    def table(self) -> pa.Table:
        """All frames, with names in place of numbers."""
        return WideFramesPart(self, 0, self.frames).table()

    def parts(self, frames: int) -> Iterator["WideFramesPart"]:
        """All frames in parts of ``frames`` each; one empty part where there are none."""
        return (WideFramesPart(self, first, last) for first, last in spans(self.frames, frames))

    def named(self, first: int, last: int) -> pa.Table:
        """The frames from ``first`` to before ``last``, with names in place of numbers."""
        values, columns = self.rows.read(first, last), {}
        for (name, candidate), number in self._index.items():
            label = name if candidate is None else f"{self.candidates[candidate]}_{name}"
            columns[label] = self._typed(name, values[:, number])
        meanings = {f"{candidate}_{name}": CANDIDATE[name] for candidate in self.candidates for name in _PER_CANDIDATE}
        return described(pa.table(columns), {**MEANINGS, **meanings})

    def _typed(self, name: str, values: np.ndarray) -> pa.Array:
        missing = np.isnan(values)
        known = np.where(missing, 0, values)
        if name in ("target", "attended"):
            numbers = np.where(known < 0, len(self.candidates), known).astype(np.int8)
            return pa.DictionaryArray.from_arrays(pa.array(numbers, mask=missing), [*self.candidates, NOT_AN_OBJECT])
        if name in _BOOL:
            return pa.array(known.astype(bool), mask=missing)
        if name in _WHOLE:
            return pa.array(known.astype(np.int32))
        return pa.array(values if name == "time_s" else values.astype(np.float32), mask=missing)


class WideFramesPart:
    """Successive frames of a table."""

    def __init__(self, frames: WideFrames, first: int, last: int):
        self._frames, self._first, self._last = frames, first, last

    def table(self) -> pa.Table:
        """These frames, with names in place of numbers."""
        return self._frames.named(self._first, self._last)
