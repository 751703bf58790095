"""Rendered people before a camera like a webcam, as video files, and what ``perceive --looks`` sees in them."""

import copy
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Protocol

import numpy as np

from jointattn_mj.footage.config import PerceiveConfig
from jointattn_mj.footage.looks.coding import ObservedLooks
from jointattn_mj.footage.looks.log import LooksLog
from jointattn_mj.footage.looks.run import observed_looks
from jointattn_mj.footage.reader import RATE
from jointattn_mj.footage.viewing import Viewing
from jointattn_mj.scene.camera import Eye
from jointattn_mj.scene.world import World
from jointattn_mj.video.reel import Reel

WIDTH, HEIGHT = 640, 480
POOL = 16
"""Number of different images of noise; each is shifted at random."""


class Camera(Protocol):
    """What a camera does to an image."""

    @property
    def fps(self) -> int:
        """Images a second, a divisor of 30."""

    @property
    def noise(self) -> float:
        """Standard deviation of each pixel's noise, grey values."""


def film(
    world: World, path: Path, minutes: float, direction: np.ndarray, camera: Camera, rng: np.random.Generator
) -> None:
    """Film a world.

    Args:
        world: The world, at its beginning.
        path: The mp4.
        minutes: Its length.
        direction: (2,) pan and tilt of the camera, rad.
        camera: Its images a second, and its noise.
        rng: Draws noise.
    """
    size = world.model.vis.global_
    size.offwidth, size.offheight = WIDTH, HEIGHT
    eye = Eye(world.physics, width=WIDTH, height=HEIGHT)
    pool = (camera.noise * rng.standard_normal((POOL, HEIGHT, WIDTH, 3))).round().astype(np.int16)
    with Reel(path, HEIGHT, WIDTH, camera.fps) as reel:
        for frame in range(round(minutes * 60 * RATE)):
            world.step(direction)
            if frame % (RATE // camera.fps) == 0:
                noise = np.roll(pool[rng.integers(POOL)], rng.integers(HEIGHT), axis=0)
                reel.add(np.clip(eye.render() + noise, 0, 255).astype(np.uint8))


def perceived(config: PerceiveConfig, minutes: tuple[float, ...]) -> dict[float, ObservedLooks]:
    """What ``perceive --looks`` has seen after so many minutes of a video: as if it ended there.

    Args:
        config: Of the command, with ``looks``.
        minutes: When to take stock, ascending.
    """
    seen: dict[float, ObservedLooks] = {}
    with TemporaryDirectory() as folder:
        viewing = Viewing(config)
        viewing.prepare()
        log = LooksLog(Path(folder), viewing.names, viewing.watcher.perceiver.pattern_size)
        for still in viewing.footage:
            viewing.see(still)
            if (viewing.frames - 1) % config.coding.every == 0:
                log.add(viewing)
            for end in minutes:
                if viewing.frames == round(end * 60 * RATE):
                    album = copy.deepcopy(viewing.album)
                    seen[end] = observed_looks(log, viewing, album.learn(config.som) if album.offered else None)
    return seen
