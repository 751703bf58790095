"""What an agent sensed, did and found in every step, kept as it was, so that all of it can be counted anew.

Counts of transitions that are taken as they come (``counts``) cannot follow when the meaning of a variable changes. A
module's variable S_Pi says whether the module was used; with hindsight it is read anew whenever a map changes.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from jointattn_mj.contingency.online.events import Event, Variables
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING, Module
from jointattn_mj.io.compiled import njit


class Experience(NamedTuple):
    """The first ``n_steps`` rows of three tables; those after them are free."""

    s: np.ndarray
    """(rows, sensors) int8 values in each step, those of modules included."""
    a: np.ndarray
    """(rows, actions) int8 commands of the joints, then whether each module was used."""
    r: np.ndarray
    """(rows, results) int8 values."""


def empty_experience(rows: int, sensors: int, actions: int, results: int) -> Experience:
    """Room for so many steps.

    Args:
        rows: Number of steps.
        sensors: Number of sensors.
        actions: Number of actions.
        results: Number of results.
    """
    return Experience(*(np.zeros((rows, width), np.int8) for width in (sensors, actions, results)))


def roomier(experience: Experience, rows: int, sensors: int, actions: int) -> Experience:
    """The same steps with room for more of them, and for the variables of more modules, 0 so far.

    Where there is too little room for steps there will be twice as much as asked for, so that steps are seldom copied.

    Args:
        experience: What is kept.
        rows: Number of steps that there must be room for.
        sensors: Number of sensors.
        actions: Number of actions.
    """
    before = len(experience.s)
    if rows <= before and (experience.s.shape[1], experience.a.shape[1]) == (sensors, actions):
        return experience
    room = before if rows <= before else 2 * rows
    more = empty_experience(room, sensors, actions, experience.r.shape[1])
    for old, new in zip(experience, more, strict=True):
        new[: len(old), : old.shape[1]] = old
    return more


@njit(cache=True, forceinline=True)
def keep(experience: Experience, row: int, s: np.ndarray, a: np.ndarray, r: np.ndarray) -> None:
    """Write a step into its row.

    Args:
        experience: Changed in place.
        row: Number of the step.
        s: (sensors,) values.
        a: (actions,) values.
        r: (results,) values.
    """
    for i in range(len(s)):
        experience.s[row, i] = s[i]
    for i in range(len(a)):
        experience.a[row, i] = a[i]
    for i in range(len(r)):
        experience.r[row, i] = r[i]


class EventSeries(NamedTuple):
    """The columns of one event, for compiled code."""

    columns: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
    """(n,) each: sensor, action, what the result is conditioned on, result."""
    sizes: np.ndarray
    """(4,) number of values of: what the result is conditioned on, sensor, action, result."""


class PastSteps:
    """All steps of an agent, as its events count them.

    Attributes:
        n_steps: Number of steps.
    """

    def __init__(self, experience: Experience, n_steps: int, variables: Variables):
        """Take the steps as they were.

        Args:
            experience: What was kept.
            n_steps: How many steps of it.
            variables: Of the agent.
        """
        self.n_steps, self._variables = n_steps, variables
        self._s, self._a, self._r = (np.asfortranarray(part[:n_steps], np.int64) for part in experience)
        self._begin = np.zeros(len(variables.sensors), np.int64)
        self._together = joint_code(self._r, self.result_sizes)

    @property
    def of_world(self) -> int:
        """Number of sensors of the world; those of modules come after them."""
        return len(self._variables.sensors) - self._variables.modules

    @property
    def result_sizes(self) -> list[int]:
        """Number of values of each result."""
        return [len(result.values) for result in self._variables.results]

    def of(self, event: Event, joint: bool = False, given: Sequence[int] = ()) -> EventSeries:
        """The series of an event.

        Args:
            event: The event.
            joint: Whether its result is conditioned on all results together, or on itself.
            given: Sensors of modules on whose values its result is conditioned as well.
        """
        sensor, action = self._variables.sensors[event.sensor], self._variables.actions[event.action]
        before = self._together if joint else self._r[:, event.result]
        values = math.prod(self.result_sizes) if joint else self.result_sizes[event.result]
        for other in given:
            before, values = 2 * before + self._s[:, other], 2 * values
        sizes = np.array([values, len(sensor.values), len(action.values), self.result_sizes[event.result]])
        return EventSeries(
            (self._s[:, event.sensor], self._a[:, event.action], before, self._r[:, event.result]), sizes
        )

    def sensed(self, joint: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, tuple[int, int]]:
        """What the world lets the agent sense after each command of a joint.

        Returns:
            (n - 1,) values of the first sensor, commands, and what all sensors of the world together have in the next
            step, numbered; and the number of values of the first two.
        """
        sensors = self._variables.sensors[: self.of_world]
        after = joint_code(self._s[1:, : self.of_world], [len(sensor.values) for sensor in sensors])
        sizes = len(self._variables.sensors[0].values), len(self._variables.actions[joint].values)
        return self._s[:-1, 0], self._a[:-1, joint], np.unique(after, return_inverse=True)[1], sizes

    def begin(self, event: Event) -> int:
        """First step in which the event could occur."""
        return int(self._begin[event.sensor])

    def begins_at(self, number: int, step: int) -> None:
        """Leave out the steps before module ``number`` was made, where its sensor is concerned."""
        self._begin[self.of_world + number] = step

    def see_in_hindsight(self, number: int, module: Module) -> None:
        """Say in which steps a module was used, by its present map: where the robot did what the module offers.

        Args:
            number: Of the module.
            module: The module. Its map may look at an earlier module's S_Pi, so earlier ones come first.
        """
        event = module.event
        offered = module.command[self._r[:, event.result], self._s[:, event.sensor]]
        used = (offered != OFFERS_NOTHING) & (offered == self._a[:, event.action])
        self._s[0, self.of_world + number] = 0
        self._s[1:, self.of_world + number] = used[:-1]


def beyond_last(series: EventSeries) -> EventSeries:
    """The series with results conditioned on what came of the same action the last time that it was done, too."""
    sensor, action, before, after = series.columns
    values = int(series.sizes[3]) + 1
    before = before * values + _last_outcomes(action, after, int(series.sizes[2]))
    return EventSeries((sensor, action, before, after), series.sizes * np.array([values, 1, 1, 1]))


@njit(cache=True)
def _last_outcomes(action: np.ndarray, after: np.ndarray, actions: int) -> np.ndarray:
    """(n,) 1 and the result that followed the same action the last time; 0 where it had not been done before."""
    last, outcomes = np.zeros(actions, np.int64), np.zeros(len(action), np.int64)
    for t in range(len(action) - 1):
        outcomes[t] = last[action[t]]
        last[action[t]] = 1 + after[t + 1]
    return outcomes


def joint_code(values: np.ndarray, sizes: Sequence[int]) -> np.ndarray:
    """Several variables as one: their values as a number in mixed radix, the last changing fastest.

    Args:
        values: (n, variables) values.
        sizes: Number of values of each variable.
    """
    code = np.zeros(len(values), np.int64)
    for column, size in zip(values.T, sizes, strict=True):
        code = code * size + column
    return code
