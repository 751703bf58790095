"""What moves while the robot's head is still (eq. 6.3, |f_i| > epsilon_i; section 6.4.1: block matching).

An image is compared with the one two frames back, in blocks of 8x8 pixels. Each block descends to the displacement
with the least sum of squared differences, in whole pixels, and a parabola through the neighbouring sums on each axis
gives the fraction. Squares, not absolute values: near its minimum a sum of squares is a parabola, whereas a sum of
absolute values is a wedge, and a parabola through a wedge halves small displacements. The sums are taken both ways,
the new block in the old image and the old block in the new one; one way alone reads up to .1 px of motion from two
images that are equal, since what enters the block on its two sides differs.

The face moves when the mean flow of its textured blocks is long enough; the region is the same through a fixation, so
that it does not move with the face. An object moves when its centroid and the flow of its blocks both do, and when its
pixels changed as those of a thing that moves: an arm that passes behind it has flow but no centroid shift, and one
that passes before it pulls the centroid, but takes pixels on one side without adding any on the other.
"""

from collections import deque
from dataclasses import dataclass
from typing import Annotated, Any

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
Box = tuple[int, int, int, int]  # x0, y0, x1, y1, the last two exclusive
NOWHERE: Box = (0, 0, 0, 0)


@dataclass(frozen=True)
class MotionConfig(Checked):
    """Options of motion detection. epsilon_i of eq. 6.3 is "a small positive constant"; all of these are choices.

    The thresholds were set on rendered fixations (no camera noise) so that objects faster than .05 m/s and heads faster
    than 4 deg/s are told from slower ones. THESIS.md's own were .20 and .12 px, with a one-way parabola.
    """

    frames_back: Annotated[int, Whole("[1, 300]")] = 2
    """A head turning at 60 deg/s shifts .6 px a frame: over two frames it stands out, over more it comes late."""
    face_px: Annotated[float, Real("[0, 1000]")] = 0.045
    """epsilon of the face (eq. 6.3), pixels in ``frames_back`` frames, of the mean flow: about 4 deg/s of head turn."""
    object_px: Annotated[float, Real("[0, 1000]")] = 0.25
    """epsilon of an object (eq. 6.3), pixels in ``frames_back`` frames, of centroid and of mean block flow alike."""
    stay_ratio: Annotated[float, Real("[0, 100]")] = 1.0
    """A flag that is on stays on above this share of its threshold; less than 1 bridges noise."""
    linger_frames: Annotated[int, Whole("[0, 1e6]")] = 0
    """And so many frames longer. With clean images the two frames back already delay the end by one."""
    texture: Annotated[float, Real("[0.001, 1e6]")] = 4.0
    """Mean squared grey difference that one pixel's shift makes in a block, below which an axis has no flow."""
    face_inset_px: Annotated[int, Whole("[0, 120]")] = 4
    """Rim of the face's box left out: hair's edge and what moves behind the head. 24x24 of 32x32 pixels stay."""
    step_px: Annotated[int, Whole("[1, 240]")] = 4
    """Distance of blocks: half overlapping, for an object is only two blocks wide."""
    object_margin_px: Annotated[int, Whole("[0, 240]")] = 2
    """Rim around an object's box, so that its outline lies inside blocks."""
    reach_px: Annotated[int, Whole("[1, 240]")] = 6
    """How far a block descends from where it starts: nought for the face, the centroid's shift for an object."""
    refit_ratio: Annotated[float, Real("[0, 100]")] = 0.7
    """From one pixel of centroid shift on, the share of changed pixels that may be left after shifting the old mask."""


@dataclass
class Motion:
    """What moves now. Arrays belong to the detector and hold until its next image."""

    face_moves: bool
    object_moves: np.ndarray  # (n,) bool
    blocks: np.ndarray  # (m, 2) centres (x, y) of the textured blocks
    flow: np.ndarray  # (m, 2) displacement (x, y), pixels since the image compared with
    owner: np.ndarray  # (m,) which object a block belongs to, n for the face


