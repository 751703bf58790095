"""Whether a gaze shift from the face to an object was joint attention (section 6.4.3). Uses the truth, tells the robot
nothing.

"We counted whether the robot was able to perform joint attention with the human or not when it directed its gaze from
his face to an object" leaves open which moment counts, for a shift takes a second and the human goes on meanwhile:

- at launch: the robot ended at the place that held the caregiver's target when the robot set out;
- at landing: the robot ended at the place that holds the caregiver's target now.
"""

from dataclasses import dataclass

import numpy as np

from jointattn_mj.scene.camera import directions_to, off_centre
from jointattn_mj.scene.world import World


@dataclass(frozen=True)
class Moment:
    """What the caregiver looked at, at one time."""

    frame: int
    phase: str
    target: int | None
    directions: np.ndarray  # (n, 2) of the objects from the robot, deg

    @classmethod
    def now(cls, world: World, frame: int) -> "Moment":
        """The present of ``world``."""
        caregiver = world.caregiver
        return cls(frame, str(caregiver.phase), caregiver.target, directions_to(caregiver.objects))

    def nearest(self, head: np.ndarray) -> tuple[int, float]:
        """The object nearest to the centre of view of a head at ``head`` (deg), and its distance (deg)."""
        distances = [off_centre(direction, head) for direction in self.directions]
        index = int(np.argmin(distances))
        return index, distances[index]


@dataclass(frozen=True)
class Judgement:
    """How a shift from the face to an object ended."""

    at_launch: bool
    at_landing: bool
    nearest: int  # object nearest to the centre of view at landing
    distance: float  # how far off it was, deg


def judge(launch: Moment, landing: Moment, head: np.ndarray) -> Judgement:
    """Judge a shift that began at ``launch`` and left the head at ``head`` (pan, tilt; deg) at ``landing``."""
    nearest, distance = landing.nearest(head)
    return Judgement(
        at_launch=launch.nearest(head)[0] == launch.target,
        at_landing=nearest == landing.target,
        nearest=nearest,
        distance=distance,
    )
