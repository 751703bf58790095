"""The camera's sensor: how a rendered image comes out grainy, darker or brighter, and late."""

from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist
from typing import Annotated

import cv2
import numpy as np

from jointattn_mj.options import Checked, Real, Seed, Whole


@dataclass(frozen=True)
class Sensor(Checked):
    """One camera. As it stands it changes nothing."""

    brightness: Annotated[float, Real("(0, 100]")] = 1.0
    """Every channel is multiplied by so much."""
    noise: Annotated[float, Real("[0, 64]")] = 0.0
    """Standard deviation, in grey values of 0..255, of what is added to each channel of each pixel, each frame anew."""
    delay: Annotated[int, Whole("[0, 30]")] = 0
    """The image shows the world of so many frames (1/30 s) ago."""
    seed: Seed = 0
    """Of the noise."""

    def expose(self, image: np.ndarray, frame: int) -> None:
        """Change an image (h, w, 3) uint8 in place; its noise depends on ``seed`` and the frame's number alone."""
        if self.brightness != 1.0:
            cv2.convertScaleAbs(image, image, self.brightness)
        if self.noise > 0:
            drawn = np.random.default_rng((self.seed, frame)).integers(0, 256, image.shape, np.uint8)
            lighter, darker = _noise_tables(self.noise)
            cv2.add(image, cv2.LUT(drawn, lighter), image)
            cv2.subtract(image, cv2.LUT(drawn, darker), image)


@lru_cache(maxsize=8)
def _noise_tables(deviation: float) -> tuple[np.ndarray, np.ndarray]:
    """What 256 equally likely draws add and take away, both (256,) uint8: normally distributed up to 2.9 deviations."""
    normal = NormalDist(0, deviation)
    values = np.array([round(normal.inv_cdf((draw + 0.5) / 256)) for draw in range(256)])
    return np.clip(values, 0, 255).astype(np.uint8), np.clip(-values, 0, 255).astype(np.uint8)
