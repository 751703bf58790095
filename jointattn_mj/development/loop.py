"""A run of an agent in a world, step by step, and its log; each world derives its own run from ``DevelopmentRun``."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from jointattn_mj.contingency.online.detector import NOTHING
from jointattn_mj.contingency.online.events import Event, Variables
from jointattn_mj.contingency.online.modules import Module
from jointattn_mj.development.agent import Developer, think
from jointattn_mj.development.contingency_log import ContingencyLog
from jointattn_mj.errors import ConfigError
from jointattn_mj.guards.restored import check_array, check_whole
from jointattn_mj.io.compiled import njit
from jointattn_mj.io.rows import RowStore


@dataclass(frozen=True)
class Found:
    """An event that was found to be contingent."""

    step: int
    """Turns that had been lived by then."""
    event: Event
    module: Module | None
    """What was made of it; nothing where there are ``most_modules`` already."""


class DevelopmentRun(ABC):
    """A mind in some world. Everything that happens is kept; it can be stopped, stored and continued after any turn.

    Attributes:
        spots: Places on the table.
        mind: Who lives.
        lived: Turns so far, of ``n_steps``.
        found: What was found to be contingent, in its order.
        columns: Names in the log.
        noted: The contingency of all events, now and then.
        witnessed: Those of them that the robot does not know, and what their values are called.
    """

    spots: int

    def __init__(self, agent: Developer, n_steps: int, sample_every: int, witnessed: Mapping[str, tuple[str, ...]]):
        """``n_steps`` is how long it can last; ``sample_every`` turns the contingency of all events is noted."""
        if n_steps < 1 or sample_every < 1:
            raise ConfigError(f"turns and sample_every must be 1 or more; got {n_steps}, {sample_every}")
        self.agent, self.n_steps, self.sample_every, self.witnessed = agent, n_steps, sample_every, dict(witnessed)
        self.steps_done = 0
        self.found: list[Found] = []
        variables = agent.variables
        sizes = [len(one.values) for one in (*variables.sensors, *variables.actions, *variables.results)]
        most = max(*sizes, agent.config.most_modules + len(agent.reactive))
        if most > np.iinfo(np.int8).max:
            raise ConfigError(f"a variable can have 127 values, and a mind 127 modules, at most; got {most}")
        self._s = np.zeros(len(variables.sensors), np.int64)
        self._r = np.zeros(len(variables.results), np.int64)
        self.columns = self._columns()
        self._log = RowStore("turns", np.int8, len(self.columns))
        self.noted = ContingencyLog(sample_every, len(agent.events))

    @abstractmethod
    def _advance(self, last: int, log: np.ndarray, samples: np.ndarray) -> tuple[int, int]:
        """Live up to turn ``last``, or until something is found; returns how far it came, and which event.

        Every step writes its row of ``log``, whose first is that of step ``steps_done``, and with ``think_and_note``
        those of ``samples``.
        """

    @abstractmethod
    def faces(self, first: int = 0, last: int | None = None) -> np.ndarray:
        """(last - first,) the caregiver's face as it was when the robot acted, in truth: 0 to spots - 1 looking at a
        spot, ``spots`` looking at the robot, ``spots + 1`` not looked at by it; turns as in ``log``."""

    @property
    def spent(self) -> float:
        """How long it has lived: turns; a world with a clock of its own says minutes."""
        return self.steps_done

    def named_variables(self) -> Variables:
        """The mind's variables under names for people, who may know what the robot does not."""
        return self.agent.variables

    def more(self) -> dict[str, Any]:
        """What else there is to say about this life, for the summary."""
        return {}

    def check(self) -> None:
        """Go on only with finite numbers; asked before every checkpoint and before results are written.

        Raises:
            NotFiniteError: What was learned, or the simulation, is NaN or infinite.
        """
        self.agent.check()

    def close(self) -> None:  # noqa: B027
        """Free what the world holds; the log stays."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a life.

        Raises:
            ValueError: It is none that compiled code can live.
        """
        self.__dict__.update(state)
        variables, most = self.agent.variables, np.iinfo(np.int64).max
        if variables.without_modules() != self._sensed():
            raise ValueError("the mind's variables are others than what is sensed and done in its world")
        for name, least in (("steps_done", 0), ("n_steps", 1), ("sample_every", 1)):
            check_whole(name, getattr(self, name), least, most)
        base = variables.without_modules()
        check_array("s", self._s, (len(base.sensors),), np.int64)
        check_array("r", self._r, (len(base.results),), np.int64)
        if self.columns != self._columns() or self._log.columns != len(self.columns):
            raise ValueError("the log has other columns")
        if (self._log.dtype, self.noted.dtype, self.noted.events) != (np.int8, np.float64, len(self.agent.events)):
            raise ValueError("the log holds other numbers")

    def _columns(self) -> tuple[str, ...]:
        variables = self.agent.variables.without_modules()
        names = [variable.name for variable in (*variables.sensors, *variables.results, *variables.joints)]
        return *names, *(f"driver of {joint.name}" for joint in variables.joints), *self.witnessed

    def _sensed(self) -> Variables:
        """Variables of the world, as the mind had them before it made modules."""
        return self.agent.variables.without_modules()

    def advance(self, n_steps: int) -> list[Found]:
        """Live so many turns more, or what is left of them; returns what was found in them."""
        known, last = len(self.found), min(self.n_steps, self.steps_done + n_steps)
        while self.steps_done < last:
            first, log, samples = self.steps_done, self._log.free(), self.noted.free()
            noted = first // self.sample_every
            room = (noted + len(samples) + 1) * self.sample_every - 1
            self.steps_done, found = self._advance(min(self._pause(last), first + len(log), room), log, samples)
            self._log.fill(self.steps_done - first)
            self.noted.fill(self.steps_done // self.sample_every - noted)
            self.take_in(found)
        return self.found[known:]

    def take_in(self, found: int) -> None:
        """What follows a turn: a module for the event of number ``found``, unless that is NOTHING."""
        module = self.agent.take_in(found)
        if found != NOTHING:
            self.found.append(Found(self.steps_done, self.agent.events[found], module))
        if module is not None:
            self.noted.widen(len(self.agent.events))

    def log(self, column: str, first: int = 0, last: int | None = None) -> np.ndarray:
        """(last - first,) values of a column, one a turn: positions among a variable's values, modules, spots or
        options; of the turns from ``first`` to before ``last``, or all."""
        return self._log.column(self.columns.index(column), first, last)

    def contingency(self) -> tuple[np.ndarray, np.ndarray]:
        """Turns (n,) after which it was noted, and each event's measure (n, events); NaN before an event existed."""
        return self.noted.n_steps(), self.noted.values()

    def attach(self, folder: Path) -> None:
        """Keep what is written down in ``folder`` from now on, and not in memory (see ``RowStore``)."""
        for rows in self._written_down():
            rows.attach(folder)

    def recall(self, folder: Path) -> None:
        """Take what was written down in ``folder`` back into memory (see ``RowStore``)."""
        for rows in self._written_down():
            rows.recall(folder)

    def _written_down(self) -> tuple[RowStore | ContingencyLog, ...]:
        return self._log, self.noted

    def _pause(self, last: int) -> int:
        """Up to which turn the mind needs nothing but to think."""
        every = self.agent.config.refresh_every
        return min(last, (self.steps_done // every + 1) * every) if every else last


@njit(cache=True, forceinline=True)
def think_and_note(agent, s, r, t, first, log, samples, every):
    """Turn ``t`` of a mind, written down; returns the event that it found, and in which column the log goes on.

    The rows of ``log`` and ``samples`` are those from turn ``first`` on.
    """
    found = think(agent, s, r)
    joints, location = len(agent.driver), 0
    row = log[t - first]
    for values in (s, r):
        for value in values:
            row[location] = value
            location += 1
    for joint in range(joints):
        row[location + joint] = agent.a[joint]
        row[location + joints + joint] = agent.driver[joint]
    if (t + 1) % every == 0:
        note = samples[(t + 1) // every - 1 - first // every]
        for event in range(len(agent.watch.values)):
            note[event] = agent.watch.values[event]
    return found, location + 2 * joints
