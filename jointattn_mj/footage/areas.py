"""Objects in footage: areas of known colours, several of each if wanted, each followed from image to image.

Colours of the faces of this video are no object's, nor is what lies in a face, is larger than things that one handles,
or is worn: what goes with the person's face wherever that goes. An object that the user has picked is known by all of
its colours, which need not be saturated.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import cv2
import numpy as np

from jointattn_mj.options import Checked, Real, Whole
from jointattn_mj.perception.objects import Areas, ColourConfig

BITS = 5
"""Colours of skin, and of picked objects, are told by cells of 2^5 levels a channel."""
LEVEL = np.arange(64) >> 1
CELL_OF = (LEVEL[:, None, None] << 2 * BITS | LEVEL[None, :, None] << BITS | LEVEL[None, None, :]).ravel()
"""Cell of each entry of a table of colours (``perception.objects``), which has 2^6 levels a channel."""
ASIDE, BELOW, SLEEVE, COLLAR = 1.6, (0.4, 6.0), 4.0, 2.0
"""Where clothes are, in face heights from the face's middle: to either side, and below it; sleeves reach farther aside,
and the collar is no farther below."""
NEAR_PX = 2
"""How far beside its box an object is still taken to be at a pixel."""

Part = tuple[int, np.ndarray, np.ndarray, int]
"""A connected area: its number, middle (x, y), box (x, y, width, height, area), and pixels."""


@dataclass(frozen=True)
class AreaConfig(Checked):
    """What counts as an object."""

    most_faces: Annotated[float, Real("[0.1, 1000]")] = 4.0
    """Largest area, in squares of the face's height: clothes and furniture are larger."""
    most_share: Annotated[float, Real("[0, 1]")] = 0.05
    """Largest area where no face is known, as a share of the image."""
    worn_faces: Annotated[float, Real("[0, 1000]")] = 1.0
    """Largest area that begins at the collar below a face, in squares of its height: a larger one is worn, and so is
    all of its colour on that person."""
    worn_s: Annotated[float, Real("[0.1, 1000]")] = 4.0
    """Seconds over which it is seen whether what is below a face goes with it."""
    skin: bool = True
    """Leave out the colours of the faces in this video, of whoever they are. Picked objects keep theirs."""
    jump_px: Annotated[float, Real("[1, 1000]")] = 24.0
    """How far an object may move from one frame to the next, pixels of the robot's image."""
    lost_images: Annotated[int, Whole("[1, 10000]")] = 15
    """Images, at 30 a second, after which a lost object may be taken up anywhere."""

    ADVANCED: ClassVar = ("worn_s", "jump_px", "lost_images")


@dataclass
class Slot:
    """One area that is followed."""

    px: np.ndarray | None = None
    """Where it was last."""
    missing: int = 0
    """Frames between then and the next image."""
    trail: list[np.ndarray] = field(default_factory=list)
    """(4,) its location and the face's, of late, while it was below the face."""


