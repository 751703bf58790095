"""A mind at a table, turn after turn: the compiled loop of chapters 4 and 5, and what it writes down."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from jointattn_mj.contingency.detector import NOTHING
from jointattn_mj.contingency.events import Event
from jointattn_mj.contingency.modules import Module
from jointattn_mj.contingency.reactive import ReactiveModule
from jointattn_mj.errors import ConfigError
from jointattn_mj.robots.developer import Developer, DeveloperConfig, think
from jointattn_mj.symbolic.table import CAREGIVER, OPTION, TableConfig, new_table, table_variables, turn

LOOKS_AT, OPTION_TAKEN = "caregiver looks at", "caregiver's option"
"""Columns of the log that the robot does not know."""


@dataclass(frozen=True)
class Found:
    """An event that was found to be contingent."""

    turn: int
    """Turns that had been lived by then."""
    event: Event
    module: Module | None
    """What was made of it; nothing where there are ``most_modules`` already."""


class Life:
    """A mind and its table. Everything that happens is kept; it can be stopped, stored and continued after any turn."""

    def __init__(
        self,
        world: TableConfig,
        mind: DeveloperConfig,
        seed: int,
        turns: int,
        reactive: Sequence[ReactiveModule] = (),
        sample_every: int = 100,
    ):
        """``turns`` is how long it can last; ``sample_every`` turns the contingency of all events is noted."""
        if seed < 0 or turns < 1 or sample_every < 1:
            raise ConfigError(
                f"seed must be 0 or more, turns and sample_every 1 or more; got {seed}, {turns}, {sample_every}"
            )
        of_world, of_mind = np.random.SeedSequence(seed).spawn(2)
        self.world, self.turns, self.sample_every = world, turns, sample_every
        self.table = new_table(world, of_world)
        self.mind = Developer(table_variables(world), mind, of_mind, reactive)
        self.lived = 0
        self.found: list[Found] = []
        variables = self.mind.variables
        sizes = [len(one.values) for one in (*variables.sensors, *variables.actions, *variables.results)]
        most = max(*sizes, mind.most_modules + len(self.mind.reactive))
        if most > np.iinfo(np.int8).max:
            raise ConfigError(f"a variable can have 127 values, and a mind 127 modules, at most; got {most}")
        self._s = np.zeros(len(variables.sensors), np.int64)
        self._r = np.zeros(len(variables.results), np.int64)
        names = [variable.name for variable in (*variables.sensors, *variables.results, *variables.joints)]
        drivers = [f"driver of {joint.name}" for joint in variables.joints]
        self.columns = (*names, *drivers, LOOKS_AT, OPTION_TAKEN)
        self._log = np.zeros((turns, len(self.columns)), np.int8)
        self._samples: list[np.ndarray] = [self._blank_samples()]

    def live(self, turns: int) -> list[Found]:
        """Live so many turns more, or what is left of them; returns what was found in them."""
        known, last = len(self.found), min(self.turns, self.lived + turns)
        while self.lived < last:
            samples = self._samples[-1]
            self.lived, found = _live(
                self.table, self.mind.mind, self.lived, self._pause(last), self._s, self._r, self._log, samples,
                self.turns // self.sample_every - len(samples), self.sample_every,
            )  # fmt: skip
            module = self.mind.take_in(found)
            if found != NOTHING:
                self.found.append(Found(self.lived, self.mind.events[found], module))
            if module is not None:
                self._samples[-1] = samples[: self._sampled()].copy()  # without the rows that it will not fill
                self._samples.append(self._blank_samples())
        return self.found[known:]

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
        """Up to which turn nothing but the compiled loop is needed."""
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


@njit(cache=True)
def _live(table, mind, first, last, s, r, log, samples, before, every):
    """Turns from ``first`` to ``last``, or until something is found; returns how far it came, and which event."""
    joints = len(mind.driver)
    for t in range(first, last):
        turn(table, mind.a, s, r)
        found = think(mind, s, r)
        place = 0
        for values in (s, r):
            for value in values:
                log[t, place] = value
                place += 1
        for joint in range(joints):
            log[t, place + joint] = mind.a[joint]
            log[t, place + joints + joint] = mind.driver[joint]
        log[t, place + 2 * joints] = table.state[CAREGIVER]
        log[t, place + 2 * joints + 1] = table.state[OPTION]
        if (t + 1) % every == 0:
            for event in range(len(mind.watch.values)):
                samples[(t + 1) // every - 1 - before, event] = mind.watch.values[event]
        if found != NOTHING:
            return t + 1, found
    return last, NOTHING
