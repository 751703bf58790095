"""A mind and its world, turn after turn, and what it writes down; a world derives from ``Life`` and lives in it."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from jointattn_mj.contingency.detector import NOTHING
from jointattn_mj.contingency.events import Event, Variables
from jointattn_mj.contingency.modules import Module
from jointattn_mj.errors import ConfigError
from jointattn_mj.robots.developer import Developer, think


@dataclass(frozen=True)
class Found:
    """An event that was found to be contingent."""

    turn: int
    """Turns that had been lived by then."""
    event: Event
    module: Module | None
    """What was made of it; nothing where there are ``most_modules`` already."""


class Life(ABC):
    """A mind in some world. Everything that happens is kept; it can be stopped, stored and continued after any turn.

    Attributes:
        spots: Places on the table.
        mind: Who lives.
        lived: Turns so far, of ``turns``.
        found: What was found to be contingent, in its order.
        columns: Names in the log.
        witnessed: Those of them that the robot does not know, and what their values are called.
    """

    spots: int

    def __init__(self, mind: Developer, turns: int, sample_every: int, witnessed: Mapping[str, tuple[str, ...]]):
        """``turns`` is how long it can last; ``sample_every`` turns the contingency of all events is noted."""
        if turns < 1 or sample_every < 1:
            raise ConfigError(f"turns and sample_every must be 1 or more; got {turns}, {sample_every}")
        self.mind, self.turns, self.sample_every, self.witnessed = mind, turns, sample_every, dict(witnessed)
        self.lived = 0
        self.found: list[Found] = []
        variables = mind.variables
        sizes = [len(one.values) for one in (*variables.sensors, *variables.actions, *variables.results)]
        most = max(*sizes, mind.config.most_modules + len(mind.reactive))
        if most > np.iinfo(np.int8).max:
            raise ConfigError(f"a variable can have 127 values, and a mind 127 modules, at most; got {most}")
        self._s = np.zeros(len(variables.sensors), np.int64)
        self._r = np.zeros(len(variables.results), np.int64)
        names = [variable.name for variable in (*variables.sensors, *variables.results, *variables.joints)]
        drivers = [f"driver of {joint.name}" for joint in variables.joints]
        self.columns = (*names, *drivers, *witnessed)
        self._log = np.zeros((turns, len(self.columns)), np.int8)
        self._samples: list[np.ndarray] = [self._blank_samples()]

    @abstractmethod
    def _advance(self, last: int, samples: np.ndarray, before: int) -> tuple[int, int]:
        """Live up to turn ``last``, or until something is found; returns how far it came, and which event.

        Every turn writes its row of the log, and with ``think_and_note`` those of ``samples``.
        """

    @abstractmethod
    def faces(self) -> np.ndarray:
        """(lived,) the caregiver's face as it was when the robot acted, in truth: 0 to spots - 1 looking at a spot,
        ``spots`` looking at the robot, ``spots + 1`` not looked at by it."""

    @property
    def spent(self) -> float:
        """How long it has lived: turns; a world with a clock of its own says minutes."""
        return self.lived

    def named_variables(self) -> Variables:
        """The mind's variables under names for people, who may know what the robot does not."""
        return self.mind.variables

    def more(self) -> dict[str, Any]:
        """What else there is to say about this life, for the summary."""
        return {}

    def check(self) -> None:
        """Go on only with finite numbers; asked before every checkpoint and before results are written.

        Raises:
            NotFiniteError: What was learned, or the simulation, is NaN or infinite.
        """
        self.mind.check()

    def live(self, turns: int) -> list[Found]:
        """Live so many turns more, or what is left of them; returns what was found in them."""
        known, last = len(self.found), min(self.turns, self.lived + turns)
        while self.lived < last:
            samples = self._samples[-1]
            before = self.turns // self.sample_every - len(samples)
            self.lived, found = self._advance(self._pause(last), samples, before)
            self.take_in(found)
        return self.found[known:]

    def take_in(self, found: int) -> None:
        """What follows a turn: a module for the event of number ``found``, unless that is NOTHING."""
        module = self.mind.take_in(found)
        if found != NOTHING:
            self.found.append(Found(self.lived, self.mind.events[found], module))
        if module is not None:
            self._samples[-1] = self._samples[-1][: self._sampled()].copy()  # without the rows that it will not fill
            self._samples.append(self._blank_samples())

    def log(self, column: str) -> np.ndarray:
        """(lived,) values of a column, one a turn: positions among a variable's values, modules, spots or options."""
        return self._log[: self.lived, self.columns.index(column)]

    def contingency(self) -> tuple[np.ndarray, np.ndarray]:
        """Turns (n,) after which it was noted, and each event's measure (n, events); NaN before an event existed."""
        values = np.full((self.lived // self.sample_every, len(self.mind.events)), np.nan)
        row = 0
        for samples in self._samples:
            part = samples[: len(values) - row]
            values[row : row + len(part), : part.shape[1]] = part
            row += len(part)
        return (np.arange(len(values)) + 1) * self.sample_every, values

    def _pause(self, last: int) -> int:
        """Up to which turn the mind needs nothing but to think."""
        every = self.mind.config.refresh_every
        return min(last, (self.lived // every + 1) * every) if every else last

    def _blank_samples(self) -> np.ndarray:
        left = self.turns // self.sample_every - self.lived // self.sample_every
        return np.empty((left, len(self.mind.events)))

    def _sampled(self) -> int:
        """How many rows of the last samples are filled."""
        return len(self._samples[-1]) - (self.turns // self.sample_every - self.lived // self.sample_every)

    def __getstate__(self) -> dict[str, Any]:
        """Only the rows that are filled."""
        samples = [*self._samples[:-1], self._samples[-1][: self._sampled()]]
        return {**self.__dict__, "_log": self._log[: self.lived], "_samples": samples}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        log, filled = self._log, self._samples[-1]
        self._log = np.zeros((self.turns, len(self.columns)), np.int8)
        self._log[: self.lived] = log
        left = self.turns // self.sample_every - self.lived // self.sample_every
        self._samples[-1] = np.empty((len(filled) + left, filled.shape[1]))
        self._samples[-1][: len(filled)] = filled


@njit(cache=True, forceinline=True)
def think_and_note(mind, s, r, t, log, samples, before, every):
    """Turn ``t`` of a mind, written down; returns the event that it found, and in which column the log goes on."""
    found = think(mind, s, r)
    joints, place = len(mind.driver), 0
    for values in (s, r):
        for value in values:
            log[t, place] = value
            place += 1
    for joint in range(joints):
        log[t, place + joint] = mind.a[joint]
        log[t, place + joints + joint] = mind.driver[joint]
    if (t + 1) % every == 0:
        for event in range(len(mind.watch.values)):
            samples[(t + 1) // every - 1 - before, event] = mind.watch.values[event]
    return found, place + 2 * joints
