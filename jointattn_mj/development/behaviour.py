"""What a robot at a table does, seen from outside: the six behaviours of Fig. 5.5, and how often each occurs.

After looking at the caregiver it follows her gaze, does not, or keeps looking at her; after looking at a spot of the
table it shifts to the caregiver, stays, or shifts to another spot. Each turn is exactly one of these.
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
"""What Fig. 5.5 calls them."""
WINDOW = 1000
"""Turns that a rate is taken over (section 5.4)."""


def behaviours(face: np.ndarray, gaze: np.ndarray, spots: int) -> np.ndarray:
    """Which of BEHAVIOURS each turn was, (turns,) int8.

    Args:
        face: (turns,) the caregiver's face as sensed before acting: 0 to spots - 1 looking at a spot, ``spots`` looking
            at the robot, ``spots + 1`` not seen, since the robot looks at the table.
        gaze: (turns,) where the robot then looks: 0 to spots - 1, or ``spots``, the caregiver.
        spots: N, places on the table.

    Raises:
        ConfigError: Series of different lengths.
    """
    if len(face) != len(gaze):
        raise ConfigError(f"face and gaze must be equally long; got {len(face)} and {len(gaze)} turns")
    visible, to_her = face <= spots, gaze == spots
    same = np.empty(len(gaze), np.bool_)
    same[:1] = False  # a robot whose first turn it is has looked at no spot before
    same[1:] = gaze[1:] == gaze[:-1]
    found = np.where(visible, NFG, np.where(same, SS, SO)).astype(np.int8)
    found[visible & (face == gaze)] = FG
    found[visible & to_her] = KEC
    found[~visible & to_her] = SC
    return found


class Series(Protocol):
    """An array, or what gives parts of one: (turns,) numbers of BEHAVIOURS."""

    def __len__(self) -> int:
        """Turns."""

    def __getitem__(self, part: slice, /) -> np.ndarray:
        """Some successive turns."""


class BehaviourLog:
    """What each turn of a life was, worked out from its log where it is asked for: ``BehaviourLog(run)[100:200]``."""

    def __init__(self, run: DevelopmentRun):
        self._life = run

    def __len__(self) -> int:
        """Turns that have been lived."""
        return self._life.steps_done

    def __getitem__(self, part: slice, /) -> np.ndarray:
        """(turns,) int8 of some successive turns, what ``behaviours`` says."""
        first, last, _ = part.indices(len(self))
        before = max(first - 1, 0)
        run = self._life
        return behaviours(run.faces(before, last), run.log(GAZE, before, last), run.spots)[first - before :]


def moving_rates(found: Series, n_steps: np.ndarray, window: int = WINDOW) -> np.ndarray:
    """Rate of each behaviour over the last ``window`` turns, (len(turns), 6); over fewer where there were not so many.

    Args:
        found: (turns,) what ``behaviours`` says.
        turns: After how many turns it is asked; each from 1 to all.
        window: Turns.
    """
    rates = np.empty((len(n_steps), len(BEHAVIOURS)))
    for row, step in zip(rates, np.asarray(n_steps).tolist(), strict=True):
        row[:] = _rates(found[max(step - window, 0) : step])
    return rates


def _rates(found: np.ndarray) -> np.ndarray:
    """How often each behaviour occurs in some turns, at least one, (6,)."""
    return np.bincount(found, minlength=len(BEHAVIOURS)) / len(found)


@dataclass(frozen=True)
class BehaviourPhase:
    """Turns between two modules."""

    first: int
    """Turns before it."""
    last: int
    """Turns until its end, where the next module is made."""
    rates: tuple[float, ...]
    """Of each behaviour over its last turns, WINDOW of them or all that it has."""


def phases(found: Series, made: Sequence[int], window: int = WINDOW) -> list[BehaviourPhase]:
    """The phases P1, P2, ... of Fig. 5.5: up to the first module, between two, and after the last.

    Args:
        found: (turns,) what ``behaviours`` says.
        made: Turns that had been lived when each module was made.
        window: Turns.
    """
    bounds = [0, *(step for step in made if step < len(found)), len(found)]
    parts = []
    for first, last in pairwise(bounds):
        if last > first:
            parts.append(BehaviourPhase(first, last, tuple(_rates(found[max(first, last - window) : last]).tolist())))
    return parts
