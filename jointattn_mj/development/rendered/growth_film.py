"""A film of growing resolution: both views, and the map of faces and the table in their present values."""

import pickle
from collections.abc import Callable
from typing import TypeVar

import cv2
import numpy as np

from jointattn_mj.contingency.online.resolution import Resolution
from jointattn_mj.development.rendered.film import INKS, Film, titled
from jointattn_mj.development.rendered.growing import Babbling, FreeGazeBody, GrowingRun
from jointattn_mj.video.paint import FAINT, GREY, PANEL, ROBOT, WHITE, Box, disc, write

_FACES = Box(672, 440, 268, 268)
_TABLE = Box(952, 440, 312, 268)
_WORDS = Box(16, 580, 640, 128)

Running = TypeVar("Running", Babbling, GrowingRun)


class GrowthFilm(Film):
    """A film of a robot whose resolution grows."""

    def scene(
        self, run: Running, resolution: Resolution, title: str, words: Callable[[Running], list[str]], n_steps: int
    ) -> None:
        """Film the next steps of a copy of ``run``.

        Args:
            run: The run, which stays as it is.
            resolution: Values of S and A to be shown.
            title: Words at the top.
            words: Gives the lines under the robot's image after each step.
            n_steps: How many steps.
        """
        copy: Running = pickle.loads(pickle.dumps(run))

        def advance() -> tuple[np.ndarray, str]:
            copy.advance(1)
            return _still(copy, resolution, title, words(copy)), ""

        self._shoot(copy.body.stage.world, n_steps, copy.body.config.senses.centre_radius_deg, advance)


def _still(run: Babbling | GrowingRun, resolution: Resolution, title: str, words: list[str]) -> np.ndarray:
    """All of an image that does not move."""
    canvas = titled(title, f"step {run.steps_done:,}", run.body.looks_at(), run.body.spots)
    _draw_faces(_FACES.of(canvas), run.body, resolution)
    _draw_table(_TABLE.of(canvas), run.body, resolution)
    area = _WORDS.of(canvas)
    area[:] = PANEL
    for row, line in enumerate(words):
        write(area, 14, 10 + 24 * row, line, WHITE if row == 0 else GREY, 15, row == 0)
    return canvas


def _draw_faces(area: np.ndarray, body: FreeGazeBody, resolution: Resolution) -> None:
    """Draw the map of faces, each unit with a frame in the colour of its value."""
    area[:] = PANEL
    write(area, 10, 8, f"Categories of faces (S): {len(resolution.sensed)}", WHITE, 15, True)
    values = resolution.sensor(np.arange(len(body.som.weights)))
    for unit, image in enumerate(body.som.images().reshape(-1, 32, 32)):
        row, column = divmod(unit, body.som.config.columns)
        x, y, side = 14 + 26 * column, 34 + 25 * row, 24
        patch = cv2.resize(image, (side - 4, side - 4), interpolation=cv2.INTER_AREA)
        grey = np.clip(128 + 50 * patch, 0, 255).astype(np.uint8)
        area[y : y + side, x : x + side] = INKS[values[unit] % len(INKS)]
        area[y + 2 : y + side - 2, x + 2 : x + side - 2] = grey[..., None]


def _draw_table(area: np.ndarray, body: FreeGazeBody, resolution: Resolution) -> None:
    """Draw directions from left to right in the colours of their regions, the head's direction, and the true spots."""
    area[:] = PANEL
    write(area, 10, 8, f"Regions of A: {len(resolution.boxes)}, and the face", WHITE, 15, True)
    low, high = body.space[0]
    width = area.shape[1] - 40

    def x_of(pan: float) -> float:
        return float(20 + width * (high + 3 - np.clip(pan, low - 3, high + 3)) / (high - low + 6))

    for number, box in enumerate(resolution.boxes):
        left, right = round(x_of(box[0, 1])), round(x_of(box[0, 0]))
        area[70:150, left + 1 : right] = INKS[(number + 2) % len(INKS)]
    for pan, _ in np.degrees(body.stage.locations):
        disc(area, np.array([x_of(pan), 166.0]), 4, FAINT)
    write(area, 10, 178, "dots: spots (truth)", GREY, 13)
    write(area, 10, 200, "pan, from the robot's left to its right", GREY, 13)
    pan, tilt = np.degrees(body.stage.world.head_angles())
    if tilt < body.space[1, 1] + 5:
        disc(area, np.array([x_of(pan), 110.0]), 9, ROBOT)
        write(area, 10, 40, f"head: pan {pan:+.0f}, tilt {tilt:+.0f} deg", ROBOT, 13)
    else:
        write(area, 10, 40, "head: at the caregiver's face", ROBOT, 13)
