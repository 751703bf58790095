"""An agent in a task as a video: the robot's view with overlays, beside the scene from the side."""

from pathlib import Path
from types import TracebackType

import numpy as np

from jointattn_mj.gaze_following.agent import GazeFollower
from jointattn_mj.scene.world import World
from jointattn_mj.video.onlooker import Onlooker
from jointattn_mj.video.reel import Reel
from jointattn_mj.viewing.eye import HEIGHT, WIDTH, EyeView

OUTSIDE = 840
"""Width of the scene from the side, pixels: both heads are in view."""
SLOWEST = 2.0
"""Least number of images a second: steps that last a second are shown in half of it."""


class TaskFilm:
    """Writes an image a step: ``with TaskFilm(path, seconds_a_step) as film: film.add(world, robot)``."""

    def __init__(self, path: Path, seconds_a_step: float):
        """Prepare a video; ``seconds_a_step`` is how long a step of the task lasts."""
        self._reel = Reel(path, HEIGHT, WIDTH + OUTSIDE, max(SLOWEST, 1 / seconds_a_step))
        self._views: dict[int, tuple[World, EyeView, Onlooker]] = {}

    def add(self, world: World, robot: GazeFollower | None) -> None:
        """Add an image of the present step.

        Args:
            world: The task's world.
            robot: The agent, whose percepts are drawn; None draws the ground truth.

        Raises:
            GLError: No image can be rendered here.
            VideoError: ffmpeg has given up.
        """
        if id(world) not in self._views:
            self._views[id(world)] = world, EyeView(world), Onlooker(world, OUTSIDE, HEIGHT)
        _, eye, onlooker = self._views[id(world)]
        self._reel.add(np.hstack([eye.draw(world, robot), onlooker.render()]))

    def __enter__(self) -> "TaskFilm":
        """Start ffmpeg.

        Raises:
            VideoError: It does not start.
        """
        self._reel.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Finish the file, and free what images needed."""
        for _, _, onlooker in self._views.values():
            onlooker.close()
        self._reel.__exit__(kind, error, traceback)
