"""What a session before a person is at, in words and numbers for the page."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from jointattn_mj.footage.sessions.session import FootageSessionRun
from jointattn_mj.gaze_following.agent import GazeFollower
from jointattn_mj.gaze_following.gate import softmax
from jointattn_mj.gaze_following.learners import Locations
from jointattn_mj.gaze_following.session import FRAMES_PER_SECOND
from jointattn_mj.gaze_following.shifts import COMMANDERS, ShiftRow
from jointattn_mj.scene.camera import direction_of, off_centre

RECENT, LISTED = 20, 8
"""Gaze shifts over which shares are taken, and that are listed."""


class LiveState:
    """Follows a session, and says what it is at."""

    def __init__(self, colours: Sequence[str]):
        """``colours``: of the candidates on the page, the face last."""
        self._colours = colours
        self._rows: list[ShiftRow] = []
        self._read = 0
        self._of_face: dict[str, float] = {}

    def of(self, session: FootageSessionRun, phase: str) -> dict[str, Any]:
        """The state now.

        Args:
            session: Between two frames.
            phase: What it is doing, in words.
        """
        new = session.shifts[self._read :]
        self._read += len(new)
        self._rows = [*self._rows, *(row for row in new if row.face_to_object)][-RECENT:]
        robot, camera = session.robot, session.camera_times()
        reading = _reading(robot, np.degrees(session.wide.head_angles()), session.names)
        if reading is not None:
            self._of_face = reading
        judged = [row.success for row in self._rows if row.success is not None]
        by_learner = [row.commanded_by == COMMANDERS[1] for row in self._rows]
        return {
            "phase": phase,
            "seconds": session.frame / FRAMES_PER_SECOND,
            "of_seconds": session.total / FRAMES_PER_SECOND if session.config.minutes is not None else None,
            "attended": None if robot.attended is None else session.names[robot.attended],
            "turning": robot.shift is not None,
            "candidates": self._candidates(session),
            "reads": [{"name": name, "share": share} for name, share in self._of_face.items()],
            "pairs": robot.iterations,
            "learner_decides": robot.gate_probability if robot.iterations else 0.0,
            "by_learner": float(np.mean(by_learner)) if by_learner else None,
            "success": float(np.mean(judged)) if judged else None,
            "judged": len(judged),
            "shifts": [_shift(row, session.started_s) for row in self._rows[-LISTED:]][::-1],
            "camera": None if camera is None else camera.plain(),
        }

    def _candidates(self, session: FootageSessionRun) -> list[dict[str, Any]]:
        attention, percept = session.robot.attention, session.robot.percept
        most = float(max(attention.interest.max(), 1e-9))
        return [
            {
                "name": name,
                "colour": self._colours[k],
                "interest": float(attention.interest[k]) / most,
                "visible": None if percept is None else bool(percept.visible[k]),
                "moves": False if percept is None else bool(percept.moves[k]),
            }
            for k, name in enumerate(session.names)
        ]


def _shift(row: ShiftRow, started_s: float) -> dict[str, Any]:
    followed = None if row.success is None else bool(row.success)
    learned = row.commanded_by == COMMANDERS[1]
    return {"seconds": row.landing_s - started_s, "to": row.reached, "learned": learned, "followed": followed}


def _reading(robot: GazeFollower, head: np.ndarray, names: tuple[str, ...]) -> dict[str, float] | None:
    """Where the robot would say that the face looks: a share of each object in view; None where it sees no face."""
    percept = robot.percept
    if percept is None or not percept.visible[robot.face] or not robot.iterations:
        return None
    numbers = np.flatnonzero(percept.visible[: robot.face])
    if not len(numbers):
        return None
    face = direction_of(percept.px[robot.face], head)
    turns = np.array([direction_of(percept.px[k], head) - face for k in numbers])
    activations = robot.face_input()
    if robot.config.learner.code == "cross_situational":
        shares = softmax(robot.config.gaze.gate_sharpness * robot.learner.score(activations, Locations(turns)))
    else:
        learned = robot.learner.predict(activations)
        off = np.array([off_centre(turn, learned) for turn in turns])
        shares = softmax(-off / robot.config.gaze.centre_radius_deg)
    return {names[k]: float(share) for k, share in zip(numbers, shares, strict=True)}