class FootageAreas:
    """Finds and follows areas of colours. It can be pickled.

    Attributes:
        counts: (n, 10) number of images in which an object had 0, 1, ... 9 or more areas.
    """

    def __init__(
        self,
        table: np.ndarray,
        by_colour: np.ndarray,
        each: int,
        colours: ColourConfig,
        config: AreaConfig,
        rate: float,
    ):
        """Make it.

        Args:
            table: (64^3,) uint8, label of each colour: 0 for none, k + 1 for object k.
            by_colour: (n,) bool, which objects are searched for by a colour rather than as picked.
            each: Areas that are followed of each object.
            colours: Least area, and largest distance of an object's pixels from its middle.
            config: What counts as an object.
            rate: Images a second.
        """
        self.config, self._table, self._each = config, table, each
        self._least, self._reach = colours.min_area_px, colours.reach_px
        self._by_colour = by_colour
        self._kept = round(config.worn_s * rate)
        self._slots = [Slot() for _ in range(len(by_colour) * each)]
        self._skin = np.zeros(1 << 3 * BITS, np.int32)
        self._effective = table
        self._faces = np.zeros((0, 4))
        self._images = 0
        self._passed = 0  # frames since the last image
        self._boxes = np.zeros((len(self._slots), 4), np.int32)
        self.counts = np.zeros((len(by_colour), 10), np.int64)

    def nothing(self) -> Areas:
        """Areas to be filled in by ``find``."""
        return Areas.empty(len(self._slots), self._reach)

    def take(self, table: np.ndarray) -> None:
        """Take another table of colours, (64^3,) uint8."""
        self._table = self._effective = table

    def show_faces(self, boxes: np.ndarray, lost: bool, shifted: bool = False) -> None:
        """Say where faces are in the next image.

        Args:
            boxes: (k, 4) x, y, width and height, pixels of the robot's image, that of the face of interest first.
            lost: Whether the image follows upon a cut.
            shifted: Whether the camera has moved since the image before, so that all goes with the face.
        """
        self._faces = boxes
        if shifted:
            for slot in self._slots:
                slot.trail.clear()
        if lost:
            self._slots = [Slot() for _ in self._slots]

    def turn(self, moved: Callable[[np.ndarray], np.ndarray]) -> None:
        """Say that the eye has turned: ``moved`` gives the new pixel (2,) of a pixel (2,) of the last image."""
        for slot in self._slots:
            slot.px = None if slot.px is None else moved(slot.px)
            slot.trail = [np.concatenate([moved(point[:2]), moved(point[2:])]) for point in slot.trail]

    def pass_over(self, frames: int) -> None:
        """Say that so many frames have gone by without a new image, as while the eye turns, or in a slow video: objects
        may have moved on meanwhile."""
        self._passed += frames
        for slot in self._slots:
            slot.missing += frames

    def find(self, image: np.ndarray, gray: np.ndarray, areas: Areas) -> None:
        """Find the objects in an image.

        Args:
            image: (h, w, 3) uint8 RGB.
            gray: (h, w) uint8; all of the grey image is written to it.
            areas: What ``nothing`` gives; it is filled in.
        """
        cv2.cvtColor(image, cv2.COLOR_RGB2GRAY, dst=gray)
        level = image >> 2
        entries = level[..., 0].astype(np.int32) << 12 | level[..., 1].astype(np.int32) << 6 | level[..., 2]
        if self.config.skin and self._images % 15 == 0 and len(self._faces):
            self._learn_skin(entries)
        self._images += 1
        labels = self._effective[entries]
        for x, y, wide, high in self._faces:  # the face itself, and the neck
            x0, y0, x1, y1 = x - 0.1 * wide, y - 0.2 * high, x + 1.1 * wide, y + 1.2 * high
            labels[max(0, round(y0)) : max(0, round(y1)), max(0, round(x0)) : max(0, round(x1))] = 0
        for k in range(len(self._by_colour)):
            self._fill(labels, k, areas)
        self._boxes, self._passed = areas.box.copy(), 0

    def is_at(self, k: int, px: np.ndarray) -> bool:
        """Whether object ``k`` was found at a pixel (2,) of the last image: whether one of its boxes holds it."""
        boxes = self._boxes[k * self._each : (k + 1) * self._each]
        inside = (px >= boxes[:, :2] - NEAR_PX) & (px < boxes[:, 2:] + NEAR_PX)
        return bool((inside.all(axis=1) & (boxes[:, 2] > boxes[:, 0])).any())

    def _learn_skin(self, entries: np.ndarray) -> None:
        """Take the colours of the middle of each face as those of skin."""
        for x, y, wide, high in self._faces:
            rows = slice(max(0, round(y + 0.2 * high)), max(0, round(y + 0.9 * high)))
            part = entries[rows, max(0, round(x + 0.2 * wide)) : max(0, round(x + 0.8 * wide))]
            if part.size >= 16:
                self._skin //= 1 if self._skin.sum() < 20_000 else 2
                self._skin += np.bincount(CELL_OF[part.ravel()], minlength=len(self._skin)).astype(np.int32)
        near = (self._skin > 0.002 * max(1, int(self._skin.sum()))).reshape((1 << BITS,) * 3)
        for axis in range(3):  # and their neighbours
            near = near | np.roll(near, 1, axis) | np.roll(near, -1, axis)
        coloured = np.concatenate([[False], self._by_colour])
        skin = near.ravel()[CELL_OF] & coloured[self._table]
        self._effective = np.where(skin, 0, self._table).astype(np.uint8)

    def _fill(self, labels: np.ndarray, k: int, areas: Areas) -> None:
        """Give the areas of one object to its slots."""
        slots = range(k * self._each, (k + 1) * self._each)
        mask = (labels == k + 1).view(np.uint8)
        candidates: list[Part] = []
        parts = np.zeros(mask.shape, np.int32)
        if cv2.countNonZero(mask) >= self._least:
            stats, centres = _connected(mask, parts)
            for part in range(1, len(stats)):
                area = int(stats[part, cv2.CC_STAT_AREA])
                if area >= self._least and not self._is_too_large(area, labels.shape):
                    candidates.append((part, centres[part], stats[part], area))
            candidates = self._without_clothes(candidates, stats[1:], centres[1:])
        self.counts[k, min(len(candidates), 9)] += 1
        owners = self._owners(candidates, slots)
        for slot in slots:
            areas.visible[slot], areas.area[slot], areas.px[slot], areas.box[slot] = False, 0, np.nan, 0
            state, given = self._slots[slot], owners.get(slot)
            if given is None:
                state.missing += 1
                continue
            part, centre, box, area = candidates[given]
            state.px, state.missing = centre.copy(), 0
            if self._is_worn(state, centre):
                continue
            areas.visible[slot], areas.area[slot], areas.px[slot] = True, area, centre
            areas.box[slot] = box[0], box[1], box[0] + box[2], box[1] + box[3]
            self._cut_mask(mask, parts, part, centre, areas, slot)

    def _owners(self, candidates: list[Part], slots: range) -> dict[int, int]:
        """Area of each slot: the nearest to where it was, or the largest that is left for one that is lost."""
        owners: dict[int, int] = {}
        left = set(range(len(candidates)))
        pairs = sorted(
            (float(np.hypot(*(candidates[candidate][1] - px))), slot, candidate)
            for slot in slots for candidate in left if (px := self._slots[slot].px) is not None
        )  # fmt: skip
        for off, slot, candidate in pairs:
            reach = self.config.jump_px * min(1 + 0.2 * self._slots[slot].missing, 3.0)
            if slot not in owners and candidate in left and off <= reach:
                owners[slot] = candidate
                left.discard(candidate)
        for slot in slots:
            state = self._slots[slot]
            if slot not in owners and left and (state.px is None or state.missing >= self.config.lost_images):
                largest = max(left, key=lambda candidate: candidates[candidate][3])
                owners[slot] = largest
                state.trail.clear()
                left.discard(largest)
        return owners

    def _without_clothes(self, candidates: list[Part], stats: np.ndarray, centres: np.ndarray) -> list[Part]:
        """The areas less those below a face, where one reaches from the collar down and is large: it is worn."""
        for face in self._faces:
            collar = face[1] + (0.5 + COLLAR) * face[3]
            large = stats[:, cv2.CC_STAT_AREA] > self.config.worn_faces * float(face[3]) ** 2
            at_collar = np.flatnonzero(large & (stats[:, cv2.CC_STAT_TOP] < collar))
            if any(_is_below(face, centres[part]) for part in at_collar):
                candidates = [candidate for candidate in candidates if not _is_below(face, candidate[1], SLEEVE)]
        return candidates

    def _is_too_large(self, area: int, shape: tuple[int, ...]) -> bool:
        """Whether an area is too large for a thing that one handles."""
        config = self.config
        if not len(self._faces):
            return area > config.most_share * shape[0] * shape[1]
        square = float(self._faces[0, 3]) ** 2
        return area > max(config.most_faces * square, 4.0 * self._least)

    def _is_worn(self, state: Slot, centre: np.ndarray) -> bool:
        """Whether an area goes with the face above it."""
        above = next((face for face in self._faces if _is_below(face, centre)), None)
        if above is None:
            state.trail.clear()
            return False
        state.trail += [np.concatenate([centre, above[:2] + above[2:] / 2])] * min(1 + self._passed, self._kept)
        del state.trail[: -self._kept]
        if len(state.trail) < self._kept:
            return False
        return all(_goes_along(half, float(above[3])) for half in np.array_split(np.array(state.trail), 2))

    def _cut_mask(
        self, mask: np.ndarray, parts: np.ndarray, part: int, centre: np.ndarray, areas: Areas, slot: int
    ) -> None:
        """Write the pixels of an area, within a window around its middle."""
        reach = self._reach
        left, top = round(float(centre[0])) - reach, round(float(centre[1])) - reach
        areas.corner[slot], areas.mask[slot] = (left, top), False
        x0, y0 = max(left, 0), max(top, 0)
        x1, y1 = min(left + 2 * reach + 1, mask.shape[1]), min(top + 2 * reach + 1, mask.shape[0])
        own = (parts[y0:y1, x0:x1] == part) & (mask[y0:y1, x0:x1] > 0)
        areas.mask[slot, y0 - top : y1 - top, x0 - left : x1 - left] = own


