"""Gaze following alone, in episodes of seconds: the caregiver looks at one object, and the robot is to fixate it."""

import numpy as np
from dm_control.utils import rewards

from jointattn_mj.scene.camera import directions_to
from jointattn_mj.scene.looker import LookingWorld
from jointattn_mj.tasks.environment import JointAttentionTask
from jointattn_mj.tasks.physics import ROBOT_RADIUS, Physics

TIME_LIMIT = 3.0
"""Seconds in an episode; a turn of the head takes some .3 s of them."""
MARGIN = np.radians(20.0)
"""Beyond ROBOT_RADIUS the reward of ``Follow`` falls to nothing over so much: the next object lies about there."""


class Wandering(LookingWorld):
    """She looks at the robot, then at one object after another."""

    steady = False


class Follow(JointAttentionTask):
    """Ten steps a second; reward grows as the robot's line of sight comes near to the object that she looks at."""

    kind = LookingWorld

    def get_reward(self, physics: Physics) -> float:
        """1 while the robot fixates her object, falling to 0 where it looks ``MARGIN`` further away."""
        target = self.world.caregiver.target
        if target is None:
            return 0.0
        angle = physics.robot_to_targets()[target]
        return float(rewards.tolerance(angle, (0, ROBOT_RADIUS), MARGIN, sigmoid="linear", value_at_margin=0))

    def best_action(self, physics: Physics) -> np.ndarray:
        """The direction of the object that she looks at or turns to, (2,), rad; of her face while that is the robot."""
        target = self.world.caregiver.target
        return np.radians(directions_to(self.world.candidate_points())[-1 if target is None else target])


class FollowSparse(Follow):
    """The same for a caregiver who looks elsewhere now and then, and reward for nothing but fixating."""

    kind = Wandering

    def get_reward(self, physics: Physics) -> float:
        """1 while the robot fixates the object that she looks at or turns to, and no other is nearer; else 0."""
        target = self.world.caregiver.target
        return float(target is not None and physics.robot_fixates() == target)
