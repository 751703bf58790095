"""What the robot makes of its picture, drawn on it: candidates, flow, what is attended, and where the head turns.

Everything here is known to the robot. Coordinates of percepts are pixels of the picture, 320x240; the drawing is twice
that size. Candidates are numbered as in ``Percept``.
"""

import cv2
import numpy as np

from jointattn_mj.perception.percept import Percept
from jointattn_mj.recording.paint import (
    GREY,
    GROUND,
    LEARNED,
    WHITE,
    Box,
    Colour,
    brackets,
    disc,
    lines,
    paler,
    shade,
    width_of,
    write,
)
from jointattn_mj.robots.gaze_follower import GazeFollower, GazeShift
from jointattn_mj.scene.camera import CENTRE_X, CENTRE_Y, pixel_of
from jointattn_mj.session import Session

SCALE = 2
FACE_HALF_PX = 16  # half the side of the face's 32x32 patch
OBJECT_HALF_PX = 13
FLOW_GAIN = 5  # flow of two frames is a pixel or less: arrows are so many times longer
FLOW_FROM_PX = 0.12  # shorter flow is not drawn
FLOW_TO_PX = 6.0  # longest arrow, pixels of the picture
_BAR = 34  # height of the line of text below the picture's contents
_WAYS = ((1, 0), (-1, 0), (0, 1), (0, -1))
_AHEAD_DEG = 60.0  # farther from the present direction nothing is drawn


class RobotsView:
    """Draws the left picture of the video into ``box``."""

    def __init__(self, names: tuple[str, ...], inks: list[Colour], box: Box):
        self._names, self._inks, self._box = names, inks, box

    def draw(self, canvas: np.ndarray, session: Session) -> None:
        """The robot's picture with what it perceives in it, or with where its head turns."""
        area, robot = self._box.of(canvas), session.robot
        size = self._box.width, self._box.height
        area[:] = cv2.resize(session.world.picture(), size, interpolation=cv2.INTER_CUBIC)
        if robot.shift is not None and robot.percept is None:
            self._draw_turning(area, robot.shift, np.degrees(session.world.head_angles()))
        elif robot.percept is not None:
            self._draw_percept(area, robot, robot.percept)
        _draw_centre(area)
        self._draw_status(area, robot)

    def _draw_percept(self, area: np.ndarray, robot: GazeFollower, percept: Percept) -> None:
        self._draw_flow(area, robot)
        places = _place(percept.px)
        for number in np.flatnonzero(percept.seen).tolist():
            half, moves = self._half(number), percept.moves[number]
            brackets(area, places[number], half, self._inks[number], 3 if moves else 2)
            if number == robot.attended:
                disc(area, places[number], half * 1.5, WHITE, 2)
        for number in np.flatnonzero(percept.seen & percept.moves).tolist():
            _label(area, places[number] + np.array([0, self._half(number) + 4]), "moves", paler(self._inks[number]))

    def _half(self, number: int) -> int:
        """Half the side of a candidate's box in the drawing."""
        return (FACE_HALF_PX if number == len(self._names) - 1 else OBJECT_HALF_PX) * SCALE

    def _draw_flow(self, area: np.ndarray, robot: GazeFollower) -> None:
        """Arrows of optical flow in the colour of what they belong to; none with ``perception truth``."""
        motion = getattr(robot.perceiver, "motion", None)
        if motion is None or not len(motion.flow):
            return
        length = np.hypot(*motion.flow.T)
        sparse = np.round(motion.blocks / 4).sum(axis=1) % 2 == 0  # half of the blocks, as on a chequered board
        drawn = sparse & (length > FLOW_FROM_PX)
        start, length, owner = _place(motion.blocks[drawn]), length[drawn, None], motion.owner[drawn]
        arrow = motion.flow[drawn] / length * np.minimum(length * FLOW_GAIN, FLOW_TO_PX) * SCALE
        side = 0.28 * np.stack([-arrow[:, 1], arrow[:, 0]], axis=1)
        head = start + 0.6 * arrow
        paths = np.stack([start, start + arrow, head + side, start + arrow, head - side], axis=1)
        for number in np.unique(owner):
            lines(area, list(paths[owner == number]), paler(self._inks[number]))

    def _draw_turning(self, area: np.ndarray, shift: GazeShift, head: np.ndarray) -> None:
        """Nothing is perceived while the head turns: a dimmer picture with the goal, and the learner's guess."""
        shade(area, GROUND, 0.35)
        if shift.suggestion is not None and not shift.by_learner:
            self._draw_goal(area, shift.suggestion, head, LEARNED, "learned guess", -45)
        ink = LEARNED if shift.by_learner else self._inks[shift.chosen]
        self._draw_goal(area, shift.command, head, ink, "goal, learned" if shift.by_learner else "goal")

    @staticmethod
    def _draw_goal(
        area: np.ndarray, goal: np.ndarray, head: np.ndarray, ink: Colour, label: str, below: int = 26
    ) -> None:
        """A cross in a ring where ``goal`` (pan, tilt; deg) is in the present picture; its label so far below it."""
        if np.abs(goal - head).max() > _AHEAD_DEG:
            return
        centre = _place(pixel_of(goal, head))
        disc(area, centre, 17, ink, 2)
        lines(area, [centre + np.outer((10, 23), way) for way in _WAYS], ink, 2)
        _label(area, centre + np.array([0, below]), label, ink)

    def _draw_status(self, area: np.ndarray, robot: GazeFollower) -> None:
        """One line in plain words."""
        bar = area[-_BAR:]
        shade(bar, GROUND, 0.78)
        x, y = 12, 8
        shift = robot.shift
        if shift is not None and robot.percept is None:
            x = write(bar, x, y, "turns its head", WHITE, 15, True) + 6
            if shift.by_learner:
                write(bar, x, y, "to where somebody with this face looks, as it has learned", LEARNED, 15)
                return
            x = write(bar, x, y, "to", WHITE, 15) + 6
            x = write(bar, x, y, self._names[shift.chosen], self._inks[shift.chosen], 15, True) + 6
            write(bar, x, y, "that it has seen  (no perception meanwhile)", GREY, 15)
        elif robot.attended is None:
            write(bar, x, y, "looks at nothing in particular", GREY, 15)
        else:
            x = write(bar, x, y, "looks at", WHITE, 15, True) + 6
            x = write(bar, x, y, self._names[robot.attended], self._inks[robot.attended], 15, True) + 6
            if robot.attended == robot.face:
                write(bar, x, y, "(what does it look at?)", GREY, 15)


def _place(pixel: np.ndarray) -> np.ndarray:
    """Where pixels (..., 2) of the robot's picture are in the drawing."""
    return (np.asarray(pixel, float) + 0.5) * SCALE - 0.5


def _label(area: np.ndarray, top: np.ndarray, text: str, ink: Colour) -> None:
    """Small text on a dark plate, centred below a point."""
    width = width_of(text, 13) + 8
    x, y = round(float(top[0])) - width // 2, round(float(top[1]))
    plate = area[max(y, 0) : max(y + 18, 0), max(x, 0) : max(x + width, 0)]
    if plate.size:
        shade(plate, GROUND, 0.7)
        write(area, x + 4, y + 1, text, ink, 13)


def _draw_centre(area: np.ndarray) -> None:
    """A fine cross at the centre of view."""
    centre = _place(np.array([CENTRE_X, CENTRE_Y]))
    lines(area, [centre + np.outer((5, 13), way) for way in _WAYS], WHITE, 1)
