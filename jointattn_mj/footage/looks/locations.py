"""Locations of objects in a video: where each was last, and at how many locations it has rested."""

import numpy as np

REST_LOOKS = 5
"""Looks for which an object must stay to have a placement."""
REST_HEIGHTS = 0.1
"""Greatest extent of an object at rest, heights of the face's square."""
MOVED_HEIGHTS = 0.25
"""Distance between two placements, heights of the face's square."""


def last_locations(px: np.ndarray, cut: np.ndarray) -> np.ndarray:
    """Fill in where each candidate was seen last.

    Args:
        px: (n, k, 2) pixels; NaN where a candidate is not seen.
        cut: (n,) whether the image was cut before this look; what was seen before then says nothing.

    Returns:
        (n, k, 2) pixels; NaN where a candidate was not seen since the cut.
    """
    numbers = np.arange(len(px))
    begun = np.maximum.accumulate(np.where(cut, numbers, 0))
    last = np.maximum.accumulate(np.where(np.isfinite(px).all(-1), numbers[:, None], -1), axis=0)
    filled = np.take_along_axis(px, np.maximum(last, 0)[..., None], axis=0)
    filled[last < begun[:, None]] = np.nan
    return filled


def known_locations(px: np.ndarray, cut: np.ndarray, moved_px: float) -> np.ndarray:
    """Fill in where candidates were while they were hidden.

    One that is seen again where it was before has stayed there. One that is seen again elsewhere was moved meanwhile,
    and nobody knows when. One that is not seen again is taken to have stayed.

    Args:
        px: (n, k, 2) pixels; NaN where a candidate is not seen.
        cut: (n,) whether the image was cut before this look; what was seen before then says nothing.
        moved_px: Distance from which a location is another one.

    Returns:
        (n, k, 2) pixels; NaN where a location is not known.
    """
    before = last_locations(px, cut)
    after = last_locations(px[::-1], np.append(False, cut[:0:-1]))[::-1]
    visible = np.isfinite(px).all(-1)
    moved = np.linalg.norm(after - before, axis=-1) > moved_px
    before[moved & ~visible] = np.nan
    return before


def placements(locations: np.ndarray) -> np.ndarray:
    """At how many locations each candidate has rested.

    Args:
        locations: (n, k, 2) in heights of the face's square; NaN where a candidate is not seen.

    Returns:
        (k,) whole numbers.
    """
    counts = np.zeros(locations.shape[1], int)
    for k in range(locations.shape[1]):
        visible = locations[np.isfinite(locations[:, k]).all(-1), k]
        if len(visible) < REST_LOOKS:
            continue
        windows = np.lib.stride_tricks.sliding_window_view(visible, REST_LOOKS, axis=0)  # (m, 2, looks)
        still = (windows.max(-1) - windows.min(-1) <= REST_HEIGHTS).all(-1)
        before = np.full(2, np.inf)
        for middle in np.median(windows[still], axis=-1):
            if not np.linalg.norm(middle - before) < MOVED_HEIGHTS:
                counts[k] += 1
                before = middle
    return counts
