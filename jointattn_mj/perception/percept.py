"""The border of perception: observations come in, percepts go out. Attention and learning know percepts only."""

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

FaceAt = Literal["found", "remembered"]
"""Where a face pattern is cut out: where the face was found in the image, or where the head is remembered to be."""


class Observation(Protocol):
    """What the robot may know of the world in one camera frame; read-only.

    ``scene.world.WorldObservation`` reads it from a simulated world as it is now, the suite's tasks give it in their
    time steps, and ``StillObservation`` holds it for an image from anywhere else.
    """

    @property
    def image(self) -> np.ndarray:
        """The camera's image: uint8 (h, w, 3) RGB, contiguous. A simulated world renders it when it is first read."""

    @property
    def head_angles(self) -> np.ndarray:
        """Pan (positive to the robot's left) and tilt (positive upwards) of the robot's head: (2,), rad."""

    @property
    def head_moves(self) -> bool:
        """Whether the robot's head turns."""


@dataclass(frozen=True)
class StillObservation:
    """An image and how the head stood when it was taken: a frame of a video, or a posed scene.

    Attributes:
        image: uint8 (h, w, 3) RGB, contiguous.
        head_angles: (2,) pan and tilt of the head, rad.
        head_moves: Whether the head turned.
    """

    image: np.ndarray
    head_angles: np.ndarray
    head_moves: bool = False

    def __repr__(self) -> str:
        shape, (pan, tilt) = self.image.shape, self.head_angles
        return f"StillObservation(image={shape}, pan={pan:.3f} rad, tilt={tilt:.3f} rad, head_moves={self.head_moves})"


@dataclass
class Percept:
    """What the robot perceives in one image (boxes "face detection", "object detection", "optical flow" of Fig. 6.2).

    Candidates for attention are the n objects that the robot knows and, last, the caregiver's face. Pixels have x to
    the right and y down, from the upper left corner of the image. The arrays hold until the perceiver's next percept.

    Attributes:
        visible: (n + 1,) bool, which candidates were detected.
        px: (n + 1, 2) pixels, centre of each candidate; NaN where it was not detected.
        moves: (n + 1,) bool, which candidates move: |f_i| > epsilon_i of eq. 6.3.
    """

    visible: np.ndarray
    px: np.ndarray
    moves: np.ndarray

    def __repr__(self) -> str:
        visible, moves = (np.flatnonzero(flags).tolist() for flags in (self.visible, self.moves))
        return f"Percept({len(self.visible)} candidates, visible={visible}, moves={moves})"


class Perceiver(Protocol):
    """Turns observations into percepts: ``PixelPerception`` from images, ``StatePerception`` from the world's state.

    Attributes:
        pattern_size: How many numbers a face pattern has.
    """

    pattern_size: int

    def perceive(self, observation: Observation, landed: bool) -> Percept:
        """The percept of this frame.

        Args:
            observation: What the robot may know now.
            landed: Whether the head has just come to rest, so that no motion is known yet.
        """

    def face_pattern(self) -> np.ndarray:
        """The face pattern f_v of the last percept, (pattern_size,); only where that percept holds the face."""
