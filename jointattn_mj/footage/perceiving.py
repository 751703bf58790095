"""The robot's perception on footage: faces, objects and motion as found by what is made for real people and cameras."""

import numpy as np

from jointattn_mj.footage.areas import FootageAreas
from jointattn_mj.footage.followed import FollowedFace
from jointattn_mj.footage.rest import Rest
from jointattn_mj.perception.percept import Observation, Percept
from jointattn_mj.perception.pixels import PixelConfig, PixelPerception


class FootagePerception(PixelPerception):
    """Percepts of a video.

    Attributes:
        areas: The object detector.
        rest: Motion at rest.
    """

    def __init__(
        self, config: PixelConfig, areas: FootageAreas, rest: Rest, followed: FollowedFace | None, memory_rate: float
    ):
        """Put it together.

        Args:
            config: Options of the robot's perception.
            areas: The object detector.
            rest: Motion at rest.
            followed: Takes the place of the robot's face detector; None leaves that.
            memory_rate: Share of each new image in the remembered location of the face, 0 to 1.
        """
        super().__init__(config, np.zeros((0, 3)), memory_rate, areas)
        self.areas, self.rest = areas, rest
        self._passed = 0  # frames without a new image since the last percept
        if followed is not None:
            self.faces = followed

    def perceive(self, observation: Observation, landed: bool) -> Percept:
        """As ``PixelPerception.perceive``; what moves is what moves more than at rest."""
        percept = super().perceive(observation, landed)
        motion = self.motion
        if motion is not None:
            measured = percept.visible & (not landed)
            percept.moves[:] = self.rest.moves(motion.strength, percept.moves, measured, 1 + self._passed)
        self._passed = 0
        return percept

    def pass_over(self, frames: int) -> None:
        """Say that so many frames have gone by without a new image, before the next one is perceived."""
        self.areas.pass_over(frames)
        self._motion.pass_over(frames)
        self._passed += frames
