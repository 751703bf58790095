"""A run of the agent of chapter 5 in some world, step by step, and its log.

Each world derives its run from ``DevelopmentRun``: ``table.run``, ``rendered.run``, ``rendered.growing``,
``realtime.run``.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from jointattn_mj.contingency.online.detector import NOTHING
from jointattn_mj.contingency.online.events import Event, Variables
from jointattn_mj.contingency.online.modules import Module
from jointattn_mj.development.agent import AgentState, Developer, think
from jointattn_mj.development.contingency_log import ContingencyLog
from jointattn_mj.errors import ConfigError
from jointattn_mj.guards.restored import check_array, check_whole
from jointattn_mj.io.compiled import njit
from jointattn_mj.io.held import Held
from jointattn_mj.io.rows import RowStore


@dataclass(frozen=True)
class Detection:
    """An event that the detector found to be contingent."""

    step: int
    """Steps done by then."""
    event: Event
    module: Module | None
    """The module that was made of it; None where there were ``most_modules`` already."""


def streams(seed: int, number: int) -> list[np.random.SeedSequence]:
    """Independent random streams of a run, one a component.

    Raises:
        ConfigError: The seed is negative.
    """
    if seed < 0:
        raise ConfigError(f"seed must be 0 or more; got {seed}")
    return np.random.SeedSequence(seed).spawn(number)


class DevelopmentRun(ABC):
    """An agent in some world, and the log of all steps. A run can be stopped, stored and continued after any step.

    Attributes:
        spots: Number of spots on the table.
        agent: The agent of chapter 5.
        n_steps: Longest possible run.
        steps_done: Steps so far.
        detections: Events that the detector found to be contingent, in order.
        columns: Names of the log's columns.
        contingency_log: Contingency of all events, every ``sample_every`` steps.
        witnessed: Columns that the robot does not know, and the names of their values.
    """

    spots: int

    def __init__(self, agent: Developer, n_steps: int, sample_every: int, witnessed: Mapping[str, tuple[str, ...]]):
        """Make the log.

        Args:
            agent: Agent before its first step.
            n_steps: Longest possible run.
            sample_every: Steps from one note of every event's contingency to the next.
            witnessed: Columns that the robot does not know, and the names of their values.

        Raises:
            ConfigError: A number is below 1, or too large for the log.
        """
        if n_steps < 1 or sample_every < 1:
            raise ConfigError(
                f"n_steps and sample_every must each be at least 1; got n_steps={n_steps}, sample_every={sample_every}"
            )
        self.agent, self.n_steps, self.sample_every, self.witnessed = agent, n_steps, sample_every, dict(witnessed)
        self.steps_done = 0
        self.detections: list[Detection] = []
        variables = agent.variables
        sizes = [len(variable.values) for variable in (*variables.sensors, *variables.actions, *variables.results)]
        most = max(*sizes, agent.config.most_modules + len(agent.reactive))
        if most > np.iinfo(np.int8).max:
            raise ConfigError(f"a variable can have at most 127 values, and an agent 127 modules; got {most}")
        self._s = np.zeros(len(variables.sensors), np.int64)
        self._r = np.zeros(len(variables.results), np.int64)
        self.columns = self._columns()
        self._log = RowStore("log", np.int8, len(self.columns))
        self.contingency_log = ContingencyLog(sample_every, len(agent.events))

    def __repr__(self) -> str:
        done, modules = f"{self.steps_done:,} of {self.n_steps:,} steps", len(self.agent.modules)
        return f"{type(self).__name__}({done}, {len(self.agent.events)} events, {modules} modules)"

    @abstractmethod
    def _advance(self, last: int, log: np.ndarray, samples: np.ndarray) -> tuple[int, int]:
        """Do the steps up to ``last``, or until an event is found.

        Args:
            last: Number of the step before which to stop.
            log: (steps, columns) int8; each step writes its row, the first that of step ``steps_done``.
            samples: (notes, events) contingency, written by ``think_and_note``.

        Returns:
            Steps done by then, and the number of the event that was found, or NOTHING.
        """

    @abstractmethod
    def faces(self, first: int = 0, last: int | None = None) -> np.ndarray:
        """True state of the caregiver's face when the robot acted, for the steps from ``first`` to before ``last``.

        Args:
            first: First step.
            last: Step after the last one; None for all steps.

        Returns:
            (last - first,) 0 to spots - 1: it looks at a spot; ``spots``: at the robot; ``spots + 1``: not visible.
        """

    @property
    def spent(self) -> float:
        """Length of the run so far, in steps; a world with a clock of its own gives minutes."""
        return self.steps_done

    def named_variables(self) -> Variables:
        """The agent's variables under names for people, who may know what the robot does not."""
        return self.agent.variables

    def more(self) -> dict[str, Any]:
        """Further entries of the summary."""
        return {}

    def check(self) -> None:
        """Check that all numbers are finite; called before every checkpoint and before results are written.

        Raises:
            NotFiniteError: What was learned, or the simulation, is NaN or infinite.
        """
        self.agent.check()

    def close(self) -> None:  # noqa: B027
        """Free what the world holds; the log stays."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a run.

        Raises:
            ValueError: Compiled code cannot use it.
        """
        self.__dict__.update(state)
        variables, most = self.agent.variables, np.iinfo(np.int64).max
        if variables.without_modules() != self._sensed():
            raise ValueError("the agent's variables are others than those of its world")
        for name, least in (("steps_done", 0), ("n_steps", 1), ("sample_every", 1)):
            check_whole(name, getattr(self, name), least, most)
        if self.steps_done != self.agent.state.n_steps[0]:
            raise ValueError(f"{self.steps_done} steps are done, and the agent has done {self.agent.state.n_steps[0]}")
        base = variables.without_modules()
        check_array("s", self._s, (len(base.sensors),), np.int64)
        check_array("r", self._r, (len(base.results),), np.int64)
        if self.columns != self._columns() or self._log.columns != len(self.columns):
            raise ValueError("the log has other columns")
        kept = self.contingency_log
        if self._log.dtype != np.int8 or kept.dtype != np.float64 or kept.events != len(self.agent.events):
            raise ValueError("the log holds other numbers")
        if kept.every != self.sample_every:
            raise ValueError(f"contingency is noted every {self.sample_every} steps, and its log says {kept.every}")

    def _columns(self) -> tuple[str, ...]:
        variables = self.agent.variables.without_modules()
        names = [variable.name for variable in (*variables.sensors, *variables.results, *variables.joints)]
        return *names, *(f"driver of {joint.name}" for joint in variables.joints), *self.witnessed

    def _sensed(self) -> Variables:
        """Variables of the world, without those of modules."""
        return self.agent.variables.without_modules()

    def advance(self, n_steps: int) -> list[Detection]:
        """Do ``n_steps`` steps more, or as many as are left; returns the events that were found in them."""
        known, last = len(self.detections), min(self.n_steps, self.steps_done + n_steps)
        while self.steps_done < last:
            first, log, samples = self.steps_done, self._log.free(), self.contingency_log.free()
            logged = first // self.sample_every
            room = (logged + len(samples) + 1) * self.sample_every - 1
            self.steps_done, event = self._advance(min(self._pause(last), first + len(log), room), log, samples)
            self._log.fill(self.steps_done - first)
            self.contingency_log.fill(self.steps_done // self.sample_every - logged)
            self.take_in(event)
        return self.detections[known:]

    def take_in(self, event: int) -> None:
        """Make a module of the event of that number, unless it is NOTHING."""
        event = self.agent.looked(event)
        module = self.agent.take_in(event)
        if event != NOTHING:
            self.detections.append(Detection(self.steps_done, self.agent.events[event], module))
        if module is not None:
            self.contingency_log.widen(len(self.agent.events))

    def log(self, column: str, first: int = 0, last: int | None = None) -> np.ndarray:
        """Values of a column in the steps from ``first`` to before ``last``.

        Args:
            column: One of ``columns``.
            first: First step.
            last: Step after the last one; None for all steps.

        Returns:
            (last - first,) positions among the values of the variable, the modules, the spots or the options.
        """
        return self._log.column(self.columns.index(column), first, last)

    def contingency(self) -> tuple[np.ndarray, np.ndarray]:
        """Steps (n,) after which contingency was noted, and each event's measure (n, events); NaN before it existed."""
        return self.contingency_log.n_steps(), self.contingency_log.values()

    def attach(self, folder: Path) -> None:
        """Keep the log in ``folder`` from now on, and not in memory (see ``RowStore``)."""
        for rows in self._written_down():
            rows.attach(folder)

    def recall(self, folder: Path) -> None:
        """Take the log that is in ``folder`` back into memory (see ``RowStore``)."""
        for rows in self._written_down():
            rows.recall(folder)

    def _written_down(self) -> tuple[RowStore | ContingencyLog, ...]:
        return self._log, self.contingency_log

    def _pause(self, last: int) -> int:
        """Step before which the agent has nothing to do between two steps."""
        pause = self.agent.next_pause
        return min(last, pause) if pause else last


@njit(cache=True, borrows=True, forceinline=True)
def think_and_note(
    agent: AgentState,
    s: np.ndarray,
    r: np.ndarray,
    t: int,
    first: int,
    log: np.ndarray,
    samples: np.ndarray,
    every: int,
) -> tuple[int, int]:
    """A step of the agent, and its row of the log.

    Args:
        agent: State of the agent, changed in place.
        s: (sensors,) values of the world's sensors.
        r: (results,) values of the results.
        t: Number of the step.
        first: Step of the first rows of ``log`` and ``samples``.
        log: (steps, columns) int8.
        samples: (notes, events) contingency.
        every: Steps from one note of the contingency to the next.

    Returns:
        Number of the event that was found, or NOTHING; and the column in which the row goes on.
    """
    event = think(agent, s, r)
    column = note(agent.a, agent.driver, s, r, log[t - first])
    if (t + 1) % every == 0:
        sample(agent.watch.values, samples[(t + 1) // every - 1 - first // every])
    return event, column


@njit(cache=True)
def hold(agent: AgentState) -> Held:
    """The agent's state, to be handed over once for many calls of ``think_held``."""
    return Held(agent)


@njit(cache=True)
def think_held(
    held: Held, s: np.ndarray, r: np.ndarray, t: int, first: int, log: np.ndarray, samples: np.ndarray, every: int
) -> tuple[int, int]:
    """``think_and_note``, for calls from Python in every step.

    Args:
        held: The agent's state, changed in place.
        s: As ``think_and_note``, like all others.
        r: Likewise.
        t: Likewise.
        first: Likewise.
        log: Likewise.
        samples: Likewise.
        every: Likewise.
    """
    return think_and_note(held.value, s, r, t, first, log, samples, every)


@njit(cache=True, borrows=True, forceinline=True)
def note(a: np.ndarray, driver: np.ndarray, s: np.ndarray, r: np.ndarray, row: np.ndarray) -> int:
    """Write a step's row of the log; returns the column in which it goes on.

    Args:
        a: Values of the joints, or more, as in ``AgentState``.
        driver: (joints,) as there.
        s: (sensors,) values of the world's sensors.
        r: (results,) values of the results.
        row: (columns,) is written.
    """
    joints, location = len(driver), 0
    for values in (s, r):
        for value in values:
            row[location] = value
            location += 1
    for joint in range(joints):
        row[location + joint] = a[joint]
        row[location + joints + joint] = driver[joint]
    return location + 2 * joints


@njit(cache=True, borrows=True, forceinline=True)
def sample(contingency: np.ndarray, row: np.ndarray) -> None:
    """Write every event's ``contingency`` (events,) into a row, as long or longer."""
    for number in range(len(contingency)):
        row[number] = contingency[number]
