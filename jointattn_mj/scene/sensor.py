"""The camera's sensor: how a rendered picture comes out grainy, darker or brighter, and late."""

from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist

import cv2
import numpy as np

from jointattn_mj.errors import ConfigError

MOST_DELAY = 30
"""Frames; a second."""


@dataclass(frozen=True)
class Sensor:
    """One camera. As it stands it changes nothing."""

    brightness: float = 1.0
    """Every channel is multiplied by so much."""
    noise: float = 0.0
    """Standard deviation, in grey values of 0..255, of what is added to each channel of each pixel, each frame anew."""
    delay: int = 0
    """The picture shows the world of so many frames (1/30 s) ago."""
    seed: int = 0
    """Of the noise."""

    def __post_init__(self) -> None:
        if not 0 < self.brightness < float("inf"):
            raise ConfigError(f"sensor.brightness: expected a factor above 0; got {self.brightness!r}")
        if not 0 <= self.noise <= 64:
            raise ConfigError(f"sensor.noise: expected grey values in [0, 64]; got {self.noise!r}")
        if not 0 <= self.delay <= MOST_DELAY:
            raise ConfigError(f"sensor.delay: expected 0 to {MOST_DELAY} frames; got {self.delay!r}")

    def expose(self, picture: np.ndarray, frame: int) -> None:
        """Change a picture (h, w, 3) uint8 in place; its noise depends on ``seed`` and the frame's number alone."""
        if self.brightness != 1.0:
            cv2.convertScaleAbs(picture, picture, self.brightness)
        if self.noise > 0:
            drawn = np.random.default_rng((self.seed, frame)).integers(0, 256, picture.shape, np.uint8)
            lighter, darker = _noise_tables(self.noise)
            cv2.add(picture, cv2.LUT(drawn, lighter), picture)
            cv2.subtract(picture, cv2.LUT(drawn, darker), picture)


@lru_cache(maxsize=8)
def _noise_tables(deviation: float) -> tuple[np.ndarray, np.ndarray]:
    """What 256 equally likely draws add and take away, both (256,) uint8: normally distributed up to 2.9 deviations."""
    normal = NormalDist(0, deviation)
    values = np.array([round(normal.inv_cdf((draw + 0.5) / 256)) for draw in range(256)])
    return np.clip(values, 0, 255).astype(np.uint8), np.clip(-values, 0, 255).astype(np.uint8)
