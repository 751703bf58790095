"""Scoring of gaze shifts from the face to an object: was it joint attention (section 6.4.3)?

Scoring uses the state of the simulation; the robot is not told. "We counted whether the robot was able to
perform joint attention with the human or not when it directed its gaze from his face to an object" leaves open which
moment counts. A shift takes a second, and the human goes on meanwhile:

- at launch: the robot ended where the caregiver's target was when the shift began;
- at landing: the robot ended where the caregiver's target is now.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from jointattn_mj.scene.camera import directions_to, off_centre
from jointattn_mj.scene.caregiver import FRAME_S
from jointattn_mj.scene.world import World


@dataclass(frozen=True)
class Moment:
    """The caregiver's target and the objects' directions at one time."""

    frame: int  # of the session
    phase: str | None  # of the caregiver's task, where that is known
    target: int | None  # object that the caregiver looks at
    directions: np.ndarray  # (n, 2) of the objects from the robot, deg

    @property
    def time_s(self) -> float:
        """Time in the session, s."""
        return self.frame * FRAME_S

    def nearest(self, head: np.ndarray) -> tuple[int, float]:
        """The object nearest to the centre of view, and its distance (deg), for a head at ``head`` (pan, tilt; deg)."""
        distances = [off_centre(direction, head) for direction in self.directions]
        index = int(np.argmin(distances))
        return index, distances[index]


_MADE_OF = ("frame", "phase", "target", "objects")


class WorldMoment(Moment):
    """A moment of a simulated world. Directions are worked out when they are looked at: few gaze shifts are judged."""

    objects: np.ndarray  # (n, 3) their centres, world frame, metres

    def __init__(self, world: World, frame: int):
        """The present moment of ``world``; ``frame`` is its number."""
        caregiver = world.caregiver
        vars(self).update(
            frame=frame, phase=str(caregiver.phase), target=caregiver.target, objects=caregiver.objects.copy()
        )

    def __getstate__(self) -> dict[str, Any]:
        """What it was made of."""
        return {name: vars(self)[name] for name in _MADE_OF}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore it.

        Raises:
            ValueError: It was made of something else.
        """
        if tuple(state) != _MADE_OF:
            raise ValueError(f"a moment of a world is made of {_MADE_OF}; got {tuple(state)}")
        vars(self).update(state)

    @cached_property
    def directions(self) -> np.ndarray:
        """(n, 2) of the objects from the robot, deg."""
        return directions_to(self.objects)


@dataclass(frozen=True)
class Judgement:
    """Score of a gaze shift from the face to an object."""

    at_launch: bool | None  # success by the caregiver's target at launch; None where that is not known
    at_landing: bool | None  # success by the target at landing, likewise
    nearest: int  # object nearest to the centre of view at landing
    distance: float  # how far off it was, deg

    def success(self, moment: Literal["either", "launch", "landing"]) -> bool | None:
        """Whether the shift was a success by the target at that moment; None where that is not known."""
        if moment != "either":
            return self.at_launch if moment == "launch" else self.at_landing
        either = {self.at_launch, self.at_landing}
        return True if True in either else None if None in either else False


def judge(launch: Moment, landing: Moment, head: np.ndarray) -> Judgement:
    """Score a gaze shift from the face to an object.

    Args:
        launch: Moment at which it began.
        landing: Moment at which it ended.
        head: Direction (pan, tilt) of the head at landing, deg.
    """
    nearest, distance = landing.nearest(head)
    return Judgement(
        at_launch=launch.nearest(head)[0] == launch.target,
        at_landing=nearest == landing.target,
        nearest=nearest,
        distance=distance,
    )
