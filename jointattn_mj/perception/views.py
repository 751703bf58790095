"""A bank of views of one face, and where in a grey image they fit best (section 6.4.1: "template matching").

The fit is the normalised cross-correlation of view and image, -1 to 1, which ignores brightness and contrast. A faint
stain on a wall could thus pass for a face; so regions with much less contrast than the first view do not count.

The centre of a view is the centre of the face. A match therefore gives the same point of the face, whichever view fits.
"""

from typing import Any

import numpy as np
from numba import uintp

from jointattn_mj.guards.restored import check_array, check_whole
from jointattn_mj.io.compiled import njit
from jointattn_mj.io.opencv import cv2

MOST_PX = 1 << 15  # largest side of an image, and so of a view
FLAT = 5.0  # standard deviation of grey values below which a region has no pattern to correlate
FAR = 1e6  # pixels; nothing is searched beyond
NEAR = 0.05  # a view that scores this much less than the best at a position may still win when it is moved a little


@njit(cache=True, fastmath=True)
def _read_window(
    gray: np.ndarray, left: int, top: int, columns: int, rows: int, side: int, least_norm: float, region: np.ndarray,
    shifted: np.ndarray, norm: np.ndarray,
) -> None:  # fmt: skip
    """Copy the window's pixels to ``region`` and ``shifted``, and the norm of the pattern at each offset to ``norm``.

    ``shifted`` has a copy for each column offset, ``side`` wide, in which the pixels under a view are contiguous. A
    norm below ``least_norm`` becomes infinite, so that the position scores 0.
    """
    height, width = rows + side - 1, columns + side - 1
    for i in range(height):
        for j in range(width):
            region[i, j] = gray[top + i, left + j] - np.float32(128)
    for j in range(columns):
        for i in range(height):
            for k in range(side):
                shifted[j, i * side + k] = region[i, j + k]
    pixels = np.float32(side * side)
    total, squares = np.zeros(width, np.float32), np.zeros(width, np.float32)
    for i in range(side):
        for j in range(width):
            total[j] += region[i, j]
            squares[j] += region[i, j] * region[i, j]
    for i in range(rows):
        box, box_squares = np.float32(0), np.float32(0)
        for j in range(side):
            box += total[j]
            box_squares += squares[j]
        for j in range(columns):
            energy = box_squares - box * box / pixels
            norm[i, j] = np.sqrt(energy) if energy > least_norm * least_norm else np.float32(np.inf)
            if j < columns - 1:
                box += total[j + side] - total[j]
                box_squares += squares[j + side] - squares[j]
        if i < rows - 1:
            for j in range(width):
                total[j] += region[i + side, j] - region[i, j]
                squares[j] += region[i + side, j] ** 2 - region[i, j] ** 2


@njit(cache=True, fastmath=True)
def _correlate(
    shifted: np.ndarray, norm: np.ndarray, penalty: np.ndarray, view: np.ndarray, side: int, row: int, column: int
) -> np.float32:
    """Normalised cross-correlation of ``view`` (zero mean, unit norm) with the region at one offset, less penalty."""
    pixels, start, dot = shifted[column], uintp(row * side), np.float32(0)
    for k in range(uintp(view.size)):  # unsigned: no wrap-around checks
        dot += view[k] * pixels[start + k]
    score: np.float32 = dot / norm[row, column] - penalty[row, column]
    return score


@njit(cache=True, fastmath=True)
def _climb(
    shifted: np.ndarray, norm: np.ndarray, penalty: np.ndarray, view: np.ndarray, side: int, rows: int, columns: int,
    best: np.float32, row: int, column: int,
) -> tuple[np.float32, int, int]:  # fmt: skip
    """The nearest peak of the correlation: best score, row, column."""
    climbing = True
    while climbing:
        climbing = False
        here, there = row, column
        for step in range(4):
            i, j = here + (step == 0) - (step == 1), there + (step == 2) - (step == 3)
            if 0 <= i < rows and 0 <= j < columns:
                score = _correlate(shifted, norm, penalty, view, side, i, j)
                if score > best:
                    best, row, column, climbing = score, i, j, True
    return best, row, column


