"""Caregivers who look at objects and leave them where they are, of their own accord or as told, and their worlds."""

from dataclasses import replace
from typing import ClassVar

import mujoco
import numpy as np

from jointattn_mj.scene.caregiver import CaregiverConfig, ObjectTransfer, Phase
from jointattn_mj.scene.layout import LayoutConfig
from jointattn_mj.scene.model import SceneConfig, rest_height
from jointattn_mj.scene.movement import Arm
from jointattn_mj.scene.world import World

PLACES_X = 1.0
"""Depth of the row of places between robot and caregiver, world frame, metres."""
MOST_Y, LEAST_APART = 0.36, 0.24
"""A row reaches so far to either side, or less with few places, which are then so far apart; metres."""
AWAY = (0.0, 0.0, -1.0)
"""Where objects are that are not on the table, out of everybody's sight."""


class Looker(ObjectTransfer):
    """Turns to an object, looks at it for a while (``gaze_s``), turns to another; her hand rests."""

    following: ClassVar[dict[Phase, Phase]] = {Phase.GREET: Phase.TURN, Phase.TURN: Phase.GAZE, Phase.GAZE: Phase.TURN}


class SteadyLooker(ObjectTransfer):
    """Has turned to an object and looks at it for ever."""

    following: ClassVar[dict[Phase, Phase]] = {Phase.GREET: Phase.TURN, Phase.TURN: Phase.GAZE, Phase.GAZE: Phase.GAZE}

    def settle(self) -> "SteadyLooker":
        """Go on until she does."""
        while self.phase != Phase.GAZE:
            self.advance()
        return self


class Told(ObjectTransfer):
    """Looks where she is told from the next step on; ``objects`` lie where others put them."""

    def look(self, point: np.ndarray | None) -> None:
        """Look at a point (3,) in the world, or at the robot."""
        gaze = np.zeros(2) if point is None else self._sight(point)
        self._plan = self._planned(gaze[None], self._hand[None])

    def advance(self) -> None:
        """Keep to it."""
        self._play(0)


class LookingWorld(World):
    """A world of somebody who looks at objects; a step is a tenth of a second.

    Attributes:
        steady: Whether she looks at one from the beginning to the end, or at the robot, and then at one after another.
    """

    frames = 3
    steady = True

    def new_caregiver(self, head: np.ndarray, arm: Arm, rng: np.random.Generator) -> ObjectTransfer:
        """See ``World``."""
        scene, layout = self.config.scene, self.config.layout
        behaviour = replace(self.config.behaviour, reach_arch_m=0.0)  # the hand would rise while it stays
        arguments = (behaviour, layout, len(scene.objects), rest_height(scene), head, arm, rng)
        return SteadyLooker(*arguments).settle() if self.steady else Looker(*arguments)


class TurnWorld(World):
    """A world in which everybody does as told, a second at a time: gazes turn to places, objects lie on them."""

    frames = 30
    """A turn lasts a second, as long as a gaze shift "takes about one second" (section 6.4.1)."""
    caregiver: Told

    def new_caregiver(self, head: np.ndarray, arm: Arm, rng: np.random.Generator) -> Told:
        """See ``World``; she looks at the robot, and no object is on the table."""
        config = self.config
        anywhere = LayoutConfig(spacing=1e-6, evenness=1)
        told = Told(CaregiverConfig(), anywhere, len(config.scene.objects), rest_height(config.scene), head, arm, rng)
        told.objects[:] = AWAY
        return told

    def arrive(self, head: np.ndarray) -> None:
        """Let things be as they would be after a step, with the robot's head at ``head`` (2,), rad."""
        self.before_step(head)
        self._script_angles[:], self._script_speeds[:] = self.caregiver.joints, 0
        self._head_angles[:], self._head_speeds[:] = head, 0
        mujoco.mj_forward(self.model, self.data)
        self._past.forget()


def places(count: int, scene: SceneConfig) -> np.ndarray:
    """Places for objects (count, 3) in a row from the robot's left to its right; world frame, metres."""
    reach = min(MOST_Y, LEAST_APART * (count - 1) / 2)
    return np.array([(PLACES_X, y, rest_height(scene)) for y in np.linspace(reach, -reach, count)])
