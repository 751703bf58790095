"""What the robot perceives in one image: the only thing that passes from eye to mind."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np


@dataclass
class Percept:
    """One look at the scene (boxes "face detection", "object detection" and "optical flow" of Fig. 6.2).

    Pixels have x to the right and y down, from the upper left corner of the image. Candidates for attention are the
    n objects that the robot knows and, last, the face. Arrays hold until the perceiver's next look.
    """

    visible: np.ndarray  # (n + 1,) bool
    px: np.ndarray  # (n + 1, 2) centre of each candidate; NaN where not seen
    moves: np.ndarray  # (n + 1,) bool, |f_i| > epsilon_i of eq. 6.3


class Perceiver(Protocol):
    """Turns observations into percepts."""

    pattern_size: int

    def look(self, observation: Mapping[str, np.ndarray], landed: bool) -> Percept:
        """Perceive this frame; ``landed`` says that the head has just come to rest, so that no motion is known yet."""

    def face_pattern(self) -> np.ndarray:
        """The face pattern f_v of the last look, (pattern_size,); only after a look that saw the face."""
