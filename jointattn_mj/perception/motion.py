"""Motion detection: which candidates move while the robot's head is still (eq. 6.3, |f_i| > epsilon_i; section 6.4.1).

An image is compared with the one two frames back by block matching (``perception.flow``).

The face moves where the mean flow of its textured blocks is long enough. Its region stays the same through a fixation,
so that it does not move with the face. An object moves where its centroid and its blocks both move, and its pixels
change as those of a moving thing. An arm that passes behind it gives flow, but no shift of the centroid. An arm that
passes before it shifts the centroid, but takes pixels on one side without adding any on the other.
"""

from collections import deque
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from jointattn_mj.guards.border import require_array
from jointattn_mj.guards.restored import check_array, check_whole
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked, Real, Whole
from jointattn_mj.perception.flow import BLOCK, region_flow
from jointattn_mj.perception.gray import require_gray
from jointattn_mj.perception.objects import Areas, check_areas
from jointattn_mj.perception.views import MOST_PX

MAX_BLOCKS = 1024  # flow vectors kept for one image
MOST_FRAMES = 1 << 31  # frames between two images
MOST_EDGE = 1 << 31  # how far out of an image a face may lie, pixels
Box = tuple[int, int, int, int]  # x0, y0, x1, y1, the last two exclusive
NOWHERE: Box = (0, 0, 0, 0)


@dataclass(frozen=True)
class MotionConfig(Checked):
    """Options of motion detection. epsilon_i of eq. 6.3 is "a small positive constant"; all of these are choices.

    Thresholds were set on rendered fixations without camera noise, so that objects faster than .05 m/s and heads faster
    than 4 degrees/s are told from slower ones.
    """

    frames_back: Annotated[int, Whole("[1, 300]")] = 2
    """Frames between the two images. A head that turns at 60 degrees/s shifts .6 px a frame: two make it stand out, and
    more would delay it."""
    face_px: Annotated[float, Real("[0, 1000]")] = 0.045
    """epsilon of the face (eq. 6.3): mean flow, pixels in ``frames_back`` frames; about 4 degrees/s of the head."""
    object_px: Annotated[float, Real("[0, 1000]")] = 0.25
    """epsilon of an object (eq. 6.3): shift of the centroid and mean flow, each, pixels in ``frames_back`` frames."""
    stay_ratio: Annotated[float, Real("[0, 100]")] = 1.0
    """What moves goes on moving above this share of its threshold; less than 1 bridges noise."""
    linger_frames: Annotated[int, Whole("[0, 1e6]")] = 0
    """Frames for which motion goes on afterwards. ``frames_back`` already delays the end by one."""
    texture: Annotated[float, Real("[0.001, 1e6]")] = 4.0
    """Least mean squared grey difference that a shift by one pixel makes in a block; below it an axis has no flow."""
    face_inset_px: Annotated[int, Whole("[0, 120]")] = 4
    """Rim of the face's box, pixels, that is left out: edge of the hair, background. 24x24 of 32x32 pixels stay."""
    step_px: Annotated[int, Whole("[1, 240]")] = 4
    """Distance of blocks, pixels: they overlap by half, since an object is only two blocks wide."""
    object_margin_px: Annotated[int, Whole("[0, 240]")] = 2
    """Rim around an object's box, pixels, so that its outline lies inside blocks."""
    reach_px: Annotated[int, Whole("[1, 240]")] = 6
    """How far a block descends, pixels, from where it starts: 0 for the face, the centroid's shift for an object."""
    refit_ratio: Annotated[float, Real("[0, 100]")] = 0.7
    """Largest share of changed pixels that remains once the old mask is shifted, for shifts of a pixel and more."""

    ADVANCED: ClassVar = ("step_px", "object_margin_px", "reach_px", "refit_ratio")


@dataclass
class Motion:
    """What moves now. The arrays belong to the detector and hold until its next image.

    Attributes:
        face_moves: Whether the face moves.
        object_moves: (n,) bool, which objects move.
        blocks: (m, 2) centres (x, y), pixels, of the textured blocks.
        flow: (m, 2) displacement (x, y), pixels in ``frames_back`` frames.
        owner: (m,) which object a block belongs to; n for the face.
        strength: (n + 1,) what is held against epsilon_i, pixels in ``frames_back`` frames, the face last.
    """

    face_moves: bool
    object_moves: np.ndarray
    blocks: np.ndarray
    flow: np.ndarray
    owner: np.ndarray
    strength: np.ndarray

    def __repr__(self) -> str:
        moving = np.flatnonzero(self.object_moves).tolist()
        return f"Motion(face_moves={self.face_moves}, objects moving={moving}, {len(self.blocks)} blocks)"


