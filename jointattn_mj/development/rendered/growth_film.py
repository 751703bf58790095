"""A film of resolution that grows: both views, and the map of faces and the table in the values that they have."""

import pickle
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import TypeVar

import cv2
import numpy as np

from jointattn_mj.contingency.online.resolution import Resolution
from jointattn_mj.development.rendered.film import HEIGHT, INKS, MOVING, RATE, RESTING, WIDTH
from jointattn_mj.development.rendered.growing import Babbling, Body, GrowingRun
from jointattn_mj.scene.camera import FOCAL_PX
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH
from jointattn_mj.scene.movement import minimum_jerk
from jointattn_mj.video.onlooker import Onlooker
from jointattn_mj.video.paint import FAINT, GREY, GROUND, PANEL, PERSON, ROBOT, WHITE, Box, disc, write
from jointattn_mj.video.reel import Reel

_EYE = Box(16, 88, 2 * IMAGE_WIDTH, 2 * IMAGE_HEIGHT)
_OUTSIDE = Box(672, 88, 592, 340)
_FACES = Box(672, 440, 268, 268)
_TABLE = Box(952, 440, 312, 268)
_WORDS = Box(16, 580, 640, 128)


Running = TypeVar("Running", Babbling, GrowingRun)


class GrowthFilm:
    """``with GrowthFilm(path) as film: film.scene(run, resolution, "born", words, n_steps=5)``."""

    def __init__(self, path: Path):
        self._reel = Reel(path, HEIGHT, WIDTH, RATE)

    def __enter__(self) -> "GrowthFilm":
        """Start ffmpeg."""
        self._reel.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Finish the file."""
        self._reel.__exit__(kind, error, traceback)

    def scene(
        self, run: Running, resolution: Resolution, title: str, words: Callable[[Running], list[str]], n_steps: int
    ) -> None:
        """Film the next ``n_steps`` turns of a copy of ``run``, with what ``words`` says of each."""
        copy: Running = pickle.loads(pickle.dumps(run))
        world = copy.body.stage.world
        onlooker = Onlooker(world, _OUTSIDE.width, _OUTSIDE.height)
        try:
            for _ in range(n_steps):
                before = world.pose()
                copy.advance(1)
                after, still = world.pose(), _still(copy, resolution, title, words(copy))
                for share in (*minimum_jerk(MOVING), *[1.0] * RESTING):
                    world.stand(after._replace(qpos=before.qpos + share * (after.qpos - before.qpos)))
                    canvas = still.copy()
                    eye = _EYE.of(canvas)
                    size = (_EYE.width, _EYE.height)
                    eye[:] = cv2.resize(world.image(), size, interpolation=cv2.INTER_CUBIC)
                    radius = 2 * np.radians(copy.body.config.senses.centre_radius_deg) * FOCAL_PX
                    disc(eye, np.array(size) / 2, radius, ROBOT, 1)
                    _OUTSIDE.of(canvas)[:] = onlooker.render()
                    self._reel.add(canvas)
        finally:
            onlooker.close()
            world.close()


def _still(run: Babbling | GrowingRun, resolution: Resolution, title: str, words: list[str]) -> np.ndarray:
    """All that does not move while bodies do."""
    canvas = np.full((HEIGHT, WIDTH, 3), GROUND, np.uint8)
    write(canvas, 16, 12, title, WHITE, 22, True)
    write(canvas, WIDTH - 16, 16, f"turn {run.steps_done:,}", WHITE, 18, align="right")
    write(canvas, _EYE.x, 58, "What the robot sees", WHITE, 16, True)
    write(canvas, _OUTSIDE.x, 58, "From outside", WHITE, 16, True)
    looks_at = run.body.looks_at()
    where = "at the robot" if looks_at == run.body.spots else f"at place {looks_at + 1}"
    write(canvas, _OUTSIDE.x + _OUTSIDE.width, 60, f"she looks {where} (truth)", PERSON, 14, align="right")
    _draw_faces(_FACES.of(canvas), run.body, resolution)
    _draw_table(_TABLE.of(canvas), run.body, resolution)
    area = _WORDS.of(canvas)
    area[:] = PANEL
    for row, line in enumerate(words):
        write(area, 14, 10 + 24 * row, line, WHITE if row == 0 else GREY, 15, row == 0)
    return canvas


def _draw_faces(area: np.ndarray, body: Body, resolution: Resolution) -> None:
    """The map of faces, a frame about each in the ink of its value."""
    area[:] = PANEL
    write(area, 10, 8, f"Faces it tells apart: {len(resolution.sensed)}", WHITE, 15, True)
    values = resolution.sensor(np.arange(len(body.som.weights)))
    for cell, image in enumerate(body.som.images().reshape(-1, 32, 32)):
        row, column = divmod(cell, body.som.config.columns)
        x, y, side = 14 + 26 * column, 34 + 25 * row, 24
        patch = cv2.resize(image, (side - 4, side - 4), interpolation=cv2.INTER_AREA)
        grey = np.clip(128 + 50 * patch, 0, 255).astype(np.uint8)
        area[y : y + side, x : x + side] = INKS[values[cell] % len(INKS)]
        area[y + 2 : y + side - 2, x + 2 : x + side - 2] = grey[..., None]


def _draw_table(area: np.ndarray, body: Body, resolution: Resolution) -> None:
    """Directions from left to right, in the inks of their regions; where the head points now, and the true places."""
    area[:] = PANEL
    write(area, 10, 8, f"Where it can look: {len(resolution.boxes)}, or at her", WHITE, 15, True)
    low, high = body.space[0]
    width = area.shape[1] - 40

    def x_of(pan: float) -> float:
        return 20 + width * (high + 3 - np.clip(pan, low - 3, high + 3)) / (high - low + 6)

    for number, box in enumerate(resolution.boxes):
        left, right = round(x_of(box[0, 1])), round(x_of(box[0, 0]))
        area[70:150, left + 1 : right] = INKS[(number + 2) % len(INKS)]
    for pan, _ in np.degrees(body.stage.locations):
        disc(area, np.array([x_of(pan), 166.0]), 4, FAINT)
    write(area, 10, 178, "dots: the places (truth)", FAINT, 13)
    write(area, 10, 200, "pan, from its left to its right", GREY, 13)
    pan, tilt = np.degrees(body.stage.world.head_angles())
    if tilt < body.space[1, 1] + 5:
        disc(area, np.array([x_of(pan), 110.0]), 9, ROBOT)
        write(area, 10, 40, f"head: pan {pan:+.0f}, tilt {tilt:+.0f} deg", ROBOT, 13)
    else:
        write(area, 10, 40, "head: at her face", ROBOT, 13)
