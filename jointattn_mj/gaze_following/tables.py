"""The larger table of a session, frames.parquet: one row a frame.

Candidates and phases are numbers in memory and names in the file.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa

from jointattn_mj.errors import ObservationError
from jointattn_mj.gaze_following.agent import GazeFollower
from jointattn_mj.gaze_following.attention import Attention
from jointattn_mj.gaze_following.columns import FRAME, described
from jointattn_mj.io.arrow import number_array, word_array
from jointattn_mj.io.compiled import njit
from jointattn_mj.io.parquet import write_parts
from jointattn_mj.io.rows import RowStore, spans
from jointattn_mj.perception.percept import Percept
from jointattn_mj.scene.camera import pixels_of_point
from jointattn_mj.scene.caregiver import FRAME_S, PHASES
from jointattn_mj.scene.tape import Tape
from jointattn_mj.scene.world import World

_PER_FRAME = (
    "phase", "target", "held", "attended", "head_moves", "rendered", "perceived", "landed", "iterations",
    "pan_deg", "tilt_deg", "face_yaw_deg", "face_pitch_deg",
)  # fmt: skip
_PER_OBJECT = ("x_m", "y_m", "z_m")
_PER_CANDIDATE = ("saliency", "motion", "interest", "visible", "moves", "x_px", "y_px")
GROUP = 1 << 16
"""Frames in a row group of the file: 36 minutes."""
_BOOL = ("head_moves", "rendered", "perceived", "landed", "visible", "moves", "really_moves")


@njit(cache=True)
def _write_row(
    row: np.ndarray, doing: np.ndarray, constant: np.ndarray, head: np.ndarray, face: np.ndarray, objects: np.ndarray,
    history: np.ndarray,
) -> None:  # fmt: skip
    """Write the columns of a row up to interest, in their order; -1 stands for None. ``history`` is (3, n + 1)."""
    does, n = len(doing), history.shape[1]
    first = does + len(constant)
    columns = first + 4 + 3 * (len(objects) + n)
    if columns > len(row) or len(objects) + 1 != n or len(history) < 3:
        raise ValueError("a row of the table is too short for the objects")
    for column in range(first):
        number = doing[column] if column < does else constant[column - does]
        row[column] = number if number >= 0 else np.nan
    for axis in range(2):
        row[first + axis], row[first + 2 + axis] = np.degrees(head[axis]), np.degrees(face[axis])
    column = first + 4
    for k in range(n - 1):
        for axis in range(3):
            row[column] = objects[k, axis]
            column += 1
    for kind in range(3):
        for k in range(n):
            row[column] = history[kind, k]
            column += 1


@njit(cache=True)
def _write_rows(
    rows: np.ndarray, doing: np.ndarray, constant: np.ndarray, head: np.ndarray, face: np.ndarray, objects: np.ndarray,
    history: np.ndarray,
) -> None:  # fmt: skip
    """Write these columns of some rows; ``history`` has one row for each, or one for all."""
    if not len(rows) == len(doing) == len(head) == len(face) == len(objects):
        raise ValueError("all parts of the table's rows must be as long")
    for t in range(len(rows)):
        after = history[min(t, len(history) - 1)]
        _write_row(rows[t], doing[t], constant, head[t], face[t], objects[t], after)


@njit(cache=True)
def _write_percept(row: np.ndarray, visible: np.ndarray, moves: np.ndarray, px: np.ndarray) -> None:
    """Write the columns of the percept, the last of a row."""
    n = len(visible)
    first = len(row) - 4 * n
    if first < 0 or n > len(moves) or n > len(px) or px.shape[1] < 2:
        raise ValueError("a row of the table is too short for the candidates")
    for k in range(n):
        row[first + k], row[first + n + k] = visible[k], moves[k]
        row[first + 2 * n + 2 * k], row[first + 2 * n + 2 * k + 1] = px[k, 0], px[k, 1]


@njit(cache=True)
def _write_percepts(rows: np.ndarray, visible: np.ndarray, moves: np.ndarray, px: np.ndarray) -> None:
    """Write the percepts of some rows."""
    if not len(rows) == len(visible) == len(moves) == len(px):
        raise ValueError("all parts of the table's rows must be as long")
    for t in range(len(rows)):
        _write_percept(rows[t], visible[t], moves[t], px[t])


def _constant(robot: GazeFollower, rendered: bool, percept: Percept | None) -> tuple[int, ...]:
    """The columns from ``attended`` to ``iterations``."""
    attended = -1 if robot.attended is None else robot.attended
    turns, landed = robot.shift is not None, robot.landed is not None
    return attended, turns, rendered, percept is not None, landed, robot.iterations


class FrameTable:
    """One row a frame. Numbers are float32; what a frame has no value for is NaN.

    What follows from the rest (how far off the face was seen, what really moved) is worked out when it is read.
    """

    def __init__(self, objects: tuple[str, ...], face_above_deg_s: float, object_above_m_s: float):
        """Make an empty table.

        Args:
            objects: Names of the objects.
            face_above_deg_s: Speed of the face, deg/s, from which it counts as truly moving.
            object_above_m_s: The same for an object, m/s.
        """
        self.candidates = (*objects, "face")
        self.above = (*[object_above_m_s] * len(objects), face_above_deg_s)
        self.face_point = np.full(3, np.nan)
        names: list[tuple[str, int | None]] = [(name, None) for name in _PER_FRAME]
        names += [(name, k) for k in range(len(objects)) for name in _PER_OBJECT]
        names += [(name, k) for name in _PER_CANDIDATE[:-2] for k in range(len(objects) + 1)]
        names += [(name, k) for k in range(len(objects) + 1) for name in _PER_CANDIDATE[-2:]]
        self.index = {name: index for index, name in enumerate(names)}
        self.rows = RowStore("frames", np.float32, len(names))

    def __repr__(self) -> str:
        """In one line: its length and its candidates."""
        return f"FrameTable({self.frames} frames, {self.frames * FRAME_S:.1f} s; {', '.join(self.candidates)})"

    @property
    def frames(self) -> int:
        """Frames so far."""
        return len(self.rows)

    def add(self, world: World, robot: GazeFollower, rendered: bool, head: np.ndarray) -> None:
        """Add the row of this frame.

        Args:
            world: State of the simulation.
            robot: The agent, after it has acted.
            rendered: Whether an image was rendered.
            head: Direction of the robot's head (2,), rad.

        Raises:
            OutputError: The file that the table is kept in cannot be written.
            ObservationError: Saliency, motion or interest of the agent's attention have no number for each candidate.
        """
        caregiver, percept, attention = world.caregiver, robot.percept, robot.attention
        row = self._free(world)[0]
        numbers = np.array([*caregiver.doing(), *_constant(robot, rendered, percept)], np.int64)
        _write_row(row, numbers[:3], numbers[3:], head, world.face_angles(), caregiver.objects, self.levels(attention))
        if percept is None:
            row[-4 * len(self.candidates) :] = np.nan
        else:
            _write_percept(row, percept.visible, percept.moves, percept.px)
        self.rows.fill(1)

    def levels(self, attention: Attention) -> np.ndarray:
        """Saliency, motion and interest of an attention model now, (3, n + 1).

        Raises:
            ObservationError: One of them has no number for each candidate.
        """
        values = np.empty((3, len(self.candidates)))
        try:
            values[0], values[1], values[2] = attention.saliency, attention.motion, attention.interest
        except (TypeError, ValueError) as error:
            raise ObservationError(
                f"saliency, motion and interest of the attention model: expected a number for each of the "
                f"{len(self.candidates)} candidates, {', '.join(self.candidates)}; {error}"
            ) from error
        return values

    @property
    def room(self) -> int:
        """How many rows ``add_all`` takes now."""
        return len(self.rows.free())

    def add_all(
        self, world: World, robot: GazeFollower, tape: Tape, history: np.ndarray, percepts: Percept | None
    ) -> None:
        """Add the rows of frames in which nothing was rendered or decided, as ``add`` does it one by one.

        Args:
            world: State of the simulation.
            robot: The agent, after them.
            tape: The frames.
            history: Saliency, motion and interest after each frame, (k, 3, n + 1), or (1, 3, n + 1) for all.
            percepts: Their percepts; None while the head turns.

        Raises:
            OutputError: The file that the table is kept in cannot be written.
        """
        rows = self._free(world)[: len(tape.doing)]
        constant = np.array(_constant(robot, False, percepts), np.int64)
        _write_rows(rows, tape.doing, constant, tape.head, tape.face, tape.objects[1:], history)
        if percepts is None:
            rows[:, -4 * len(self.candidates) :] = np.nan
        else:
            _write_percepts(rows, percepts.visible, percepts.moves, percepts.px)
        self.rows.fill(len(rows))

    def _free(self, world: World) -> np.ndarray:
        """Rows that are free; before the first row is written, where the face is gets noted."""
        if not self.frames:
            self.face_point[:] = world.candidate_points()[-1]  # it stays there
        return self.rows.free()

    def column(self, name: str, candidate: int | None = None) -> np.ndarray:
        """Values (frames,) of a column so far; a column of candidates needs the candidate's number."""
        return self.rows.column(self.index[name, candidate])

    def table(self) -> pa.Table:
        """All frames, with names in place of numbers."""
        return self.part().table()

    def part(self, first: int = 0, last: int | None = None) -> "FramePart":
        """The frames from ``first`` to before ``last``, by default to the end."""
        return FramePart(self, first, self.frames if last is None else last)

    def recent(self, frames: int) -> "FramePart":
        """The last ``frames`` frames, or as many as there are."""
        return self.part(max(0, self.frames - frames))

    def parts(self, frames: int) -> Iterator["FramePart"]:
        """All frames in parts of ``frames`` each; one empty part where there are none."""
        return (self.part(first, last) for first, last in spans(self.frames, frames))