@njit(cache=True)
def _changed(mask, corner, before, corner_before, shift_x, shift_y):
    """Pixels gained and lost from the mask before, moved by a shift, to the mask now."""
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
def _moved_as_one(mask, corner, box, before, corner_before, box_before, shift_x, shift_y, refit_ratio):
    """Whether the pixels changed as a moving thing's do, and not as those of one that something passes before.

    A small move gains pixels on one side and loses some on the other, or, for a box seen straight on, just one whole
    row or column. A move of a pixel or more is undone by shifting.
    """
    gained, lost = _changed(mask, corner, before, corner_before, 0, 0)
    if shift_x * shift_x + shift_y * shift_y <= 1.0:
        wide, high = box[2] - box[0], box[3] - box[1]
        wide_before, high_before = box_before[2] - box_before[0], box_before[3] - box_before[1]
        rows = abs(wide * high - wide_before * high_before)
        one_row = max(abs(wide - wide_before), abs(high - high_before)) == 1
        return min(gained, lost) >= 1 or (one_row and abs(max(gained, lost) - rows) <= 0.1 * rows)
    x, y = np.int64(np.rint(shift_x)), np.int64(np.rint(shift_y))
    gained_still, lost_still = _changed(mask, corner, before, corner_before, x, y)
    return gained_still + lost_still <= refit_ratio * (gained + lost)


@njit(cache=True)
def _mean_length(flow, start, count):
    """Length of the mean of flow vectors start..count; 0 without any."""
    x, y = 0.0, 0.0
    for i in range(start, count):
        x += flow[i, 0]
        y += flow[i, 1]
    return np.hypot(x, y) / (count - start) if count > start else 0.0


@njit(cache=True)
def _common(corner, other, side, shape, part):
    """What two windows of ``side`` pixels have in common within the image."""
    for axis in range(2):
        part[axis] = max(corner[axis], other[axis], 0)
        part[2 + axis] = min(min(corner[axis], other[axis]) + side, shape[1 - axis])


@njit(cache=True)
def _equal(now, before, part):
    """Whether a part is the same in two images."""
    for y in range(part[1], part[3]):
        for x in range(part[0], part[2]):
            if now[y, x] != before[y, x]:
                return False
    return True


@njit(cache=True)
def _measure(
    now, before, face_box, face_part, visible, px, box, mask, corner,
    visible_before, px_before, box_before, mask_before, corner_before,
    inset, step, margin, reach, floor, least, refit_ratio, blocks, flow, owners, strength,
):  # fmt: skip
    """Flow of the blocks of the face and of objects that may have moved, and each one's strength of motion, pixels.

    An object whose centroid has not moved by ``least`` has no flow, nor has a face that looks the same to the last
    grey value. Returns the number of blocks.
    """
    n, count = len(visible), 0
    part = np.zeros(4, np.int64)
    for k in range(n):
        strength[k] = 0.0
        if visible[k] and visible_before[k]:
            x, y = px[k, 0] - px_before[k, 0], px[k, 1] - px_before[k, 1]
            if np.hypot(x, y) > least and _moved_as_one(
                mask[k], corner[k], box[k], mask_before[k], corner_before[k], box_before[k], x, y, refit_ratio
            ):
                start, start_x, start_y = count, np.int64(np.rint(x)), np.int64(np.rint(y))
                _common(corner[k], corner_before[k], mask.shape[1], now.shape, part)
                count = region_flow(
                    now, before, part, box[k], step, margin, start_y, start_x, reach, floor, k,
                    count, blocks, flow, owners,
                )  # fmt: skip
                strength[k] = min(np.hypot(x, y), _mean_length(flow, start, count))
    start = count
    for k in range(4):
        part[k] = face_part[k]
    if not _equal(now, before, part):
        count = region_flow(
            now, before, part, np.array(face_box), step, -inset, 0, 0, reach, floor, n, count, blocks, flow, owners
        )
    strength[n] = _mean_length(flow, start, count)
    return count


