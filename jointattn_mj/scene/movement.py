"""How bodies move: minimum-jerk profiles, gaze directions, and the arm's inverse kinematics in closed form.

All functions work on whole paths: a movement is planned once and played frame by frame. Points and directions are in
the caregiver's frame unless said otherwise: origin on the floor below the head, x towards the robot, y to the
caregiver's left, z up; metres and radians.
"""

from dataclasses import dataclass
from functools import lru_cache

import mujoco
import numpy as np

from jointattn_mj.errors import ObservationError
from jointattn_mj.guards.border import require_array
from jointattn_mj.guards.restored import check_array
from jointattn_mj.io.compiled import njit

ARM_JOINTS = ("shoulder_yaw", "shoulder_pitch", "shoulder_roll", "elbow", "wrist_yaw", "wrist_pitch", "wrist_roll")


@lru_cache(maxsize=256)
def minimum_jerk(frames: int) -> np.ndarray:
    """Progress of a minimum-jerk movement at the end of each of its frames: (frames,), rising to exactly 1.

    The array is shared, and read-only.
    """
    tau = np.arange(1, frames + 1) / frames
    progress: np.ndarray = tau**3 * (10 - 15 * tau + 6 * tau**2)
    progress.flags.writeable = False
    return progress


def path_between(start: np.ndarray, end: np.ndarray, frames: int, arch: float = 0.0) -> np.ndarray:
    """A minimum-jerk path.

    Args:
        start: (d,) where the path starts; it is not part of the path.
        end: (d,) where it ends.
        frames: Its length.
        arch: Height of a parabola that raises the last axis. Speed and acceleration still vanish at either end.

    Returns:
        (frames, d), in the unit of ``start``.
    """
    progress = minimum_jerk(frames)[:, None]
    path: np.ndarray = start + progress * (np.asarray(end) - start)
    path[:, -1] += 4 * arch * (progress * (1 - progress))[:, 0]
    return path


