"""The robot's perception and attention (boxes of Fig. 6.2) on a video from a camera that never turns.

A gaze shift moves attention within the image. It takes as long as the robot's head would turn, and no interest changes
meanwhile (Fig. 6.3b). Perception goes on, for the camera is still.
"""

import numpy as np

from jointattn_mj.footage.perceiving import FootagePerception
from jointattn_mj.gaze_following.attention import AttentionConfig, AttentionSelector
from jointattn_mj.gaze_following.fixation import attend
from jointattn_mj.perception.percept import Percept, StillObservation

AHEAD = np.zeros(2)


class Watcher:
    """Attends to one candidate after another; candidates are numbered as in ``Percept``.

    Attributes:
        percept: The last percept; None before the first frame.
        attended: Candidate that is fixated; during a shift, the last one fixated; None at first.
        goal: Candidate to which a shift under way leads, else None.
        face: Number of the candidate that is the face.
        attention: The attention selector.
        perceiver: The robot's perception.
    """

    def __init__(
        self, perceiver: FootagePerception, config: AttentionConfig, objects: int, shift_frames: int,
        rng: np.random.Generator,
    ):  # fmt: skip
        """Make a watcher that has perceived nothing.

        Args:
            perceiver: The robot's perception.
            config: Settings of the attention selector.
            objects: Number of objects, n; the face is candidate n.
            shift_frames: Frames that a shift takes; 0 for at once.
            rng: Draws the targets of attention.
        """
        self.perceiver = perceiver
        self.attention = AttentionSelector(config, objects, rng)
        self.face = objects
        self.attended: int | None = None
        self.goal: int | None = None
        self.percept: Percept | None = None
        self._shift_frames = shift_frames
        self._left = 0

    def see(self, image: np.ndarray, fresh: bool, cut: bool) -> Percept:
        """Perceive one frame, and attend; returns the percept.

        Args:
            image: (240, 320, 3) uint8 RGB, contiguous.
            fresh: Whether it is another image than in the frame before; a repetition is not perceived again.
            cut: Whether motion since the frame before is unknown.
        """
        percept = self.percept
        if percept is None or fresh:
            self.percept = percept = self.perceiver.perceive(StillObservation(image, AHEAD), landed=cut)
        else:
            self.perceiver.pass_over(1)
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
        """Advance one frame of a shift; whether it was the last."""
        self._left -= 1
        if self._left > 0:
            return False
        self.attended, self.goal = goal, None
        self.attention.settle()
        return True
