"""Optical flow by block matching between two grey images (section 6.4.1), to a fraction of a pixel.

Each block of 8x8 pixels descends to the displacement, in whole pixels, with the least sum of squared differences. A
parabola through the neighbouring sums on each axis gives the fraction. Near its minimum a sum of squares is a parabola;
a sum of absolute values is a wedge, and a parabola through a wedge halves small displacements. Sums are taken both
ways, the new block in the old image and the old block in the new one. One way alone gives up to .1 px of motion for two
equal images, since what enters the block on its two sides differs.
"""

import numpy as np
from numba import uintp

from jointattn_mj.io.compiled import njit

BLOCK = 8  # pixels; section 6.4.1 names block matching without a size


@njit(cache=True)
def _difference(now: np.ndarray, before: np.ndarray, y: int, x: int, dy: int, dx: int) -> int:
    """Sum of squared differences between the block at (x, y) now and the one at (x - dx, y - dy) before."""
    total = np.int32(0)
    row_now, row_before = uintp(y), uintp(y - dy)
    column_now, column_before = uintp(x), uintp(x - dx)
    for i in range(uintp(BLOCK)):
        for j in range(uintp(BLOCK)):
            off = np.int32(now[row_now + i, column_now + j]) - np.int32(before[row_before + i, column_before + j])
            total += off * off
    return int(total)


@njit(cache=True)
def _inside(y: int, x: int, part: np.ndarray) -> bool:
    inside: bool = part[1] <= y <= part[3] - BLOCK and part[0] <= x <= part[2] - BLOCK
    return inside


@njit(cache=True)
def _fraction(before: float, here: float, after: float, floor: float) -> float:
    """Vertex of the parabola through three sums, -.5 to .5; NaN if it is flatter than ``floor``."""
    curve = before - 2 * here + after
    if curve < floor:
        return np.nan
    return min(max(0.5 * (before - after) / curve, -0.5), 0.5)


@njit(cache=True)
def _block_flow(
    now: np.ndarray, before: np.ndarray, part: np.ndarray, y: int, x: int, start_y: int, start_x: int, reach: int,
    floor: float, out: np.ndarray,
) -> bool:  # fmt: skip
    """Write the displacement (x, y) of one block to ``out``, by descent from a start. False if it has no texture."""
    if not _inside(y - start_y, x - start_x, part):
        start_y, start_x = 0, 0
    dy, dx = start_y, start_x
    here = _difference(now, before, y, x, dy, dx)
    around = np.empty(4, np.int64)
    while True:
        best, step = here, -1
        for side in range(4):
            next_y = dy + (side == 0) - (side == 1)
            next_x = dx + (side == 2) - (side == 3)
            off_y, off_x = abs(next_y - start_y), abs(next_x - start_x)
            if not _inside(y - next_y, x - next_x, part) or max(off_y, off_x) > reach:
                return False
            around[side] = _difference(now, before, y, x, next_y, next_x)
            if around[side] < best:
                best, step = around[side], side
        if step < 0:
            break
        dy += (step == 0) - (step == 1)
        dx += (step == 2) - (step == 3)
        here = best
    if not (_inside(y - 1, x - 1, part) and _inside(y + 1, x + 1, part)):
        return False
    for side in range(4):  # and the other way round: the old block, moved by the same difference, in the new image
        off_y = (side == 0) - (side == 1)
        off_x = (side == 2) - (side == 3)
        around[side] += _difference(before, now, y - dy, x - dx, -dy - off_y, -dx - off_x)
    here *= 2
    part_y, part_x = _fraction(around[1], here, around[0], 2 * floor), _fraction(around[3], here, around[2], 2 * floor)
    if np.isnan(part_y) and np.isnan(part_x):
        return False
    out[0] = 0.0 if np.isnan(part_x) else dx + part_x
    out[1] = 0.0 if np.isnan(part_y) else dy + part_y
    return True


@njit(cache=True)
def region_flow(
    now: np.ndarray, before: np.ndarray, part: np.ndarray, box: np.ndarray, step: int, margin: int, start_y: int,
    start_x: int, reach: int, floor: float, owner: int, count: int, blocks: np.ndarray, flow: np.ndarray,
    owners: np.ndarray,
) -> int:  # fmt: skip
    """Append the flow of the textured blocks of one region to the arrays.

    Args:
        now: (h, w) uint8 grey image.
        before: The same some frames ago.
        part: x0, y0, x1, y1 (the last two exclusive) of what may be read of both images.
        box: The region, likewise.
        step: Distance of blocks, pixels.
        margin: Rim around the region, pixels; a negative one leaves a rim out.
        start_y: Where blocks start to descend, pixels.
        start_x: Likewise.
        reach: How far they descend from there, pixels.
        floor: Least curvature of a block's sums, below which it has no texture.
        owner: Number to write for these blocks.
        count: How many blocks the arrays hold.
        blocks: (m, 2) centres (x, y).
        flow: (m, 2) displacements (x, y), pixels.
        owners: (m,) numbers.

    Returns:
        The new count.
    """
    y1, x1 = min(box[3] + margin, part[3]), min(box[2] + margin, part[2])  # a negative margin leaves a rim out
    for y in range(max(box[1] - margin, part[1]), y1 - BLOCK + 1, step):
        for x in range(max(box[0] - margin, part[0]), x1 - BLOCK + 1, step):
            if count == len(blocks):
                return count
            if _block_flow(now, before, part, y, x, start_y, start_x, reach, floor, flow[count]):
                blocks[count, 0], blocks[count, 1] = x + (BLOCK - 1) / 2, y + (BLOCK - 1) / 2
                owners[count] = owner
                count += 1
    return count
