"""The caregiver's face: where it is, and what it looks like (box "face detection" of Fig. 6.2; sections 6.3.2, 6.4.1).

"The template matching method is used as face detector and a 32x32 pixel face-like region is extracted." The robot
comes with one innate idea of a face, OpenCV's frontal Haar cascade, and uses it until it has seen a frontal face once.
That view is its first template. As the head turns and the fit gets worse, it keeps further views, cropped where it
expects the face's centre rather than where the features went, for a face that turns in place moves its features, not
its place; and the poorer the fit, the more it answers with the expected place.

When no view fits near the expected place, the whole image is searched. A good fit elsewhere wins; else a fair one
where the robot expects the face is taken for a pose not seen before; else no face is reported.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, ClassVar, NamedTuple, Protocol

import cv2
import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.guards.restored import check_array
from jointattn_mj.options import Checked, Real, Share, Whole
from jointattn_mj.perception.gray import require_gray
from jointattn_mj.perception.views import MOST_PX, ViewBank, crop

PATCH_SIDE = 32  # "a 32x32 pixel face-like region is extracted", section 6.4.1
PATCH_MARGIN = 4  # pixels around it that its blur reads

Fit = Annotated[float, Real("[-1, 2]")]
"""A normalised cross-correlation; above 1 there is none."""


@dataclass(frozen=True)
class FaceDetectorConfig(Checked):
    """Options of the face detector. Section 6.4.1 fixes template matching and the 32x32 patch; the rest is open."""

    side_px: Annotated[int, Whole("[8, 240]")] = 32
    """Side of template and patch in the image. A head at the caregiver's distance is 27 wide and 41 high."""
    search_radius_px: Annotated[int, Whole("[0, 120]")] = 4
    """How far from the expected place a face is looked for: the robot knows its head's angles to a pixel or two."""
    distance_penalty: Annotated[float, Real("[0, 100]")] = 0.002
    """What a squared pixel from the expected place costs in fit, when places and views are compared: .03 at the edge.
    Keeps a pose not seen before from being taken for another view a few pixels off."""
    max_views: Annotated[int, Whole("[2, 1000]")] = 48
    """Views kept. Spread over yaw +-45 and pitch -5..45 deg that is one for every 10 deg or so."""
    forget_after: Annotated[int, Whole("[0, 1e9]")] = 20_000
    """Images for which a view fits best in none before a new one may take its place: eleven minutes of looking."""
    search_all_below: Fit = 0.80
    """Fit of the last view and its neighbours below which every view is tried in the whole window."""
    add_view_below: Fit = 0.82
    """Fit below which the present look is kept as a new view, if the place is plausible. From here down to
    ``redetect_below`` the answer passes over from the fitted place to the expected one."""
    location_gain: Share = 0.05
    """Share by which the detector's own memory of the face's place follows what it sees, where none is given to it."""
    add_view_every: Annotated[int, Whole("[0, 1e6]")] = 3
    """Images in a row with a face before a view may be added, and between two additions: 6 deg of a 60 deg/s turn."""
    contrast_ratio: Annotated[float, Real("[0, 100]")] = 0.4
    """Share of the first view's contrast that a face has at least: keeps stains on the wall out."""
    redetect_below: Fit = 0.65
    """Fit below which the tracked place is given up and the whole image searched."""
    elsewhere_above: Fit = 0.82
    """Fit that a place other than the expected one needs; ``redetect_below`` is enough if the cascade sees a face
    there. Clutter of a face's contrast reached .75 in the rendered room, with the bank full of views."""
    confirm_above: Fit = 0.40
    """A fit this good where the robot expects the face is the face in an unknown pose, if none elsewhere is good."""
    redetect_every: Annotated[int, Whole("[1, 1e6]")] = 5
    """Images from one search to the next while that is so."""
    redetect_views: Annotated[int, Whole("[1, 1000]")] = 6
    """Views tried over the whole image, at half resolution: the first and those used last."""
    haar_every: Annotated[int, Whole("[1, 1e6]")] = 15
    """Images between two tries of the Haar cascade while no face is known or found: it costs several ms."""
    haar_scale: Annotated[float, Real("[1.01, 10]")] = 1.08
    """Scale step of the cascade."""
    haar_neighbours: Annotated[int, Whole("[0, 1000]")] = 3
    """Overlapping hits that the cascade asks for."""
    haar_min_px: Annotated[int, Whole("[1, 240]")] = 24
    """Smallest face that the cascade looks for; 24 is the size it was trained with."""
    patch_blur_px: Annotated[float, Real("[0, 32]")] = 0.7
    """Standard deviation of the blur of the patch. Interpolating between pixels blurs by an amount that depends on the
    fraction; a little blur of its own makes the patch nearly the same at every fraction of a pixel."""

    RENAMED: ClassVar = {"place_gain": "location_gain"}

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.redetect_below < self.add_view_below:
            raise ConfigError(
                "faces.redetect_below must be less than add_view_below; "
                f"got {self.redetect_below}, {self.add_view_below}"
            )


