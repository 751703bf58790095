"""The robot's view with overlays: its percepts or, for agents without perception, the ground truth."""

from typing import NamedTuple

import cv2
import numpy as np

from jointattn_mj.gaze_following.agent import GazeFollower
from jointattn_mj.gaze_following.film.overlay import RobotsView
from jointattn_mj.scene.camera import in_image, pixels_of_points
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH
from jointattn_mj.scene.world import World
from jointattn_mj.video.onlooker import sights
from jointattn_mj.video.paint import GREEN, GREY, GROUND, PERSON, ROBOT, Box, Colour, brackets, ink_of, shade, write
from jointattn_mj.video.percepts import FACE_HALF_PX, OBJECT_HALF_PX, SCALE, caption, location

WIDTH, HEIGHT = SCALE * IMAGE_WIDTH, SCALE * IMAGE_HEIGHT
_BAR = 34  # height of the line of text, pixels


class _Watched(NamedTuple):
    world: World
    robot: GazeFollower


class EyeView:
    """Draws the robot's view of worlds that all have the same objects."""

    def __init__(self, world: World):
        self._names = (*(item.name for item in world.config.scene.objects), "face")
        inks: list[Colour] = [*(ink_of(item.rgb) for item in world.config.scene.objects), PERSON]
        self._percepts = RobotsView(self._names, inks, Box(0, 0, WIDTH, HEIGHT))
        self._canvas = np.zeros((HEIGHT, WIDTH, 3), np.uint8)

    def draw(self, world: World, robot: GazeFollower | None) -> np.ndarray:
        """Draw the view now.

        Args:
            world: The task's world.
            robot: The agent, whose percepts are drawn; None draws the ground truth.

        Returns:
            uint8 (480, 640, 3) RGB, which holds until the next call.

        Raises:
            GLError: No image can be rendered here.
        """
        if robot is not None:
            self._percepts.draw(self._canvas, _Watched(world, robot))
        else:
            size = (WIDTH, HEIGHT)
            self._canvas[:] = cv2.resize(world.image(), size, interpolation=cv2.INTER_CUBIC)
            self._draw_ground_truth(world)
        return self._canvas

    def _draw_ground_truth(self, world: World) -> None:
        """Draw brackets around what robot and caregiver look at, green where it is the same object."""
        area, face = self._canvas, len(self._names) - 1
        robot, person = (sight.hit for sight in sights(world))
        together = robot is not None and robot == person and robot != face
        px = pixels_of_points(world.candidate_points(), np.degrees(world.head_angles()))
        visible = in_image(px)
        words = {"robot": (robot, ROBOT, -1), "caregiver": (None if person == face else person, PERSON, 1)}
        for who, (number, ink, side) in words.items():
            if number is not None and visible[number]:
                half = (FACE_HALF_PX if number == face else OBJECT_HALF_PX) * SCALE
                brackets(area, location(px[number]), half, GREEN if together else ink, 2)
                below = np.array([0, half + 4 if side > 0 else -half - 22])
                caption(area, location(px[number]) + below, f"{who} looks", GREEN if together else ink)
        bar = area[-_BAR:]
        shade(bar, GROUND, 0.78)
        at = "nothing" if robot is None else self._names[robot]
        x = write(bar, 12, 8, f"The robot looks at {at}", ROBOT, 15, True) + 12
        at = "nothing" if person is None else "the robot" if person == face else self._names[person]
        x = write(bar, x, 8, f"the caregiver at {at}", PERSON, 15, True) + 12
        write(bar, x, 8, "(ground truth)", GREY, 15)
