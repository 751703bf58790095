"""A caregiver who sits for the robot: posed, rendered and perceived outside of any episode."""

import mujoco
import numpy as np

from jointattn_mj.perception.percept import StillObservation
from jointattn_mj.perception.pixels import PixelPerception
from jointattn_mj.scene.servo import HEAD_JOINTS
from jointattn_mj.scene.world import SCRIPTED_JOINTS, World

SWEEP_DEG = 45.0
"""How far to either side the caregiver turns in ``sweep``, degrees of gaze."""
SWEEP_PITCHES_DEG = (0.0, 15.0, 30.0, 45.0)
"""Pitches of gaze at which the caregiver does so, degrees: from straight ahead down to the near edge of the table."""
SWEEP_STEP_DEG = 3.0
"""Turn of the gaze from one image to the next, degrees."""


class Sitter:
    """The caregiver with head and eyes turned as in ``scene.caregiver``, and all else at rest."""

    def __init__(self, stage: World, head_share: float, perception: PixelPerception):
        """Prepare to pose.

        Args:
            stage: The world that is posed; it must be reset before it is used for anything else.
            head_share: Share of a gaze shift that the caregiver's head makes, 0 to 1; the eyes make the rest.
            perception: The robot's perception, which learns what it sees.
        """
        self._stage, self._head_share, self._perception = stage, head_share, perception
        self._gaze = [stage.model.joint(name).qposadr[0] for name in SCRIPTED_JOINTS[:6]]
        self._robot = [stage.model.joint(name).qposadr[0] for name in HEAD_JOINTS]

    def pattern(self, gaze: np.ndarray, head: np.ndarray) -> np.ndarray | None:
        """Face pattern (1024,) for a ``gaze`` (2,) and the robot's ``head`` (2,), deg; None if no face was detected."""
        data = self._stage.data
        neck = self._head_share * gaze
        data.qpos[self._gaze] = np.radians(np.concatenate([neck, gaze - neck, gaze - neck]))
        data.qpos[self._robot] = np.radians(head)
        mujoco.mj_forward(self._stage.model, data)
        observation = StillObservation(self._stage.eye.render(), np.radians(head))
        percept = self._perception.glance(observation)
        return self._perception.face_pattern() if percept.visible[-1] else None

    def sweep(self, head: np.ndarray) -> None:
        """Look at the robot, then over the whole table, so that perception has seen the face from all sides.

        Args:
            head: (2,) pan and tilt of the robot's head, degrees.
        """
        yaws = np.arange(0, SWEEP_DEG + SWEEP_STEP_DEG / 2, SWEEP_STEP_DEG)
        there_and_back = np.concatenate([yaws, yaws[::-1], -yaws, -yaws[::-1]])
        for pitch in SWEEP_PITCHES_DEG:
            for yaw in there_and_back:
                self.pattern(np.array([yaw, pitch]), head)