NOTHING: Any = np.int64(0)
"""For a plain 0, numba compiles what it is given to once more."""


@njit(cache=True)
def _changed(
    mask: np.ndarray, corner: np.ndarray, before: np.ndarray, corner_before: np.ndarray, shift_x: int, shift_y: int
) -> tuple[int, int]:
    """Numbers of pixels gained and lost from the old mask, moved by a shift, to the new one."""
    side = mask.shape[0]
    right, down = corner[0] - corner_before[0] - shift_x, corner[1] - corner_before[1] - shift_y
    now, old, both = 0, 0, 0
    for i in range(side):
        for j in range(side):
            old += before[i, j]
            if mask[i, j]:
                now += 1
                if 0 <= i + down < side and 0 <= j + right < side:
                    both += before[i + down, j + right]
    return now - both, old - both


@njit(cache=True)
def _moved_as_one(
    mask: np.ndarray, corner: np.ndarray, box: np.ndarray, before: np.ndarray, corner_before: np.ndarray,
    box_before: np.ndarray, shift_x: float, shift_y: float, refit_ratio: float,
) -> bool:  # fmt: skip
    """Whether an object's pixels changed because it moved, and not because something passed before it.

    A small move gains pixels on one side and loses some on the other; or, for a box seen straight on, gains or loses
    just one row or column. After a move of a pixel or more, shifting the old mask leaves little difference.
    """
    gained, lost = _changed(mask, corner, before, corner_before, NOTHING, NOTHING)
    if shift_x * shift_x + shift_y * shift_y <= 1.0:
        wide, high = box[2] - box[0], box[3] - box[1]
        wide_before, high_before = box_before[2] - box_before[0], box_before[3] - box_before[1]
        rows = abs(wide * high - wide_before * high_before)
        one_row = max(abs(wide - wide_before), abs(high - high_before)) == 1
        return min(gained, lost) >= 1 or (one_row and abs(max(gained, lost) - rows) <= 0.1 * rows)
    x, y = int(np.rint(shift_x)), int(np.rint(shift_y))
    gained_still, lost_still = _changed(mask, corner, before, corner_before, x, y)
    return gained_still + lost_still <= refit_ratio * (gained + lost)


@njit(cache=True)
def _mean_length(flow: np.ndarray, start: int, count: int) -> float:
    """Length of the mean of the flow vectors from ``start`` to ``count``; 0 without any."""
    x, y = 0.0, 0.0
    for i in range(start, count):
        x += flow[i, 0]
        y += flow[i, 1]
    return np.hypot(x, y) / (count - start) if count > start else 0.0


@njit(cache=True)
def _common(corner: np.ndarray, other: np.ndarray, side: int, shape: tuple[int, ...], part: np.ndarray) -> None:
    """Write the part that two windows of ``side`` pixels have in common within the image."""
    for axis in range(2):
        part[axis] = max(corner[axis], other[axis], 0)
        part[2 + axis] = min(min(corner[axis], other[axis]) + side, shape[1 - axis])


@njit(cache=True)
def _equal(now: np.ndarray, before: np.ndarray, part: np.ndarray) -> bool:
    """Whether a part is the same in two images."""
    for y in range(part[1], part[3]):
        for x in range(part[0], part[2]):
            if now[y, x] != before[y, x]:
                return False
    return True


