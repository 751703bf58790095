"""The gate, which decides who commands a gaze shift, and the head's movement (Fig. 6.2).

Directions are pairs (pan, tilt) in degrees, as in ``scene.camera``.
"""

import math
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np

from jointattn_mj.guards.restored import check_array, check_whole
from jointattn_mj.options import Checked, Positive, Real, Whole
from jointattn_mj.scene.movement import minimum_jerk


@dataclass(frozen=True)
class GazeConfig(Checked):
    """Settings of the gate and of gaze shifts."""

    gate: Literal["sigmoid", "shut", "open", "certainty"] = "sigmoid"
    """Let a shift from the face to an object be commanded by the draw of eq. 6.8 (sigmoid), by visual feedback alone
    (shut, a baseline), by the learner alone (open), or by the learner with the probability that it gives to the best
    object in view (certainty): it then decides as soon as it knows, however many pairs that took."""
    gate_sharpness: Annotated[float, Real("(0, 100]")] = 3.0
    """With gate certainty: the probability of an object is its share of exp(sharpness * evidence)."""
    commands: Literal["direction", "object"] = "direction"
    """Let the learner command the turn of the head that it has learned for the face, as the text does, or a turn to
    that object in view which goes best with the face. Seen from the robot objects lie a few degrees apart, so a bare
    direction often ends beside the right one."""
    wait_for_still_face: bool = False
    """Leave the face only in a frame in which it is not seen to move. A head that turns does not yet show where its
    gaze will rest; a fifth to a quarter of all misses came from that."""
    read_again: bool = False
    """In shifts that the learner commands, perceive the face again at the feedback frames, and aim by it anew: the
    caregiver's gaze may have moved on meanwhile."""
    gate_midpoint: Annotated[float, Real("[-1e9, 1e9]")] = 150.0
    """Learning iterations p after which visual feedback and learner command equally often (eq. 6.8)."""
    gate_width: Positive = 22.5
    """Width q of the transition between them, learning iterations (eq. 6.8)."""
    shift_frames: Annotated[int, Whole("[1, 10000]")] = 26
    """Move the head's reference over N frames; with the settling of the servos a shift takes 26 to 27 ("about one
    second", 6.4.1)."""
    attends: Literal["nearest", "centred"] = "nearest"
    """After a shift that ended beside everything, attend to the nearest candidate all the same, or to none."""
    feedback_frames: tuple[Annotated[int, Whole("[0, 10000]")], ...] = (17,)
    """Frames of a shift at which visual feedback perceives again and corrects its aim, for a carried object moves on in
    the 0.8 s of a shift. Colour areas are visible while the head turns, flow is not. Empty: one open-loop command."""
    centre_radius_deg: Annotated[float, Real("(0, 180]")] = 3.5
    """Angle from the centre of view within which a candidate is gazed at, deg ("around the center of
    the view", 6.3.1)."""


def softmax(values: np.ndarray) -> np.ndarray:
    """exp(values) (n,) over their sum; (0,) for none."""
    powers: np.ndarray = np.exp(values - values.max(initial=-np.inf))
    return powers / powers.sum() if len(powers) else powers


def gate_probability(config: GazeConfig, iterations: int, scores: np.ndarray | None = None) -> float:
    """Probability Pr_g(l) that the learner commands a shift (eq. 6.8).

    1 / (1 + exp(-x)) is written as (1 + tanh(x / 2)) / 2, which never overflows.

    Args:
        config: Kind of the gate, and its constants.
        iterations: Learning iterations so far, l.
        scores: The learner's evidence (n,) for the objects in view; read by the gate certainty alone.

    Returns:
        From 0 to 1; 0 with the gate certainty where no object is in view.
    """
    if config.gate == "certainty":
        return float(softmax(config.gate_sharpness * scores).max()) if scores is not None and len(scores) else 0.0
    if config.gate != "sigmoid":
        return float(config.gate == "open")
    return (1 + math.tanh((iterations - config.gate_midpoint) / (2 * config.gate_width))) / 2


_MOST_DEG = 1e6
"""No command of a learner is as large, deg; a larger one was put into a checkpoint by hand."""


class HeadShift:
    """Minimum-jerk reference of one gaze shift for the head's servos; its aim may change on the way.

    Attributes:
        frame: References that were given out; the end, which is held until the head stands still, counts once.
    """

    def __init__(self, start: np.ndarray, end: np.ndarray, frames: int):
        """Plan a shift.

        Args:
            start: Direction (2,) at which the reference begins.
            end: Direction (2,) at which it ends.
            frames: Its length.
        """
        self._progress = minimum_jerk(frames)
        self._start, self._end = start, end
        self._offset = 0.0  # progress at which the present aim was taken
        self.frame = 0

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take over what a checkpoint holds.

        Raises:
            ValueError: It is no movement of a head.
        """
        vars(self).update(state)
        progress = np.asarray(self._progress)
        check_array("the progress of a gaze shift", self._progress, (progress.size,), float, 0, 1)
        for name, direction in (("start", self._start), ("end", self._end)):
            check_array(f"the {name} of a gaze shift", direction, (2,), float, -_MOST_DEG, _MOST_DEG)
        if not 0 <= self._offset < 1:
            raise ValueError(f"the share of a gaze shift that is over must be in [0, 1); got {self._offset!r:.80}")
        check_whole("the frame of a gaze shift", self.frame, 0, progress.size)

    def aim(self, end: np.ndarray) -> None:
        """Let the rest of the movement lead to ``end`` (2,) without a jump; only before all is ``commanded``."""
        self._start = self._reference(self.frame - 1) if self.frame else self._start
        self._offset = float(self._progress[self.frame - 1]) if self.frame else 0.0
        self._end = end

    def next_reference(self) -> np.ndarray:
        """The reference (2,) for the coming frame; the end when the movement is over."""
        reference = self._reference(min(self.frame, self.frames - 1))
        self.pass_by(1)
        return reference

    def coming(self, frames: int) -> np.ndarray:
        """References (frames, 2) for the next frames, whose aim stays."""
        coming = self._progress[self.frame : self.frame + frames]
        if len(coming) < frames:  # the end is held
            coming = np.append(coming, np.full(frames - len(coming), self._progress[-1]))
        parts = (coming[:, None] - self._offset) / (1 - self._offset)
        references: np.ndarray = self._start + parts * (self._end - self._start)
        return references

    def pass_by(self, frames: int) -> None:
        """Count the references for so many frames as given out."""
        self.frame = min(self.frame + frames, self.frames)

    @property
    def frames(self) -> int:
        """Length of the movement."""
        return len(self._progress)

    @property
    def commanded(self) -> bool:
        """Whether the whole reference has been given out."""
        return self.frame >= self.frames

    def frames_before(self, stops: tuple[int, ...]) -> int:
        """How many references are still to be given out before the next one of ``stops``, or before all are."""
        return min(stop for stop in (*stops, self.frames) if stop >= self.frame) - self.frame

    def _reference(self, frame: int) -> np.ndarray:
        part = (float(self._progress[frame]) - self._offset) / (1 - self._offset)
        (from_pan, from_tilt), (to_pan, to_tilt) = self._start.tolist(), self._end.tolist()
        return np.array([from_pan + part * (to_pan - from_pan), from_tilt + part * (to_tilt - from_tilt)])
