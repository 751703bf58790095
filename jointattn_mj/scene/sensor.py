"""The camera's sensor: noise, brightness and delay of rendered images."""

from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist
from typing import Annotated

import numpy as np

from jointattn_mj.io.opencv import cv2
from jointattn_mj.options import Checked, Real, Seed, Whole


@dataclass(frozen=True)
class Sensor(Checked):
    """One camera. The defaults change nothing."""

    brightness: Annotated[float, Real("(0, 100]")] = 1.0
    """Factor on every channel."""
    noise: Annotated[float, Real("[0, 64]")] = 0.0
    """Standard deviation of noise on each channel of each pixel, grey values of 0..255; drawn for every frame."""
    delay: Annotated[int, Whole("[0, 30]")] = 0
    """How many frames of 1/30 s ago the image shows the world."""
    seed: Seed = 0
    """Seed of the noise."""

    def expose(self, image: np.ndarray, frame: int) -> None:
        """Apply brightness and noise to an image (h, w, 3) uint8 in place; ``seed`` and ``frame`` decide the noise."""
        if self.brightness != 1.0:
            cv2.convertScaleAbs(image, image, self.brightness)
        if self.noise > 0:
            drawn = np.random.default_rng((self.seed, frame)).integers(0, 256, image.shape, np.uint8)
            lighter, darker = _noise_tables(self.noise)
            cv2.add(image, cv2.LUT(drawn, lighter), image)
            cv2.subtract(image, cv2.LUT(drawn, darker), image)


@lru_cache(maxsize=8)
def _noise_tables(deviation: float) -> tuple[np.ndarray, np.ndarray]:
    """What each of 256 equally likely draws adds and subtracts, both (256,) uint8: normal, up to 2.9 sigma."""
    normal = NormalDist(0, deviation)
    values = np.array([round(normal.inv_cdf((draw + 0.5) / 256)) for draw in range(256)])
    return np.clip(values, 0, 255).astype(np.uint8), np.clip(-values, 0, 255).astype(np.uint8)
