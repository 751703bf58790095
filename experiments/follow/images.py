"""What a learner gets of the camera: a small grey image, or a small patch of the face."""

from typing import Any

import cv2
import gymnasium
import numpy as np
from gymnasium import spaces


class SmallImage(gymnasium.ObservationWrapper):
    """Makes the observation ``camera`` grey, and ``height`` pixels high."""

    def __init__(self, environment: gymnasium.Env, height: int):
        super().__init__(environment)
        rows, columns, _ = environment.observation_space["camera"].shape
        self._size = round(columns * height / rows), height
        small = spaces.Box(0, 255, (1, *self._size[::-1]), np.uint8)
        self.observation_space = spaces.Dict({**environment.observation_space.spaces, "camera": small})

    def observation(self, observation: dict[str, Any]) -> dict[str, Any]:
        """The same with ``camera`` uint8 (1, height, width)."""
        grey = cv2.cvtColor(observation["camera"], cv2.COLOR_RGB2GRAY)
        return {**observation, "camera": cv2.resize(grey, self._size, interpolation=cv2.INTER_AREA)[None]}


class SmallPatch(gymnasium.ObservationWrapper):
    """Shrinks the observation ``face_patch`` to ``side`` pixels."""

    def __init__(self, environment: gymnasium.Env, side: int):
        super().__init__(environment)
        self._size = side, side
        small = spaces.Box(0, 255, self._size, np.uint8)
        self.observation_space = spaces.Dict({**environment.observation_space.spaces, "face_patch": small})

    def observation(self, observation: dict[str, Any]) -> dict[str, Any]:
        """The same with ``face_patch`` uint8 (side, side)."""
        small = cv2.resize(observation["face_patch"], self._size, interpolation=cv2.INTER_AREA)
        return {**observation, "face_patch": small}
