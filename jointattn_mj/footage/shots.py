"""Cuts, and motion of the camera, by small grey images of the video.

A cut changes most of the image at once, in a way that no shift explains. A camera that moves shifts the image's borders
in all directions alike; a person who moves does not. Motion of people and things in an image whose camera moves is not
known.
"""

from dataclasses import dataclass
from typing import Annotated

import cv2
import numpy as np

from jointattn_mj.options import Checked, Real, Whole

WIDTH, HEIGHT = 160, 120
"""Size of the small image."""
GRID = 8
"""Distance of the points whose motion is measured, pixels of the small image."""
SECTORS = 6
"""Sectors of the border, one after the other around it, that are looked at for themselves."""


@dataclass(frozen=True)
class ShotConfig(Checked):
    """How cuts and a moving camera are noticed."""

    cut_change: Annotated[float, Real("[0, 255]")] = 14.0
    """Mean change of grey value from which an image may follow upon a cut."""
    cut_ratio: Annotated[float, Real("[1, 1000]")] = 4.0
    """The same, as a multiple of what is usual in this video at this time."""
    cut_likeness: Annotated[float, Real("[-1, 1]")] = 0.6
    """Correlation with the image before, both sharing no edges, below which it does."""
    camera_px: Annotated[float, Real("[0, 1000]")] = 0.13
    """Shift of the image's border between two images, hundredths of its width, from which the camera moves."""
    camera_frames: Annotated[int, Whole("[1, 1000]")] = 3
    """Images in a row with such a shift until the camera is said to move, or without one until it is said to rest."""


class Shots:
    """Notices cuts and a moving camera, image by image. It can be pickled.

    Attributes:
        cut: Whether the last image follows upon a cut.
        camera_moves: Whether the camera moves in it.
        shift: (2,) shift of the border since the image before, hundredths of the image's width; NaN if unknown.
        cuts: Number of cuts so far.
    """

    def __init__(self, config: ShotConfig):
        self.config = config
        self.cut = self.camera_moves = False
        self.shift = np.full(2, np.nan)
        self.cuts = 0
        self._before = np.zeros((0, 0), np.uint8)
        self._usual = 2.0
        self._streak = 0

    @property
    def shifted(self) -> bool:
        """Whether the border shows a shift since the image before, if only a small one."""
        return self.camera_moves or bool(np.hypot(*self.shift) > self.config.camera_px / 2)

    def see(self, image: np.ndarray) -> bool:
        """Take one more image, (h, w, 3) uint8 BGR; returns whether it follows upon a cut."""
        coloured = cv2.resize(image, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
        small = np.asarray(cv2.cvtColor(coloured, cv2.COLOR_BGR2GRAY), np.uint8)
        before, self._before = self._before, small
        self.cut, self.shift = False, np.full(2, np.nan)
        if not before.size:
            return False
        change = float(cv2.absdiff(small, before).mean())
        config = self.config
        if change >= max(config.cut_change, config.cut_ratio * self._usual):
            self.cut = _correlation(small, before) < config.cut_likeness
        if self.cut:
            self.cuts += 1
            self._streak, self.camera_moves = 0, False
            return True
        self._usual += 0.1 * (change - self._usual)
        self.shift = _border_shift(before, small) if change > 0 else np.zeros(2)
        moved = bool(np.hypot(*self.shift) > config.camera_px)
        self._streak = self._streak + 1 if moved != self.camera_moves else 0
        if self._streak >= config.camera_frames:
            self.camera_moves, self._streak = moved, 0
        return False


def _correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Correlation of two grey images at their best shift of up to an eighth of their size."""
    margin_x, margin_y = WIDTH // 8, HEIGHT // 8
    part = second[margin_y:-margin_y, margin_x:-margin_x]
    return float(cv2.matchTemplate(first, part, cv2.TM_CCOEFF_NORMED).max())


def _border_shift(before: np.ndarray, now: np.ndarray) -> np.ndarray:
    """Shift (2,) on which the sectors of the border agree, hundredths of the width; zeros where they do not."""
    x, y = np.meshgrid(np.arange(GRID // 2, WIDTH, GRID), np.arange(GRID // 2, HEIGHT, GRID))
    rim = (x < WIDTH // 5) | (x > WIDTH - WIDTH // 5) | (y < HEIGHT // 5) | (y > HEIGHT - HEIGHT // 5)
    points = np.stack([x[rim], y[rim]], axis=1).astype(np.float32)
    strength = cv2.cornerMinEigenVal(before, 7)[points[:, 1].astype(int), points[:, 0].astype(int)]
    points = points[strength > 2e-4]
    if len(points) < SECTORS:
        return np.zeros(2)
    there, tracked, _ = cv2.calcOpticalFlowPyrLK(
        before, now, points[:, None], points[:, None].copy(), winSize=(11, 11), maxLevel=2
    )
    moved, kept = (there[:, 0] - points)[tracked[:, 0] == 1], points[tracked[:, 0] == 1]
    angle = np.arctan2(kept[:, 1] - HEIGHT / 2, kept[:, 0] - WIDTH / 2)
    sector = ((angle + np.pi) / (2 * np.pi) * SECTORS).astype(int) % SECTORS
    medians = [np.median(moved[sector == k], axis=0) for k in range(SECTORS) if (sector == k).sum() >= 2]
    if len(medians) < 3:
        return np.zeros(2)
    lengths = np.hypot(*np.array(medians).T)
    third = np.sort(lengths)[len(lengths) // 3]  # two of three sectors move at least so much
    middle = np.median(medians, axis=0)
    return np.asarray(middle * min(1.0, third / max(float(np.hypot(*middle)), 1e-6)) * 100 / WIDTH)
