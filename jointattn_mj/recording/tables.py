"""The two tables of a session: one row a frame, one row a gaze shift; written as Parquet.

Frames go into one flat array that is allocated once, so that memory stays flat and a frame costs microseconds.
Candidates and phases are numbers there and names in the file.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numba import njit

from jointattn_mj.recording.columns import FRAME, SHIFT, described
from jointattn_mj.recording.files import write_whole
from jointattn_mj.referee import Judgement, Moment
from jointattn_mj.robots.gaze_follower import GazeFollower, GazeShift
from jointattn_mj.scene.camera import off_centre, pixels_of_points
from jointattn_mj.scene.caregiver import FRAME_S, Phase
from jointattn_mj.scene.world import World

PHASES = tuple(Phase)
_PHASE_NUMBER = {phase: number for number, phase in enumerate(PHASES)}
_PER_FRAME = (
    "phase", "target", "held", "attended", "head_moves", "rendered", "looked", "landed", "iterations",
    "pan_deg", "tilt_deg", "face_yaw_deg", "face_pitch_deg",
)  # fmt: skip
_PER_OBJECT = ("x_m", "y_m", "z_m")
_PER_CANDIDATE = ("saliency", "motion", "interest", "seen", "moves", "x_px", "y_px")
_BOOL = ("head_moves", "rendered", "looked", "landed", "seen", "moves", "really_moves")


@njit(cache=True)
def _write(row, numbers, head, face, objects, saliency, motion, interest):
    """The columns up to interest, in their order; -1 stands for None. Compiled: it runs in every frame."""
    for column, number in enumerate(numbers):
        row[column] = number if number >= 0 else np.nan
    column = len(numbers)
    for angle in (head[0], head[1], face[0], face[1]):
        row[column] = np.degrees(angle)
        column += 1
    for k in range(len(objects)):
        for axis in range(3):
            row[column] = objects[k, axis]
            column += 1
    n = len(saliency)
    row[column : column + n] = saliency
    row[column + n : column + 2 * n] = motion
    row[column + 2 * n : column + 3 * n] = interest


@njit(cache=True)
def _write_percept(row, seen, moves, px):
    """The columns of what was seen, the last of a row."""
    n = len(seen)
    for k in range(n):
        row[k], row[n + k], row[2 * n + 2 * k], row[2 * n + 2 * k + 1] = seen[k], moves[k], px[k, 0], px[k, 1]


class FrameTable:
    """One row a frame. Numbers are float32; what a frame has no value for is NaN.

    What follows from the rest (how far off the face was seen, what really moved) is worked out when it is read.
    """

    def __init__(self, frames: int, objects: tuple[str, ...], face_above_deg_s: float, object_above_m_s: float):
        """``face_above_deg_s`` and ``object_above_m_s``: speeds from which on something really moves."""
        self.candidates = (*objects, "face")
        self.frames = 0
        self._above = (*[object_above_m_s] * len(objects), face_above_deg_s)
        self._face_point = np.full((1, 3), np.nan)
        names: list[tuple[str, int | None]] = [(name, None) for name in _PER_FRAME]
        names += [(name, k) for k in range(len(objects)) for name in _PER_OBJECT]
        names += [(name, k) for name in _PER_CANDIDATE[:-2] for k in range(len(objects) + 1)]
        names += [(name, k) for k in range(len(objects) + 1) for name in _PER_CANDIDATE[-2:]]
        self._index = {name: index for index, name in enumerate(names)}
        self._values = np.full((frames, len(names)), np.nan, np.float32)

    def add(self, world: World, robot: GazeFollower, rendered: bool, head: np.ndarray) -> None:
        """Write down this frame: the world as it is, and what the robot made of it. ``head`` (2,) in rad."""
        row, caregiver, percept, attention = self._values[self.frames], world.caregiver, robot.percept, robot.attention
        numbers = (
            _PHASE_NUMBER[caregiver.phase],
            -1 if caregiver.target is None else caregiver.target,
            -1 if caregiver.held is None else caregiver.held,
            -1 if robot.attended is None else robot.attended,
            int(robot.shift is not None),
            int(rendered),
            int(percept is not None),
            int(robot.landed is not None),
            robot.iterations,
        )
        _write(
            row, numbers, head, world.face_angles(), caregiver.objects,
            attention.saliency, attention.motion, attention.interest,
        )  # fmt: skip
        if percept is not None:
            _write_percept(row[-4 * len(percept.seen) :], percept.seen, percept.moves, percept.px)
        if self.frames == 0:
            self._face_point[:] = world.candidate_points()[-1]
        self.frames += 1

    def column(self, name: str, candidate: int | None = None) -> np.ndarray:
        """(frames,) values of a column so far; per-candidate columns need the candidate's number."""
        return self._values[: self.frames, self._index[name, candidate]]

    def face_error_px(self) -> np.ndarray:
        """Distance (frames,) of the face as seen from where it really was; NaN where it was not seen."""
        face = len(self.candidates) - 1
        heads = np.column_stack([self.column("pan_deg"), self.column("tilt_deg")])
        real = np.array([pixels_of_points(self._face_point, head)[0] for head in heads]).reshape(-1, 2)
        return np.hypot(self.column("x_px", face) - real[:, 0], self.column("y_px", face) - real[:, 1])

    def really_moves(self, candidate: int) -> np.ndarray:
        """Whether a candidate really moved since the last frame, (frames,) bool."""
        names = _PER_OBJECT if candidate < len(self.candidates) - 1 else ("face_yaw_deg", "face_pitch_deg")
        owner = candidate if candidate < len(self.candidates) - 1 else None
        path = np.column_stack([self.column(name, owner) for name in names])
        speed = np.linalg.norm(np.diff(path, axis=0, prepend=path[:1]), axis=1) / FRAME_S
        return speed > self._above[candidate]

    def table(self) -> pa.Table:
        """The table with names for numbers."""
        columns: dict[str, pa.Array] = {"time_s": pa.array(np.arange(self.frames) * FRAME_S)}
        for name, candidate in self._index:
            label = name if candidate is None else f"{self.candidates[candidate]}_{name}"
            values = self.column(name, candidate)
            if name == "phase":
                columns[label] = _named(values, PHASES)
            elif name in ("target", "held", "attended"):
                columns[label] = _named(values, self.candidates)
            else:
                columns[label] = _typed(name, values)
        columns["face_error_px"] = _typed("face_error_px", self.face_error_px())
        for number, name in enumerate(self.candidates):
            columns[f"{name}_really_moves"] = pa.array(self.really_moves(number))
        return described(pa.table(columns), FRAME, self.candidates)

    def __getstate__(self) -> dict[str, Any]:
        """Only the rows that are filled."""
        return {**self.__dict__, "_values": self._values[: self.frames], "_capacity": len(self._values)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        filled, capacity = state.pop("_values"), state.pop("_capacity")
        self.__dict__.update(state)
        self._values = np.full((capacity, filled.shape[1]), np.nan, np.float32)
        self._values[: len(filled)] = filled


@dataclass(frozen=True)
class ShiftRow:
    """One gaze shift; ``columns.SHIFT`` says what each column means. None where a column does not apply."""

    launch_s: float
    landing_s: float
    source: str | None
    chosen: str
    reached: str | None
    commanded_by: str
    phase_at_launch: str
    phase_at_landing: str
    target_at_launch: str | None
    target_at_landing: str | None
    start_pan_deg: float
    start_tilt_deg: float
    command_pan_deg: float
    command_tilt_deg: float
    landing_pan_deg: float
    landing_tilt_deg: float
    learned: bool
    iterations: int
    face_to_object: bool
    nearest: str | None
    nearest_off_deg: float | None
    on_nothing: bool | None
    success_at_launch: bool | None
    success_at_landing: bool | None
    success: bool | None
    pan_error_deg: float | None
    tilt_error_deg: float | None
    map_error_deg: float | None


def shift_row(
    shift: GazeShift,
    launch: Moment,
    landing: Moment,
    head: np.ndarray,
    iterations: int,
    names: tuple[str, ...],
    judgement: Judgement | None,
    success: bool | None,
    centre_radius_deg: float,
) -> ShiftRow:
    """The row of a shift that has just landed with the head at ``head``; ``names`` are the candidates'."""

    def name(number: int | None) -> str | None:
        return None if number is None else names[number]

    aimed = judgement is not None and launch.target is not None
    target = launch.directions[launch.target] if aimed else np.full(2, np.nan)
    return ShiftRow(
        launch_s=launch.frame * FRAME_S,
        landing_s=landing.frame * FRAME_S,
        source=name(shift.source),
        chosen=names[shift.chosen],
        reached=name(shift.reached),
        commanded_by="learner" if shift.by_learner else "visual_feedback",
        phase_at_launch=launch.phase,
        phase_at_landing=landing.phase,
        target_at_launch=name(launch.target),
        target_at_landing=name(landing.target),
        start_pan_deg=float(shift.start[0]),
        start_tilt_deg=float(shift.start[1]),
        command_pan_deg=float(shift.command[0]),
        command_tilt_deg=float(shift.command[1]),
        landing_pan_deg=float(head[0]),
        landing_tilt_deg=float(head[1]),
        learned=shift.learned,
        iterations=iterations,
        face_to_object=judgement is not None,
        nearest=name(judgement.nearest) if judgement else None,
        nearest_off_deg=judgement.distance if judgement else None,
        on_nothing=judgement.distance > centre_radius_deg if judgement else None,
        success_at_launch=judgement.at_launch if judgement else None,
        success_at_landing=judgement.at_landing if judgement else None,
        success=success,
        pan_error_deg=float(head[0] - target[0]) if aimed else None,
        tilt_error_deg=float(head[1] - target[1]) if aimed else None,
        map_error_deg=off_centre(target, shift.suggestion) if aimed and shift.suggestion is not None else None,
    )


def write_parquet(path: Path, table: pa.Table) -> None:
    """Write a table, whole or not at all."""
    write_whole(path, lambda temporary: pq.write_table(table, temporary, compression="zstd"))


def shift_table(rows: list[ShiftRow]) -> pa.Table:
    """All shifts as one table; it has its columns even without a row."""
    kinds = {"float": pa.float64(), "str": pa.string(), "bool": pa.bool_(), "int": pa.int64()}
    fields = [
        pa.field(name, kinds[str(getattr(kind, "__name__", kind)).split(" ")[0]])
        for name, kind in ShiftRow.__annotations__.items()
    ]
    return described(pa.Table.from_pylist([vars(row) for row in rows], schema=pa.schema(fields)), SHIFT)


def _named(values: np.ndarray, names: tuple[str, ...]) -> pa.Array:
    missing = np.isnan(values)
    numbers = pa.array(np.where(missing, 0, values).astype(np.int8), mask=missing)
    return pa.DictionaryArray.from_arrays(numbers, pa.array([str(name) for name in names]))


def _typed(name: str, values: np.ndarray) -> pa.Array:
    missing = np.isnan(values)
    if name in _BOOL:
        return pa.array(np.where(missing, 0, values).astype(bool), mask=missing)
    if name == "iterations":
        return pa.array(values.astype(np.int32))
    return pa.array(values, mask=missing)
