"""The world as it was some frames ago, for cameras with a delay. Poses are kept, not images."""

from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np

from jointattn_mj.scene.placing import place

State = tuple[np.ndarray, np.ndarray]
"""Joint angles (nq,), and positions of objects (n, 3), metres."""


class Past:
    """The states at the ends of the last steps.

    Attributes:
        steps: How many steps ago is to be shown, fractions included. Within a step angles change at constant speed, and
            objects are where they are at its end.
    """

    def __init__(self, steps: float):
        self.steps = steps
        self._states: deque[State] = deque(maxlen=max(1, int(np.ceil(steps))))

    def note(self, data: mujoco.MjData) -> None:
        """Keep the present state; to be called before each step."""
        if self.steps > 0:
            self._states.append((data.qpos.copy(), data.mocap_pos.copy()))

    def forget(self) -> None:
        """Drop all states, as at the start of an episode."""
        self._states.clear()

    def state(self, data: mujoco.MjData) -> State:
        """The state ``steps`` ago, or the first one if that is later."""
        states = [*self._states, (data.qpos.copy(), data.mocap_pos.copy())]
        back = min(self.steps, len(states) - 1)
        whole, part = int(back), back - int(back)
        angles, positions = states[-1 - whole]
        if part > 0:
            angles = (1 - part) * angles + part * states[-2 - whole][0]
        return angles, positions

    @contextmanager
    def shown(self, model: mujoco.MjModel, data: mujoco.MjData) -> Iterator[None]:
        """Within the block, bodies, cameras and lights of ``data`` are where they were ``steps`` ago."""
        now = data.qpos.copy(), data.mocap_pos.copy()
        _pose(model, data, self.state(data))
        try:
            yield
        finally:
            _pose(model, data, now)


def _pose(model: mujoco.MjModel, data: mujoco.MjData, state: State) -> None:
    data.qpos[:], data.mocap_pos[:] = state
    place(model, data)
