"""What moves while the robot's head is still (eq. 6.3, |f_i| > epsilon_i; section 6.4.1: block matching).

A picture is compared with the one two frames back, in blocks of 8x8 pixels. Each block descends to the displacement
with the least sum of squared differences, in whole pixels, and a parabola through the neighbouring sums on each axis
gives the fraction. Squares, not absolute values: near its minimum a sum of squares is a parabola, whereas a sum of
absolute values is a wedge, and a parabola through a wedge halves small displacements. The sums are taken both ways,
the new block in the old picture and the old block in the new one; one way alone reads up to .1 px of motion from two
pictures that are equal, since what enters the block on its two sides differs.

The face moves when the mean flow of its textured blocks is long enough; the region is the same through a fixation, so
that it does not move with the face. An object moves when its centroid and the flow of its blocks both do, and when its
pixels changed as those of a thing that moves: an arm that passes behind it has flow but no centroid shift, and one
that passes before it pulls the centroid, but takes pixels on one side without adding any on the other.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit, uintp

from jointattn_mj.errors import ConfigError
from jointattn_mj.perception.flow import BLOCK, region_flow
from jointattn_mj.perception.objects import Areas

MAX_BLOCKS = 1024  # flow vectors kept for one picture


@dataclass(frozen=True)
class MotionConfig:
    """Options of motion detection. epsilon_i of eq. 6.3 is "a small positive constant"; all of these are choices.

    The thresholds were set on rendered fixations (no camera noise) so that objects faster than .05 m/s and heads faster
    than 4 deg/s are told from slower ones. THESIS.md's own were .20 and .12 px, with a one-way parabola.
    """

    frames_back: int = 2
    """A head turning at 60 deg/s shifts .6 px a frame: over two frames it stands out, over more it comes late."""
    face_px: float = 0.045
    """epsilon of the face (eq. 6.3), pixels in ``frames_back`` frames, of the mean flow: about 4 deg/s of head turn."""
    object_px: float = 0.25
    """epsilon of an object (eq. 6.3), pixels in ``frames_back`` frames, of centroid and of mean block flow alike."""
    stay_ratio: float = 1.0
    """A flag that is on stays on above this share of its threshold; less than 1 bridges noise."""
    linger_frames: int = 0
    """And so many frames longer. With clean pictures the two frames back already delay the end by one."""
    texture: float = 4.0
    """Mean squared grey difference that one pixel's shift makes in a block, below which an axis has no flow."""
    face_inset_px: int = 4
    """Rim of the face's box left out: hair's edge and what moves behind the head. 24x24 of 32x32 pixels stay."""
    step_px: int = 4
    """Distance of blocks: half overlapping, for an object is only two blocks wide."""
    object_margin_px: int = 2
    """Rim around an object's box, so that its outline lies inside blocks."""
    reach_px: int = 6
    """How far a block descends from where it starts: nought for the face, the centroid's shift for an object."""
    refit_ratio: float = 0.7
    """From one pixel of centroid shift on, the share of changed pixels that may be left after shifting the old mask."""

    def __post_init__(self) -> None:
        if self.frames_back < 1 or self.step_px < 1 or self.reach_px < 1:
            raise ConfigError(
                "motion: expected frames_back, step_px and reach_px of 1 or more, came "
                f"{self.frames_back}, {self.step_px}, {self.reach_px}"
            )


@dataclass
class Motion:
    """What moves now. Arrays belong to the detector and hold until its next picture."""

    face_moves: bool
    object_moves: np.ndarray  # (n,) bool
    blocks: np.ndarray  # (m, 2) centres (x, y) of the textured blocks
    flow: np.ndarray  # (m, 2) displacement (x, y), pixels since the picture compared with
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
def _keep(gray, corner, side, face_box, rim, picture, parts):
    """Copy to ``picture`` what will be read of ``gray``, each object's window and the face's; ``parts`` says where."""
    height, width = gray.shape
    values, kept = gray.ravel(), picture.ravel()
    n = len(corner)
    for k in range(n + 1):
        if k == n:
            x0, y0, x1, y1 = face_box[0] - rim, face_box[1] - rim, face_box[2] + rim, face_box[3] + rim
        else:
            x0, y0, x1, y1 = corner[k, 0], corner[k, 1], corner[k, 0] + side, corner[k, 1] + side
        x0, y0, x1, y1 = max(x0, 0), max(y0, 0), min(x1, width), min(y1, height)
        parts[k, 0], parts[k, 1], parts[k, 2], parts[k, 3] = x0, y0, x1, y1
        for y in range(y0, y1):
            start = uintp(y * width + x0)
            for at in range(start, start + uintp(max(x1 - x0, 0))):
                kept[at] = values[at]


