"""Curves of the robot's interest and learning, who looks at what, the map of faces, and a line for each gaze shift."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import rerun as rr

from jointattn_mj.adapters.rerun import entities as at
from jointattn_mj.adapters.rerun.rows import Rows
from jointattn_mj.gaze_following.film.composer import DOES, verdict_in_words
from jointattn_mj.gaze_following.film.panels import face_cells, lit
from jointattn_mj.gaze_following.session import FRAMES_PER_MINUTE, SessionRun
from jointattn_mj.gaze_following.shifts import ShiftRow
from jointattn_mj.gaze_following.summary import rate_of_success
from jointattn_mj.video.paint import FAINT, GREEN, LEARNED, Colour

TURNS = "turns its head"
_FACES_PX = 216  # side of the image of the map, pixels


class AgentCurves:
    """Logs curves at every frame, and all else when it changes."""

    def __init__(self, rows: Rows, session: SessionRun, inks: list[Colour]):
        log = rows.log
        self._rows, self._names = rows, session.names
        self._counted = len(session.shifts)
        self._last: dict[str, Any] = {}
        self._known: np.ndarray | None = None
        self._cells = face_cells(session.robot.som, _FACES_PX)
        curves = {
            at.INTEREST: rr.SeriesLines(names=session.names, colors=inks),
            at.HEAD: rr.SeriesLines(names=["pan", "tilt"]),
            at.GATE: rr.SeriesLines(names=["learner decides"], colors=[LEARNED]),
            at.SUCCESS: rr.SeriesLines(names=["success"], colors=[GREEN]),
        }
        looks = rr.StateConfiguration(values=[*session.names, TURNS], colors=[*inks, FAINT])
        for path, look in (curves | {at.ROBOT_LOOKS: looks, at.PERSON_LOOKS: looks}).items():
            log.log(path, look, static=True)

    def write(self, session: SessionRun) -> None:
        """Log a frame."""
        robot = session.robot
        self._rows.add(at.INTEREST, rr.Scalars, scalars=robot.attention.interest.copy())
        self._rows.add(at.HEAD, rr.Scalars, scalars=np.degrees(session.world.head_angles()))
        self._write_doings(session)
        chance = robot.gate_probability
        self._write(at.GATE, chance, lambda: rr.Scalars(chance))
        self._write_map(session)
        for row in session.shifts[self._counted :]:
            self._rows.log.log(at.SHIFTS, rr.TextLog(_in_words(row), level="INFO" if row.face_to_object else "TRACE"))
        if len(session.shifts) > self._counted:
            self._counted = len(session.shifts)
            self._write_success(session)

    def _write_doings(self, session: SessionRun) -> None:
        """Log who looks at what, and what the caregiver does."""
        robot, caregiver = session.robot, session.world.caregiver
        looks = TURNS if robot.shift is not None else self._name(robot.attended)
        target = self._name(caregiver.target)
        before, after = DOES[caregiver.phase]
        does = " ".join(word for word in (before, target, after) if word)
        for path, state in ((at.ROBOT_LOOKS, looks), (at.PERSON_LOOKS, target), (at.PERSON_DOES, does)):
            self._write(path, state, partial(rr.StateChange, state=[state]))

    def _name(self, number: int | None) -> str:
        return "" if number is None else self._names[number]

    def _write_map(self, session: SessionRun) -> None:
        """Log the map's activations when the robot turns away from a face."""
        shift, som = session.robot.shift, session.robot.som
        known = None if shift is None else shift.activations
        if known is None or known is self._known or known.size != len(som.weights):  # a learner may read something else
            return
        self._known = known
        sheet = known.reshape(som.config.rows, som.config.columns).astype(np.float32)
        tensor = rr.Tensor(sheet, dim_names=("row", "column"), value_range=(0, float(sheet.max())))
        self._rows.log.log(at.ACTIVATIONS, tensor)
        self._rows.log.log(at.FACES, rr.Image(lit(self._cells, known, sheet.shape)).compress(jpeg_quality=85))

    def _write_success(self, session: SessionRun) -> None:
        """Log the rate of success (eq. 6.9) up to now; later shifts do not change it."""
        counts = session.shifts.column("face_to_object") == 1
        if counts[-1]:
            now = np.array([session.frame / FRAMES_PER_MINUTE])
            landed, success = (session.shifts.column(name)[counts] for name in ("landing_s", "success"))
            rate = rate_of_success(now, landed / 60, success == 1)
            self._rows.log.log(at.SUCCESS, rr.Scalars(rate))

    def _write(self, path: str, value: Any, make: Callable[[], Any]) -> None:
        """Log what ``make`` gives if ``value`` has changed."""
        if path not in self._last or self._last[path] != value:
            self._last[path] = value
            self._rows.log.log(path, make())


def _in_words(row: ShiftRow) -> str:
    """How a gaze shift ended, in words."""
    if row.face_to_object:
        who = "learner" if row.commanded_by == "learner" else "eyes"
        return f"{'✓' if row.success else '✗'} {verdict_in_words(row)} ({who})"
    return f"{row.source or 'nothing'} → {row.reached or 'nothing'}"
