"""Grey values of an image, worked out only where somebody reads them: a sixth of it is enough in most looks."""

from typing import Any

import numpy as np
from numba import uintp

from jointattn_mj.errors import ObservationError
from jointattn_mj.guards.border import checked_by, numbers, require_array
from jointattn_mj.io.compiled import njit

_RED, _GREEN, _BLUE, _HALF, _BITS = (np.uint32(k) for k in (9798, 19235, 3735, 1 << 14, 15))  # OpenCV's weights


def require_image(image: Any) -> None:
    """Hold an image against what compiled code reads.

    Raises:
        ObservationError: It is no uint8 array (h, w, 3), has no pixels, or does not lie in memory row by row.
    """
    require_array("image", image, (-1, -1, 3), "u")
    _require_pixels("image", image)


def require_gray(gray: Any, shape: tuple[int, ...] = (-1, -1)) -> None:
    """The same for a grey image (h, w) uint8."""
    require_array("grey image", gray, shape, "u")
    _require_pixels("grey image", gray)


def _require_pixels(name: str, image: np.ndarray) -> None:
    if image.dtype != np.uint8 or image.size == 0 or not image.flags.c_contiguous:
        raise ObservationError(
            f"{name}: expected uint8, one pixel or more, contiguous (see numpy.ascontiguousarray); "
            f"got {image.dtype} {image.shape}"
        )


def _check_fill(image, gray, x0, y0, x1, y1):
    require_image(image)
    require_gray(gray, image.shape[:2])
    numbers("part of the image", (x0, y0, x1, y1), (4,))


@checked_by(_check_fill)
@njit(cache=True)
def fill_gray(image, gray, x0, y0, x1, y1):
    """Work out ``gray`` (h, w) uint8 from x0, y0 to x1, y1 (exclusive; cut at the border), as OpenCV does to the bit.

    image: (h, w, 3) uint8 RGB, contiguous like ``gray``.
    """
    height, width = gray.shape
    x0, y0, x1, y1 = max(x0, 0), max(y0, 0), min(x1, width), min(y1, height)
    if x1 <= x0:
        return
    channels, values = image.ravel(), gray.ravel()
    for y in range(y0, y1):
        start = uintp(y * width + x0)
        for k in range(start, start + uintp(x1 - x0)):  # unsigned: no wrap-around checks, six times as fast
            at = uintp(3) * k
            red, green = np.uint32(channels[at]), np.uint32(channels[at + uintp(1)])
            blue = np.uint32(channels[at + uintp(2)])
            values[k] = (_RED * red + _GREEN * green + _BLUE * blue + _HALF) >> _BITS
