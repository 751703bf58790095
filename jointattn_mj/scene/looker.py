"""Caregivers who look at objects without moving them, by a script of their own or as directed, and their worlds."""

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

SPOTS_X = 1.0
"""x of the row of spots between robot and caregiver, world frame, metres."""
MOST_Y, LEAST_APART = 0.36, 0.24
"""How far a row of spots reaches to either side, and how far apart few spots are; metres."""
AWAY = (0.0, 0.0, -1.0)
"""Where objects that are not on the table are kept out of sight; world frame, metres."""
HAND_DOWN_DEG, HAND_UP_DEG = -25.0, 75.0
"""Pitch of the robot's forearm in the first and in the last gesture; the others lie between."""


class WanderingGaze(TransferScript):
    """Looks at the robot, then at one object after another for ``gaze_s`` each; the hand rests."""

    following: ClassVar[dict[Phase, Phase]] = {Phase.GREET: Phase.TURN, Phase.TURN: Phase.GAZE, Phase.GAZE: Phase.TURN}


class SteadyGaze(TransferScript):
    """Turns to an object and looks at it from then on; the hand rests."""

    following: ClassVar[dict[Phase, Phase]] = {Phase.GREET: Phase.TURN, Phase.TURN: Phase.GAZE, Phase.GAZE: Phase.GAZE}

    def settle(self) -> "SteadyGaze":
        """Advance until the gaze rests on the object."""
        while self.phase != Phase.GAZE:
            self.advance()
        return self


STRAIGHT = np.zeros(2)
ARM = 6
"""Index of the first arm joint among ``TransferScript.joints``."""


class DirectedCaregiver(TransferScript):
    """Looks where ``look_at`` says, from the next step on; ``objects`` lie where the world's owner puts them."""

    def look_at(self, point: np.ndarray | None, head_off: np.ndarray = STRAIGHT) -> None:
        """Direct the gaze.

        Args:
            point: (3,) what to look at, world frame, metres; None for the robot.
            head_off: (2,) error of the head's yaw and pitch, rad, which the eyes make up for.
        """
        gaze = np.zeros(2) if point is None else self._sight(point)
        head = self.config.head_share * gaze + head_off
        eyes = gaze - head
        self.joints = np.concatenate([head, eyes, eyes, self.joints[ARM:]])

    def advance(self) -> None:
        """Keep the pose."""


class LookingWorld(World):
    """A world in which the caregiver only looks; a step is a tenth of a second.

    Attributes:
        steady: Whether the caregiver looks at one object all the time, or at the robot and then at object after object.
    """

    frames = 3
    steady = True

    def new_caregiver(self, head: np.ndarray, arm: Arm, rng: np.random.Generator) -> TransferScript:
        """See ``World``."""
        scene, layout = self.config.scene, self.config.layout
        behaviour = replace(self.config.behaviour, reach_arch_m=0.0)  # the hand would rise while it stays
        arguments = (behaviour, layout, len(scene.objects), rest_height(scene), head, arm, rng)
        return SteadyGaze(*arguments).settle() if self.steady else WanderingGaze(*arguments)


class Pose(NamedTuple):
    """Pose of all bodies: ``qpos``, ``mocap_pos`` and ``mocap_quat`` as in MjData."""

    qpos: np.ndarray
    mocap_pos: np.ndarray
    mocap_quat: np.ndarray


class TableWorld(World):
    """A world that is directed step by step, as the table of chapters 4 and 5: gazes and objects go to spots."""

    frames = 30
    """A step lasts a second, since a gaze shift "takes about one second" (section 6.4.1)."""
    caregiver: DirectedCaregiver

    def new_caregiver(self, head: np.ndarray, arm: Arm, rng: np.random.Generator) -> DirectedCaregiver:
        """See ``World``; the caregiver looks at the robot, and no object is on the table."""
        config = self.config
        anywhere = LayoutConfig(spacing=1e-6, evenness=1)
        objects, height = len(config.scene.objects), rest_height(config.scene)
        caregiver = DirectedCaregiver(CaregiverConfig(), anywhere, objects, height, head, arm, rng)
        caregiver.objects[:] = AWAY
        return caregiver

    def gesture(self, number: int, of: int) -> None:
        """Let the robot's hand make gesture ``number`` of 0 to ``of`` - 1, which its own eye does not see."""
        pitch = np.radians(HAND_DOWN_DEG + (HAND_UP_DEG - HAND_DOWN_DEG) * number / max(1, of - 1))
        self.data.mocap_quat[self._forearm] = np.cos(pitch / 2), 0, -np.sin(pitch / 2), 0

    def _bind(self, config: WorldConfig, physics: Physics) -> None:
        """See ``World``."""
        super()._bind(config, physics)
        self._forearm = self.model.body("robot/forearm").mocapid[0]

    def pose(self) -> Pose:
        """The pose of all bodies now."""
        return Pose(self.data.qpos.copy(), self.data.mocap_pos.copy(), self.data.mocap_quat.copy())

    def stand(self, pose: Pose) -> None:
        """Put all bodies into a pose, until the next step or ``arrive``."""
        self.data.qpos[:], self.data.mocap_pos[:], self.data.mocap_quat[:] = pose
        mujoco.mj_forward(self.model, self.data)
        self._image = None

    def arrive(self, head: np.ndarray) -> None:
        """Put everything where a step would bring it, and the robot's head at ``head`` (2,), pan and tilt, rad."""
        caregiver = self.caregiver
        caregiver.advance()
        self._script_angles[:], self._script_speeds[:] = caregiver.joints, 0
        self._head_angles[:], self._head_speeds[:], self._controls[:] = head, 0, head
        self._object_positions[:] = self._objects_before[:] = caregiver.objects
        mujoco.mj_forward(self.model, self.data)
        self._past.forget()
        self._image = None


def spot_positions(count: int, scene: SceneConfig) -> np.ndarray:
    """Centres (count, 3) of objects on the spots, a row from the robot's left to its right; world frame, metres."""
    reach = min(MOST_Y, LEAST_APART * (count - 1) / 2)
    return np.array([(SPOTS_X, y, rest_height(scene)) for y in np.linspace(reach, -reach, count)])
