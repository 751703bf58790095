"""Face detection: where the caregiver's face is, and its pattern (Fig. 6.2; sections 6.3.2, 6.4.1).

"The template matching method is used as face detector and a 32x32 pixel face-like region is extracted." The detector
begins with OpenCV's frontal Haar cascade. The first frontal face that it detects becomes its first template, called a
view. As the head turns and the fit gets worse, it adds views, cropped at the expected centre of the face: a head that
turns moves its features, not its position. The worse the fit, the nearer the answer to the expected position.

Where no view fits near the expected position, the whole image is searched. A good fit elsewhere wins. Else a fair fit
at the expected position counts as a new pose of the face. Else no face is reported.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, ClassVar, NamedTuple, Protocol

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.guards.restored import check_array
from jointattn_mj.io.opencv import cv2
from jointattn_mj.options import Checked, Real, Share, Whole
from jointattn_mj.perception.gray import require_gray
from jointattn_mj.perception.views import MOST_PX, ViewBank, crop

PATCH_SIDE = 32  # "a 32x32 pixel face-like region is extracted", section 6.4.1
PATCH_MARGIN = 4  # pixels around it that its blur reads

Fit = Annotated[float, Real("[-1, 2]")]
"""A normalised cross-correlation, -1 to 1; a threshold above 1 is never reached."""


@dataclass(frozen=True)
class FaceDetectorConfig(Checked):
    """Options of the face detector. Section 6.4.1 fixes template matching and the 32x32 patch; the rest is open."""

    side_px: Annotated[int, Whole("[8, 240]")] = 32
    """Side of views and patch in the image, pixels; a head at the caregiver's distance is 27 wide and 41 high."""
    search_radius_px: Annotated[int, Whole("[0, 120]")] = 4
    """Distance from the expected position, pixels, within which a face is searched; the head's angles are so exact."""
    distance_penalty: Annotated[float, Real("[0, 100]")] = 0.002
    """Loss of fit for each squared pixel from the expected position: .03 at the edge. It keeps a new pose from being
    taken for another view a few pixels off."""
    max_views: Annotated[int, Whole("[2, 1000]")] = 48
    """Largest number of views: one for every 10 degrees or so of yaw (+-45) and pitch (-5 to 45)."""
    forget_after: Annotated[int, Whole("[0, 1e9]")] = 20_000
    """Images in which a view never fits best, before a new one may replace it: eleven minutes."""
    search_all_below: Fit = 0.80
    """Fit of the last view and its neighbours below which every view is tried in the whole window."""
    add_view_below: Fit = 0.82
    """Fit below which the present face becomes a new view, if its position is plausible. From here down to
    ``redetect_below`` the answer passes from the fitted position to the expected one."""
    location_gain: Share = 0.05
    """Share of a new position in the detector's own memory, which serves where no expected position is given."""
    add_view_every: Annotated[int, Whole("[0, 1e6]")] = 3
    """Images in a row with a face before a view may be added, and between two additions: 6 degrees at 60 degrees/s."""
    contrast_ratio: Annotated[float, Real("[0, 100]")] = 0.4
    """Least contrast of a face, as a share of the first view's; it keeps stains on the wall out."""
    redetect_below: Fit = 0.65
    """Fit below which the tracked position is given up and the whole image searched."""
    elsewhere_above: Fit = 0.82
    """Fit that a position far from the expected one needs; ``redetect_below`` is enough where the cascade detects a
    face. Clutter with a face's contrast reached .75 in the rendered room, with the bank full of views."""
    confirm_above: Fit = 0.40
    """Fit at the expected position above which it is the face in a new pose, if no fit elsewhere is good."""
    redetect_every: Annotated[int, Whole("[1, 1e6]")] = 5
    """Images from one search of the whole image to the next, meanwhile."""
    redetect_views: Annotated[int, Whole("[1, 1000]")] = 6
    """Views that are tried over the whole image, at half resolution: the first and those used last."""
    haar_every: Annotated[int, Whole("[1, 1e6]")] = 15
    """Images between two runs of the Haar cascade while no face is known or detected; it takes several milliseconds."""
    haar_scale: Annotated[float, Real("[1.01, 10]")] = 1.08
    """Factor between two scales of the cascade."""
    haar_neighbours: Annotated[int, Whole("[0, 1000]")] = 3
    """Overlapping hits that the cascade needs."""
    haar_min_px: Annotated[int, Whole("[1, 240]")] = 24
    """Smallest face for the cascade, pixels; it was trained with 24."""
    patch_blur_px: Annotated[float, Real("[0, 32]")] = 0.7
    """Standard deviation of the patch's blur, pixels. Interpolation between pixels blurs too, depending on the
    fraction; this blur makes the patch nearly the same at every fraction of a pixel."""

    RENAMED: ClassVar = {"place_gain": "location_gain"}
    ADVANCED: ClassVar = (
        "search_radius_px", "add_view_every", "elsewhere_above", "confirm_above", "redetect_every", "redetect_views",
        "location_gain", "haar_every", "haar_scale", "haar_neighbours", "haar_min_px", "patch_blur_px",
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.redetect_below < self.add_view_below:
            raise ConfigError(
                "faces.redetect_below must be less than add_view_below; "
                f"got {self.redetect_below}, {self.add_view_below}"
            )


class FaceFix(NamedTuple):
    """One answer of the detector.

    Attributes:
        x: Centre of the face, pixels; NaN where there is none.
        y: Likewise.
        score: Normalised cross-correlation of the best view, -1 to 1.
        detected: Whether a face was detected.
    """

    x: float
    y: float
    score: float
    detected: bool


NO_FACE = FaceFix(float("nan"), float("nan"), -1.0, False)


class FaceFinder(Protocol):
    """What a face detector offers. Images are grey, (h, w) uint8; pixels have x to the right and y down."""

    @property
    def reach_px(self) -> int:
        """How far from the expected position, pixels, it reads the image, unless it calls ``complete``."""

    def detect(
        self, gray: np.ndarray, expected_px: tuple[float, float] | None, complete: Callable[[], None]
    ) -> FaceFix:
        """Detect the face; see ``FaceDetector.detect``."""

    def patch(self, gray: np.ndarray, fix: FaceFix) -> np.ndarray:
        """The face pattern f_v: (32, 32) float32 grey values, 0 to 255, around ``fix``."""

    def box(self, fix: FaceFix, shape: tuple[int, int]) -> tuple[int, int, int, int]:
        """The face's region x0, y0, x1, y1 (the last two exclusive) in an image (h, w); motion is measured in it."""


@cache
def _cascade() -> "cv2.CascadeClassifier":
    """OpenCV's frontal cascade, one for the process, since it cannot be pickled with a detector."""
    folder = cv2.data.haarcascades  # type: ignore[attr-defined]
    return cv2.CascadeClassifier(folder + "haarcascade_frontalface_default.xml")


def haar_faces(gray: np.ndarray, config: FaceDetectorConfig) -> np.ndarray:
    """Detect frontal faces by the Haar cascade.

    Args:
        gray: (h, w) uint8.
        config: The fields that begin with ``haar_``.

    Returns:
        (k, 3) centre x, y and side, pixels, the largest face first.
    """
    boxes = _cascade().detectMultiScale(
        gray, config.haar_scale, config.haar_neighbours, minSize=(config.haar_min_px, config.haar_min_px)
    )
    if len(boxes) == 0:
        return np.zeros((0, 3))
    faces = np.asarray(boxes, float)
    faces = faces[np.argsort(-faces[:, 2], kind="stable")]
    return np.hstack([faces[:, :2] + (faces[:, 2:3] - 1) / 2, faces[:, 2:3]])


class FaceDetector:
    """Tracks one face by views that it collects itself. It can be pickled."""

    def __init__(self, config: FaceDetectorConfig | None = None):
        self.config = config or FaceDetectorConfig()
        self.bank = ViewBank(
            self.config.side_px, self.config.max_views, self.config.search_radius_px, self.config.distance_penalty,
            self.config.search_all_below, self.config.contrast_ratio, self.config.forget_after,
        )  # fmt: skip
        self._position: tuple[float, float] | None = None  # slow memory, pixels, where no expected position is given
        self._streak = 0  # images in a row with a face, since the last view was added
        self._until_haar = 0
        self._until_search = 0

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a detector.

        Raises:
            ValueError: Its face is beyond any image.
        """
        self.__dict__.update(state)
        if self._position is not None:
            check_array("the face's position", np.array(self._position), (2,), float, -MOST_PX, MOST_PX)

    @property
    def reach_px(self) -> int:
        """How far from the expected position, pixels, the image is read while the face is near it."""
        return self.config.side_px // 2 + self.config.search_radius_px + PATCH_MARGIN + 2

    def detect(
        self,
        gray: np.ndarray,
        expected_px: tuple[float, float] | None = None,
        complete: Callable[[], None] = lambda: None,
    ) -> FaceFix:
        """Detect the face in an image.

        Args:
            gray: (h, w) uint8.
            expected_px: (x, y) expected centre of the face, pixels, from the robot's slow memory of its direction in
                the world; None: the detector's own memory of the last images serves.
            complete: Called before ``gray`` is read beyond ``reach_px``, to fill in all of it.

        Returns:
            Centre, score, and whether a face was detected.

        Raises:
            ObservationError: ``gray`` is no such image.
        """
        require_gray(gray)
        if self.bank.n == 0 or expected_px is None:
            complete()
        if self.bank.n == 0:
            return self._first_sight(gray)
        config = self.config
        expected = self._position if expected_px is None else expected_px
        score, x, y = self.bank.match(gray, *expected) if expected is not None else (-1.0, 0.0, 0.0)
        near = score >= (config.redetect_below if expected_px is None else config.confirm_above)
        if score >= config.redetect_below:
            self._until_search = self._until_haar = 0
        elif self._until_search > 0 and near:
            self._until_search -= 1
        else:
            self._until_search = config.redetect_every - 1
            complete()
            elsewhere = self._search_everywhere(gray)
            if elsewhere is not None:
                (score, x, y), near = elsewhere, False
            elif not near:
                self._position, self._streak = None, 0
                return FaceFix(float("nan"), float("nan"), score, False)
        if near and expected is not None:
            x, y = self._learn(gray, expected, (x, y), score)
            gain = config.location_gain
            self._position = expected[0] + gain * (x - expected[0]), expected[1] + gain * (y - expected[1])
        else:
            self._position, self._streak = (x, y), 0
        return FaceFix(x, y, score, True)

    def _learn(
        self, gray: np.ndarray, expected: tuple[float, float], fit: tuple[float, float], score: float
    ) -> tuple[float, float]:
        """Add a view where none fits well, cropped at the expected position. Returns the position to answer with."""
        config = self.config
        self._streak += 1
        if score >= config.add_view_below:
            return fit
        if self._streak > config.add_view_every:
            self.bank.add(gray, expected[0], expected[1])
            self._streak = 0
        trust = max(0.0, (score - config.redetect_below) / (config.add_view_below - config.redetect_below))
        return expected[0] + trust * (fit[0] - expected[0]), expected[1] + trust * (fit[1] - expected[1])

    def patch(self, gray: np.ndarray, fix: FaceFix) -> np.ndarray:
        """The face pattern f_v: (32, 32) float32 grey values, 0 to 255, around ``fix``."""
        side = self.config.side_px
        if self.config.patch_blur_px > 0:
            wide = crop(gray, fix.x, fix.y, side + 2 * PATCH_MARGIN)
            wide = cv2.GaussianBlur(wide, (0, 0), self.config.patch_blur_px)
            face = wide[PATCH_MARGIN:-PATCH_MARGIN, PATCH_MARGIN:-PATCH_MARGIN]
        else:
            face = crop(gray, fix.x, fix.y, side)
        if side != PATCH_SIDE:
            face = cv2.resize(face, (PATCH_SIDE, PATCH_SIDE), interpolation=cv2.INTER_AREA)
        return np.ascontiguousarray(face)

    def box(self, fix: FaceFix, shape: tuple[int, int]) -> tuple[int, int, int, int]:
        """The face's region x0, y0, x1, y1 (the last two exclusive), cut at the border of an image (h, w)."""
        x0, y0 = round(fix.x - (self.config.side_px - 1) / 2), round(fix.y - (self.config.side_px - 1) / 2)
        x1, y1 = x0 + self.config.side_px, y0 + self.config.side_px
        return max(x0, 0), max(y0, 0), min(x1, shape[1]), min(y1, shape[0])

    def _first_sight(self, gray: np.ndarray) -> FaceFix:
        """Without views: ask the cascade, and keep the face that it detects as the first view."""
        face = self._ask_cascade(gray)
        if face is None or not self.bank.add(gray, *face):
            return NO_FACE
        self._position = face
        return FaceFix(face[0], face[1], 1.0, True)

    def _ask_cascade(self, gray: np.ndarray) -> tuple[float, float] | None:
        """Centre, pixels, of the largest frontal face; the cascade runs at most once in ``haar_every`` images."""
        if self._until_haar > 0:
            self._until_haar -= 1
            return None
        faces = haar_faces(gray, self.config)
        if len(faces) == 0:
            self._until_haar = self.config.haar_every - 1
            return None
        return float(faces[0, 0]), float(faces[0, 1])

    def _search_everywhere(self, gray: np.ndarray) -> tuple[float, float, float] | None:
        """Score and centre of the best fit in the whole image: good, or fair where the cascade detects a face."""
        config = self.config
        centres = self.bank.search(gray, config.redetect_views)
        best = max((self.bank.match(gray, *centre) for centre in centres), default=(-1.0, float("nan"), float("nan")))
        if best[0] >= config.elsewhere_above:
            return best
        face = self._ask_cascade(gray)
        if face is None:
            return None
        best = self.bank.match(gray, *face)
        return best if best[0] >= config.redetect_below else None