@njit(cache=True)
def _common(part, other, out):
    """The rectangle that two have in common."""
    out[0], out[1] = max(part[0], other[0]), max(part[1], other[1])
    out[2], out[3] = min(part[2], other[2]), min(part[3], other[3])


@njit(cache=True)
def _equal(now, before, part):
    """Whether a part is the same in two pictures."""
    for y in range(part[1], part[3]):
        for x in range(part[0], part[2]):
            if now[y, x] != before[y, x]:
                return False
    return True


@njit(cache=True)
def _measure(
    now, before, pictures, parts, face_box, seen, px, box, mask, corner,
    inset, step, margin, reach, floor, least, refit_ratio, blocks, flow, owners, strength,
):  # fmt: skip
    """Flow of the blocks of the face and of objects that may have moved, and each one's strength of motion, pixels.

    An object whose centroid has not moved by ``least`` has no flow, nor has a face that looks the same to the last
    grey value. Returns the number of blocks.
    """
    n, count = seen.shape[1], 0
    part = np.empty(4, parts.dtype)
    for k in range(n):
        strength[k] = 0.0
        if seen[now, k] and seen[before, k]:
            x, y = px[now, k, 0] - px[before, k, 0], px[now, k, 1] - px[before, k, 1]
            if np.hypot(x, y) > least and _moved_as_one(
                mask[now, k], corner[now, k], box[now, k], mask[before, k], corner[before, k], box[before, k], x, y,
                refit_ratio,
            ):  # fmt: skip
                start, start_x, start_y = count, np.int64(np.rint(x)), np.int64(np.rint(y))
                _common(parts[now, k], parts[before, k], part)
                count = region_flow(
                    pictures[now], pictures[before], part, box[now, k], step, margin, start_y, start_x, reach, floor,
                    k, count, blocks, flow, owners,
                )  # fmt: skip
                strength[k] = min(np.hypot(x, y), _mean_length(flow, start, count))
    start = count
    _common(parts[now, n], parts[before, n], part)
    if not _equal(pictures[now], pictures[before], part):
        count = region_flow(
            pictures[now], pictures[before], part, face_box, step, -inset, 0, 0, reach, floor,
            n, count, blocks, flow, owners,
        )  # fmt: skip
    strength[n] = _mean_length(flow, start, count)
    return count


@njit(cache=True)
def _raise_flags(strength, face_px, object_px, stay_ratio, linger, on, left):
    """Thresholds with hysteresis: eq. 6.3's |f_i| > epsilon_i."""
    for i in range(len(on)):
        threshold = face_px if i == len(on) - 1 else object_px
        if strength[i] > (stay_ratio * threshold if on[i] else threshold):
            on[i], left[i] = True, linger
        elif left[i] > 0:
            left[i] -= 1
        else:
            on[i] = False


@njit(cache=True)
def _update(
    gray, face_box, seen, px, box, mask, corner,
    frame, frames_back, pictures, parts, kept_seen, kept_px, kept_box, kept_mask, kept_corner,
    face_px, object_px, stay_ratio, linger, floor, inset, step, margin, reach, refit_ratio,
    blocks, flow, owners, strength, on, left,
):  # fmt: skip
    """Keep one more look, and compare it with an earlier one (arguments as in MotionDetector). Number of blocks.

    pictures: (frames_back + 1, h, w) grey, valid in parts; parts: (.., n + 1, 4) x0, y0, x1, y1, the face's last; the
    other kept arrays are those of ``Areas`` with the same first axis.
    """
    now = frame % len(pictures)
    _keep(gray, corner, mask.shape[1], face_box, reach + 1 - inset, pictures[now], parts[now])
    kept_seen[now], kept_px[now], kept_box[now], kept_mask[now], kept_corner[now] = seen, px, box, mask, corner
    back = min(frame, frames_back)
    if back == 0:
        return 0
    scale = frames_back / back
    count = _measure(
        now, (frame - back) % len(pictures), pictures, parts, face_box,
        kept_seen, kept_px, kept_box, kept_mask, kept_corner,
        inset, step, margin, reach, floor, min(stay_ratio, 1.0) * object_px / scale, refit_ratio,
        blocks, flow, owners, strength,
    )  # fmt: skip
    strength *= scale
    flow[:count] *= scale
    _raise_flags(strength, face_px, object_px, stay_ratio, linger, on, left)
    return count