class FaceFix(NamedTuple):
    """One answer of the detector."""

    x: float  # pixels, centre of the face; NaN when not found
    y: float
    score: float  # normalised cross-correlation of the best view, -1..1
    found: bool


class FaceFinder(Protocol):
    """What any face detector must offer; images are grey, (h, w) uint8, pixels x to the right and y down."""

    @property
    def reach_px(self) -> int:
        """How far from the expected place it reads the image, unless it calls ``complete``."""

    def detect(
        self, gray: np.ndarray, expected_px: tuple[float, float] | None, complete: Callable[[], None]
    ) -> FaceFix:
        """Where the face is; see ``FaceDetector.detect``."""

    def patch(self, gray: np.ndarray, fix: FaceFix) -> np.ndarray:
        """The face pattern f_v: (32, 32) float32 grey values 0..255 around ``fix``."""

    def box(self, fix: FaceFix, shape: tuple[int, int]) -> tuple[int, int, int, int]:
        """Its region x0, y0, x1, y1 (the last two exclusive) inside an image (h, w); motion is looked for there."""


@cache
def _cascade() -> cv2.CascadeClassifier:
    """OpenCV's bundled frontal cascade (a process-wide cache, for it cannot be pickled with a detector)."""
    folder = cv2.data.haarcascades  # type: ignore[attr-defined]
    return cv2.CascadeClassifier(folder + "haarcascade_frontalface_default.xml")


def haar_faces(gray: np.ndarray, config: FaceDetectorConfig) -> np.ndarray:
    """(k, 3) centre x, y and side in pixels of the frontal faces that the cascade finds, the largest first."""
    boxes = _cascade().detectMultiScale(
        gray, config.haar_scale, config.haar_neighbours, minSize=(config.haar_min_px, config.haar_min_px)
    )
    if len(boxes) == 0:
        return np.zeros((0, 3))
    found = np.asarray(boxes, float)
    found = found[np.argsort(-found[:, 2], kind="stable")]
    return np.hstack([found[:, :2] + (found[:, 2:3] - 1) / 2, found[:, 2:3]])


