"""The task ``object_transfer``: the caregiver takes objects up, observes them, puts them elsewhere (section 6.4.2)."""

from collections import OrderedDict

import numpy as np
from dm_env import specs

from jointattn_mj.scene.camera import directions_to
from jointattn_mj.tasks.environment import JointAttentionTask, TaskObservation
from jointattn_mj.tasks.physics import Physics

TIME_LIMIT = 60.0
"""Seconds in an episode: seven or eight transfers of an object."""


class ObjectTransfer(JointAttentionTask):
    """Thirty steps a second; reward while both look at the same object."""

    def observation_spec(self, physics: Physics) -> OrderedDict[str, specs.Array]:
        """Shapes and bounds of what ``get_observation`` returns."""
        spec = super().observation_spec(physics)
        spec["head_moves"] = specs.Array((), bool, name="head_moves")
        return spec

    def get_observation(self, physics: Physics) -> TaskObservation:
        """As in every task, and whether the robot's head turns."""
        observation = super().get_observation(physics)
        observation["head_moves"] = np.array(self.world.head_moves())
        return observation

    def get_reward(self, physics: Physics) -> float:
        """1 while both look at the same object, else 0."""
        return float(physics.joint_attention())

    def best_action(self, physics: Physics) -> np.ndarray:
        """Direction (2,), rad, of the object that the caregiver looks at; of the face while that is the robot."""
        target = self.world.caregiver.target
        points = self.world.candidate_points()
        angles: np.ndarray = np.radians(directions_to(points)[-1 if target is None else target])
        return angles
