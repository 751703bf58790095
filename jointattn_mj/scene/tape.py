"""Successive frames of a world: what was to be seen in each of them."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Tape:
    """A number of successive frames, k; each as it was before its step.

    Attributes:
        doing: (k, 3) int, what ``TransferScript.doing`` says of the caregiver.
        head: (k, 2) pan and tilt of the robot's head, rad.
        face: (k, 2) yaw and pitch of the caregiver's head, rad.
        face_speeds: (k, 2) their speeds, rad/s.
        objects: (k + 1, n, 3) centres of the objects, world frame, metres: in the frame before, and in each frame.
    """

    doing: np.ndarray
    head: np.ndarray
    face: np.ndarray
    face_speeds: np.ndarray
    objects: np.ndarray

    def __len__(self) -> int:
        """Frames on it."""
        return len(self.doing)

    def __repr__(self) -> str:
        return f"Tape({len(self)} frames)"
