"""A film of growing resolution: both views, and the map of faces and directions of gaze in colours of their values."""

import pickle
from collections.abc import Callable
from typing import TypeVar

import cv2
import numpy as np

from jointattn_mj.contingency.online.resolution import Resolution
from jointattn_mj.development.rendered.film import INKS, RunFilm, headed
from jointattn_mj.development.rendered.growing import Babbling, FreeGazeBody, GrowingRun
from jointattn_mj.video.paint import (
    GREY,
    PANEL,
    ROBOT,
    SMALL,
    TEXT,
    TITLE,
    WHITE,
    Box,
    disc,
    fitting,
    write,
)

_FACES = Box(672, 440, 268, 268)
_TABLE = Box(952, 440, 312, 268)
_WORDS = Box(16, 580, 640, 128)

Running = TypeVar("Running", Babbling, GrowingRun)


class GrowthFilm(RunFilm):
    """``with GrowthFilm(path) as film: film.growth(run, resolution, "at first", words, n_steps=5)``."""

    def growth(
        self, run: Running, resolution: Resolution, title: str, words: Callable[[Running], list[str]], n_steps: int
    ) -> None:
        """Film the next steps of a copy of ``run``.

        Args:
            run: The run, at any step.
            resolution: Values of faces and of gaze that it has by then.
            title: Says what the scene is.
            words: Gives lines about the run after a step.
            n_steps: Steps that are filmed.
        """
        copy: Running = pickle.loads(pickle.dumps(run))

        def step() -> tuple[np.ndarray, str, str]:
            copy.advance(1)
            return _still(copy, resolution, title, words(copy)), "", ""

        self._film(copy.body.stage.world, copy.body.config.senses.centre_radius_px, n_steps, step)


def _still(run: Babbling | GrowingRun, resolution: Resolution, title: str, words: list[str]) -> np.ndarray:
    """All that stays the same during a step, (720, 1280, 3) uint8."""
    canvas = headed(title, f"step {run.steps_done:,}", run.body.looks_at(), run.body.spots)
    _draw_faces(_FACES.of(canvas), run.body, resolution)
    _draw_table(_TABLE.of(canvas), run.body, resolution)
    area = _WORDS.of(canvas)
    area[:] = PANEL
    for row, line in enumerate(words):
        size = fitting(line, area.shape[1] - 28, (18, 16, 14), row == 0)
        write(area, 14, 8 + 28 * row, line, WHITE if row == 0 else GREY, size, row == 0)
    return canvas


def _draw_faces(area: np.ndarray, body: FreeGazeBody, resolution: Resolution) -> None:
    """Draw the map of faces, each unit framed in the colour of its value."""
    area[:] = PANEL
    write(area, 12, 6, f"Faces it tells apart: {len(resolution.sensed)}", WHITE, 19, True)
    values = resolution.sensor(np.arange(len(body.som.weights)))
    for unit, image in enumerate(body.som.images().reshape(-1, 32, 32)):
        row, column = divmod(unit, body.som.config.columns)
        x, y, side = 14 + 26 * column, 34 + 25 * row, 24
        patch = cv2.resize(image, (side - 4, side - 4), interpolation=cv2.INTER_AREA)
        grey = np.clip(140 + 60 * patch, 0, 255).astype(np.uint8)
        area[y : y + side, x : x + side] = INKS[values[unit] % len(INKS)]
        area[y + 2 : y + side - 2, x + 2 : x + side - 2] = grey[..., None]


def _draw_table(area: np.ndarray, body: FreeGazeBody, resolution: Resolution) -> None:
    """Draw directions from left to right in the colours of their regions, the head's direction and the true spots."""
    area[:] = PANEL
    title = f"Directions of gaze: {len(resolution.boxes)}, and the face"
    write(area, 12, 6, title, WHITE, fitting(title, area.shape[1] - 20, (TITLE, 18, TEXT, SMALL), True), True)
    low, high = body.space[0]
    width = area.shape[1] - 40

    def x_of(pan: float) -> float:
        return float(20 + width * (high + 3 - np.clip(pan, low - 3, high + 3)) / (high - low + 6))

    for number, box in enumerate(resolution.boxes):
        left, right = round(x_of(box[0, 1])), round(x_of(box[0, 0]))
        area[70:150, left + 1 : right] = INKS[(number + 2) % len(INKS)]
    for pan, _ in np.degrees(body.stage.locations):
        disc(area, np.array([x_of(pan), 166.0]), 6, GREY)
    write(area, 12, 182, "dots: spots of objects, which", GREY, SMALL)
    write(area, 12, 202, "the robot is not told", GREY, SMALL)
    write(area, 12, 230, "from its left to its right", GREY, SMALL)
    pan, tilt = np.degrees(body.stage.world.head_angles())
    if tilt < body.space[1, 1] + 5:
        disc(area, np.array([x_of(pan), 110.0]), 9, ROBOT)
        write(area, 12, 38, f"head: pan {pan:+.0f}, tilt {tilt:+.0f} deg", ROBOT, SMALL)
    else:
        write(area, 12, 38, "head: at the face", ROBOT, SMALL)