class MotionDetector:
    """Tells who moves. Holds what it needs of the last few pictures: it can be pickled."""

    def __init__(self, config: MotionConfig | None = None):
        self.config = config or MotionConfig()
        self._blocks = np.zeros((MAX_BLOCKS, 2))
        self._flow = np.zeros((MAX_BLOCKS, 2))
        self._owners = np.zeros(MAX_BLOCKS, np.int64)
        self._allocate((0, 0), Areas.empty(0, 0))

    def _allocate(self, shape: tuple[int, ...], areas: Areas) -> None:
        slots, n = self.config.frames_back + 1, len(areas.seen)
        self._shape = shape, areas.mask.shape
        self._pictures = np.zeros((slots, *shape), np.uint8)
        self._parts = np.zeros((slots, n + 1, 4), np.int32)
        looks = (areas.seen, areas.px, areas.box, areas.mask, areas.corner)
        self._looks = tuple(np.zeros((slots, *array.shape), array.dtype) for array in looks)
        self._on, self._left, self._strength = np.zeros(n + 1, bool), np.zeros(n + 1, int), np.zeros(n + 1)
        self.reset()

    def reset(self) -> None:
        """Forget all pictures: the head has moved, and a fixation begins (section 6.3.2: no flow while it turns)."""
        self._frame = 0
        self._box = (0, 0, 0, 0)  # nothing yet
        self._on[:] = False
        self._left[:] = 0

    def face_part(self, face_box: tuple[int, int, int, int] | None) -> tuple[int, int, int, int]:
        """x0, y0, x1, y1 of what `update` will read for the face; it reads the objects in the windows of their masks.

        Args:
            face_box: As for `update`.
        """
        box = self._box
        if face_box is not None:
            shift = max(abs(box[0] - face_box[0]), abs(box[1] - face_box[1]))
            if box[2] == 0 or shift > (face_box[2] - face_box[0]) / 2:
                self._box = box = face_box
        rim = self.config.reach_px + 1 - self.config.face_inset_px
        return box[0] - rim, box[1] - rim, box[2] + rim, box[3] + rim

    def update(self, gray: np.ndarray, face_box: tuple[int, int, int, int] | None, areas: Areas) -> Motion:
        """What moves, from one more picture of this fixation.

        Args:
            gray: (h, w) uint8.
            face_box: x0, y0, x1, y1 of the face, None if unseen. The first of a fixation stays in force until `reset`,
                or until the face is found half a box away.
            areas: The objects' areas in the same picture.

        In the first picture nothing moves; in the next ones, before ``frames_back`` pictures have passed, the oldest is
        compared with, and the displacement scaled up.
        """
        config, n = self.config, len(areas.seen)
        if self._shape != (gray.shape, areas.mask.shape):
            self._allocate(gray.shape, areas)
        self.face_part(face_box)
        blocks = _update(
            gray, self._box, areas.seen, areas.px, areas.box, areas.mask, areas.corner,
            self._frame, config.frames_back, self._pictures, self._parts, *self._looks,
            config.face_px, config.object_px, config.stay_ratio, config.linger_frames,
            config.texture * BLOCK * BLOCK * 2, config.face_inset_px, config.step_px, config.object_margin_px,
            config.reach_px, config.refit_ratio,
            self._blocks, self._flow, self._owners, self._strength, self._on, self._left,
        )  # fmt: skip
        self._frame += 1
        return Motion(
            bool(self._on[n]), self._on[:n], self._blocks[:blocks], self._flow[:blocks], self._owners[:blocks]
        )
