"""Motion against what this person and this camera do at rest.

A living face always moves a little, and a hand-held camera moves everything. What moves (eq. 6.3) is what moves clearly
more than it mostly does: epsilon_i is the larger of the configured one and a multiple of the motion that the candidate
does not reach in 40 % of its images of the last minute.
"""

from collections import deque
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from jointattn_mj.options import Checked, Real, Share, Whole

LONGEST = 30
"""Frames for which an image counts at most: one that is held for longer says no more."""


@dataclass(frozen=True)
class RestConfig(Checked):
    """How much motion counts as rest: that of a still face, and of a camera that shakes a little."""

    ratio: Annotated[float, Real("[0, 100]")] = 2.5
    """Multiple of the motion at rest that counts as motion; 0 takes the configured thresholds alone."""
    quantile: Share = 0.4
    """Share of the images in which a candidate is taken to rest."""
    memory_images: Annotated[int, Whole("[10, 100000]")] = 1800
    """Images that are remembered, at 30 a second: a minute. An image of a slower video counts for all of its frames."""
    fewest_images: Annotated[int, Whole("[1, 100000]")] = 60
    """Images from which rest is known, counted likewise; before, the configured thresholds decide."""


class Rest:
    """Learns how much each candidate moves at rest. It can be pickled.

    Attributes:
        level: (n,) motion at rest, pixels; NaN while it is not known.
    """

    def __init__(self, config: RestConfig, count: int):
        self.config = config
        self.level = np.full(count, np.nan)
        self._kept: list[deque[float]] = [deque(maxlen=config.memory_images) for _ in range(count)]
        self._images = 0

    def moves(self, strength: np.ndarray, moves: np.ndarray, measured: np.ndarray, frames: int = 1) -> np.ndarray:
        """Which candidates move, (n,) bool.

        Args:
            strength: (n,) motion of each, pixels.
            moves: (n,) bool, which move by the configured thresholds.
            measured: (n,) bool, of which motion is known in this image.
            frames: Frames since the image before.
        """
        for k in np.flatnonzero(measured).tolist():
            self._kept[k].extend([float(strength[k])] * min(frames, LONGEST))
        if self._images % 10 == 0:
            for k, kept in enumerate(self._kept):
                if len(kept) >= self.config.fewest_images:
                    self.level[k] = np.quantile(np.fromiter(kept, float), self.config.quantile)
        self._images += 1
        least = np.nan_to_num(self.level) * self.config.ratio
        return np.asarray(moves & measured & (strength > least))
