"""Sensors and results of chapter 5 (Table 5.1) from images.

The robot gazes at what is at the centre of its image: a face, an object, or nothing. The face's value is a category
that the robot learned itself (``perception.categories``). A frontal face is one whose category the calibration showed;
any other is a profile. Each part of perception can be replaced by ground truth, which shows what its errors cost.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np

from jointattn_mj.contingency.online.events import Variable, Variables
from jointattn_mj.development.table.world import TableConfig, table_variables
from jointattn_mj.guards.finite import check_finite
from jointattn_mj.options import Checked, Real
from jointattn_mj.perception.categories import FaceCategories, GroupingConfig
from jointattn_mj.perception.faces import FaceDetectorConfig
from jointattn_mj.perception.percept import Observation, Percept
from jointattn_mj.perception.pixels import PixelConfig, PixelPerception
from jointattn_mj.perception.som import SOM, SOMConfig
from jointattn_mj.scene.camera import CENTRE_X, CENTRE_Y, FOCAL_PX

OBJECT, NO_OBJECT = 0, 1
"""Values of S2 at a table with one kind of objects."""
PARTS = ("face", "category", "object")
"""Parts of perception: whether a face is at the centre of view, its category, and whether an object is there."""

ABRUPT = PixelConfig(FaceDetectorConfig(confirm_above=0.2))
"""Perception of faces that turn at once. The detector of chapter 6 learns a turned face from the views in between; they
are missing here, and under some lights a turned face fits the frontal view by no more than 0.2 to 0.4. With the
detector's own threshold three of twenty robots never found one."""


@dataclass(frozen=True)
class SensesConfig(Checked):
    """From images to values of sensors."""

    pixels: PixelConfig = field(default_factory=PixelConfig)
    """Detection of faces and colour areas, as in chapter 6."""
    som: SOMConfig = field(default_factory=SOMConfig)
    """The map of face patterns."""
    grouping: GroupingConfig = field(default_factory=GroupingConfig)
    """Grouping of the map's units into the values of S1."""
    centre_radius_deg: Annotated[float, Real("(0, 180]")] = 3.5
    """What is within this distance of the centre of view is gazed at, degrees; as in chapter 6."""
    frontal_share: Annotated[float, Real("[0, 1)")] = 0.05
    """A category is frontal if it got more than this share of the calibration's faces. Frontal faces may fall into two
    categories; a robot that took one of them for a profile found nothing after gaze following."""
    frontal_likeness: Annotated[float, Real("[0, 1)")] = 0.0
    """A category is frontal as well if its faces are nearer to those of the calibration than this share of the median
    over the other categories. After a turn a frontal face may be cut out in another way than during calibration. 0:
    what calibration did not show is never frontal."""
    state: tuple[Literal["face", "category", "object"], ...] = ()
    """Parts of perception that are taken from the simulator's state: face, category, object."""

    ADVANCED: ClassVar = ("frontal_share", "frontal_likeness")
    RENAMED: ClassVar = {"truth": "state"}

    @property
    def centre_radius_px(self) -> float:
        """What is within this distance of the centre of an image is gazed at, pixels."""
        radius: float = np.radians(self.centre_radius_deg) * FOCAL_PX
        return radius


class CentralView(NamedTuple):
    """What an image shows at its centre; pixels as in ``Percept``, NaN for what was not detected."""

    face: bool
    """Whether a face is at the centre."""
    object: bool
    """Whether an object is at the centre."""
    face_px: np.ndarray
    """(2,) centre of the face, wherever it is in the image."""
    object_px: np.ndarray
    """(2,) centre of the object that is nearest to the centre of view."""
    pattern: np.ndarray | None
    """Grey patch (1024,) of the face at the centre; None if there is none."""


UNDETECTED = np.full(2, np.nan)
EMPTY_VIEW = CentralView(False, False, UNDETECTED, UNDETECTED, None)


def central_view(perception: PixelPerception, observation: Observation, radius_px: float) -> CentralView:
    """Perceive an image.

    Args:
        perception: Detectors of faces and colour areas.
        observation: Image and head angles, as in ``Perceiver``.
        radius_px: What is so near to the centre of view counts as being there, pixels.
    """
    percept = perception.glance(observation)
    off = px_off_centre(percept)
    face, nearest = bool(off[-1] <= radius_px), int(off[:-1].argmin())
    return CentralView(
        face=face,
        object=bool(off[nearest] <= radius_px),
        face_px=percept.px[-1].copy(),
        object_px=percept.px[nearest].copy() if percept.visible[nearest] else UNDETECTED,
        pattern=perception.face_pattern() if face else None,
    )


def px_off_centre(percept: Percept) -> np.ndarray:
    """Distance (n + 1,) of each candidate from the centre of view, pixels; infinite for one that is not visible."""
    off: np.ndarray = np.hypot(percept.px[:, 0] - CENTRE_X, percept.px[:, 1] - CENTRE_Y)
    off[~percept.visible] = np.inf
    return off


