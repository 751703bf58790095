"""How gaze shifts are commanded and carried out: the gate and the head's movement (Fig. 6.2).

Directions are pairs (pan, tilt) in degrees, as in ``scene.camera``.
"""

import math
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from jointattn_mj.options import Checked, Positive, Real, Whole
from jointattn_mj.scene.movement import minimum_jerk


@dataclass(frozen=True)
class GazeConfig(Checked):
    """How gaze shifts are commanded and carried out."""

    gate: Literal["sigmoid", "shut", "open"] = "sigmoid"
    """Who commands a shift from the face to an object: eq. 6.8, always visual feedback (a baseline), or always the
    learner."""
    gate_midpoint: Annotated[float, Real("[-1e9, 1e9]")] = 150.0
    """p of eq. 6.8, learning iterations."""
    gate_width: Positive = 22.5
    """q of eq. 6.8, learning iterations."""
    shift_frames: Annotated[int, Whole("[1, 10000]")] = 26
    """Frames over which the head's reference moves; with the servo's settling a shift takes 26 to 27 frames ("about
    one second", 6.4.1)."""
    attends: Literal["nearest", "centred"] = "nearest"
    """What is attended after a shift that ended beside everything: the nearest candidate all the same, or nothing."""
    feedback_frames: tuple[Annotated[int, Whole("[0, 10000]")], ...] = (17,)
    """Frames of a shift at which visual feedback looks again and corrects its aim; a carried object moves on in the
    0.8 s of a shift. Colour areas can be seen while the head turns, flow cannot. Empty: one open-loop command."""
    centre_radius_deg: Annotated[float, Real("(0, 180]")] = 3.5
    """An object this near to the centre of view is being gazed at: "around the center of the view" (6.3.1)."""


def gate_probability(config: GazeConfig, iterations: int) -> float:
    """Pr_g(l), eq. 6.8: the chance that the learner's command is taken after so many learning iterations.

    1 / (1 + exp(-x)) is written as (1 + tanh(x / 2)) / 2, which never overflows.
    """
    if config.gate != "sigmoid":
        return float(config.gate == "open")
    return (1 + math.tanh((iterations - config.gate_midpoint) / (2 * config.gate_width))) / 2


class HeadShift:
    """One gaze shift: a minimum-jerk reference for the head's servos, which may be aimed anew on the way."""

    def __init__(self, start: np.ndarray, end: np.ndarray, frames: int):
        self._progress = minimum_jerk(frames)
        self._start, self._end = start, end
        self._offset = 0.0  # progress at which the present aim was taken
        self.frame = 0

    def aim(self, end: np.ndarray) -> None:
        """Let the rest of the movement lead to ``end``, without a jump; only while not all is ``commanded``."""
        self._start = self._reference(self.frame - 1) if self.frame else self._start
        self._offset = float(self._progress[self.frame - 1]) if self.frame else 0.0
        self._end = end

    def next_reference(self) -> np.ndarray:
        """The reference (2,) for the coming frame; stays at the end when the movement is over."""
        reference = self._reference(min(self.frame, len(self._progress) - 1))
        self.frame += 1
        return reference

    @property
    def commanded(self) -> bool:
        """Whether the whole reference has been given out."""
        return self.frame >= len(self._progress)

    def _reference(self, frame: int) -> np.ndarray:
        part = (self._progress[frame] - self._offset) / (1 - self._offset)
        return self._start + part * (self._end - self._start)
