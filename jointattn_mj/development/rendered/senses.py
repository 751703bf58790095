"""Sensations and results of chapter 5 (Table 5.1) from images.

The robot gazes at what is at the centre of its image: a face, an object, or nothing. Which face it is, is said by
categories of its own (``perception.categories``). A frontal face is one like those that greeted it; any other is a
profile. Each part can be replaced by the truth, to see what its errors cost.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal, NamedTuple

import numpy as np

from jointattn_mj.contingency.online.events import Variable, Variables
from jointattn_mj.development.table.world import TableConfig, table_variables
from jointattn_mj.guards.finite import check_finite
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked, Real
from jointattn_mj.perception.categories import FaceCategories, GroupingConfig
from jointattn_mj.perception.faces import FaceDetectorConfig
from jointattn_mj.perception.pixels import PixelConfig, PixelPerception
from jointattn_mj.perception.som import SOM, SOMConfig
from jointattn_mj.scene.camera import CENTRE_X, CENTRE_Y, FOCAL_PX

PARTS = ("face", "category", "object")
"""What perception consists of: whether there is a face at the centre, of which category, and whether an object is."""

ABRUPT = PixelConfig(FaceDetectorConfig(confirm_above=0.2))
"""For faces that have turned at once, without the views between by which the detector of chapter 6 gets to know a
turned face: under some lights they fit the frontal view by no more than 0.2 to 0.4, and with the detector's own
threshold three of twenty robots never found one."""


@dataclass(frozen=True)
class SensesConfig(Checked):
    """How images become values of variables."""

    pixels: PixelConfig = field(default_factory=PixelConfig)
    """Faces and colour areas, as in chapter 6."""
    som: SOMConfig = field(default_factory=SOMConfig)
    """The map of face patterns."""
    grouping: GroupingConfig = field(default_factory=GroupingConfig)
    """How its cells become the values of S1."""
    centre_radius_deg: Annotated[float, Real("(0, 180]")] = 3.5
    """What is so near to the centre of view is gazed at, as in chapter 6."""
    frontal_share: Annotated[float, Real("[0, 1)")] = 0.05
    """A category is frontal if it had more than this share of the faces that greeted the robot: frontal faces may fall
    into two categories, and a robot that took one of them for a profile found nothing after gaze following."""
    truth: tuple[Literal["face", "category", "object"], ...] = ()
    """Parts of perception that are replaced by the truth: face, category, object."""


class Gazed(NamedTuple):
    """What an image shows, and whether that is at its centre; pixels as in ``Percept``, NaN for what was not found."""

    face: bool
    object: bool
    face_px: np.ndarray
    """(2,) centre of the face, wherever it is."""
    object_px: np.ndarray
    """(2,) centre of the object that is nearest to the centre of view."""
    pattern: np.ndarray | None
    """Grey patch (1024,) of the face at the centre; None if there is none."""


NOWHERE = np.full(2, np.nan)
NOTHING_LOOKED_AT = Gazed(False, False, NOWHERE, NOWHERE, None)


def gazed(perception: PixelPerception, image: np.ndarray, head: np.ndarray, radius_deg: float) -> Gazed:
    """Look at an image (h, w, 3) that was taken with the head at ``head`` (2,), rad."""
    percept = perception.look({"camera": image, "head_angles": head}, True)
    face, nearest, near = _centre(percept.visible, percept.px, np.radians(radius_deg) * FOCAL_PX)
    return Gazed(
        face, near, percept.px[-1].copy(), NOWHERE if nearest < 0 else percept.px[nearest].copy(),
        perception.face_pattern() if face else None,
    )  # fmt: skip


@njit(cache=True)
def _centre(visible, px, radius):
    """Whether the face is within ``radius`` of the centre; the nearest object, or -1, and whether that is."""
    nearest, least = -1, np.inf
    for k in range(len(visible)):
        off = np.hypot(px[k, 0] - CENTRE_X, px[k, 1] - CENTRE_Y) if visible[k] else np.inf
        if k == len(visible) - 1:
            return off <= radius, nearest, least <= radius
        if off < least:
            nearest, least = k, off


class Senses:
    """Turns what is gazed at into (S, R); made when the robot has seen enough faces to have categories of them.

    Attributes:
        looks: Whether images are needed at all.
        variables: Those of the mind: S1 has a value for each category.
        categories: Of faces.
        frontal: (values of S1,) bool: the categories of the faces that greeted the robot; one, or a few.
    """

    def __init__(
        self,
        config: SensesConfig,
        table: TableConfig,
        patterns: np.ndarray,
        greetings: int,
        rng: np.random.Generator,
    ):
        """``patterns`` (n, d): faces that were seen, of which the first ``greetings`` looked at the robot."""
        self._truth = {part: part in config.truth for part in PARTS}
        self.looks = not all(self._truth.values())
        som = SOM(patterns.shape[1], config.som, rng)
        som.train(patterns, rng)
        self.categories = FaceCategories(som, patterns, config.grouping)
        self._of_table = table_variables(table)
        self.variables = self._of_table if self._truth["category"] else _visible(self._of_table, self.categories.count)
        self._faces = len(self.variables.sensors[0].values) - 1
        if self._truth["category"]:
            votes = np.array([table.spots])
        else:
            votes = np.array([self.categories.of(pattern) for pattern in patterns[:greetings]])
        greeted = np.bincount(votes, minlength=self._faces + 1)
        self.frontal = greeted > config.frontal_share * len(votes)
        self._likeliest = int(greeted.argmax())

    def check(self) -> None:
        """Go on only with finite numbers.

        Raises:
            NotFiniteError: The map of faces holds NaN or infinity.
        """
        check_finite({"map of faces": self.categories.som.weights})

    def read(self, gazed: Gazed, sensors: np.ndarray, results: np.ndarray, s: np.ndarray, r: np.ndarray) -> None:
        """Write the values of this turn.

        Args:
            gazed: What the image shows.
            sensors: True values (2,), for the parts that are replaced by the truth.
            results: True values (results,).
            s: (2,) is written.
            r: (results,) is written.
        """
        truth = self._truth
        not_visible, none = len(self._of_table.sensors[0].values) - 1, 1
        face = sensors[0] != not_visible if truth["face"] else gazed.face
        if not face:
            s[0] = self._faces
        elif truth["category"]:
            s[0] = sensors[0] if sensors[0] != not_visible else self._likeliest
        elif gazed.pattern is not None:
            s[0] = self.categories.of(gazed.pattern)
        else:
            s[0] = self._likeliest
        there = sensors[1] != none if truth["object"] else gazed.object and not face
        s[1] = 0 if there else none
        r[0] = self.frontal[s[0]]
        if len(r) == 3:
            r[1] = face and not r[0]
        r[len(r) - 1] = there


def _visible(variables: Variables, categories: int) -> Variables:
    """The variables with categories of faces for what the caregiver looks at."""
    names = tuple(f"face {number}" for number in range(1, categories + 1))
    face = variables.sensors[0]
    return replace(variables, sensors=(Variable(face.name, (*names, face.values[-1])), *variables.sensors[1:]))


def named_by_majority(variables: Variables, counts: np.ndarray, truth: Sequence[str]) -> Variables:
    """Variables whose categories of faces bear the name of what she mostly looked at when they were seen.

    Only for people who read results: the robot does not know these names.

    Args:
        variables: The mind's.
        counts: (categories + 1, truths) how often each value of S1 came with each truth.
        truth: Names of the true values.
    """
    face, names = variables.sensors[0], list[str]()
    for number in range(len(face.values) - 1):
        name = truth[int(counts[number].argmax())] if counts[number].any() else face.values[number]
        again = sum(earlier.split(" (")[0] == name for earlier in (face.values[-1], *names))
        names.append(f"{name} ({again + 1})" if again else name)
    return replace(variables, sensors=(Variable(face.name, (*names, face.values[-1])), *variables.sensors[1:]))
