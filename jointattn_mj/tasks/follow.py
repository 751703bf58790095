"""The tasks ``follow`` and ``follow_hard``: the caregiver looks at an object, and the robot is to fixate it."""

import numpy as np
from dm_control.utils import rewards

from jointattn_mj.scene.camera import directions_to
from jointattn_mj.scene.looker import LookingWorld
from jointattn_mj.tasks.environment import JointAttentionTask
from jointattn_mj.tasks.physics import ROBOT_RADIUS, Physics

TIME_LIMIT = 3.0
"""Seconds in an episode; a shift of the robot's head takes some .3 s of them."""
MARGIN = np.radians(20.0)
"""Angle, rad, over which the reward of ``Follow`` falls to 0 beyond ROBOT_RADIUS: the next object is about that far."""


class WanderingWorld(LookingWorld):
    """A world in which the caregiver looks at the robot, then at one object after another."""

    steady = False


class Follow(JointAttentionTask):
    """Ten steps a second. Reward grows as the robot's line of sight comes near to the caregiver's object."""

    kind = LookingWorld

    def get_reward(self, physics: Physics) -> float:
        """1 within ROBOT_RADIUS of the caregiver's object, falling to 0 over ``MARGIN``."""
        target = self.world.caregiver.target
        return 0.0 if target is None else float(self.rewards(physics.robot_to_targets(), target))

    @staticmethod
    def rewards(angles: np.ndarray, targets: int | np.ndarray) -> np.ndarray:
        """Rewards (...) for angles (..., n + 1), rad, to all targets; ``targets`` (...) are the caregiver's."""
        angle = np.take_along_axis(angles, np.asarray(targets)[..., None], -1)[..., 0]
        near: np.ndarray = rewards.tolerance(angle, (0, ROBOT_RADIUS), MARGIN, sigmoid="linear", value_at_margin=0)
        return near

    def best_action(self, physics: Physics) -> np.ndarray:
        """Direction (2,), rad, of what the caregiver looks at or turns to; of the face while that is the robot."""
        target = self.world.caregiver.target
        direction = directions_to(self.world.candidate_points())[-1 if target is None else target]
        angles: np.ndarray = np.radians(direction)
        return angles


class FollowSparse(Follow):
    """The same with a caregiver who looks at one object after another, and reward for fixating alone."""

    kind = WanderingWorld

    @staticmethod
    def rewards(angles: np.ndarray, targets: int | np.ndarray) -> np.ndarray:
        """1 where the robot fixates what the caregiver looks at or turns to, and no other target is nearer; else 0."""
        nearest = (angles.argmin(-1) == targets) & (angles.min(-1) <= ROBOT_RADIUS)
        return nearest.astype(float)