@njit(cache=True)
def _measure(
    now: np.ndarray, before: np.ndarray, face_box: Box, face_part: Box, visible: np.ndarray, px: np.ndarray,
    box: np.ndarray, mask: np.ndarray, corner: np.ndarray, visible_before: np.ndarray, px_before: np.ndarray,
    box_before: np.ndarray, mask_before: np.ndarray, corner_before: np.ndarray, inset: int, step: int, margin: int,
    reach: int, floor: float, least: float, refit_ratio: float, blocks: np.ndarray, flow: np.ndarray,
    owners: np.ndarray, strength: np.ndarray,
) -> int:  # fmt: skip
    """Work out the flow of the face and of objects that may have moved, and each one's strength of motion, pixels.

    An object whose centroid moved less than ``least`` has no flow, nor has a face without any changed grey value.
    Returns the number of blocks.
    """
    n = len(visible)
    count: int = NOTHING
    part, face = np.zeros(4, np.int64), np.zeros(4, box.dtype)
    for k in range(n):
        strength[k] = 0.0
        if visible[k] and visible_before[k]:
            x, y = px[k, 0] - px_before[k, 0], px[k, 1] - px_before[k, 1]
            if np.hypot(x, y) > least and _moved_as_one(
                mask[k], corner[k], box[k], mask_before[k], corner_before[k], box_before[k], x, y, refit_ratio
            ):
                start, start_x, start_y = count, int(np.rint(x)), int(np.rint(y))
                _common(corner[k], corner_before[k], mask.shape[1], now.shape, part)
                count = region_flow(
                    now, before, part, box[k], step, margin, start_y, start_x, reach, floor, k,
                    count, blocks, flow, owners,
                )  # fmt: skip
                strength[k] = min(np.hypot(x, y), _mean_length(flow, start, count))
    start = count
    for k in range(4):
        part[k], face[k] = face_part[k], face_box[k]
    if not _equal(now, before, part):
        count = region_flow(
            now, before, part, face, step, -inset, NOTHING, NOTHING, reach, floor, n, count, blocks, flow, owners
        )
    strength[n] = _mean_length(flow, start, count)
    return count


@njit(cache=True)
def _raise_flags(
    strength: np.ndarray, flow: np.ndarray, scale: float, face_px: float, object_px: float, stay_ratio: float,
    linger: int, on: np.ndarray, left: np.ndarray,
) -> None:  # fmt: skip
    """Apply thresholds with hysteresis, |f_i| > epsilon_i (eq. 6.3), after scaling up strength and flow."""
    strength *= scale
    flow *= scale
    for i in range(len(on)):
        threshold = face_px if i == len(on) - 1 else object_px
        if strength[i] > (stay_ratio * threshold if on[i] else threshold):
            on[i], left[i] = True, linger
        elif left[i] > 0:
            left[i] -= 1
        else:
            on[i] = False


_WHOLE_BOX = (int,) * 4


def _is_plain(box: Any) -> bool:
    """Whether a box is a tuple of four whole numbers that compiled code takes; told sooner than by an array."""
    whole = type(box) is tuple and tuple(map(type, box)) == _WHOLE_BOX
    return whole and min(box) >= -MOST_EDGE and max(box) <= MOST_EDGE