def gaze_angles(eye: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Yaw (to the caregiver's left) and pitch (nose down) from ``eye`` (3,) to ``points`` (..., 3): (..., 2), rad."""
    along = points - eye
    yaw = np.arctan2(along[..., 1], along[..., 0])
    pitch = -np.arctan2(along[..., 2], np.hypot(along[..., 0], along[..., 1]))
    return np.stack([yaw, pitch], axis=-1)


def rotation_to_zyx(rotation: np.ndarray) -> np.ndarray:
    """Angles (3,), rad, of three hinges about z, then y, then x that make up ``rotation`` (3, 3).

    Raises:
        ObservationError: It is no rotation.
    """
    require_array("rotation", rotation, (3, 3), "f", -2, 2)
    return np.array(_zyx(np.ascontiguousarray(rotation.T)))


@njit(cache=True)
def _zyx(axes: np.ndarray) -> tuple[float, float, float]:
    """``rotation_to_zyx`` of a rotation's columns, as three numbers, which take half as long to compile as an array."""
    yaw = np.arctan2(axes[0, 1], axes[0, 0])
    pitch = np.arctan2(-axes[0, 2], np.hypot(axes[0, 0], axes[0, 1]))
    return yaw, pitch, np.arctan2(axes[1, 2], axes[2, 2])


@njit(cache=True)
def _transposed_times(a: np.ndarray, b: np.ndarray, product: np.ndarray) -> None:
    """Put the product of a transposed matrix (3, 3) and another into a third; numba's own would need scipy."""
    for i in range(3):
        for j in range(3):
            product[i, j] = 0.0
            for k in range(3):
                product[i, j] += a[k, i] * b[k, j]


@njit(cache=True)
def _reach(
    points: np.ndarray,
    swing: np.ndarray,
    shoulder: np.ndarray,
    upper: float,
    fore: float,
    grasp: np.ndarray,
    hand: np.ndarray,
) -> np.ndarray:
    """``Arm.reach``, point by point. Compiled: in numpy it takes most of the planning, which falls into one frame.

    Vectors of three numbers are written out: whole-array operations take four times as long to compile. All arrays have
    two axes, and none is transposed: others would be compiled apart.
    """
    joints, along = np.zeros((len(points), 7)), np.zeros((1, 3))
    axes, elbow, forearm, wrist = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    for t in range(len(points)):
        squares = 0.0
        for i in range(3):
            held = 0.0
            for k in range(3):
                held += hand[i, k] * grasp[k]
            along[0, i] = points[t, i] - shoulder[i] - held
            squares += along[0, i] * along[0, i]
        distance = np.sqrt(squares)
        for i in range(3):
            along[0, i] /= distance
        distance = min(max(distance, abs(upper - fore) + 1e-6), upper + fore - 1e-6)
        level = np.hypot(along[0, 0], along[0, 1])
        right_x, right_y = along[0, 1] / level, -along[0, 0] / level
        cos_swing, sin_swing = np.cos(swing[t]), np.sin(swing[t])

        # Law of cosines: the angle at the shoulder between the line to the wrist and the upper arm, and the elbow's.
        at_shoulder = np.arccos((upper**2 + distance**2 - fore**2) / (2 * upper * distance))
        bend = np.pi - np.arccos((upper**2 + fore**2 - distance**2) / (2 * upper * fore))
        cos_shoulder, sin_shoulder = np.cos(at_shoulder), np.sin(at_shoulder)

        # The upper arm's axes: x along it, y in the plane of the arm on the side to which the elbow bends.
        above = right_y * along[0, 2], -right_x * along[0, 2], right_x * along[0, 1] - right_y * along[0, 0]
        for i, right in enumerate((right_x, right_y, 0.0)):
            side = cos_swing * right + sin_swing * above[i]
            axes[0, i] = cos_shoulder * along[0, i] + sin_shoulder * side
            axes[1, i] = sin_shoulder * along[0, i] - cos_shoulder * side
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            axes[2, i] = axes[0, j] * axes[1, k] - axes[0, k] * axes[1, j]
        elbow[0, 0], elbow[0, 1], elbow[1, 0], elbow[1, 1] = np.cos(bend), -np.sin(bend), np.sin(bend), np.cos(bend)
        elbow[2, 2] = 1.0
        joints[t, 0], joints[t, 1], joints[t, 2] = _zyx(axes)
        joints[t, 3] = bend
        _transposed_times(axes, elbow, forearm)
        _transposed_times(hand, forearm, wrist)  # its columns
        joints[t, 4], joints[t, 5], joints[t, 6] = _zyx(wrist)
    return joints


@dataclass(frozen=True)
class Arm:
    """An arm of two links, whose hand keeps one orientation wherever it goes.

    One degree of freedom is free: the swing of the elbow about the line from shoulder to wrist. With swing 0 the elbow
    points to the caregiver's right, at the same level; a positive swing raises it.

    Attributes:
        shoulder: (3,) position of the shoulder, metres.
        upper: Length of the upper arm, metres.
        fore: Length of the forearm, metres.
        grasp: (3,) from the wrist to a held object's centre, the hand's frame, metres.
        hand: (3, 3) orientation of the hand.
    """

    shoulder: np.ndarray
    upper: float
    fore: float
    grasp: np.ndarray
    hand: np.ndarray

    def __repr__(self) -> str:
        return f"Arm(upper={self.upper:.3f} m, fore={self.fore:.3f} m)"

    def __post_init__(self) -> None:
        for name, shape in (("shoulder", (3,)), ("grasp", (3,)), ("hand", (3, 3))):
            check_array(f"the arm's {name}", getattr(self, name), shape, float)

    @classmethod
    def from_model(cls, model: mujoco.MjModel, hand_pitch: float) -> "Arm":
        """The caregiver's arm of a model; ``hand_pitch``, rad, tilts the fingers down."""
        cos, sin = np.cos(hand_pitch), np.sin(hand_pitch)
        return cls(
            shoulder=model.body("caregiver/shoulder").pos.copy(),
            upper=float(model.body("caregiver/elbow").pos[0]),
            fore=float(model.body("caregiver/wrist").pos[0]),
            grasp=model.site("caregiver/grasp").pos.copy(),
            hand=np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]]),
        )

    def reach(self, points: np.ndarray, swing: np.ndarray) -> np.ndarray:
        """Inverse kinematics.

        Args:
            points: (T, 3) where the grasp is to be, metres. Points out of reach are approached by the straight arm.
            swing: (T,) how far the elbow is raised above the level of shoulder and wrist, rad.

        Returns:
            Joint angles (T, 7), rad, in the order of ``ARM_JOINTS``.

        Raises:
            ObservationError: Shapes differ from these.
        """
        if points.shape != (*swing.shape, 3) or swing.ndim != 1:
            raise ObservationError(f"the arm takes points (T, 3) and swing (T,); got {points.shape} and {swing.shape}")
        joints: np.ndarray = _reach(points, swing, self.shoulder, self.upper, self.fore, self.grasp, self.hand)
        return joints
