"""The servos of the robot's head in closed form: what MuJoCo's implicit integrator makes of them.

The head turns about its centre of mass, has the same inertia about every axis, and touches nothing. So each of its two
joints follows a difference equation of its own, to rounding.
"""

from typing import NamedTuple

import mujoco
import numpy as np

from jointattn_mj.io.compiled import njit

HEAD_JOINTS = ("robot/pan", "robot/tilt")


class Servos(NamedTuple):
    """The servos of pan and tilt.

    Attributes:
        stiffness: (2,) torque for each rad that the command is ahead, N m/rad.
        damping: (2,) torque against each rad/s, N m s/rad.
        inertia: (2,) kg m^2.
        seconds: Length of a step of the physics, s.
    """

    stiffness: np.ndarray
    damping: np.ndarray
    inertia: np.ndarray
    seconds: float

    @classmethod
    def of_model(cls, model: mujoco.MjModel) -> "Servos":
        """Those of a compiled scene."""
        joints = [model.joint(name) for name in HEAD_JOINTS]
        motors = [int(np.flatnonzero(model.actuator_trnid[:, 0] == joint.id)[0]) for joint in joints]
        return cls(
            stiffness=model.actuator_gainprm[motors, 0],
            damping=-model.actuator_biasprm[motors, 2],
            inertia=np.array([model.dof_M0[joint.dofadr[0]] for joint in joints]),
            seconds=float(model.opt.timestep),
        )


@njit(cache=True)
def turn(servos: Servos, angles: np.ndarray, speeds: np.ndarray, commands: np.ndarray, steps: int) -> None:
    """Turn heads, in place.

    Args:
        servos: Of each of them.
        angles: (n, 2) pan and tilt, rad.
        speeds: (n, 2), rad/s.
        commands: (n, 2) desired angles, rad.
        steps: Steps of the physics that this takes.
    """
    for _ in range(steps):
        for head in range(len(angles)):
            for axis in range(2):
                ahead, damping = commands[head, axis] - angles[head, axis], servos.damping[axis]
                torque = servos.stiffness[axis] * ahead - damping * speeds[head, axis]
                speeds[head, axis] += servos.seconds * torque / (servos.inertia[axis] + servos.seconds * damping)
                angles[head, axis] += servos.seconds * speeds[head, axis]


@njit(cache=True)
def steps_to_rest(
    servos: Servos, angles: np.ndarray, speeds: np.ndarray, commands: np.ndarray, least: int, still: float
) -> int:
    """How many of the steps that follow ``commands`` a head takes, ``least`` at least, before it stands still.

    Args:
        servos: The head's.
        angles: (1, 2) pan and tilt, rad.
        speeds: (1, 2), rad/s.
        commands: (k, 2) desired angles, rad.
        least: 0 to k.
        still: Speed of either joint up to which a head stands still, rad/s.

    Returns:
        k where it does not.
    """
    angles, speeds = angles.copy(), speeds.copy()
    for step in range(len(commands)):
        if step >= least and max(abs(speeds[0, 0]), abs(speeds[0, 1])) <= still:
            return step
        turn(servos, angles, speeds, commands[step : step + 1], 1)
    return len(commands)
