"""The face of interest as the robot's perception takes it: location, box, and pattern from the video's own pixels."""

from typing import Protocol

import cv2
import numpy as np

from jointattn_mj.footage.frame_map import IMAGE_HEIGHT, IMAGE_WIDTH
from jointattn_mj.footage.people import Sighting
from jointattn_mj.perception.faces import NO_FACE, PATCH_SIDE, FaceFix

PATTERN_HEIGHTS = 1.1
"""Side of the square that becomes the pattern, in heights of the face's box, which reaches from brow to chin."""
RAISED = 0.1
"""How far the region in which motion is measured lies above the pattern's, in heights of that: a mouth that speaks, and
a hand at the chin, are not the head."""
BLUR_PX = 0.7
"""Standard deviation of the pattern's blur, as of ``perception.faces``."""


class ToImage(Protocol):
    """A map from pixels of the video to those of the robot's image."""

    @property
    def scale_x(self) -> float:
        """Pixels of the robot's image for the width of one of the video."""

    @property
    def scale_y(self) -> float:
        """Pixels of the robot's image for the height of one of the video."""

    def to_image(self, px: np.ndarray) -> np.ndarray:
        """Pixels (..., 2) of the robot's image for pixels of the video."""


class FollowedFace:
    """Hands a face that was found in the video to ``PixelPerception``, in place of its own detector."""

    reach_px = 0

    def __init__(self) -> None:
        self._fix = NO_FACE
        self._side = np.zeros(2)
        self._pattern = np.zeros((PATCH_SIDE, PATCH_SIDE), np.float32)

    def show(self, face: Sighting | None, image: np.ndarray, mapped: ToImage) -> None:
        """Say where the face is in the next image.

        Args:
            face: The face; None where it was not found.
            image: (h, w, 3) uint8 BGR, the video's image.
            mapped: From its pixels to those of the robot's image.
        """
        self._fix = NO_FACE
        if face is None:
            return
        x, y = mapped.to_image(face.centre - 0.5)
        if not (0 <= x < IMAGE_WIDTH and 0 <= y < IMAGE_HEIGHT):
            return
        high = PATTERN_HEIGHTS * float(face.smooth[3])
        side = np.array([high * mapped.scale_y / mapped.scale_x, high])
        self._fix = FaceFix(float(x), float(y), face.score, True)
        self._side = side * (mapped.scale_x, mapped.scale_y)
        self._pattern = pattern(image, face.centre, side)

    def detect(self, gray: np.ndarray, expected_px: tuple[float, float] | None, complete: object) -> FaceFix:
        """The face that was shown last.

        Args:
            gray: Grey image (h, w) uint8, which is not looked at: faces were found before.
            expected_px: Where a face is expected, pixels; not used.
            complete: Finishes the grey image; not called.
        """
        return self._fix

    def patch(self, gray: np.ndarray, fix: FaceFix) -> np.ndarray:
        """Its pattern: (32, 32) float32 grey values, 0 to 255."""
        return self._pattern

    def box(self, fix: FaceFix, shape: tuple[int, int]) -> tuple[int, int, int, int]:
        """The region of its motion x0, y0, x1, y1 (the last two exclusive), cut at the border of an image (h, w)."""
        wide, high = (round(float(side)) for side in self._side)
        x0, y0 = round(fix.x - (wide - 1) / 2), round(fix.y - (high - 1) / 2 - RAISED * high)
        return max(x0, 0), max(y0, 0), min(x0 + wide, shape[1]), min(y0 + high, shape[0])


def pattern(image: np.ndarray, centre: np.ndarray, side: np.ndarray) -> np.ndarray:
    """A region of an image as a face pattern.

    Args:
        image: (h, w, 3) uint8 BGR.
        centre: (2,) x, y of its middle, pixels from the image's left and upper edge.
        side: (2,) its width and height, pixels.

    Returns:
        (32, 32) float32 grey values, 0 to 255.
    """
    times = int(np.ceil(max(*side, PATCH_SIDE) / PATCH_SIDE))  # each pixel of the pattern is a mean of times x times
    out = PATCH_SIDE * times
    scale = out / side
    corner = centre - side / 2
    into = np.array(
        [[scale[0], 0, scale[0] * (0.5 - corner[0]) - 0.5], [0, scale[1], scale[1] * (0.5 - corner[1]) - 0.5]]
    )
    region = cv2.warpAffine(image, into, (out, out), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    gray = cv2.cvtColor(region, cv2.COLOR_BGR2GRAY).astype(np.float32)
    small = cv2.resize(gray, (PATCH_SIDE, PATCH_SIDE), interpolation=cv2.INTER_AREA)
    return np.ascontiguousarray(cv2.GaussianBlur(small, (0, 0), BLUR_PX))