@njit(cache=True, fastmath=True)
def _scan(
    shifted: np.ndarray,
    norm: np.ndarray,
    penalty: np.ndarray,
    view: np.ndarray,
    side: int,
    rows: int,
    columns: int,
    step: int,
) -> tuple[np.float32, int, int]:
    """Best score, row, column among every ``step``-th offset, the middle one included."""
    best, row, column = np.float32(-2), 0, 0
    for i in range((rows // 2) % step, rows, step):
        for j in range((columns // 2) % step, columns, step):
            score = _correlate(shifted, norm, penalty, view, side, i, j)
            if score > best:
                best, row, column = score, i, j
    return best, row, column


@njit(cache=True, fastmath=True)
def _vertex(before: np.float32, here: np.float32, after: np.float32) -> np.float32:
    """Position of a parabola's peak, -.5 to .5, through three neighbouring values, the highest of which is ``here``."""
    curve = before - 2 * here + after
    return np.float32(0.5) * (before - after) / curve if curve < 0 else np.float32(0)


@njit(cache=True, fastmath=True)
def _match(
    gray: np.ndarray, views: np.ndarray, n: int, last: int, side: int, x: float, y: float, radius: int,
    distance_penalty: float, search_all_below: float, least_norm: float, region: np.ndarray, shifted: np.ndarray,
    norm: np.ndarray, penalty: np.ndarray, out: np.ndarray,
) -> int:  # fmt: skip
    """The view that fits best with its centre within ``radius`` of (x, y); -1 where that lies outside the image.

    The view that fitted last climbs from the position next to (x, y). The others are tried where it arrives, and those
    that come near climb too. If the best scores below ``search_all_below``, all are tried at every second position.
    Score, x and y of the centre, refined by a parabola on each axis, are written to ``out``.
    """
    corner_x, corner_y = x - (side - 1) / 2, y - (side - 1) / 2
    left, top = int(np.rint(corner_x)), int(np.rint(corner_y))
    first_x, last_x = max(left - radius, 0), min(left + radius, gray.shape[1] - side)
    first_y, last_y = max(top - radius, 0), min(top + radius, gray.shape[0] - side)
    columns, rows = last_x - first_x + 1, last_y - first_y + 1
    if columns <= 0 or rows <= 0:
        return -1
    _read_window(gray, first_x, first_y, columns, rows, side, least_norm, region, shifted, norm)
    for i in range(rows):
        for j in range(columns):
            off = (first_x + j - corner_x) ** 2 + (first_y + i - corner_y) ** 2
            penalty[i, j] = distance_penalty * off
    row, column = min(max(top - first_y, 0), rows - 1), min(max(left - first_x, 0), columns - 1)
    best = _correlate(shifted, norm, penalty, views[last], side, row, column)
    best, row, column = _climb(shifted, norm, penalty, views[last], side, rows, columns, best, row, column)
    view, row0, column0, last_score = last, row, column, best
    for k in range(n):
        if k != last:
            score = _correlate(shifted, norm, penalty, views[k], side, row0, column0)
            if score > last_score - NEAR:
                score, i, j = _climb(shifted, norm, penalty, views[k], side, rows, columns, score, row0, column0)
                if score > best:
                    best, row, column, view = score, i, j, k
    if best < search_all_below:
        for k in range(n):
            score, i, j = _scan(shifted, norm, penalty, views[k], side, rows, columns, 2)
            if score > best - NEAR:
                score, i, j = _climb(shifted, norm, penalty, views[k], side, rows, columns, score, i, j)
                if score > best:
                    best, row, column, view = score, i, j, k
    part_x, part_y = np.float32(0), np.float32(0)
    pattern = views[view]
    if 0 < column < columns - 1:
        before = _correlate(shifted, norm, penalty, pattern, side, row, column - 1)
        part_x = _vertex(before, best, _correlate(shifted, norm, penalty, pattern, side, row, column + 1))
    if 0 < row < rows - 1:
        before = _correlate(shifted, norm, penalty, pattern, side, row - 1, column)
        part_y = _vertex(before, best, _correlate(shifted, norm, penalty, pattern, side, row + 1, column))
    out[0] = best + penalty[row, column]
    out[1], out[2] = first_x + column + part_x + (side - 1) / 2, first_y + row + part_y + (side - 1) / 2
    return view


def crop(gray: np.ndarray, x: float, y: float, side: int) -> np.ndarray:
    """Crop a square from an image.

    Args:
        gray: (h, w) uint8.
        x: Its centre, pixels; values between pixels are interpolated, those beyond the border repeated.
        y: Likewise.
        side: Its side, pixels.

    Returns:
        (side, side) float32 grey values.
    """
    return cv2.getRectSubPix(gray, (side, side), (float(x), float(y)), patchType=cv2.CV_32F)


def normalised(patch: np.ndarray) -> tuple[np.ndarray, float]:
    """A patch with zero mean and unit norm, or zeros if it is flat; and its norm without the mean."""
    centred = patch - patch.mean()
    norm = float(np.linalg.norm(centred))
    flat = norm <= FLAT * np.sqrt(patch.size)
    return (np.zeros_like(centred) if flat else centred / norm).astype(np.float32), norm


class ViewBank:
    """Square views of a face.

    Views stay: newer ones, each positioned by those before it, would let the face's position drift. Only when the bank
    is full, a view that has not fitted best in ``forget_after`` matches is replaced; never the first.

    Attributes:
        n: How many views there are.
    """

    def __init__(
        self, side: int, capacity: int, radius: int, distance_penalty: float, search_all_below: float,
        contrast_ratio: float, forget_after: int,
    ):  # fmt: skip
        """Make an empty bank.

        Args:
            side: Side of views, pixels.
            capacity: Largest number of views.
            radius: Distance from the expected position, pixels, that ``match`` searches.
            distance_penalty: Loss of score for each squared pixel from there.
            search_all_below: Score below which ``match`` tries all views in all of the window.
            contrast_ratio: Least contrast of a match, as a share of the first view's.
            forget_after: Matches after which an unused view may be replaced.
        """
        self.side, self.capacity, self.radius = side, capacity, radius
        self.search_all_below, self.contrast_ratio = search_all_below, contrast_ratio
        self.forget_after, self.distance_penalty = forget_after, distance_penalty
        self.n = 0
        self._least_norm = 0.0
        self._views = np.zeros((capacity, side * side), np.float32)
        self._used = np.zeros(capacity, np.int64)
        self._clock = 0
        self._last = 0
        self._region = np.zeros((side + 2 * radius, side + 2 * radius), np.float32)
        self._shifted = np.zeros((2 * radius + 1, (side + 2 * radius) * side), np.float32)
        self._norm = np.zeros((2 * radius + 1, 2 * radius + 1), np.float32)
        self._penalty = np.zeros((2 * radius + 1, 2 * radius + 1), np.float32)
        self._out = np.zeros(3)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a bank.

        Raises:
            ValueError: Compiled code could not search it.
        """
        self.__dict__.update(state)
        side, radius, capacity = self.side, self.radius, self.capacity
        window, offsets = side + 2 * radius, 2 * radius + 1
        check_whole("side", side, 1, MOST_PX)
        check_whole("radius", radius, 0, MOST_PX)
        check_whole("views", self.n, 0, capacity)
        check_whole("the last view", self._last, 0, max(self.n - 1, 0))
        check_array("views", self._views, (capacity, side * side), np.float32)
        check_array("used", self._used, (capacity,), np.int64)
        check_array("region", self._region, (window, window), np.float32)
        check_array("shifted", self._shifted, (offsets, window * side), np.float32)
        check_array("norm", self._norm, (offsets, offsets), np.float32)
        check_array("penalty", self._penalty, (offsets, offsets), np.float32)
        check_array("out", self._out, (3,), float)

    @property
    def views(self) -> np.ndarray:
        """The views, (n, side, side) float32, with zero mean and unit norm."""
        return self._views[: self.n].reshape(-1, self.side, self.side)

    def add(self, gray: np.ndarray, x: float, y: float) -> bool:
        """Add the region around a point as a view.

        Args:
            gray: (h, w) uint8.
            x: The point, pixels.
            y: Likewise.

        Returns:
            Whether it was added; not if it is flat, or the bank full of views in use.
        """
        view, norm = normalised(crop(gray, x, y, self.side))
        if not view.any():
            return False
        if self.n == 0:
            self._least_norm = self.contrast_ratio * norm
        slot = self.n
        if self.n == self.capacity:
            slot = 1 + int(self._used[1:].argmin())
            if self._clock - self._used[slot] < self.forget_after:
                return False
        else:
            self.n += 1
        self._views[slot] = view.ravel()
        self._used[slot] = self._clock
        self._last = slot
        return True

    def recent(self, count: int) -> np.ndarray:
        """Indices of the first view and the ``count - 1`` others used last."""
        order = 1 + np.argsort(-self._used[1 : self.n], kind="stable")[: count - 1]
        return np.concatenate([np.zeros(1, int), order])

    def match(self, gray: np.ndarray, x: float, y: float) -> tuple[float, float, float]:
        """The best fit of any view near a point; positions nearer to it are preferred.

        Args:
            gray: (h, w) uint8.
            x: The point, pixels.
            y: Likewise.

        Returns:
            Score, -1 to 1, and the centre (x, y), pixels with fractions; -1 and NaN where the window lies outside.
        """
        view = -1
        if self.n > 0 and abs(x) < FAR and abs(y) < FAR:
            view = _match(
                gray, self._views, self.n, self._last, self.side, x, y, self.radius, self.distance_penalty,
                self.search_all_below, self._least_norm,
                self._region, self._shifted, self._norm, self._penalty, self._out,
            )  # fmt: skip
        if view < 0:
            return -1.0, float("nan"), float("nan")
        self._clock += 1
        self._last = view
        self._used[view] = self._clock
        score, centre_x, centre_y = self._out.tolist()
        return score, centre_x, centre_y

    def search(self, gray: np.ndarray, count: int) -> list[tuple[float, float]]:
        """Where views fit best in the whole image, at half resolution.

        Args:
            gray: (h, w) uint8.
            count: How many views are tried: those of ``recent``.

        Returns:
            A centre (x, y), pixels, for each view; none in an image that is smaller than a view.
        """
        if min(gray.shape) < self.side:
            return []
        half = cv2.resize(gray, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA).astype(np.float32)
        side, middle = self.side // 2, (self.side - 1) / 2
        mean = cv2.blur(half, (side, side), anchor=(0, 0), borderType=cv2.BORDER_REPLICATE)
        square = cv2.blur(half * half, (side, side), anchor=(0, 0), borderType=cv2.BORDER_REPLICATE)
        faint = square - mean * mean < (self._least_norm / self.side / 2) ** 2  # the coarse image has less contrast
        centres = []
        for index in self.recent(count):
            small = cv2.resize(self.views[index], (side, side), interpolation=cv2.INTER_AREA)
            fit = cv2.matchTemplate(half, small, cv2.TM_CCOEFF_NORMED)
            fit[faint[: fit.shape[0], : fit.shape[1]]] = -1
            left, top = cv2.minMaxLoc(fit)[3]
            centres.append((2 * left + middle, 2 * top + middle))
        return centres
