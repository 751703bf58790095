"""Where and when to look: the attention selector of section 6.3.2 (eq. 6.1 to 6.7, Table 6.1).

The interest measure of a candidate is its saliency times its motion saliency. Saliency habituates while the candidate
is attended; motion saliency grows while it moves. Candidates are the n objects and, last, the face.
"""

from dataclasses import dataclass
from typing import Annotated, Any, Literal, Protocol

import numpy as np

from jointattn_mj.guards.border import require_array
from jointattn_mj.guards.restored import check_array, check_whole
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import TOP_LEVEL, Checked, Positive, Real, Whole

MOST_FRAMES = 1 << 53
"""Frames of a fixation that a checkpoint may speak of."""


@dataclass(frozen=True)
class AttentionConfig(Checked):
    """Settings of the attention selector: Table 6.1, constants of section 6.4.1, and what the text leaves open."""

    motion_cues: Annotated[bool, TOP_LEVEL] = True
    """Use motion saliency; without it, that of every candidate is 1 (the comparison of section 6.4.3)."""
    face_preference: Positive = 1500.0
    """Preference C of the face: its saliency at first (Table 6.1)."""
    object_preference: Positive = 800.0
    """Preference C of each object (Table 6.1)."""
    face_decay: Annotated[float, Real("[0, 100]")] = 2.0e-2
    """Habituation of the attended face, per frame: alpha is exp(-face_decay) (Table 6.1)."""
    object_decay: Annotated[float, Real("[0, 100]")] = 1.0e-2
    """Habituation of an attended object, per frame: alpha is exp(-object_decay) (Table 6.1)."""
    face_growth: Annotated[float, Real("[0, 1]")] = 1.2e-2
    """Recovery of the face, per frame: beta is exp(face_growth) (Table 6.1)."""
    object_growth: Annotated[float, Real("[0, 1]")] = 2.0e-3
    """Recovery of an object, per frame: beta is exp(object_growth) (Table 6.1)."""
    recovery: Literal["min", "max"] = "min"
    """Bound an unattended candidate's saliency in eq. 6.6 by min or max of C and beta S. The text prints max, with
    which interest grows without the bound that Fig. 6.3b draws; with min it recovers to C."""
    motion_gain: Annotated[float, Real("[0, 1e6]")] = 4.5
    """Gain a of the motion saliency (eq. 6.4)."""
    motion_delay: Annotated[float, Real("[0, 1e6]")] = 20.0
    """Degree of motion d at which half of the gain is reached, frames (eq. 6.4)."""
    motion_width: Positive = 1.4
    """Width T of the rise of the motion saliency, frames (eq. 6.4)."""
    selection_period: Annotated[int, Whole("[1, 1e6]")] = 18
    """Draw the next target (eq. 6.7) every N frames of fixation. The text gives no number; 0.6 s gives its number of
    shifts. A draw at every frame gives half as many again, and destroys the effect of cues."""


@njit(cache=True)
def motion_saliency(motion: float, gain: float, delay: float, width: float) -> float:
    """Motion saliency M_i = g(m_i), eq. 6.2 and 6.4.

    Args:
        motion: Degree of motion m_i, frames.
        gain: a of eq. 6.4.
        delay: d of eq. 6.4, frames.
        width: T of eq. 6.4, frames.
    """
    saliency: float = 1 + gain / (1 + np.exp((delay - motion) / width))
    return saliency


@njit(cache=True)
def _advance(
    history: np.ndarray, saliency: np.ndarray, motion: np.ndarray, interest: np.ndarray, attended: int,
    moves: np.ndarray, preference: np.ndarray, decay: np.ndarray, growth: np.ndarray, toward_preference: bool,
    gain: float, delay: float, width: float,
) -> None:  # fmt: skip
    """Advance by as many frames as ``moves`` has, and note what comes of each as far as ``history`` has room."""
    if moves.shape[1] != saliency.size:
        raise ValueError("attention needs to know of each candidate whether it moves")
    for t in range(len(moves)):
        for i in range(saliency.size):
            motion[i] = motion[i] + 1 if moves[t, i] else max(motion[i] - 1, 0)  # eq. 6.3
            if i == attended:  # eq. 6.6
                saliency[i] *= decay[i]
            elif toward_preference:
                saliency[i] = min(preference[i], growth[i] * saliency[i])
            else:
                saliency[i] = max(preference[i], growth[i] * saliency[i])
            interest[i] = saliency[i] * motion_saliency(motion[i], gain, delay, width)  # eq. 6.1
            if t < len(history):
                history[t, 0, i], history[t, 1, i], history[t, 2, i] = saliency[i], motion[i], interest[i]


_NO_HISTORY = np.empty((0, 3, 0))


