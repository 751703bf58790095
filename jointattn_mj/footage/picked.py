"""The colours of an object that the user has picked in one image of the video."""

from itertools import combinations

import cv2
import numpy as np

from jointattn_mj.errors import FootageError
from jointattn_mj.footage.areas import BITS, CELL_OF
from jointattn_mj.footage.colours import Sought
from jointattn_mj.footage.reader import Footage

TOLERANCE = 14
"""Difference from the picked pixel up to which its neighbours belong to the object at first (CIE Lab, 8 bits)."""
LARGEST_SHARE = 0.15
"""Largest share of the image that a picked object takes."""
SHARED = 0.5
"""Share of the colours of one object from which another is taken to have the same."""
LIKELIER = 3.0
"""How much likelier a colour must be on the object than elsewhere in the image."""


def picked_tables(footage: Footage, sought: tuple[Sought, ...]) -> dict[str, np.ndarray]:
    """Which colours belong to each object that was picked, by name.

    Args:
        footage: The video; it is read up to the last time that was picked.
        sought: All objects.

    Returns:
        (64^3,) bool for each.

    Raises:
        FootageError: The video has no such time or pixel, an object cannot be told from what is around it, or two have
            the same colours.
    """
    waiting = sorted((item.picked[0], item.name, item) for item in sought if item.picked is not None)
    tables: dict[str, np.ndarray] = {}
    if not waiting:
        return tables
    for frame, still in enumerate(footage):
        while waiting and frame >= footage.frame_at(waiting[0][0]):
            wanted = waiting.pop(0)[2]
            tables[wanted.name] = colours_at(still.image, wanted)
        if not waiting:
            require_apart(tables)
            return tables
    raise FootageError(
        f"object {waiting[0][1]} was picked at {waiting[0][0]:g} s, and {footage.path} ends before; pick it earlier"
    )


def require_apart(tables: dict[str, np.ndarray]) -> None:
    """Check that no two objects have the same colours, by which alone they are told apart.

    Args:
        tables: The colours of each, (64^3,) bool, by name.

    Raises:
        FootageError: Two have.
    """
    for (name, own), (other, others) in combinations(tables.items(), 2):
        if (own & others).sum() > SHARED * min(own.sum(), others.sum()):
            raise FootageError(
                f"objects {name} and {other} have the same colours: is one before the other at that time? Pick another "
                "pixel or time; of things that look alike pick one, and follow several areas of it (`areas_each`)"
            )


def colours_at(image: np.ndarray, sought: Sought) -> np.ndarray:
    """The colours of the object at a pixel, as a table (64^3,) bool.

    Args:
        image: (h, w, 3) uint8 BGR.
        sought: The object.

    Raises:
        FootageError: The pixel lies outside, or the object cannot be told from what is around it.
    """
    assert sought.picked is not None
    seconds, (x, y) = sought.picked[0], (int(value) for value in sought.picked[1:])
    height, width = image.shape[:2]
    if not (0 <= x < width and 0 <= y < height):
        raise FootageError(f"object {sought.name} was picked at pixel {x},{y}; the video has {width}x{height}")
    own = _region(image, x, y)
    share = float(own.mean())
    if share > LARGEST_SHARE:
        raise FootageError(
            f"object {sought.name}: what is at pixel {x},{y} at {seconds:g} s takes {share:.0%} of the image, and is "
            "not told from what is around it; pick another pixel or time"
        )
    there, elsewhere = _shares(image[own]), _shares(image[~own])
    belongs = (there > 2e-4) & (there > LIKELIER * elsewhere)
    if there[belongs].sum() < 0.3:
        raise FootageError(
            f"object {sought.name}: the colours at pixel {x},{y} at {seconds:g} s are found all over the image; pick a "
            "pixel of another colour on it"
        )
    return np.asarray(belongs[CELL_OF])


def _region(image: np.ndarray, x: int, y: int) -> np.ndarray:
    """Pixels (h, w) bool of what is at (x, y): like its surroundings of one colour, refined by GrabCut."""
    height, width = image.shape[:2]
    lab = cv2.cvtColor(cv2.GaussianBlur(image, (0, 0), 1.0), cv2.COLOR_BGR2LAB)
    filled = np.zeros((height + 2, width + 2), np.uint8)
    flags = 8 | cv2.FLOODFILL_FIXED_RANGE | cv2.FLOODFILL_MASK_ONLY | (1 << 8)
    cv2.floodFill(
        lab, filled, (x, y), 0, (2 * TOLERANCE, TOLERANCE, TOLERANCE), (2 * TOLERANCE, TOLERANCE, TOLERANCE), flags
    )
    seed = filled[1:-1, 1:-1]
    if seed.mean() > LARGEST_SHARE:
        return seed.astype(bool)
    left, top, wide, high = cv2.boundingRect(seed)
    grow = max(6, round(0.3 * max(wide, high)))
    x0, y0 = max(0, left - 3 * grow), max(0, top - 3 * grow)
    x1, y1 = min(width, left + wide + 3 * grow), min(height, top + high + 3 * grow)
    mask = np.full((height, width), cv2.GC_BGD, np.uint8)
    mask[max(0, top - grow) : top + high + grow, max(0, left - grow) : left + wide + grow] = cv2.GC_PR_BGD
    mask[seed > 0] = cv2.GC_PR_FGD
    mask[max(0, y - 2) : y + 3, max(0, x - 2) : x + 3] = cv2.GC_FGD
    part = np.ascontiguousarray(mask[y0:y1, x0:x1])
    if (part == cv2.GC_BGD).sum() < 16 or (part & 1).sum() < 16:
        return seed.astype(bool)
    cv2.setRNGSeed(0)  # GrabCut clusters colours from random ones
    models = np.zeros((1, 65)), np.zeros((1, 65))
    cv2.grabCut(image[y0:y1, x0:x1], part, (0, 0, 1, 1), *models, 3, cv2.GC_INIT_WITH_MASK)
    whole = np.zeros((height, width), np.uint8)
    whole[y0:y1, x0:x1] = part & 1
    parts = cv2.connectedComponents(whole, connectivity=8)[1]
    return np.asarray(parts == parts[y, x])


def _shares(pixels: np.ndarray) -> np.ndarray:
    """Share of each cell of colours in pixels (n, 3) uint8 BGR, a little of it given to neighbouring cells."""
    level = pixels.astype(np.int32) >> 8 - BITS
    cells = level[:, 2] << 2 * BITS | level[:, 1] << BITS | level[:, 0]
    counts = np.bincount(cells, minlength=1 << 3 * BITS).reshape((1 << BITS,) * 3).astype(float)
    for axis in range(3):
        before, after = np.roll(counts, 1, axis), np.roll(counts, -1, axis)
        counts = 0.6 * counts + 0.2 * (before + after)
    return np.asarray(counts.ravel() / max(float(counts.sum()), 1.0))