class FramePart:
    """Successive frames of a table, from number ``first`` on; ``len`` counts them."""

    def __init__(self, table: FrameTable, first: int, last: int):
        self.first, self._table = first, table
        self._before = min(first, 1)  # 1 with the frame before them, for motion
        self._values = table.rows.read(first - self._before, last)

    def __len__(self) -> int:
        """Frames in it."""
        return len(self._values) - self._before

    def column(self, name: str, candidate: int | None = None) -> np.ndarray:
        """Values (frames,) of a column; a column of candidates needs the candidate's number."""
        return self._values[self._before :, self._table.index[name, candidate]]

    def face_error_px(self) -> np.ndarray:
        """Distance (frames,) of the face in the percept from its true pixel; NaN where it was not visible."""
        face = len(self._table.candidates) - 1
        heads = np.column_stack([self.column("pan_deg"), self.column("tilt_deg")])
        real = pixels_of_point(self._table.face_point, heads)
        error: np.ndarray = np.hypot(self.column("x_px", face) - real[:, 0], self.column("y_px", face) - real[:, 1])
        return error

    def really_moves(self, candidate: int) -> np.ndarray:
        """Whether a candidate truly moved since the frame before, (frames,) bool; False in the first of a session."""
        face = candidate == len(self._table.candidates) - 1
        names, owner = (("face_yaw_deg", "face_pitch_deg"), None) if face else (_PER_OBJECT, candidate)
        path = self._values[:, [self._table.index[name, owner] for name in names]]
        speed = np.linalg.norm(np.diff(path, axis=0, prepend=path[:1]), axis=1) / FRAME_S
        moves: np.ndarray = speed[self._before :] > self._table.above[candidate]
        return moves

    def table(self) -> pa.Table:
        """These frames, with names in place of numbers."""
        candidates = self._table.candidates
        columns: dict[str, pa.Array] = {"time_s": number_array((self.first + np.arange(len(self))) * FRAME_S)}
        for name, candidate in self._table.index:
            label = name if candidate is None else f"{candidates[candidate]}_{name}"
            values = self.column(name, candidate)
            if name == "phase":
                columns[label] = _named(values, PHASES)
            elif name in ("target", "held", "attended"):
                columns[label] = _named(values, candidates)
            else:
                columns[label] = _typed(name, values)
        columns["face_error_px"] = _typed("face_error_px", self.face_error_px())
        for number, name in enumerate(candidates):
            columns[f"{name}_really_moves"] = number_array(self.really_moves(number))
        return described(pa.table(columns), FRAME, candidates)


def write_frames(path: Path, frames: FrameTable) -> None:
    """Write all frames as Parquet, whole or not at all.

    Raises:
        OutputError: The file cannot be written.
    """
    write_parts(path, (part.table() for part in frames.parts(GROUP)))


def _named(values: np.ndarray, names: tuple[str, ...]) -> pa.Array:
    missing = np.isnan(values)
    indices = number_array(np.where(missing, 0, values).astype(np.int8), missing)
    return pa.DictionaryArray.from_arrays(indices, word_array(names))


def _typed(name: str, values: np.ndarray) -> pa.Array:
    missing = np.isnan(values)
    if name in _BOOL:
        return number_array(np.where(missing, 0, values).astype(bool), missing)
    if name == "iterations":
        return number_array(values.astype(np.int32))
    return number_array(values, missing)
