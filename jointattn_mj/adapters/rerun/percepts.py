"""The robot's percepts as boxes and arrows on its image, in its pixels, 320x240."""

from typing import Any

import numpy as np
import rerun as rr

from jointattn_mj.adapters.rerun.entities import FLOW, GOAL, VISIBLE
from jointattn_mj.adapters.rerun.rows import Rows
from jointattn_mj.gaze_following.agent import GazeFollower
from jointattn_mj.gaze_following.session import SessionRun
from jointattn_mj.perception.motion import Motion
from jointattn_mj.scene.camera import pixel_of
from jointattn_mj.video.paint import LEARNED, WHITE, Colour, paler
from jointattn_mj.video.percepts import FACE_HALF_PX, FLOW_FROM_PX, FLOW_GAIN, FLOW_TO_PX, OBJECT_HALF_PX

_AHEAD_DEG = 60.0  # goals further from the present direction are not drawn
_NOBODY = np.zeros(0, int)


class Percepts:
    """Logs detected candidates, with thicker boxes where they move; optical flow; and the goal of a gaze shift."""

    def __init__(self, rows: Rows, names: tuple[str, ...], inks: list[Colour]):
        self._rows, self._names = rows, np.array(names)
        self._inks = np.array(inks, np.uint8)
        self._pale = np.array([paler(ink) for ink in inks], np.uint8)
        self._half = np.array([OBJECT_HALF_PX] * (len(names) - 1) + [FACE_HALF_PX], np.float32)
        self._shown: dict[str, bool] = {}
        rows.log.log(VISIBLE, rr.Boxes2D.from_fields(show_labels=True), static=True)
        rows.log.log(FLOW, rr.Arrows2D.from_fields(radii=0.25), static=True)
        rows.log.log(GOAL, rr.Points2D.from_fields(radii=3.0, show_labels=True), static=True)

    def write(self, session: SessionRun) -> None:
        """Log a frame; there are no percepts while the head turns."""
        robot = session.robot
        self._write_visible(robot)
        self._write_flow(None if robot.percept is None else getattr(robot.perceiver, "motion", None))
        self._write_goals(robot, np.degrees(session.world.head_angles()))

    def _write_visible(self, robot: GazeFollower) -> None:
        percept = robot.percept
        visible = _NOBODY if percept is None else np.flatnonzero(percept.visible)
        px, moves = (np.zeros((0, 2)), _NOBODY) if percept is None else (percept.px, percept.moves)
        attended = visible == (-1 if robot.attended is None else robot.attended)
        half = self._half[visible] * np.where(attended, 1.25, 1.0)
        self._add(
            VISIBLE,
            rr.Boxes2D,
            centers=px[visible],
            half_sizes=np.column_stack([half, half]),
            colors=np.where(attended[:, None], np.array(WHITE, np.uint8), self._inks[visible]),
            radii=np.where(moves[visible], 1.0, 0.5),
            labels=self._names[visible],
        )

    def _write_flow(self, motion: Motion | None) -> None:
        blocks, flow, owner = np.zeros((0, 2)), np.zeros((0, 2)), _NOBODY
        if motion is not None and len(motion.flow):
            length = np.hypot(*motion.flow.T)
            drawn = length > FLOW_FROM_PX
            blocks, length, owner = motion.blocks[drawn], length[drawn, None], motion.owner[drawn]
            flow = motion.flow[drawn] / length * np.minimum(length * FLOW_GAIN, FLOW_TO_PX)
        self._add(FLOW, rr.Arrows2D, origins=blocks, vectors=flow, colors=self._pale[owner])

    def _write_goals(self, robot: GazeFollower, head: np.ndarray) -> None:
        """Log where the head turns; where the eyes decide, also where the learner would have turned it."""
        shift = robot.shift if robot.percept is None else None
        goals: list[tuple[np.ndarray, Colour, str]] = []
        if shift is not None and shift.by_learner:
            goals.append((shift.command, LEARNED, "goal, learned"))
        elif shift is not None:
            red, green, blue = self._inks[shift.chosen].tolist()
            goals.append((shift.command, (red, green, blue), "goal"))
            if shift.suggestion is not None:
                goals.append((shift.suggestion, LEARNED, "learned guess"))
        goals = [goal for goal in goals if np.abs(goal[0] - head).max() <= _AHEAD_DEG]
        self._add(
            GOAL,
            rr.Points2D,
            positions=np.array([pixel_of(direction, head) for direction, _, _ in goals]).reshape(-1, 2),
            colors=np.array([ink for _, ink, _ in goals], np.uint8).reshape(-1, 3),
            labels=[label for _, _, label in goals],
        )

    def _add(self, path: str, kind: type, **values: Any) -> None:
        """Add a row if there is something to show, or was in the row before."""
        present = len(next(iter(values.values()))) > 0
        if present or self._shown.get(path, False):
            self._rows.add(path, kind, **values)
        self._shown[path] = present
