"""Digital pan and tilt: the robot's image as a part of a wide image, by the geometry of a pinhole camera.

The wide image's camera and the robot's eye have their optical centres in the same point. A pixel of one is therefore a
pixel of the other by a homography that depends on the head's angles alone. Directions are (pan, tilt), degrees, as in
``scene.camera``.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import cv2
import numpy as np

from jointattn_mj.errors import FootageError
from jointattn_mj.options import TOP_LEVEL, Checked, Real
from jointattn_mj.scene.camera import CENTRE_X, CENTRE_Y, FOCAL_PX
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH

LEAST_DEG = 5.0
"""How far the head must be able to turn to either side, and up or down: less than an object's distance to the next."""
HALVINGS = 12
"""Halvings of the distance to the border of the wide image, for the head's limit there: to a hundredth of a degree."""
_CORNERS = np.array([[-0.5, -0.5, 1], [IMAGE_WIDTH - 0.5, -0.5, 1], [-0.5, IMAGE_HEIGHT - 0.5, 1],
                     [IMAGE_WIDTH - 0.5, IMAGE_HEIGHT - 0.5, 1]]).T  # fmt: skip
_EYE = np.array([[0, 0, 1], [-1 / FOCAL_PX, 0, CENTRE_X / FOCAL_PX], [0, -1 / FOCAL_PX, CENTRE_Y / FOCAL_PX]])
"""From a pixel (x, y, 1) of the robot's image to its ray: ahead, to the left, up."""


@dataclass(frozen=True)
class HeadConfig(Checked):
    """The digital head: which part of the wide image the robot sees, and how far it turns."""

    fov_deg: Annotated[Annotated[float, Real("[10, 170]")] | None, TOP_LEVEL] = None
    """Horizontal field of view of a wide camera, of which the robot's image then takes 61.9 degrees (chapter 6). If not
    given, view-share says how much of the wide image it takes."""
    view_share: Annotated[float, Real("[0.05, 1]"), TOP_LEVEL] = 0.7
    """Height of the robot's image as a share of the wide one's, without fov-deg. With 0.7 a face on the upper third of
    the wide image and objects on its lower third are as far apart as in chapter 6."""
    mount_deg: Annotated[float, Real("[-80, 80]"), TOP_LEVEL] = 0.0
    """Elevation of the camera; less than 0 where it looks down."""
    border: Annotated[Literal["limit", "black"], TOP_LEVEL] = "limit"
    """At the border of the wide image: the head turns no farther (limit), or turns, and the robot sees black beyond."""
    most_pan_deg: Annotated[float, Real("[0, 90]")] = 90.0
    """How far the head turns to either side. The border of the wide image may come first."""
    most_tilt_deg: Annotated[float, Real("[0, 90]")] = 60.0
    """How far it turns up or down."""
    noise: Annotated[float, Real("[0, 64]")] = 0.0
    """Standard deviation of noise that is added to each channel of the robot's image, grey values of 0..255."""

    ADVANCED: ClassVar = ("most_pan_deg", "most_tilt_deg", "noise")