class Senses:
    """Turns what is at the centre of view into values of S and R.

    Attributes:
        looks: Whether images are needed; not if all parts of perception are replaced by ground truth.
        variables: The agent's: S1 has a value for each category of faces.
        categories: Of faces.
        frontal: (values of S1,) bool: the categories of the calibration's faces, and of faces like them.
    """

    def __init__(
        self,
        config: SensesConfig,
        table: TableConfig,
        patterns: np.ndarray,
        calibration: int,
        rng: np.random.Generator,
    ):
        """Make categories of the faces that were seen.

        Args:
            config: Perception, and how faces are grouped.
            table: Rules of the table.
            patterns: (n, d) faces that were seen.
            calibration: How many of them, at the beginning, are the calibration's.
            rng: For the map of faces.
        """
        self._from_state = {part: part in config.state for part in PARTS}
        self.looks = not all(self._from_state.values())
        som = SOM(patterns.shape[1], config.som, rng)
        som.train(patterns, rng)
        self.categories = FaceCategories(som, patterns, config.grouping)
        of_table = table_variables(table)
        self._not_visible = len(of_table.sensors[0].values) - 1
        self.variables = of_table if self._from_state["category"] else with_faces(of_table, self.categories.count)
        self._no_face = len(self.variables.sensors[0].values) - 1
        if self._from_state["category"]:
            shown = np.array([table.spots])
        else:
            shown = np.array([self.categories.of(pattern) for pattern in patterns[:calibration]])
        self.frontal = frontal_categories(shown, self._no_face, config.frontal_share)
        if config.frontal_likeness and not self._from_state["category"]:
            of_category = np.array([self.categories.of(pattern) for pattern in patterns])
            self.frontal |= alike(patterns, of_category, self.frontal, config.frontal_likeness)
        self._likeliest = int(np.bincount(shown).argmax())

    def turned(self, patterns: Sequence[np.ndarray]) -> int:
        """How many of these faces (d,) are not frontal, by their categories."""
        return sum(not self.frontal[self.categories.of(pattern)] for pattern in patterns)

    def check(self) -> None:
        """Go on only with finite numbers.

        Raises:
            NotFiniteError: The map of faces holds NaN or infinity.
        """
        check_finite({"map of faces": self.categories.som.weights})

    def read(self, view: CentralView, sensors: np.ndarray, results: np.ndarray, s: np.ndarray, r: np.ndarray) -> None:
        """Write the values of this step.

        Args:
            view: What the image shows.
            sensors: (2,) true values, for the parts that are replaced by ground truth.
            results: (results,) true values.
            s: (2,) is written.
            r: (results,) is written.
        """
        from_state = self._from_state
        visible = sensors[0] != self._not_visible if from_state["face"] else view.face
        if not visible:
            face = self._no_face
        elif from_state["category"]:
            face = sensors[0] if sensors[0] != self._not_visible else self._likeliest
        elif view.pattern is not None:
            face = self.categories.of(view.pattern)
        else:
            face = self._likeliest
        there = sensors[1] == OBJECT if from_state["object"] else view.object and not visible
        write_values(face, there, self.frontal, s, r)


def frontal_categories(shown: np.ndarray, count: int, share: float) -> np.ndarray:
    """Which categories of faces are frontal.

    Args:
        shown: (n,) categories of the calibration's faces.
        count: How many categories there are.
        share: A category with more than this share of the faces is frontal.

    Returns:
        (count + 1,) bool; the last stands for no face, and is False.
    """
    return np.bincount(shown, minlength=count + 1) > share * len(shown)


def alike(patterns: np.ndarray, category: np.ndarray, frontal: np.ndarray, share: float) -> np.ndarray:
    """Which categories of faces are much more like frontal ones than the others are.

    Args:
        patterns: (n, d) faces.
        category: (n,) their categories.
        frontal: (count + 1,) whether a category is known to be frontal; the last stands for no face.
        share: Of the median of all distances to the nearest frontal category; those below it are alike.

    Returns:
        (count + 1,) bool; categories without faces, and those in ``frontal``, are not.
    """
    likes = np.zeros_like(frontal)
    others = [number for number in np.unique(category) if not frontal[number]]
    means = [patterns[category == number].mean(axis=0) for number in np.unique(category[frontal[category]])]
    if others and means:
        apart = np.array([
            min(np.linalg.norm(patterns[category == number].mean(axis=0) - mean) for mean in means) for number in others
        ])  # fmt: skip
        likes[others] = apart < share * np.median(apart)
    return likes


def write_values(face: int, object_there: bool, frontal: np.ndarray, s: np.ndarray, r: np.ndarray) -> None:
    """Write sensors and results of chapter 5 (Table 5.1).

    Args:
        face: Category of the face at the centre of view; the last for no face.
        object_there: Whether an object is at the centre of view.
        frontal: (values of S1,) whether a category is frontal.
        s: (2,) is written: face, object.
        r: (results,) is written: frontal face, profile if the table has that result, object.
    """
    s[0], s[1] = face, OBJECT if object_there else NO_OBJECT
    r[0] = frontal[face]
    if len(r) == 3:
        r[1] = face < len(frontal) - 1 and not r[0]
    r[-1] = object_there


def with_faces(variables: Variables, categories: int) -> Variables:
    """``variables`` whose first sensor has so many categories of faces as values, and "not seen"."""
    face, names = variables.sensors[0], tuple(f"face {number}" for number in range(1, categories + 1))
    return replace(variables, sensors=(Variable(face.name, (*names, face.values[-1])), *variables.sensors[1:]))


def named_by_majority(variables: Variables, counts: np.ndarray, truth: Sequence[str]) -> Variables:
    """Variables whose categories of faces bear the name of the caregiver's most frequent gaze target.

    For people who read results only: the robot does not know these names.

    Args:
        variables: The agent's.
        counts: (categories + 1, true values) steps by the value of S1 and by the true value.
        truth: Names of the true values.
    """
    face, names = variables.sensors[0], list[str]()
    for number in range(len(face.values) - 1):
        name = truth[int(counts[number].argmax())] if counts[number].any() else face.values[number]
        again = sum(earlier.split(" (")[0] == name for earlier in (face.values[-1], *names))
        names.append(f"{name} ({again + 1})" if again else name)
    return replace(variables, sensors=(Variable(face.name, (*names, face.values[-1])), *variables.sensors[1:]))