class MotionDetector:
    """Tells which candidates move, from the last few images. It can be pickled."""

    def __init__(self, config: MotionConfig | None = None):
        self.config = config or MotionConfig()
        self._blocks = np.zeros((MAX_BLOCKS, 2))
        self._flow = np.zeros((MAX_BLOCKS, 2))
        self._owners = np.zeros(MAX_BLOCKS, np.int64)
        self._kept: deque[tuple[np.ndarray, Box, Areas]] = deque(maxlen=self.config.frames_back)
        self._ages: deque[int] = deque(maxlen=self.config.frames_back)  # frames since each of them
        self._on, self._left, self._strength = np.zeros(1, bool), np.zeros(1, int), np.zeros(1)
        self._box: Box | None = None

    def __getstate__(self) -> dict[str, Any]:
        """All but working space."""
        return {name: value for name, value in self.__dict__.items() if name not in ("_blocks", "_flow", "_owners")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a detector.

        Raises:
            ValueError: Compiled code could not go on with it.
        """
        fresh = MotionDetector(state["config"])
        self.__dict__.update({**fresh.__dict__, **state})
        check_array("on", self._on, self._on.shape[:1], bool)
        check_array("left", self._left, self._on.shape, int)
        check_array("strength", self._strength, self._on.shape, float)
        for box in (self._box, *(part for _, part, _ in self._kept)):
            for edge in box or ():
                check_whole("an edge", edge, -MOST_PX, MOST_PX)
        check_whole("the number of ages", len(self._ages), len(self._kept), len(self._kept))
        for age in self._ages:
            check_whole("an age", age, 0, MOST_FRAMES)

    def check_kept(self, gray: np.ndarray, areas: Areas) -> None:
        """Check that the kept images and areas are like these.

        Raises:
            ValueError: They are not.
        """
        for before, _, old in self._kept:
            check_array("an image", before, gray.shape, np.uint8)
            check_areas(old, areas)

    def reset(self) -> None:
        """Forget all images, as a fixation begins (section 6.3.2: there is no flow while the head turns)."""
        self._kept.clear()
        self._ages.clear()
        self._box = None
        self._on[:] = False
        self._left[:] = 0

    def pass_over(self, frames: int) -> None:
        """Say that so many frames have shown no new image, as those of a slow video: the next shift took longer."""
        for k in range(len(self._ages)):
            self._ages[k] += frames

    def face_part(self, face_box: Box | None, shape: tuple[int, ...]) -> Box:
        """The part of an image that ``update`` will read for the face; objects are read in the windows of their masks.

        Args:
            face_box: As for ``update``.
            shape: Height and width of the image.

        Returns:
            x0, y0, x1, y1, the last two exclusive.
        """
        box = self._box
        if face_box is not None:
            half = (face_box[2] - face_box[0]) / 2
            if box is None or max(abs(box[0] - face_box[0]), abs(box[1] - face_box[1])) > half:
                self._box = box = face_box
        if box is None:
            return NOWHERE
        rim = self.config.reach_px + 1 - self.config.face_inset_px
        return max(box[0] - rim, 0), max(box[1] - rim, 0), min(box[2] + rim, shape[1]), min(box[3] + rim, shape[0])

    def update(self, gray: np.ndarray, face_box: Box | None, areas: Areas) -> Motion:
        """Take one more image of this fixation.

        In the first image nothing moves. It is compared with the newest image that is ``frames_back`` frames old, or
        with the oldest. Displacements are scaled to ``frames_back`` frames. An image of another size starts a new
        fixation.

        Args:
            gray: (h, w) uint8, contiguous. It is kept, not copied: leave it as it is for ``frames_back`` updates.
            face_box: x0, y0, x1, y1 of the face; None if it was not detected. The first of a fixation is used until
                ``reset``, or until the face is detected half a box away.
            areas: The objects' areas in the same image; they are kept too.

        Returns:
            What moves.

        Raises:
            ObservationError: ``gray`` or ``face_box`` is not such.
        """
        config, n = self.config, len(areas.visible)
        require_gray(gray)
        if face_box is not None and not _is_plain(face_box):
            require_array("face_box", np.asarray(face_box), (4,), "iu", -MOST_EDGE, MOST_EDGE)
        if self._kept and (gray.shape, areas.mask.shape) != (self._kept[-1][0].shape, self._kept[-1][2].mask.shape):
            self.reset()
        if len(self._on) != n + 1:
            self._on, self._left, self._strength = np.zeros(n + 1, bool), np.zeros(n + 1, int), np.zeros(n + 1)
            self.reset()
        part, blocks = self.face_part(face_box, gray.shape), 0
        self.pass_over(1)
        while len(self._ages) > 1 and self._ages[1] >= config.frames_back:
            self._kept.popleft(), self._ages.popleft()
        if self._kept:
            before, part_before, old = self._kept[0]
            scale = config.frames_back / self._ages[0]
            box = self._box if part == part_before and self._box is not None else NOWHERE
            blocks = _measure(
                gray, before, box, part,
                areas.visible, areas.px, areas.box, areas.mask, areas.corner,
                old.visible, old.px, old.box, old.mask, old.corner,
                config.face_inset_px, config.step_px, config.object_margin_px, config.reach_px,
                config.texture * BLOCK * BLOCK * 2, min(config.stay_ratio, 1.0) * config.object_px / scale,
                config.refit_ratio, self._blocks, self._flow, self._owners, self._strength,
            )  # fmt: skip
            _raise_flags(
                self._strength, self._flow[:blocks], scale, config.face_px, config.object_px, config.stay_ratio,
                config.linger_frames, self._on, self._left,
            )  # fmt: skip
        self._kept.append((gray, part, areas))
        self._ages.append(0)
        return Motion(
            bool(self._on[n]), self._on[:n], self._blocks[:blocks], self._flow[:blocks], self._owners[:blocks],
            self._strength,
        )  # fmt: skip
