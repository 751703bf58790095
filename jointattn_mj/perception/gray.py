"""Grey values of an image, worked out only where they are read: mostly a sixth of the image."""

from typing import Any

import numpy as np
from numba import uintp

from jointattn_mj.errors import ObservationError
from jointattn_mj.guards.border import checked_by, numbers, require_array
from jointattn_mj.io.compiled import njit

_RED, _GREEN, _BLUE, _HALF, _BITS = (np.uint32(k) for k in (9798, 19235, 3735, 1 << 14, 15))  # OpenCV's weights
_BYTE, _ANY = np.dtype(np.uint8), (-1, -1)


def require_image(image: Any) -> None:
    """Check that an image can be read by compiled code.

    Raises:
        ObservationError: It is no uint8 array (h, w, 3), has no pixels, or does not lie in memory row by row.
    """
    if not _is_plain(image, 3) or image.shape[2] != 3:
        require_array("image", image, (-1, -1, 3), "u")
        _require_pixels("image", image)


def require_gray(gray: Any, shape: tuple[int, ...] = _ANY) -> None:
    """Check a grey image (h, w) uint8, likewise.

    Args:
        gray: The image.
        shape: Its height and width; -1 for any.

    Raises:
        ObservationError: It is no such image.
    """
    if not _is_plain(gray, 2) or shape not in (_ANY, gray.shape):
        require_array("grey image", gray, shape, "u")
        _require_pixels("grey image", gray)


def _is_plain(image: Any, axes: int) -> bool:
    """Whether an image is one as nearly all are; told in a quarter of the time that the checks take."""
    plain: bool = type(image) is np.ndarray and image.dtype is _BYTE and image.ndim == axes and image.size > 0
    return plain and image.flags.c_contiguous


def _require_pixels(name: str, image: np.ndarray) -> None:
    if image.dtype != np.uint8 or image.size == 0 or not image.flags.c_contiguous:
        raise ObservationError(
            f"{name}: expected uint8, one pixel or more, contiguous (see numpy.ascontiguousarray); "
            f"got {image.dtype} {image.shape}"
        )


def _check_fill(image: Any, gray: Any, x0: Any, y0: Any, x1: Any, y1: Any) -> None:
    require_image(image)
    require_gray(gray, image.shape[:2])
    numbers("part of the image", (x0, y0, x1, y1), (4,))


@checked_by(_check_fill)
@njit(cache=True)
def fill_gray(image: np.ndarray, gray: np.ndarray, x0: int, y0: int, x1: int, y1: int) -> None:
    """Work out part of a grey image, as OpenCV does to the bit.

    Args:
        image: (h, w, 3) uint8 RGB, contiguous.
        gray: (h, w) uint8, contiguous; written to.
        x0: Left edge of the part, pixels; it is cut at the border.
        y0: Upper edge.
        x1: Right edge, exclusive.
        y1: Lower edge, exclusive.
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
