"""Bodies, cameras and lights where the joints are, without the rest of MuJoCo's step."""

import mujoco


def place(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Put all that images show where ``data.qpos`` and the objects' positions have it."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)
