"""What a robot at a table does, seen from outside: the six behaviours of Fig. 5.5, and how often each occurs.

After looking at the caregiver it follows her gaze, does not, or keeps looking at her; after looking at a spot of the
table it shifts to the caregiver, stays, or shifts to another spot. Each turn is exactly one of these.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

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
    seen, to_her = face <= spots, gaze == spots
    same = np.empty(len(gaze), np.bool_)
    same[:1] = False  # a robot whose first turn it is has looked at no spot before
    same[1:] = gaze[1:] == gaze[:-1]
    found = np.where(seen, NFG, np.where(same, SS, SO)).astype(np.int8)
    found[seen & (face == gaze)] = FG
    found[seen & to_her] = KEC
    found[~seen & to_her] = SC
    return found


def moving_rates(found: np.ndarray, turns: np.ndarray, window: int = WINDOW) -> np.ndarray:
    """Rate of each behaviour over the last ``window`` turns, (len(turns), 6); over fewer where there were not so many.

    Args:
        found: (turns,) what ``behaviours`` says.
        turns: After how many turns it is asked; each from 1 to all.
        window: Turns.
    """
    turns = np.asarray(turns, np.int64)
    first = np.maximum(turns - window, 0)
    rates = np.empty((len(turns), len(BEHAVIOURS)))
    for number in range(len(BEHAVIOURS)):
        upto = np.concatenate([np.zeros(1, np.int32), np.cumsum(found == number, dtype=np.int32)])
        rates[:, number] = (upto[turns] - upto[first]) / (turns - first)
    return rates


@dataclass(frozen=True)
class Phase:
    """Turns between two modules."""

    first: int
    """Turns before it."""
    last: int
    """Turns until its end, where the next module is made."""
    rates: tuple[float, ...]
    """Of each behaviour over its last turns, WINDOW of them or all that it has."""


def phases(found: np.ndarray, made: Sequence[int], window: int = WINDOW) -> list[Phase]:
    """The phases P1, P2, ... of Fig. 5.5: up to the first module, between two, and after the last.

    Args:
        found: (turns,) what ``behaviours`` says.
        made: Turns that had been lived when each module was made.
        window: Turns.
    """
    bounds = [0, *(turn for turn in made if turn < len(found)), len(found)]
    parts = []
    for first, last in pairwise(bounds):
        if last > first:
            counts = np.bincount(found[max(first, last - window) : last], minlength=len(BEHAVIOURS))
            parts.append(Phase(first, last, tuple((counts / counts.sum()).tolist())))
    return parts