@njit(cache=True)
def _raise_flags(strength, flow, scale, face_px, object_px, stay_ratio, linger, on, left):
    """Thresholds with hysteresis: eq. 6.3's |f_i| > epsilon_i. Strength and flow are scaled up first."""
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


class MotionDetector:
    """Tells who moves. Holds the last few images and areas: it can be pickled."""

    def __init__(self, config: MotionConfig | None = None):
        self.config = config or MotionConfig()
        self._blocks = np.zeros((MAX_BLOCKS, 2))
        self._flow = np.zeros((MAX_BLOCKS, 2))
        self._owners = np.zeros(MAX_BLOCKS, np.int64)
        self._kept: deque[tuple[np.ndarray, Box, Areas]] = deque(maxlen=self.config.frames_back)
        self._on, self._left, self._strength = np.zeros(1, bool), np.zeros(1, int), np.zeros(1)
        self._box: Box | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Without working space."""
        return {name: value for name, value in self.__dict__.items() if name not in ("_blocks", "_flow", "_owners")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a detector. Raises ValueError: It is none that compiled code can go on with."""
        fresh = MotionDetector(state["config"])
        self.__dict__.update({**fresh.__dict__, **state})
        check_array("on", self._on, self._on.shape[:1], bool)
        check_array("left", self._left, self._on.shape, int)
        check_array("strength", self._strength, self._on.shape, float)
        for box in (self._box, *(part for _, part, _ in self._kept)):
            for edge in box or ():
                check_whole("an edge", edge, -MOST_PX, MOST_PX)

    def check_kept(self, gray: np.ndarray, areas: Areas) -> None:
        """Refuse what is kept of other images than such. Raises ValueError."""
        for before, _, found in self._kept:
            check_array("an image", before, gray.shape, np.uint8)
            check_areas(found, areas)

    def reset(self) -> None:
        """Forget all images: the head has moved, and a fixation begins (section 6.3.2: no flow while it turns)."""
        self._kept.clear()
        self._box = None
        self._on[:] = False
        self._left[:] = 0

    def face_part(self, face_box: Box | None, shape: tuple[int, ...]) -> Box:
        """What `update` will read of an image (h, w) for the face; it reads the objects in the windows of their masks.

        Args:
            face_box: As for `update`.
            shape: h, w.
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
        """What moves, from one more image of this fixation.

        Args:
            gray: (h, w) uint8, contiguous.
            face_box: x0, y0, x1, y1 of the face, None if unseen. The first of a fixation stays in force until `reset`,
                or until the face is found half a box away.
            areas: The objects' areas in the same image.

        Image and areas are kept, not copied: the caller leaves them as they are for the next ``frames_back`` updates.
        In the first image nothing moves; in the next ones, before ``frames_back`` images have passed, the oldest is
        compared with, and the displacement scaled up. An image of another size begins anew.

        Raises:
            ObservationError: ``gray`` or ``face_box`` is not such.
        """
        config, n = self.config, len(areas.visible)
        require_gray(gray)
        if face_box is not None:
            require_array("face_box", np.asarray(face_box), (4,), "iu")
        if self._kept and (gray.shape, areas.mask.shape) != (self._kept[-1][0].shape, self._kept[-1][2].mask.shape):
            self.reset()
        if len(self._on) != n + 1:
            self._on, self._left, self._strength = np.zeros(n + 1, bool), np.zeros(n + 1, int), np.zeros(n + 1)
            self.reset()
        part, blocks = self.face_part(face_box, gray.shape), 0
        if self._kept:
            before, part_before, old = self._kept[0]
            scale = config.frames_back / len(self._kept)
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
        return Motion(
            bool(self._on[n]), self._on[:n], self._blocks[:blocks], self._flow[:blocks], self._owners[:blocks]
        )
