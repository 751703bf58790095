"""The digital head's body: the robot's own servos of pan and tilt, simulated without a scene."""

from typing import Any

import mujoco
import numpy as np

from jointattn_mj.guards.restored import check_array
from jointattn_mj.scene.model import build_robot
from jointattn_mj.scene.world import HEAD_STILL_DEG_S

_STILL = np.radians(HEAD_STILL_DEG_S)


class DigitalHead:
    """Pan and tilt of the robot's head; they follow a command as in the rendered world. It can be pickled."""

    def __init__(self) -> None:
        self._model = build_robot()
        self._data = mujoco.MjData(self._model)

    @property
    def angles(self) -> np.ndarray:
        """Pan and tilt, (2,), rad; a new array."""
        angles: np.ndarray = self._data.qpos.copy()
        return angles

    @property
    def moves(self) -> bool:
        """Whether the head turns."""
        return bool(np.abs(self._data.qvel).max() > _STILL)

    def step(self, command: np.ndarray) -> None:
        """Follow ``command`` (2,), rad, for a thirtieth of a second."""
        self._data.ctrl[:] = command
        mujoco.mj_step(self._model, self._data)

    def __getstate__(self) -> dict[str, Any]:
        """Angles and speeds; the model is compiled again."""
        return {"qpos": self._data.qpos.copy(), "qvel": self._data.qvel.copy()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a head. Raises ValueError: Its angles or speeds are none."""
        for name in ("qpos", "qvel"):
            check_array(f"the head's {name}", state[name], (2,), float, -mujoco.mjMAXVAL, mujoco.mjMAXVAL)
        self.__init__()  # type: ignore[misc]
        self._data.qpos[:], self._data.qvel[:] = state["qpos"], state["qvel"]
