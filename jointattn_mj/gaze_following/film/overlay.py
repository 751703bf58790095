"""What the robot makes of its image, drawn on it: its percept, and where the head turns.

Everything here is known to the robot. Candidates are numbered as in ``Percept``.
"""

from typing import Protocol

import cv2
import numpy as np

from jointattn_mj.gaze_following.agent import GazeFollower, GazeShift
from jointattn_mj.scene.camera import CENTRE_X, CENTRE_Y, pixel_of
from jointattn_mj.scene.world import World
from jointattn_mj.video.paint import GREY, GROUND, LEARNED, WHITE, Box, Colour, disc, lines, shade, write
from jointattn_mj.video.percepts import PerceptInk, caption, location

_BAR = 34  # height of the line of text below the image's contents
_WAYS = ((1, 0), (-1, 0), (0, 1), (0, -1))
_AHEAD_DEG = 60.0  # farther from the present direction nothing is drawn


class Watched(Protocol):
    """A robot in its world, such as a session."""

    @property
    def world(self) -> World:
        """The world."""

    @property
    def robot(self) -> GazeFollower:
        """The mind."""


class RobotsView:
    """Draws the left image of the video into ``box``."""

    def __init__(self, names: tuple[str, ...], inks: list[Colour], box: Box):
        self._names, self._inks, self._box = names, inks, box
        self._percept = PerceptInk(inks)

    def draw(self, canvas: np.ndarray, session: Watched) -> None:
        """The robot's image with what it perceives in it, or with where its head turns."""
        area, robot = self._box.of(canvas), session.robot
        size = self._box.width, self._box.height
        area[:] = cv2.resize(session.world.image(), size, interpolation=cv2.INTER_CUBIC)
        if robot.shift is not None and robot.percept is None:
            self._draw_turning(area, robot.shift, np.degrees(session.world.head_angles()))
        elif robot.percept is not None:
            motion = getattr(robot.perceiver, "motion", None)  # none with ``perception state``
            self._percept.draw(area, robot.percept, robot.attended, motion)
        _draw_centre(area)
        self._draw_status(area, robot)

    def _draw_turning(self, area: np.ndarray, shift: GazeShift, head: np.ndarray) -> None:
        """Nothing is perceived while the head turns: a dimmer image with the goal, and the learner's guess."""
        shade(area, GROUND, 0.35)
        if shift.suggestion is not None and not shift.by_learner:
            self._draw_goal(area, shift.suggestion, head, LEARNED, "learned guess", -45)
        ink = LEARNED if shift.by_learner else self._inks[shift.chosen]
        self._draw_goal(area, shift.command, head, ink, "goal, learned" if shift.by_learner else "goal")

    @staticmethod
    def _draw_goal(
        area: np.ndarray, goal: np.ndarray, head: np.ndarray, ink: Colour, label: str, below: int = 26
    ) -> None:
        """A cross in a ring where ``goal`` (pan, tilt; deg) is in the present image; its label so far below it."""
        if np.abs(goal - head).max() > _AHEAD_DEG:
            return
        centre = location(pixel_of(goal, head))
        disc(area, centre, 17, ink, 2)
        lines(area, [centre + np.outer((10, 23), way) for way in _WAYS], ink, 2)
        caption(area, centre + np.array([0, below]), label, ink)

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


def _draw_centre(area: np.ndarray) -> None:
    """A fine cross at the centre of view."""
    centre = location(np.array([CENTRE_X, CENTRE_Y]))
    lines(area, [centre + np.outer((5, 13), way) for way in _WAYS], WHITE, 1)