def _connected(mask: np.ndarray, parts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find connected areas, only in the part of the image that has any, which takes a third of the time.

    Args:
        mask: (h, w) uint8, 1 in the areas.
        parts: (h, w) int32 zeros; the number of each pixel's area is written to it, from 1.

    Returns:
        (k + 1, 5) x, y, width, height and area of each, and their middles (k + 1, 2); the first are of the rest.
    """
    x, y, wide, high = cv2.boundingRect(mask)
    left, top = max(0, x - 2) & ~1, max(0, y - 2) & ~1  # so far away the border changes nothing; even as blocks are
    within = np.s_[top : y + high + 2, left : x + wide + 2]
    closed = cv2.morphologyEx(mask[within], cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    _, parts[within], stats, centres = cv2.connectedComponentsWithStats(closed, connectivity=8)
    stats[:, [cv2.CC_STAT_LEFT, cv2.CC_STAT_TOP]] += (left, top)
    return stats, centres + np.array((left, top))


def _goes_along(trail: np.ndarray, high: float) -> bool:
    """Whether a face has moved, and something with it.

    Args:
        trail: (n, 4) locations of that something and of the face, pixels.
        high: Height of the face, pixels.
    """
    own, face, apart = (
        np.ptp(part, axis=0).max() for part in (trail[:, :2], trail[:, 2:], trail[:, :2] - trail[:, 2:])
    )
    return bool(face > 0.2 * high and apart < 0.6 * face and own > 0.4 * face)


def _is_below(face: np.ndarray, centre: np.ndarray, aside: float = ASIDE) -> bool:
    """Whether a point is where the clothes of the person with that face are, so many face heights aside at most."""
    off = (centre - face[:2] - face[2:] / 2) / face[3]
    return bool(abs(off[0]) < aside and BELOW[0] < off[1] < BELOW[1])
