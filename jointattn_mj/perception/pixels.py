"""Perception from the camera image: face, objects and motion (left of the attention selector in Fig. 6.2)."""

from collections import deque
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from jointattn_mj.errors import ObservationError
from jointattn_mj.guards.border import numbers, require_array
from jointattn_mj.guards.restored import check_array
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked, check_argument
from jointattn_mj.perception.faces import NO_FACE, PATCH_SIDE, FaceDetector, FaceDetectorConfig, FaceFinder
from jointattn_mj.perception.gray import fill_gray, require_image
from jointattn_mj.perception.motion import Motion, MotionConfig, MotionDetector
from jointattn_mj.perception.objects import Areas, ColourAreas, ColourConfig, ObjectFinder, check_areas
from jointattn_mj.perception.percept import FaceAt, Observation, Percept
from jointattn_mj.scene import camera

MEMORY_RATE = 0.02
"""Share of each new image in the remembered direction of the face, which says where to expect it."""

MOST_RAD = 100.0
"""Largest angle of the head that is accepted, rad."""

_pixel_of = njit(cache=True)(camera.pixel_of)
_direction_of = njit(cache=True)(camera.direction_of)


@njit(cache=True)
def _fill(image: np.ndarray, gray: np.ndarray, x0: int, y0: int, x1: int, y1: int) -> None:
    """``fill_gray`` of what has been checked."""
    fill_gray(image, gray, x0, y0, x1, y1)


def _require_head(head: Any) -> None:
    """Check angles of a head, (2,), rad. Single numbers are compared sooner than arrays."""
    require_array("head_angles", head, (2,), "f")
    pan, tilt = head.tolist()
    if not (type(pan) is type(tilt) is float and abs(pan) <= MOST_RAD and abs(tilt) <= MOST_RAD):
        require_array("head_angles", head, (2,), "f", -MOST_RAD, MOST_RAD)
        numbers("head_angles", head, (2,))  # none is masked


@njit(cache=True)
def _expect(
    direction: np.ndarray, head: np.ndarray, image: np.ndarray, gray: np.ndarray, reach: int
) -> tuple[float, float]:
    """Pixel x, y of a remembered direction (2,), degrees, for a head at (2,), rad; fills ``gray`` around it."""
    x, y = _pixel_of(direction, np.degrees(head))
    column, row = round(x), round(y)
    fill_gray(image, gray, column - reach, row - reach, column + reach, row + reach)
    return x, y


@njit(cache=True)
def _remember(direction: np.ndarray, x: float, y: float, head: np.ndarray, rate: float) -> None:
    """Move a remembered direction (2,), degrees, by ``rate`` towards that of pixel (x, y), for a head at (2,), rad."""
    there = _direction_of(np.array([x, y]), np.degrees(head))
    for axis in range(2):
        direction[axis] += rate * (there[axis] - direction[axis])


@njit(cache=True)
def _gather(
    visible: np.ndarray, px: np.ndarray, moves: np.ndarray, areas_visible: np.ndarray, areas_px: np.ndarray,
    objects_move: np.ndarray, face_detected: bool, x: float, y: float, face_moves: bool,
) -> None:  # fmt: skip
    """Write the percept of the objects and, last, of the face."""
    n = len(areas_visible)
    if not n + 1 == len(visible) == len(px) == len(moves) or not n == len(areas_px) == len(objects_move):
        raise ValueError("the percept is not as long as the objects and a face")
    for k in range(n):  # slices would compile strings, for their errors
        visible[k], px[k, 0], px[k, 1], moves[k] = areas_visible[k], areas_px[k, 0], areas_px[k, 1], objects_move[k]
    visible[n], px[n, 0], px[n, 1], moves[n] = face_detected, x, y, face_moves