class FaceDetector:
    """Tracks one face with views that it collects itself. All state is arrays and numbers: it can be pickled."""

    def __init__(self, config: FaceDetectorConfig | None = None):
        self.config = config or FaceDetectorConfig()
        self.bank = ViewBank(
            self.config.side_px, self.config.max_views, self.config.search_radius_px, self.config.distance_penalty,
            self.config.search_all_below, self.config.contrast_ratio, self.config.forget_after,
        )  # fmt: skip
        self._location: tuple[float, float] | None = None  # slow memory in the image, for want of a better one
        self._streak = 0  # images in a row with a face, since the last view was added
        self._until_haar = 0
        self._until_search = 0

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a detector. Raises ValueError: Its face is in no place of an image."""
        self.__dict__.update(state)
        if self._location is not None:
            check_array("place", np.array(self._location), (2,), float, -MOST_PX, MOST_PX)

    @property
    def reach_px(self) -> int:
        """How far from the expected place `detect` and `patch` read the image while the face is about there."""
        return self.config.side_px // 2 + self.config.search_radius_px + PATCH_MARGIN + 2

    def detect(
        self,
        gray: np.ndarray,
        expected_px: tuple[float, float] | None = None,
        complete: Callable[[], None] = lambda: None,
    ) -> FaceFix:
        """Find the face in an image (h, w) uint8.

        Args:
            gray: The image.
            expected_px: (x, y) where the face's centre should be, from the robot's slow memory of its direction in the
                world; None if it has none, then the detector's own memory of the last images serves.
            complete: Called to fill in all of ``gray`` when it is to be read beyond ``reach_px``.

        Raises:
            ObservationError: ``gray`` is no such image.
        """
        require_gray(gray)
        if self.bank.n == 0 or expected_px is None:
            complete()
        if self.bank.n == 0:
            return self._first_sight(gray)
        config = self.config
        expected = self._location if expected_px is None else expected_px
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
                self._location, self._streak = None, 0
                return FaceFix(float("nan"), float("nan"), score, False)
        if near and expected is not None:
            x, y = self._learn(gray, expected, (x, y), score)
            gain = config.location_gain
            self._location = expected[0] + gain * (x - expected[0]), expected[1] + gain * (y - expected[1])
        else:
            self._location, self._streak = (x, y), 0
        return FaceFix(x, y, score, True)

    def _learn(
        self, gray: np.ndarray, expected: tuple[float, float], fit: tuple[float, float], score: float
    ) -> tuple[float, float]:
        """Keep a look that no view fits well, cropped where the face is expected. Returns the place to answer with."""
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
        """The face pattern f_v: (32, 32) float32 grey values 0..255 around ``fix``."""
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
        """The region of ``fix`` as x0, y0, x1, y1 (the last two exclusive), cut at the border of an image (h, w)."""
        x0, y0 = round(fix.x - (self.config.side_px - 1) / 2), round(fix.y - (self.config.side_px - 1) / 2)
        x1, y1 = x0 + self.config.side_px, y0 + self.config.side_px
        return max(x0, 0), max(y0, 0), min(x1, shape[1]), min(y1, shape[0])

    def _first_sight(self, gray: np.ndarray) -> FaceFix:
        """No view yet: ask the cascade, and keep what it finds as the first view."""
        nothing = FaceFix(float("nan"), float("nan"), -1.0, False)
        found = self._ask_cascade(gray)
        if found is None or not self.bank.add(gray, *found):
            return nothing
        self._location = found
        return FaceFix(found[0], found[1], 1.0, True)

    def _ask_cascade(self, gray: np.ndarray) -> tuple[float, float] | None:
        """Centre of the largest frontal face, at most once in ``haar_every`` images."""
        if self._until_haar > 0:
            self._until_haar -= 1
            return None
        faces = haar_faces(gray, self.config)
        if len(faces) == 0:
            self._until_haar = self.config.haar_every - 1
            return None
        return float(faces[0, 0]), float(faces[0, 1])

    def _search_everywhere(self, gray: np.ndarray) -> tuple[float, float, float] | None:
        """Score and centre of the best fit in the whole image, if it is good or the cascade sees a face there."""
        config = self.config
        locations = self.bank.search(gray, config.redetect_views)
        best = max(
            (self.bank.match(gray, *location) for location in locations), default=(-1.0, float("nan"), float("nan"))
        )
        if best[0] >= config.elsewhere_above:
            return best
        found = self._ask_cascade(gray)
        if found is None:
            return None
        best = self.bank.match(gray, *found)
        return best if best[0] >= config.redetect_below else None
