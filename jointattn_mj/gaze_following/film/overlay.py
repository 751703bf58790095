"""The robot's image with what it perceives drawn on it, and the goal of a gaze shift.

Everything here is known to the robot. Candidates are numbered as in ``Percept``.
"""

from typing import Protocol

import cv2
import numpy as np

from jointattn_mj.gaze_following.agent import GazeFollower, GazeShift
from jointattn_mj.scene.camera import CENTRE_X, CENTRE_Y, in_image, pixel_of
from jointattn_mj.scene.world import World
from jointattn_mj.video.paint import GREY, GROUND, LEARNED, WHITE, Box, Colour, disc, lines, shade, write
from jointattn_mj.video.percepts import PerceptInk, caption, location

BAR = 38
"""Height of the line of text at the bottom of a view, pixels."""
STATUS = 19
"""Size of its text, pixels."""
_WAYS = ((1, 0), (-1, 0), (0, 1), (0, -1))
_AHEAD_DEG = 60.0  # farther from the present direction no goal is drawn


class Watched(Protocol):
    """A robot in its world, such as a session."""

    @property
    def world(self) -> World:
        """The world."""

    @property
    def robot(self) -> GazeFollower:
        """The agent."""


class RobotsView:
    """Draws the robot's image with its percept, and one line on what the robot does."""

    def __init__(self, names: tuple[str, ...], inks: list[Colour], box: Box):
        """Prepare a view.

        Args:
            names: Of the candidates, the face last.
            inks: Their colours.
            box: Where on the canvas the view goes, pixels.
        """
        self._names, self._inks, self._box = names, inks, box
        self._percept = PerceptInk(inks)

    def draw(self, canvas: np.ndarray, session: Watched) -> None:
        """Draw the robot's image with its percept or, during a gaze shift, with the goal of the shift."""
        area, robot = self._box.of(canvas), session.robot
        size = self._box.width, self._box.height
        area[:] = cv2.resize(session.world.image(), size, interpolation=cv2.INTER_CUBIC)
        above = area[:-BAR]
        if robot.shift is not None and robot.percept is None:
            self._draw_shift(above, robot, robot.shift, np.degrees(session.world.head_angles()))
        elif robot.percept is not None:
            motion = getattr(robot.perceiver, "motion", None)  # none with ``perception state``
            self._percept.draw(above, robot.percept, robot.attended, motion)
        _draw_centre(above)
        self._draw_status(area, robot)

    def _draw_shift(self, area: np.ndarray, robot: GazeFollower, shift: GazeShift, head: np.ndarray) -> None:
        """Dim the image, for nothing is perceived during a shift; mark its goal and the learner's suggestion."""
        shade(area, GROUND, 0.35)
        if shift.suggestion is not None and not shift.by_learner and robot.iterations:
            apart = np.abs(
                location(pixel_of(shift.command, head)) - location(pixel_of(shift.suggestion, head)) + [0, 76]
            )
            crowded = apart[0] < 130 and apart[1] < 28  # the words would lie on those of the goal
            self._draw_goal(area, shift.suggestion, head, LEARNED, "learned guess", 26 if crowded else -50)
        ink = LEARNED if shift.by_learner else self._inks[shift.chosen]
        self._draw_goal(area, shift.command, head, ink, "learned goal" if shift.by_learner else "goal")

    @staticmethod
    def _draw_goal(
        area: np.ndarray, goal: np.ndarray, head: np.ndarray, ink: Colour, label: str, below: int = 26
    ) -> None:
        """Draw a cross in a ring at a direction, if that is in the image.

        Args:
            area: The image, in place.
            goal: Direction (pan, tilt), deg.
            head: Direction of the head, deg.
            ink: Colour.
            label: Words beside it.
            below: How far below the ring's centre the words begin, pixels.
        """
        if np.abs(goal - head).max() > _AHEAD_DEG:
            return
        pixel = pixel_of(goal, head)
        centre = location(pixel)
        if not in_image(pixel[None])[0] or centre[1] >= len(area):
            return
        disc(area, centre, 17, ink, 2)
        lines(area, [centre + np.outer((10, 23), way) for way in _WAYS], ink, 2)
        caption(area, centre + np.array([0, below]), label, ink)

    def _draw_status(self, area: np.ndarray, robot: GazeFollower) -> None:
        """Write one line on what the robot does."""
        bar = area[-BAR:]
        shade(bar, GROUND, 0.88)
        x, y = 12, 7
        shift = robot.shift
        if shift is not None and robot.percept is None:
            x = write(bar, x, y, "turns its head", WHITE, STATUS, True) + 7
            if shift.by_learner:
                write(bar, x, y, "to where it learned this face looks", LEARNED, STATUS)
                return
            x = write(bar, x, y, "to", WHITE, STATUS) + 7
            x = write(bar, x, y, self._names[shift.chosen], self._inks[shift.chosen], STATUS, True) + 7
            write(bar, x, y, "(no perception meanwhile)", GREY, STATUS)
        elif robot.attended is None:
            write(bar, x, y, "looks at nothing in particular", GREY, STATUS)
        else:
            x = write(bar, x, y, "looks at", WHITE, STATUS, True) + 7
            x = write(bar, x, y, self._names[robot.attended], self._inks[robot.attended], STATUS, True) + 7
            if robot.attended == robot.face:
                write(bar, x, y, "(what does it look at?)", GREY, STATUS)


def _draw_centre(area: np.ndarray) -> None:
    """Draw a fine cross at the centre of view."""
    centre = location(np.array([CENTRE_X, CENTRE_Y]))
    lines(area, [centre + np.outer((5, 13), way) for way in _WAYS], WHITE, 1)