class Lens:
    """Geometry of one wide image.

    Attributes:
        width: Of the wide image, pixels.
        height: Likewise.
        scale: Pixels of the robot's image for the height of one of the wide image, in its middle.
    """

    def __init__(self, width: int, height: int, config: HeadConfig, aspect: float = 1.0):
        """Lay out a wide image.

        Args:
            width: Of the wide image, pixels.
            height: Likewise.
            config: Field of view, and what happens at the border.
            aspect: Width of a pixel over its height.

        Raises:
            FootageError: The head could hardly turn before it comes to the border.
        """
        self.width, self.height, self.config = width, height, config
        if config.fov_deg is None:
            focal = FOCAL_PX * config.view_share * height / IMAGE_HEIGHT
        else:
            focal = width * aspect / 2 / float(np.tan(np.radians(config.fov_deg / 2)))
        self.scale = FOCAL_PX / focal
        self._wide = np.array([[(width - 1) / 2, -focal / aspect, 0], [(height - 1) / 2, 0, -focal], [1, 0, 0]], float)
        self._mount = _rotation(0.0, config.mount_deg).T
        if config.border == "limit":
            self._require_room()

    def homography(self, head: np.ndarray) -> np.ndarray:
        """From pixels (x, y, 1) of the robot's image to those of the wide one, with the head at ``head`` (2,), deg."""
        matrix: np.ndarray = self._wide @ self._mount @ _rotation(float(head[0]), float(head[1])) @ _EYE
        return matrix

    def crop(self, wide_image: np.ndarray, head: np.ndarray) -> np.ndarray:
        """The robot's image, (240, 320, 3) uint8 RGB.

        Args:
            wide_image: (height, width, 3) uint8 BGR.
            head: (2,) pan and tilt, deg.
        """
        matrix, times = self.homography(head), int(1 / self.scale)
        if times > 1:  # what is sampled must not be finer than the image
            wide_image, corner = self._part(wide_image, matrix, times)
            shrink = np.array([[1 / times, 0, 0.5 / times - 0.5], [0, 1 / times, 0.5 / times - 0.5], [0, 0, 1]])
            matrix = shrink @ np.array([[1, 0, -corner[0]], [0, 1, -corner[1]], [0, 0, 1]]) @ matrix
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        image = cv2.warpPerspective(wide_image, matrix, (IMAGE_WIDTH, IMAGE_HEIGHT), flags=flags)
        return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), np.uint8)

    def to_image(self, px: np.ndarray, head: np.ndarray) -> np.ndarray:
        """Pixels (k, 2) of the robot's image for pixels (k, 2) of the wide image.

        Args:
            px: Pixels of the wide image; the centre of the first one is (0, 0).
            head: (2,) pan and tilt, deg.
        """
        rows = np.linalg.inv(self.homography(head)) @ np.column_stack([px, np.ones(len(px))]).T
        ahead = np.where(rows[2] > 0, rows[2], np.nan)
        image_px: np.ndarray = (rows[:2] / ahead).T
        return image_px

    def direction(self, px: np.ndarray) -> np.ndarray:
        """Direction (2,) of a pixel (2,) of the wide image, deg."""
        x, y, z = self._mount.T @ np.linalg.inv(self._wide) @ np.array([px[0], px[1], 1.0])
        return np.degrees([np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))])

    def fits(self, pan: float, tilt: float) -> bool:
        """Whether the robot's image lies inside the wide image, with the head at ``pan`` and ``tilt``, deg."""
        x, y, ahead = self.homography(np.array([pan, tilt])) @ _CORNERS
        inside = (ahead > 0) & (x >= -0.5 * ahead) & (x <= (self.width - 0.5) * ahead)
        return bool((inside & (y >= -0.5 * ahead) & (y <= (self.height - 0.5) * ahead)).all())

    def limited(self, head: np.ndarray) -> np.ndarray:
        """The direction (2,) nearest to ``head`` (2,), deg, to which the head can turn: pan gives way before tilt."""
        config = self.config
        pan = min(max(float(head[0]), -config.most_pan_deg), config.most_pan_deg)
        tilt = min(max(float(head[1]), -config.most_tilt_deg), config.most_tilt_deg)
        if config.border == "limit" and not self.fits(pan, tilt):
            if not self.fits(0.0, tilt):
                tilt = _last(config.mount_deg, tilt, lambda tilt: self.fits(0.0, tilt))
            pan = _last(0.0, pan, lambda pan: self.fits(pan, tilt))
        return np.array([pan, tilt])

    def reach(self) -> tuple[float, float, float]:
        """How far the head turns from the wide image's middle to either side, up, and down, deg."""
        mount = self.config.mount_deg
        aside, up, down = (self.limited(np.array(to)) for to in ((90.0, mount), (0.0, mount + 90), (0.0, mount - 90)))
        return float(aside[0]), float(up[1]) - mount, mount - float(down[1])

    def _require_room(self) -> None:
        """Raises FootageError: The wide image is too narrow."""
        config = self.config
        aside, up, down = self.reach() if self.fits(0.0, config.mount_deg) else (0.0, 0.0, 0.0)
        if min(aside, up, down) >= min(LEAST_DEG, config.most_pan_deg, config.most_tilt_deg):
            return
        what = (
            f"a field of view of {config.fov_deg:g} degrees (`fov_deg`)"
            if config.fov_deg is not None
            else f"`view_share={config.view_share:g}`"
        )
        raise FootageError(
            f"with {what} in images of {self.width}x{self.height} the head could turn by {aside:.0f} degrees aside, "
            f"{up:.0f} up and {down:.0f} down, and {LEAST_DEG:g} are the least; leave `fov_deg` out and give a smaller "
            "`view_share`, or let the robot see black beyond the wide image with `border='black'`"
        )

    @staticmethod
    def _part(wide_image: np.ndarray, matrix: np.ndarray, times: int) -> tuple[np.ndarray, tuple[int, int]]:
        """The part of the wide image that the image needs, made smaller, and its corner x, y in the wide image."""
        x, y, ahead = matrix @ _CORNERS
        height, width = wide_image.shape[:2]
        if (ahead <= 0).any():
            x0, y0, x1, y1 = 0, 0, width, height
        else:
            x0, x1 = max(0, int((x / ahead).min()) - times), min(width, int((x / ahead).max()) + 2 * times)
            y0, y1 = max(0, int((y / ahead).min()) - times), min(height, int((y / ahead).max()) + 2 * times)
        wide, high = max(1, (x1 - x0) // times), max(1, (y1 - y0) // times)
        part = wide_image[y0 : y0 + high * times, x0 : x0 + wide * times]
        if not part.size:
            return np.zeros((1, 1, 3), np.uint8), (x0, y0)
        return cv2.resize(part, (wide, high), interpolation=cv2.INTER_AREA), (x0, y0)


def _rotation(pan: float, tilt: float) -> np.ndarray:
    """From the eye's frame (ahead, left, up) to the base's, with the head at ``pan`` and ``tilt``, deg."""
    p, t = np.radians([pan, tilt])
    about_up = np.array([[np.cos(p), -np.sin(p), 0], [np.sin(p), np.cos(p), 0], [0, 0, 1]])
    about_left = np.array([[np.cos(t), 0, -np.sin(t)], [0, 1, 0], [np.sin(t), 0, np.cos(t)]])
    rotation: np.ndarray = about_up @ about_left
    return rotation


def _last(inside: float, outside: float, fits: Callable[[float], bool]) -> float:
    """The last value from ``inside`` to ``outside`` that fits."""
    for _ in range(HALVINGS):
        middle = (inside + outside) / 2
        inside, outside = (middle, outside) if fits(middle) else (inside, middle)
    return inside