@dataclass(frozen=True)
class PixelConfig(Checked):
    """Options of perception from images, part by part."""

    faces: FaceDetectorConfig = field(default_factory=FaceDetectorConfig)
    """Face detection by template matching."""
    colours: ColourConfig = field(default_factory=ColourConfig)
    """Objects as colour areas."""
    motion: MotionConfig = field(default_factory=MotionConfig)
    """Optical flow by block matching."""


class PixelPerception:
    """Percepts from images alone; of the world it knows the colours of the objects.

    Attributes:
        faces: The face detector; it can be exchanged before the first image.
        colours: The object detector.
        fix: The last answer of the face detector.
        motion: The last answer of the motion detector, with its flow vectors; None before the first image and after
            ``glance``.
    """

    pattern_size = PATCH_SIDE**2
    _part: tuple[int, ...] | None = None  # of images, where a face is looked for; None: everywhere

    def __init__(
        self,
        config: PixelConfig,
        rgb: np.ndarray,
        memory_rate: float = MEMORY_RATE,
        objects: ObjectFinder | None = None,
        face_at: FaceAt = "found",
    ):
        """Make the detectors.

        Args:
            config: Their options.
            rgb: (n, 3) the objects' nominal colours, 0 to 1.
            memory_rate: Share of each new image in the remembered direction of the face, 0 to 1.
            objects: Object detector in place of the one by ``rgb``, which then says nothing.
            face_at: Where face patterns are cut out. A face that is found farther from where it is remembered than the
                detector searches is cut out where it was found.

        Raises:
            ConfigError: ``face_at`` is no such choice.
        """
        check_argument("face_at", face_at, FaceAt)
        self.faces: FaceFinder = FaceDetector(config.faces)
        self.colours: ObjectFinder = ColourAreas(rgb, config.colours) if objects is None else objects
        self._motion = MotionDetector(config.motion)
        self._face_direction = np.zeros(2)
        self._knows_face = False
        self._memory_rate = memory_rate
        self._gray = np.zeros((0, 0), np.uint8)
        self.fix = self._cut_at = NO_FACE
        self._apart_px = config.faces.search_radius_px if face_at == "remembered" else -1  # from there, at most
        self._buffers: deque[tuple[np.ndarray, Areas]] = deque()  # grey images and areas, written to in turn
        self.motion: Motion | None = None
        count = len(self.colours.nothing().visible) + 1
        self._percept = Percept(np.zeros(count, bool), np.full((count, 2), np.nan), np.zeros(count, bool))

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a perceiver.

        Raises:
            ValueError: Compiled code could not go on with it.
        """
        self.__dict__.update(state)
        areas, count = self.colours.nothing(), len(self.colours.nothing().visible) + 1
        check_array("the face's direction", self._face_direction, (2,), float, -360, 360)
        check_array("visible", self._percept.visible, (count,), bool)
        check_array("moves", self._percept.moves, (count,), bool)
        check_array("px", self._percept.px, (count, 2), float)
        for gray, kept in self._buffers:
            check_array("a grey image", gray, self._gray.shape, np.uint8)
            check_areas(kept, areas)
        check_array("the grey image", self._gray, self._gray.shape, np.uint8)
        self._motion.check_kept(self._gray, areas)
        if self._part is not None:
            check_array("the part that is looked at", np.array(self._part), (4,), int)

    def narrow(self, part: tuple[int, ...]) -> None:
        """From the next image on, look for no face whose surroundings lie beyond a part of the image.

        Args:
            part: x0, y0, x1, y1 (the last two exclusive), pixels.
        """
        self._part = part

    def perceive(self, observation: Observation, landed: bool) -> Percept:
        """Detect face, objects and motion in an image.

        Args:
            observation: Image, and angles of the head, rad.
            landed: Whether a fixation begins, before which no motion is known.

        Returns:
            The percept; it holds until the next one.

        Raises:
            ObservationError: ``observation`` has no image (h, w, 3) uint8, contiguous, or no two angles, rad.
        """
        image, areas = self._detect(observation)
        gray, fix = self._gray, self.fix
        box = self.faces.box(fix, gray.shape) if fix.detected else None
        if landed:
            self._motion.reset()
        _fill(image, gray, *self._motion.face_part(box, gray.shape))
        self.motion = self._motion.update(gray, box, areas)
        return self._gathered(areas, self.motion.object_moves, self.motion.face_moves)

    def glance(self, observation: Observation) -> Percept:
        """Detect face and objects in an image that is compared with no other, before or after: nothing moves in it.

        Args:
            observation: As for ``perceive``, like what is returned and raised.
        """
        _, areas = self._detect(observation)
        self._motion.reset()
        self.motion = None
        return self._gathered(areas, np.zeros(len(areas.visible), bool), False)

    def _detect(self, observation: Observation) -> tuple[np.ndarray, Areas]:
        """Detect face and objects in an image. Returns it and the objects' areas; ``fix`` says where the face is.

        Args:
            observation: As for ``perceive``.
        """
        head: Any = getattr(observation, "head_angles", None)
        image: Any = getattr(observation, "image", None)
        require_image(image)
        _require_head(head)
        gray, areas = self._next_buffers(image.shape[:2])
        expected = None
        self.colours.find(image, gray, areas)
        if self._knows_face:
            expected = _expect(self._face_direction, head, image, gray, self.faces.reach_px)
        if expected is not None and self._beyond(expected, gray.shape):
            fix = NO_FACE
        else:
            fix = self.faces.detect(gray, expected, lambda: _fill(image, gray, 0, 0, *gray.shape[::-1]))
        self.fix = fix
        self._cut_at = fix
        if expected is not None and max(abs(fix.x - expected[0]), abs(fix.y - expected[1])) <= self._apart_px:
            self._cut_at = fix._replace(x=expected[0], y=expected[1])
        if fix.detected:
            _remember(self._face_direction, fix.x, fix.y, head, self._memory_rate if self._knows_face else 1.0)
            self._knows_face = True
        return image, areas

    def _beyond(self, expected: tuple[float, float], shape: tuple[int, ...]) -> bool:
        """Whether a face expected at a pixel (x, y) of an image (h, w) is not to be looked for."""
        if self._part is None:
            return False
        reach, (x0, y0, x1, y1) = self.faces.reach_px, self._part
        left, right = max(expected[0] - reach, 0), min(expected[0] + reach, shape[1])
        top, bottom = max(expected[1] - reach, 0), min(expected[1] + reach, shape[0])
        return not (x0 <= left and right <= x1 and y0 <= top and bottom <= y1)

    def _gathered(self, areas: Areas, objects_move: np.ndarray, face_moves: bool) -> Percept:
        """The percept of the last image.

        Args:
            areas: The objects'.
            objects_move: (n,) which objects move.
            face_moves: Whether the face does.
        """
        percept, fix = self._percept, self.fix
        _gather(
            percept.visible, percept.px, percept.moves, areas.visible, areas.px, objects_move,
            fix.detected, fix.x, fix.y, face_moves,
        )  # fmt: skip
        return percept

    def _next_buffers(self, shape: tuple[int, ...]) -> tuple[np.ndarray, Areas]:
        """Grey image (h, w) and areas to write to: those that the motion detector needs no more."""
        if self._gray.shape != shape:
            kept = self._motion.config.frames_back + 1
            self._buffers = deque((np.zeros(shape, np.uint8), self.colours.nothing()) for _ in range(kept))
        self._buffers.rotate()
        self._gray, areas = self._buffers[0]
        return self._gray, areas

    def face_pattern(self) -> np.ndarray:
        """The face pattern f_v of the last image: a grey patch of 32x32 pixels, (1024,) float32, 0 to 255.

        Raises:
            ObservationError: There was no image, or no face was detected in it.
        """
        if not self.fix.detected:
            raise ObservationError("expected a face in the last image; got none: check percept.visible[-1] first")
        return self.faces.patch(self._gray, self._cut_at).ravel()
