"""How a world's bodies move in a step, in compiled code: set out, stepped many times over, and what has moved."""

from math import sqrt
from typing import Any

import numpy as np

from jointattn_mj.io.compiled import njit
from jointattn_mj.scene.servo import Servos, turn


@njit(cache=True)
def set_out(
    joints: np.ndarray,
    angles: np.ndarray,
    speeds: np.ndarray,
    objects: np.ndarray,
    positions: np.ndarray,
    seconds: float,
) -> None:
    """Set ``speeds`` that bring ``angles`` to ``joints`` in ``seconds``, and the objects' ``positions``.

    Compiled: 0.8 microseconds a step instead of 3.9.

    Args:
        joints: (m,) the caregiver's joints at the end of the step, rad.
        angles: (m,) the same now.
        speeds: (m,) takes their speeds, rad/s.
        objects: (n, 3) where the objects are to be, metres.
        positions: (n, 3) takes that.
        seconds: Length of the step, s.
    """
    if not len(joints) == len(angles) == len(speeds) or objects.shape != positions.shape:
        raise ValueError("joints and objects do not fit the world")
    for k in range(len(speeds)):
        speeds[k] = (joints[k] - angles[k]) / seconds
    for k in range(len(positions)):
        for axis in range(positions.shape[1]):
            positions[k, axis] = objects[k, axis]


@njit(cache=True)
def run_in_physics(
    step1: Any, step2: Any, model: int, data: int, commands: np.ndarray, joints: np.ndarray, objects: np.ndarray,
    seconds: float, controls: np.ndarray, angles: np.ndarray, speeds: np.ndarray, positions: np.ndarray,
    heads: np.ndarray, head: np.ndarray, face: np.ndarray, face_speeds: np.ndarray,
) -> None:  # fmt: skip
    """Simulate a step for each of ``commands``, and note before it where head and face are.

    Args:
        step1: MuJoCo's ``mj_step1``.
        step2: Its ``mj_step2``.
        model: Address of the model.
        data: Address of the data, of which the other arrays are views.
        commands: (k, 2) desired pan and tilt, rad.
        joints: (k, m) the caregiver's joints at the end of each step, rad.
        objects: (k, n, 3) the objects then, metres.
        seconds: Length of a step, s.
        controls: (2,) of the head's servos.
        angles: (m,) of the caregiver's joints, rad, yaw and pitch of the face first.
        speeds: (m,) theirs, rad/s.
        positions: (n, 3) of the objects.
        heads: (1, 2) pan and tilt, rad.
        head: (k, 2) takes pan and tilt before each step.
        face: (k, 2) takes yaw and pitch of the face, rad.
        face_speeds: (k, 2) takes their speeds, rad/s.
    """
    for t in range(len(commands)):
        _note(heads, angles, speeds, head[t], face[t], face_speeds[t])
        for axis in range(2):
            controls[axis] = commands[t, axis]
        set_out(joints[t], angles, speeds, objects[t], positions, seconds)
        step2(model, data)
        step1(model, data)


@njit(cache=True)
def run_closed_form(
    servos: Servos, head_speeds: np.ndarray, commands: np.ndarray, joints: np.ndarray, objects: np.ndarray,
    seconds: float, controls: np.ndarray, angles: np.ndarray, speeds: np.ndarray, positions: np.ndarray,
    heads: np.ndarray, head: np.ndarray, face: np.ndarray, face_speeds: np.ndarray,
) -> None:  # fmt: skip
    """The same without the physics.

    Args:
        servos: The head's.
        head_speeds: (1, 2) its speeds, rad/s.
        commands: As for ``run_in_physics``, like the rest.
        joints: See there.
        objects: See there.
        seconds: See there.
        controls: See there.
        angles: See there.
        speeds: See there.
        positions: See there.
        heads: See there.
        head: See there.
        face: See there.
        face_speeds: See there.
    """
    for t in range(len(commands)):
        _note(heads, angles, speeds, head[t], face[t], face_speeds[t])
        set_out(joints[t], angles, speeds, objects[t], positions, seconds)
        for k in range(len(angles)):
            angles[k] = joints[t, k]
        controls[:] = commands[t]
        turn(servos, heads, head_speeds, commands[t : t + 1], 1)


@njit(cache=True)
def _note(
    heads: np.ndarray, angles: np.ndarray, speeds: np.ndarray, head: np.ndarray, face: np.ndarray,
    face_speeds: np.ndarray,
) -> None:  # fmt: skip
    """Note where head (1, 2) and face are, and how fast the face turns."""
    for axis in range(2):
        head[axis], face[axis], face_speeds[axis] = heads[0, axis], angles[axis], speeds[axis]


@njit(cache=True)
def note_moves(
    objects: np.ndarray, before: np.ndarray, speeds: np.ndarray, face_above: float, path_above: float, moved: np.ndarray
) -> None:
    """Note which candidates moved in a frame; ``World.moving`` is this for the present frame.

    Compiled: 2 microseconds instead of 9, in every frame that is perceived from the state.

    Args:
        objects: (n, 3) where the objects are, metres.
        before: (n, 3) where they were a frame before.
        speeds: (2,) or more, of the caregiver's head in yaw and pitch, rad/s.
        face_above: Speed above which the head moves, rad/s.
        path_above: Square of the path in a frame above which an object moves, square metres.
        moved: (n + 1,) bool, takes the result.
    """
    for k in range(len(objects)):
        path = 0.0
        for axis in range(3):
            path += (objects[k, axis] - before[k, axis]) ** 2
        moved[k] = path > path_above
    moved[len(objects)] = sqrt(speeds[0] * speeds[0] + speeds[1] * speeds[1]) > face_above
