"""Behaviour of a robot at a table: the six behaviours of Fig. 5.5, and how often each occurs.

After looking at the caregiver the robot follows the gaze, does not, or keeps looking at the face. After looking at a
spot of the table it shifts to the caregiver, stays, or shifts to another spot. Each step is exactly one of these.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np

from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.meaning import GAZE
from jointattn_mj.errors import ConfigError

FG, NFG, KEC, SC, SS, SO = range(6)
BEHAVIOURS = (
    "following the caregiver's gaze",
    "not following it",
    "keeping eye contact",
    "shifting to the caregiver",
    "staying at the same spot",
    "shifting to another spot",
)
SHORT = ("FG", "NFG", "KEC", "SC", "SS", "SO")
"""Their names in Fig. 5.5."""
WINDOW = 1000
"""Steps over which a rate is taken (section 5.4)."""


def behaviours(face: np.ndarray, gaze: np.ndarray, spots: int) -> np.ndarray:
    """Classify each step as one of BEHAVIOURS.

    Args:
        face: (steps,) the caregiver's face as sensed before acting: 0 to spots - 1 looking at a spot, ``spots`` looking
            at the robot, ``spots + 1`` not visible, since the robot looks at the table.
        gaze: (steps,) where the robot then looks: 0 to spots - 1, or ``spots``, the caregiver.
        spots: N, the number of spots on the table.

    Returns:
        (steps,) int8, positions in BEHAVIOURS.

    Raises:
        ConfigError: Series of different lengths.
    """
    if len(face) != len(gaze):
        raise ConfigError(f"face and gaze must be equally long; got {len(face)} and {len(gaze)} steps")
    visible, to_caregiver = face <= spots, gaze == spots
    same = np.empty(len(gaze), np.bool_)
    same[:1] = False  # before its first step the robot has looked at no spot
    same[1:] = gaze[1:] == gaze[:-1]
    kinds = np.where(visible, NFG, np.where(same, SS, SO)).astype(np.int8)
    kinds[visible & (face == gaze)] = FG
    kinds[visible & to_caregiver] = KEC
    kinds[~visible & to_caregiver] = SC
    return kinds


class Series(Protocol):
    """An array, or what gives parts of one: (steps,) positions in BEHAVIOURS."""

    def __len__(self) -> int:
        """Number of steps."""

    def __getitem__(self, part: slice, /) -> np.ndarray:
        """Some successive steps."""


class BehaviourLog:
    """The behaviour in each step of a run, computed from its log when asked for: ``BehaviourLog(run)[100:200]``."""

    def __init__(self, run: DevelopmentRun):
        self._run = run

    def __len__(self) -> int:
        """Steps done."""
        return self._run.steps_done

    def __getitem__(self, part: slice, /) -> np.ndarray:
        """(steps,) int8 of some successive steps, as ``behaviours`` gives them."""
        first, last, _ = part.indices(len(self))
        before = max(first - 1, 0)
        run = self._run
        return behaviours(run.faces(before, last), run.log(GAZE, before, last), run.spots)[first - before :]


def moving_rates(series: Series, steps: np.ndarray, window: int = WINDOW) -> np.ndarray:
    """Rate of each behaviour over the last ``window`` steps, or over all before where there are fewer.

    Args:
        series: (steps,) as ``behaviours`` gives them.
        steps: (n,) numbers of steps done, each from 1 to all.
        window: Steps.

    Returns:
        (n, 6) rates.
    """
    rates = np.empty((len(steps), len(BEHAVIOURS)))
    for row, step in zip(rates, np.asarray(steps).tolist(), strict=True):
        row[:] = _rates(series[max(step - window, 0) : step])
    return rates


def _rates(series: np.ndarray) -> np.ndarray:
    """Rate of each behaviour in some steps, at least one, (6,)."""
    return np.bincount(series, minlength=len(BEHAVIOURS)) / len(series)


@dataclass(frozen=True)
class BehaviourPhase:
    """The steps between two modules."""

    first: int
    """Steps done before it."""
    last: int
    """Steps done at its end, where the next module is made."""
    rates: tuple[float, ...]
    """Rate of each behaviour over its last WINDOW steps, or over all that it has."""


def phases(series: Series, made: Sequence[int], window: int = WINDOW) -> list[BehaviourPhase]:
    """The phases P1, P2, ... of Fig. 5.5: up to the first module, between two, and after the last.

    Args:
        series: (steps,) as ``behaviours`` gives them.
        made: Steps done when each module was made.
        window: Steps.
    """
    bounds = [0, *(step for step in made if step < len(series)), len(series)]
    parts = []
    for first, last in pairwise(bounds):
        if last > first:
            parts.append(BehaviourPhase(first, last, tuple(_rates(series[max(first, last - window) : last]).tolist())))
    return parts