class Attention(Protocol):
    """Interface of attention models; candidates are the n objects and, last, the face."""

    saliency: np.ndarray
    """(n + 1,), logged, as are motion and interest."""
    motion: np.ndarray
    interest: np.ndarray

    def advance(self, attended: int | None, moves: np.ndarray) -> None:
        """Advance one frame of fixation.

        Args:
            attended: Candidate that is fixated, or None.
            moves: (n + 1,) bool, which candidates move.
        """

    def settle(self) -> None:
        """Begin a fixation: a gaze shift has ended."""

    def consider(self, visible: np.ndarray) -> int | None:
        """After a frame of fixation: the next candidate to look at of the ``visible``, (n + 1,) bool; None to stay."""


class AttentionSelector:
    """Draws the next gaze target by the interest measures of the objects (0 to n-1) and of the face (n).

    ``advance`` is called in every frame of fixation. During a gaze shift it is not, so interest stays (Fig. 6.3b).

    Attributes:
        saliency: S_i, eq. 6.5 and 6.6, (n + 1,).
        motion: m_i, eq. 6.3, frames, (n + 1,).
        interest: I_i, eq. 6.1, (n + 1,).
    """

    def __init__(self, config: AttentionConfig, objects: int, rng: np.random.Generator):
        """Make a selector whose saliencies are the preferences C.

        Args:
            config: Its settings.
            objects: Number of objects, n.
            rng: Draws the targets.
        """
        self.config, self._rng = config, rng
        self.face = objects
        face = np.arange(objects + 1) == objects
        self._preference = np.where(face, config.face_preference, config.object_preference)
        self._decay = np.exp(-np.where(face, config.face_decay, config.object_decay))
        self._growth = np.exp(np.where(face, config.face_growth, config.object_growth))
        self.saliency = self._preference.copy()  # S_i, eq. 6.5
        self.motion = np.zeros(objects + 1)  # m_i
        self.interest = self._preference.copy()  # I_i
        self._dwelt = 0  # frames of this fixation
        self._gain = config.motion_gain if config.motion_cues else 0.0

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a selector. Raises ValueError: Its arrays are not of one length."""
        self.__dict__.update(state)
        for name in ("saliency", "motion", "interest", "_preference", "_decay", "_growth"):
            check_array(name, getattr(self, name), (self.face + 1,), float)
        check_whole("the frames of this fixation", self._dwelt, 0, MOST_FRAMES)

    def advance(self, attended: int | None, moves: np.ndarray) -> None:
        """Advance one frame: habituation, recovery and motion (eq. 6.1, 6.3, 6.6).

        Args:
            attended: Candidate that is fixated, or None.
            moves: (n + 1,) bool, which candidates move.

        Raises:
            ObservationError: ``moves`` is no bool array (n + 1,).
        """
        if not isinstance(moves, np.ndarray) or moves.shape != self.saliency.shape or moves.dtype != bool:
            require_array("moves", moves, self.saliency.shape, "b")
        self._advance(_NO_HISTORY, attended, moves[None])

    def pass_by(self, attended: int | None, moves: np.ndarray) -> np.ndarray:
        """Advance by the frames of fixation that ``moves`` has, (k, n + 1) bool, of which none draws (``undrawn``).

        Returns:
            Saliency, motion and interest after each frame, (k, 3, n + 1).
        """
        history = np.empty((len(moves), 3, self.face + 1))
        self._advance(history, attended, moves)
        self._dwelt += len(moves)
        return history

    @property
    def undrawn(self) -> int:
        """How many frames of fixation pass before that with the next draw."""
        return self.config.selection_period - 1 - self._dwelt % self.config.selection_period

    def _advance(self, history: np.ndarray, attended: int | None, moves: np.ndarray) -> None:
        config = self.config
        _advance(
            history, self.saliency, self.motion, self.interest, -1 if attended is None else attended, moves,
            self._preference, self._decay, self._growth, config.recovery == "min",
            self._gain, config.motion_delay, config.motion_width,
        )  # fmt: skip

    def settle(self) -> None:
        """Begin a fixation: count frames to the next draw from now on."""
        self._dwelt = 0

    def consider(self, visible: np.ndarray) -> int | None:
        """Draw among the ``visible``, (n + 1,) bool, after every ``selection_period`` frames of fixation; else None."""
        self._dwelt += 1
        return self.draw(visible) if self._dwelt % self.config.selection_period == 0 else None

    def draw(self, visible: np.ndarray) -> int | None:
        """Draw a candidate among the ``visible``, (n + 1,) bool, by eq. 6.7; None when none is of any interest."""
        bound = np.cumsum(np.where(visible, self.interest, 0.0))
        if not bound[-1] > 0:
            return None
        return int(np.searchsorted(bound, self._rng.random() * bound[-1], side="right"))
