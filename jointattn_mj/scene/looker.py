"""Caregivers who look at objects and leave them where they are, of their own accord or as told, and their worlds."""

from dataclasses import replace
from typing import ClassVar, NamedTuple

import mujoco
import numpy as np
from dm_control.mujoco import Physics

from jointattn_mj.scene.caregiver import CaregiverConfig, Phase, TransferScript
from jointattn_mj.scene.layout import LayoutConfig
from jointattn_mj.scene.model import SceneConfig, rest_height
from jointattn_mj.scene.movement import Arm
from jointattn_mj.scene.world import World, WorldConfig

LOCATIONS_X = 1.0
"""Depth of the row of places between robot and caregiver, world frame, metres."""
MOST_Y, LEAST_APART = 0.36, 0.24
"""A row reaches so far to either side, or less with few places, which are then so far apart; metres."""
AWAY = (0.0, 0.0, -1.0)
"""Where objects are that are not on the table, out of everybody's sight."""
HAND_DOWN_DEG, HAND_UP_DEG = -25.0, 75.0
"""Pitch of the robot's forearm in its first and in its last gesture; the others lie between."""


class Looker(TransferScript):
    """Turns to an object, looks at it for a while (``gaze_s``), turns to another; her hand rests."""

    following: ClassVar[dict[Phase, Phase]] = {Phase.GREET: Phase.TURN, Phase.TURN: Phase.GAZE, Phase.GAZE: Phase.TURN}


class SteadyLooker(TransferScript):
    """Has turned to an object and looks at it for ever."""

    following: ClassVar[dict[Phase, Phase]] = {Phase.GREET: Phase.TURN, Phase.TURN: Phase.GAZE, Phase.GAZE: Phase.GAZE}

    def settle(self) -> "SteadyLooker":
        """Go on until she does."""
        while self.phase != Phase.GAZE:
            self.advance()
        return self


STRAIGHT = np.zeros(2)
ARM = 6
"""Her joints from here on are those of the arm."""


class Told(TransferScript):
    """Looks where she is told from the next step on; ``objects`` lie where others put them."""

    def look_at(self, point: np.ndarray | None, head_off: np.ndarray = STRAIGHT) -> None:
        """Look at a point (3,) in the world, or at the robot.

        ``head_off`` (2,): how far beside its share of the way the head comes to rest, rad; the eyes make up for it.
        """
        gaze = np.zeros(2) if point is None else self._sight(point)
        head = self.config.head_share * gaze + head_off
        eyes = gaze - head
        self.joints = np.concatenate([head, eyes, eyes, self.joints[ARM:]])

    def advance(self) -> None:
        """Keep to it."""


class LookingWorld(World):
    """A world of somebody who looks at objects; a step is a tenth of a second.

    Attributes:
        steady: Whether she looks at one from the beginning to the end, or at the robot, and then at one after another.
    """

    frames = 3
    steady = True

    def new_caregiver(self, head: np.ndarray, arm: Arm, rng: np.random.Generator) -> TransferScript:
        """See ``World``."""
        scene, layout = self.config.scene, self.config.layout
        behaviour = replace(self.config.behaviour, reach_arch_m=0.0)  # the hand would rise while it stays
        arguments = (behaviour, layout, len(scene.objects), rest_height(scene), head, arm, rng)
        return SteadyLooker(*arguments).settle() if self.steady else Looker(*arguments)


class Pose(NamedTuple):
    """Of all bodies; as in MjData."""

    qpos: np.ndarray
    mocap_pos: np.ndarray
    mocap_quat: np.ndarray


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

    def gesture(self, number: int, of: int) -> None:
        """Let the robot's hand make a gesture, 0 to ``of`` - 1; its own eye does not see it."""
        pitch = np.radians(HAND_DOWN_DEG + (HAND_UP_DEG - HAND_DOWN_DEG) * number / max(1, of - 1))
        self.data.mocap_quat[self._forearm] = np.cos(pitch / 2), 0, -np.sin(pitch / 2), 0

    def _bind(self, config: WorldConfig, physics: Physics) -> None:
        """See ``World``."""
        super()._bind(config, physics)
        self._forearm = self.model.body("robot/forearm").mocapid[0]

    def pose(self) -> Pose:
        """How bodies stand."""
        return Pose(self.data.qpos.copy(), self.data.mocap_pos.copy(), self.data.mocap_quat.copy())

    def stand(self, pose: Pose) -> None:
        """Let bodies stand like that, until the next step or arrival."""
        self.data.qpos[:], self.data.mocap_pos[:], self.data.mocap_quat[:] = pose
        mujoco.mj_forward(self.model, self.data)
        self._image = None

    def arrive(self, head: np.ndarray) -> None:
        """Let things be as they would be after a step, with the robot's head at ``head`` (2,), rad."""
        caregiver = self.caregiver
        caregiver.advance()
        self._script_angles[:], self._script_speeds[:] = caregiver.joints, 0
        self._head_angles[:], self._head_speeds[:], self._controls[:] = head, 0, head
        self._object_locations[:] = self._objects_before[:] = caregiver.objects
        mujoco.mj_forward(self.model, self.data)
        self._past.forget()
        self._image = None


def locations(count: int, scene: SceneConfig) -> np.ndarray:
    """Places for objects (count, 3) in a row from the robot's left to its right; world frame, metres."""
    reach = min(MOST_Y, LEAST_APART * (count - 1) / 2)
    return np.array([(LOCATIONS_X, y, rest_height(scene)) for y in np.linspace(reach, -reach, count)])
