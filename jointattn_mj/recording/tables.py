"""The two tables of a session: one row a frame, one row a gaze shift; written as Parquet.

Frames go into one flat array that is allocated once, so that memory stays flat and a frame costs microseconds.
Candidates and phases are numbers there and names in the file.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from jointattn_mj.recording.files import write_whole
from jointattn_mj.robots.gaze_follower import GazeFollower, GazeShift
from jointattn_mj.referee import Judgement, Moment
from jointattn_mj.scene.camera import off_centre, pixels_of_points
from jointattn_mj.scene.caregiver import FRAME_S, Phase
from jointattn_mj.scene.world import World

PHASES = tuple(Phase)
_PHASE_NUMBER = {phase: number for number, phase in enumerate(PHASES)}
_FIXED = (
    "phase", "target", "held", "pan_deg", "tilt_deg", "head_moves", "rendered", "attended", "looked", "landed",
    "face_error_px", "iterations",
)  # fmt: skip
_PER_CANDIDATE = ("seen", "x_px", "y_px", "moves", "really_moves", "saliency", "motion", "interest")
_BOOL = ("head_moves", "rendered", "looked", "landed", "seen", "moves", "really_moves")


class FrameTable:
    """One row a frame. Numbers are float32; what a frame has no value for is NaN."""

    def __init__(self, frames: int, objects: tuple[str, ...], face_above_deg_s: float, object_above_m_s: float):
        """``face_above_deg_s`` and ``object_above_m_s``: speeds from which on something really moves."""
        self.candidates = (*objects, "face")
        self.frames = 0
        self._above = face_above_deg_s, object_above_m_s
        self._start = {name: len(_FIXED) + i * len(self.candidates) for i, name in enumerate(_PER_CANDIDATE)}
        self._values = np.full((frames, len(_FIXED) + len(_PER_CANDIDATE) * len(self.candidates)), np.nan, np.float32)

    def add(self, world: World, robot: GazeFollower, rendered: bool, head: np.ndarray) -> None:
        """Write down this frame: the world as it is, and what the robot made of it."""
        row, caregiver, width = self._values[self.frames], world.caregiver, len(self.candidates)
        percept, attention = robot.percept, robot.attention
        face_error = np.nan
        begin = len(_FIXED)
        if percept is not None:
            face = pixels_of_points(world.candidate_points()[-1:], head)[0]
            face_error = np.hypot(*(percept.px[-1] - face))
            seen = begin + width
            row[begin:seen] = percept.seen
            row[seen : seen + 2 * width] = percept.px.T.ravel()
            row[seen + 2 * width : seen + 3 * width] = percept.moves
            row[seen + 3 * width : seen + 4 * width] = world.moving(*self._above)
        row[begin + 5 * width : begin + 6 * width] = attention.saliency
        row[begin + 6 * width : begin + 7 * width] = attention.motion
        row[begin + 7 * width : begin + 8 * width] = attention.interest()
        row[: len(_FIXED)] = (
            _PHASE_NUMBER[caregiver.phase],
            np.nan if caregiver.target is None else caregiver.target,
            np.nan if caregiver.held is None else caregiver.held,
            head[0],
            head[1],
            robot.shift is not None,
            rendered,
            np.nan if robot.attended is None else robot.attended,
            percept is not None,
            robot.landed is not None,
            face_error,
            robot.iterations,
        )
        self.frames += 1

    def column(self, name: str, candidate: int | None = None) -> np.ndarray:
        """(frames,) values of a column so far; per-candidate columns need the candidate's number."""
        index = _FIXED.index(name) if candidate is None else self._start[name] + candidate
        return self._values[: self.frames, index]

    def table(self) -> pa.Table:
        """The table with names for numbers."""
        columns: dict[str, pa.Array] = {"time_s": pa.array(np.arange(self.frames) * FRAME_S)}
        for name in _FIXED:
            values = self.column(name)
            if name == "phase":
                columns[name] = _named(values, PHASES)
            elif name in ("target", "held", "attended"):
                columns[name] = _named(values, self.candidates)
            else:
                columns[name] = _typed(name, values)
        for name in _PER_CANDIDATE:
            for number, candidate in enumerate(self.candidates):
                columns[f"{candidate}_{name}"] = _typed(name, self.column(name, number))
        return pa.table(columns)


@dataclass(frozen=True)
class ShiftRow:
    """One gaze shift. Angles in degrees; times in seconds of the session; None where a column does not apply."""

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
    """Object nearest to the centre of view after landing; this and all below only for face-to-object shifts."""
    nearest_off_deg: float | None
    on_nothing: bool | None
    success_at_launch: bool | None
    success_at_landing: bool | None
    success: bool | None
    pan_error_deg: float | None
    """Landing minus the caregiver's target at launch, pan alone (infants follow horizontal displacement first)."""
    tilt_error_deg: float | None
    map_error_deg: float | None
    """Angle between the learner's suggestion at launch and the caregiver's target then, whoever commanded."""


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
    return pa.Table.from_pylist([vars(row) for row in rows], schema=pa.schema(fields))


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
