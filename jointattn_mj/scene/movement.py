"""How bodies move: minimum-jerk profiles, gaze directions, and the arm's inverse kinematics in closed form.

Everything here is a pure function of whole paths: a caregiver plans a movement once and plays it frame by frame.
Points and directions are in the caregiver's own frame unless said otherwise: origin on the floor below her, x towards
the robot, y to her left, z up; metres and radians.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from jointattn_mj.errors import ObservationError
from jointattn_mj.guards.border import checked_by, require_array
from jointattn_mj.guards.restored import check_array
from jointattn_mj.io.compiled import njit

ARM_JOINTS = ("shoulder_yaw", "shoulder_pitch", "shoulder_roll", "elbow", "wrist_yaw", "wrist_pitch", "wrist_roll")


def minimum_jerk(frames: int) -> np.ndarray:
    """Progress of a minimum-jerk movement at the end of each of its frames: (frames,), rising to exactly 1."""
    tau = np.arange(1, frames + 1) / frames
    return tau**3 * (10 - 15 * tau + 6 * tau**2)


def path_between(start: np.ndarray, end: np.ndarray, frames: int, arch: float = 0.0) -> np.ndarray:
    """Minimum-jerk path from ``start`` (excluded) to ``end``, (frames, d), raised in its last axis by ``arch`` midway.

    The arch is a parabola over the straight way, so that speed and acceleration still vanish at either end.
    """
    progress = minimum_jerk(frames)[:, None]
    path = start + progress * (np.asarray(end) - start)
    path[:, -1] += 4 * arch * (progress * (1 - progress))[:, 0]
    return path


def gaze_angles(eye: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Yaw (to her left) and pitch (nose down) that turn a face at ``eye`` (3,) to ``points`` (..., 3): (..., 2)."""
    along = points - eye
    yaw = np.arctan2(along[..., 1], along[..., 0])
    pitch = -np.arctan2(along[..., 2], np.hypot(along[..., 0], along[..., 1]))
    return np.stack([yaw, pitch], axis=-1)


def _check_rotation(rotation):
    require_array("rotation", rotation, (3, 3), "f", -2, 2)


@checked_by(_check_rotation)
@njit(cache=True)
def rotation_to_zyx(rotation):
    """Angles (3,) of three hinges about z, then y, then x that make ``rotation`` (3, 3)."""
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    pitch = np.arctan2(-rotation[2, 0], np.hypot(rotation[0, 0], rotation[1, 0]))
    return np.array([yaw, pitch, np.arctan2(rotation[2, 1], rotation[2, 2])])


@njit(cache=True)
def _times(a, b):
    """Product of two 3x3 matrices (numba's own needs scipy)."""
    product = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            for k in range(3):
                product[i, j] += a[i, k] * b[k, j]
    return product


@njit(cache=True)
def _reach(points, swing, shoulder, upper, fore, grasp, hand):
    """`Arm.reach` point by point. Compiled: in numpy this is most of what planning costs, and falls into one frame."""
    joints = np.empty((len(points), 7))
    for t in range(len(points)):
        to_wrist = points[t] - shoulder
        for i in range(3):
            to_wrist[i] -= (hand[i] * grasp).sum()
        distance = np.sqrt((to_wrist**2).sum())
        along = to_wrist / distance
        distance = min(max(distance, abs(upper - fore) + 1e-6), upper + fore - 1e-6)
        right = np.array([along[1], -along[0], 0.0]) / np.hypot(along[0], along[1])
        side = np.cos(swing[t]) * right + np.sin(swing[t]) * np.cross(right, along)

        # Law of cosines: the angle at the shoulder between the line to the wrist and the upper arm, and the elbow's.
        at_shoulder = np.arccos((upper**2 + distance**2 - fore**2) / (2 * upper * distance))
        bend = np.pi - np.arccos((upper**2 + fore**2 - distance**2) / (2 * upper * fore))

        # The upper arm's frame: x along it, y in the plane of the arm on the side to which the elbow bends.
        x = np.cos(at_shoulder) * along + np.sin(at_shoulder) * side
        y = np.sin(at_shoulder) * along - np.cos(at_shoulder) * side
        frame = np.column_stack((x, y, np.cross(x, y)))
        turn = np.array([[np.cos(bend), -np.sin(bend), 0.0], [np.sin(bend), np.cos(bend), 0.0], [0.0, 0.0, 1.0]])
        joints[t, :3] = rotation_to_zyx(frame)
        joints[t, 3] = bend
        joints[t, 4:] = rotation_to_zyx(_times(_times(frame, turn).T, hand))
    return joints


@dataclass(frozen=True)
class Arm:
    """An arm of two links with ball-like shoulder and wrist; the hand keeps one orientation wherever it goes.

    The arm has one degree of freedom to spare, the swing of the elbow about the line from shoulder to wrist. The
    caller chooses it: swing 0 points the elbow level to her right, a positive swing raises it.
    """

    shoulder: np.ndarray  # (3,)
    upper: float
    fore: float
    grasp: np.ndarray  # (3,) from the wrist to a held object's centre, in the hand's frame
    hand: np.ndarray  # (3, 3) the hand's orientation

    def __post_init__(self) -> None:
        for name, shape in (("shoulder", (3,)), ("grasp", (3,)), ("hand", (3, 3))):
            check_array(f"the arm's {name}", getattr(self, name), shape, float)

    @classmethod
    def from_model(cls, model: mujoco.MjModel, hand_pitch: float) -> "Arm":
        """Read the lengths from the model; ``hand_pitch`` tilts the fingers down by so many radians."""
        cos, sin = np.cos(hand_pitch), np.sin(hand_pitch)
        return cls(
            shoulder=model.body("caregiver/shoulder").pos.copy(),
            upper=float(model.body("caregiver/elbow").pos[0]),
            fore=float(model.body("caregiver/wrist").pos[0]),
            grasp=model.site("caregiver/grasp").pos.copy(),
            hand=np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]]),
        )

    def reach(self, points: np.ndarray, swing: np.ndarray) -> np.ndarray:
        """Joint angles (T, 7), in the order of ``ARM_JOINTS``, that bring the grasp to ``points`` (T, 3).

        ``swing`` (T,) raises the elbow above the level of shoulder and wrist, rad. A point beyond the arm's length is
        approached as far as the straight arm goes.
        """
        if points.shape != (*swing.shape, 3) or swing.ndim != 1:
            raise ObservationError(f"the arm takes points (T, 3) and swing (T,); got {points.shape} and {swing.shape}")
        return _reach(points, swing, self.shoulder, self.upper, self.fore, self.grasp, self.hand)
