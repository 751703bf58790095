"""What a learner gets of the camera: a small grey image, or a small patch of the face; grey is a share of white.

Pixels are not normalised each by its own spread. That would make as much of those that hardly change as of those that
tell the gaze, of which PPO then learns much less.
"""

from typing import Any

import cv2
import gymnasium
import numpy as np
from gymnasium import spaces


class SmallImage(gymnasium.ObservationWrapper):
    """Makes the observation ``camera`` grey, from 0 to 1, and ``height`` pixels high."""

    def __init__(self, environment: gymnasium.Env, height: int):
        super().__init__(environment)
        rows, columns, _ = environment.observation_space["camera"].shape
        self._size = round(columns * height / rows), height
        self.observation_space = _with(environment, camera=(1, *self._size[::-1]))

    def observation(self, observation: dict[str, Any]) -> dict[str, Any]:
        """The same with ``camera`` float32 (1, height, width)."""
        grey = cv2.cvtColor(observation["camera"], cv2.COLOR_RGB2GRAY)
        return {**observation, "camera": _shrunk(grey, self._size)[None]}


class SmallPatch(gymnasium.ObservationWrapper):
    """Shrinks the observation ``face_patch`` to ``side`` pixels, from 0 to 1."""

    def __init__(self, environment: gymnasium.Env, side: int):
        super().__init__(environment)
        self._size = side, side
        self.observation_space = _with(environment, face_patch=self._size)

    def observation(self, observation: dict[str, Any]) -> dict[str, Any]:
        """The same with ``face_patch`` float32 (side, side)."""
        return {**observation, "face_patch": _shrunk(observation["face_patch"], self._size)}


def _with(environment: gymnasium.Env, **shapes: tuple[int, ...]) -> spaces.Dict:
    """What is observed, with shares of these shapes in place of what had their names."""
    shares = {name: spaces.Box(0, 1, shape, np.float32) for name, shape in shapes.items()}
    return spaces.Dict({**environment.observation_space.spaces, **shares})


def _shrunk(grey: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    return cv2.resize(grey, size, interpolation=cv2.INTER_AREA) / np.float32(255)
