"""Who watches a video: the robot's perception and attention (boxes of Fig. 6.2), before a camera that never turns.

A fixation is attention to a place of the image, and a gaze shift moves attention alone. It takes as long as the
robot's head would turn, and as then (Fig. 6.3b) no interest changes meanwhile. Perception goes on: the camera is still.
"""

import numpy as np

from jointattn_mj.gaze_following.attention import AttentionConfig, AttentionSelector
from jointattn_mj.gaze_following.fixation import attend
from jointattn_mj.perception.percept import Percept
from jointattn_mj.perception.pixels import PixelPerception

AHEAD = np.zeros(2)


class Watcher:
    """Attends to one candidate after another; candidates are numbered as in ``Percept``.

    Attributes:
        percept: The last percept.
        attended: Candidate that is fixated, or was last while a shift is under way; None at first.
        goal: Candidate that a shift under way leads to, else None.
        attention: The attention selector.
        perceiver: The robot's perception.
    """

    def __init__(
        self, perceiver: PixelPerception, config: AttentionConfig, objects: int, shift_frames: int,
        rng: np.random.Generator,
    ):  # fmt: skip
        """``shift_frames``: how long a shift takes; 0 for at once."""
        self.perceiver = perceiver
        self.attention = AttentionSelector(config, objects, rng)
        self.face = objects
        self.attended: int | None = None
        self.goal: int | None = None
        self.percept: Percept | None = None
        self._shift_frames = shift_frames
        self._left = 0

    def see(self, image: np.ndarray, fresh: bool, cut: bool) -> Percept:
        """One frame of life.

        Args:
            image: (240, 320, 3) uint8 RGB, contiguous.
            fresh: Whether it is another image than in the frame before; a repetition is not looked at again.
            cut: Whether no motion can be seen from the image before to this one.
        """
        percept = self.percept
        if percept is None or fresh:
            self.percept = percept = self.perceiver.look({"camera": image, "head_angles": AHEAD}, landed=cut)
        fixating = self.goal is None
        if self.goal is not None and not self._arrive(self.goal):
            return percept
        chosen = attend(self.attention, self.attended, percept, fixating)
        if chosen is not None:
            self.goal, self._left = chosen, self._shift_frames
            if self._left == 0:
                self._arrive(chosen)
        return percept

    def _arrive(self, goal: int) -> bool:
        """One frame of a shift; whether it was the last."""
        self._left -= 1
        if self._left > 0:
            return False
        self.attended, self.goal = goal, None
        self.attention.settle()
        return True
