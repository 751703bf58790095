"""Where and when to look: the attention selector of section 6.3.2 (eq. 6.1 to 6.7, Table 6.1).

Each candidate has an interest measure, the product of a saliency that habituates while it is attended and of a motion
saliency that grows while it moves. Candidates are the n objects and, last, the face.
"""

from dataclasses import dataclass
from typing import Annotated, Any, Literal, Protocol

import numpy as np

from jointattn_mj.guards.border import require_array
from jointattn_mj.guards.restored import check_array
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import TOP_LEVEL, Checked, Positive, Real, Whole


@dataclass(frozen=True)
class AttentionConfig(Checked):
    """Table 6.1, the constants of section 6.4.1, and what the text leaves open."""

    motion_cues: Annotated[bool, TOP_LEVEL] = True
    """Without them the motion saliency is 1 for every candidate (the comparison of section 6.4.3)."""
    face_preference: Positive = 1500.0
    """C of the face, Table 6.1."""
    object_preference: Positive = 800.0
    """C of each object, Table 6.1."""
    face_decay: Annotated[float, Real("[0, 100]")] = 2.0e-2
    """alpha of the face is exp(-this) per frame, Table 6.1."""
    object_decay: Annotated[float, Real("[0, 100]")] = 1.0e-2
    """alpha of an object is exp(-this) per frame, Table 6.1."""
    face_growth: Annotated[float, Real("[0, 1]")] = 1.2e-2
    """beta of the face is exp(this) per frame, Table 6.1."""
    object_growth: Annotated[float, Real("[0, 1]")] = 2.0e-3
    """beta of an object is exp(this) per frame, Table 6.1."""
    recovery: Literal["min", "max"] = "min"
    """How an unattended candidate's saliency is bounded by C in eq. 6.6. The text prints max, under which nothing
    recovers towards C and interest grows without the bound that Fig. 6.3b draws; min says "recovers"."""
    motion_gain: Annotated[float, Real("[0, 1e6]")] = 4.5
    """a of eq. 6.4."""
    motion_delay: Annotated[float, Real("[0, 1e6]")] = 20.0
    """d of eq. 6.4, frames."""
    motion_width: Positive = 1.4
    """T of eq. 6.4, frames."""
    selection_period: Annotated[int, Whole("[1, 1e6]")] = 18
    """Frames of dwell from one draw by eq. 6.7 to the next. The text gives none; 0.6 s with shifts of about a second
    gives its number of shifts, a draw at every frame gives half as many again and destroys the effect of cues."""


@njit(cache=True)
def motion_saliency(motion: float, gain: float, delay: float, width: float) -> float:
    """M_i = g(m_i), eq. 6.2 and 6.4, from the degree of motion m_i in frames."""
    return 1 + gain / (1 + np.exp((delay - motion) / width))


@njit(cache=True)
def _advance(
    saliency, motion, interest, attended, moves, preference, decay, growth, toward_preference, gain, delay, width
):
    if moves.size != saliency.size:
        raise ValueError("attention needs to know of each candidate whether it moves")
    for i in range(saliency.size):
        motion[i] = motion[i] + 1 if moves[i] else max(motion[i] - 1, 0)  # eq. 6.3
        if i == attended:  # eq. 6.6
            saliency[i] *= decay[i]
        elif toward_preference:
            saliency[i] = min(preference[i], growth[i] * saliency[i])
        else:
            saliency[i] = max(preference[i], growth[i] * saliency[i])
        interest[i] = saliency[i] * motion_saliency(motion[i], gain, delay, width)  # eq. 6.1


class Attention(Protocol):
    """What any attention model must offer; candidates are the n objects and, last, the face."""

    saliency: np.ndarray
    """(n + 1,) for the log, as are the next two."""
    motion: np.ndarray
    interest: np.ndarray

    def advance(self, attended: int | None, moves: np.ndarray) -> None:
        """One frame of fixation: ``attended`` is fixated, and of the candidates some move, (n + 1,) bool."""

    def settle(self) -> None:
        """A gaze shift has ended."""

    def consider(self, visible: np.ndarray) -> int | None:
        """After each frame: which candidate to look at next among those ``visible``, (n + 1,) bool; None to stay."""


class AttentionSelector:
    """Interest measures of the objects (0 to n-1) and of the face (n), one ``advance`` per frame of fixation.

    Nothing changes while the robot turns its head, for then no frame is advanced (Fig. 6.3b).

    Attributes:
        saliency: S_i, eq. 6.5 and 6.6, (n + 1,).
        motion: m_i, eq. 6.3, frames, (n + 1,).
        interest: I_i, eq. 6.1, (n + 1,).
    """

    def __init__(self, config: AttentionConfig, objects: int, rng: np.random.Generator):
        self.config, self._rng = config, rng
        self.face = objects
        face = np.arange(objects + 1) == objects
        self._preference = np.where(face, config.face_preference, config.object_preference)
        self._decay = np.exp(-np.where(face, config.face_decay, config.object_decay))
        self._growth = np.exp(np.where(face, config.face_growth, config.object_growth))
        self.saliency = self._preference.copy()  # S_i, eq. 6.5
        self.motion = np.zeros(objects + 1)  # m_i
        self.interest = self._preference.copy()  # I_i
        self._dwelt = 0  # frames since the last shift
        self._gain = config.motion_gain if config.motion_cues else 0.0

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a selector. Raises ValueError: Its arrays are not of one length."""
        self.__dict__.update(state)
        for name in ("saliency", "motion", "interest", "_preference", "_decay", "_growth"):
            check_array(name, getattr(self, name), (self.face + 1,), float)

    def advance(self, attended: int | None, moves: np.ndarray) -> None:
        """One frame: habituate to ``attended``, recover for the rest, count motion (eq. 6.1, 6.3, 6.6).

        Raises:
            ObservationError: ``moves`` is no bool array (n + 1,).
        """
        config = self.config
        if not isinstance(moves, np.ndarray) or moves.shape != self.saliency.shape or moves.dtype != bool:
            require_array("moves", moves, self.saliency.shape, "b")
        _advance(
            self.saliency, self.motion, self.interest, -1 if attended is None else attended, moves,
            self._preference, self._decay, self._growth, config.recovery == "min",
            self._gain, config.motion_delay, config.motion_width,
        )  # fmt: skip

    def settle(self) -> None:
        """A shift has ended: the time to the next draw begins."""
        self._dwelt = 0

    def consider(self, visible: np.ndarray) -> int | None:
        """One more frame of dwell; every ``selection_period`` of them a draw among the ``visible``, else None."""
        self._dwelt += 1
        return self.draw(visible) if self._dwelt % self.config.selection_period == 0 else None

    def draw(self, visible: np.ndarray) -> int | None:
        """The next candidate to look at, drawn by eq. 6.7 among those in view; None when none is of any interest."""
        bound = np.cumsum(np.where(visible, self.interest, 0.0))
        if not bound[-1] > 0:
            return None
        return int(np.searchsorted(bound, self._rng.random() * bound[-1], side="right"))
