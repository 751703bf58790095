"""What an agent sensed, did and found in every step, kept as it was, so that all of it can be counted anew.

Counts of transitions that are taken as they come (``counts``) cannot follow when the meaning of a variable changes. A
module's variable S_Pi says whether the module was used; with hindsight it is read anew whenever a map changes.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from jointattn_mj.contingency.online.events import Event, Variables
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING, Module
from jointattn_mj.errors import ConfigError
from jointattn_mj.io.compiled import njit

MANY = 1000
"""Number of combinations of sensations above which those that occurred are numbered anew."""
LARGEST = 2**62
"""Number of combinations above which their numbers would overflow."""


class Experience(NamedTuple):
    """The first ``n_steps`` rows of three tables; those after them are free. With fewer rows than steps the last steps
    are kept, each in the row of its number modulo the number of rows."""

    s: np.ndarray
    """(rows, sensors) int8 values in each step, those of modules included."""
    a: np.ndarray
    """(rows, actions) int8 commands of the joints, then whether each module was used."""
    r: np.ndarray
    """(rows, results) int8 values."""


def check_kept(variables: Variables) -> None:
    """Refuse variables whose values do not fit into the tables.

    Raises:
        ConfigError: One has too many.
    """
    most = np.iinfo(np.int8).max
    for variable in (*variables.sensors, *variables.actions, *variables.results):
        if len(variable.values) > most:
            raise ConfigError(
                "stop rule local, and modules that learn, keep all steps, of variables with at most "
                f"{most} values each; got {len(variable.values)} values of {variable.name!r}. Sort them into fewer"
            )


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


@njit(cache=True, borrows=True, forceinline=True)
def keep(experience: Experience, row: int, s: np.ndarray, a: np.ndarray, r: np.ndarray) -> None:
    """Write a step into its row.

    Args:
        experience: Changed in place.
        row: Number of the step.
        s: (sensors,) values.
        a: (actions,) values.
        r: (results,) values.
    """
    row %= len(experience.s)
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


class EventColumns(NamedTuple):
    """All steps, and which of their columns are those of each of E events; for compiled code."""

    s: np.ndarray
    """(n, sensors) values."""
    a: np.ndarray
    """(n, actions) values."""
    before: np.ndarray
    """(n, results) what each result is conditioned on."""
    r: np.ndarray
    """(n, results) values."""
    events: np.ndarray
    """(E, 4) sensor, action, result, and the first step in which the event could occur."""
    sizes: np.ndarray
    """(E, 4) number of values of: what the result is conditioned on, sensor, action, result."""

    def of(self, number: int) -> EventSeries:
        """The columns of the event of that number."""
        sensor, action, result, _ = self.events[number]
        return EventSeries(
            (self.s[:, sensor], self.a[:, action], self.before[:, result], self.r[:, result]), self.sizes[number]
        )


class PastSteps:
    """All steps of an agent that are kept, as its events count them.

    Attributes:
        n_steps: Number of steps.
        forgotten: Number of steps before them.
    """

    def __init__(self, experience: Experience, n_steps: int, variables: Variables):
        """Take the steps as they were.

        Args:
            experience: What was kept.
            n_steps: How many steps there were.
            variables: Of the agent.
        """
        self.n_steps, self._variables = min(n_steps, len(experience.s)), variables
        self.forgotten = n_steps - self.n_steps
        rows = np.arange(self.forgotten, n_steps) % len(experience.s) if self.forgotten else slice(n_steps)
        self._s, self._a, self._r = (np.array(part[rows], order="F") for part in experience)
        self._begin = np.zeros(len(variables.sensors), np.int64)
        self._values = [
            np.array([len(variable.values) for variable in group])
            for group in (variables.sensors, variables.actions, variables.results)
        ]
        self._together = ranks(joint_code(self._r, self._values[2]))

    @property
    def of_world(self) -> int:
        """Number of sensors of the world; those of modules come after them."""
        return len(self._variables.sensors) - self._variables.modules

    def of(self, event: Event) -> EventSeries:
        """The series of an event, with its result conditioned on itself."""
        sizes = [values[number] for values, number in zip(self._values, event, strict=True)]
        result = self._r[:, event.result]
        columns = self._s[:, event.sensor], self._a[:, event.action], result.astype(np.int64), result
        return EventSeries(columns, np.array([sizes[-1], *sizes]))

    def columns(self, events: Sequence[Event], joint: bool, given: Mapping[int, Sequence[int]]) -> EventColumns:
        """The columns of some events.

        Args:
            events: The events.
            joint: Whether each result is conditioned on all results together, or on itself.
            given: Sensors of modules on whose values a result is conditioned as well, by result.
        """
        before = np.zeros(self._r.shape, np.int64, order="F")
        values = np.zeros(len(before.T), np.int64)
        for result in range(len(values)):
            codes, uses = self._together if joint else self._r[:, result], given.get(result, ())
            if uses:
                most = int(codes.max(initial=0)) + 1
                codes = joint_code(np.column_stack([codes, self._s[:, uses]]), [most] + [2] * len(uses))
            before[:, result] = ranks(codes)
            values[result] = before[:, result].max(initial=-1) + 1
        numbers = np.array(events, np.int64).reshape(-1, 3)
        sizes = [counts[numbers[:, part]] for part, counts in enumerate(self._values)]
        return EventColumns(
            self._s, self._a, before, self._r,
            np.column_stack([numbers, self._begin[numbers[:, 0]]]),
            np.column_stack([values[numbers[:, 2]], *sizes]),
        )  # fmt: skip

    def sensed(self, joint: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, tuple[int, int, int]]:
        """What the world lets the agent sense after each command of a joint.

        Returns:
            (n - 1,) values of the first sensor, commands, and what all sensors of the world together have in the next
            step, numbered; and the number of values of each of the three.
        """
        values = self._values[0][: self.of_world]
        after = joint_code(self._s[1:, : self.of_world], values)
        sizes = int(values[0]), int(self._values[1][joint]), int(after.max(initial=-1)) + 1
        if sizes[2] > MANY:
            after = ranks(after)
            sizes = (*sizes[:2], int(after.max()) + 1)
        return self._s[:-1, 0], self._a[:-1, joint], after, sizes

    def begin(self, event: Event) -> int:
        """First step in which the event could occur."""
        return int(self._begin[event.sensor])

    def begins_at(self, number: int, step: int) -> None:
        """Leave out the steps before module ``number`` was made, at ``step``, where its sensor is concerned."""
        self._begin[self.of_world + number] = max(0, step - self.forgotten)

    def see_in_hindsight(self, number: int, module: Module) -> None:
        """Say in which steps a module was used, by its present map: where the robot did what the module offers.

        Args:
            number: Of the module.
            module: The module. Its map may look at an earlier module's S_Pi, so earlier ones come first.
        """
        event = module.event
        _use(
            module.command,
            self._r[:, event.result],
            self._s[:, event.sensor],
            self._a[:, event.action],
            self._s[:, self.of_world + number],
        )


@njit(cache=True)
def _use(command: np.ndarray, r: np.ndarray, s: np.ndarray, a: np.ndarray, used: np.ndarray) -> None:
    """Write whether a module was used in the step before: whether what was done is what it offers.

    Args:
        command: (R, S) command that it offers.
        r: (n,) values of its result.
        s: (n,) values of its sensor.
        a: (n,) values of its action.
        used: (n,) is written.
    """
    used[:1] = 0
    for t in range(len(used) - 1):
        offered = command[r[t], s[t]]
        used[t + 1] = offered != OFFERS_NOTHING and offered == a[t]


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


def joint_code(values: np.ndarray, sizes: Sequence[int] | np.ndarray) -> np.ndarray:
    """Several variables as one: their values as a number in mixed radix, the last changing fastest.

    Of so many variables that the number would overflow, the first ones that occur together are numbered first.

    Args:
        values: (n, variables) values.
        sizes: Number of values of each variable.
    """
    code, bound = np.zeros(len(values), np.int64), 1
    for column, size in zip(values.T, map(int, sizes), strict=True):
        if bound * size > LARGEST:
            code, bound = ranks(code), max(1, len(code))
        code, bound = code * size + column, bound * size
    return code


def ranks(codes: np.ndarray) -> np.ndarray:
    """(n,) the codes, 0 or more, numbered anew from 0 in their order, so that each number occurs."""
    if codes.max(initial=0) > MANY + len(codes):
        number: np.ndarray = np.unique(codes, return_inverse=True)[1]
    else:
        number = (np.cumsum(np.bincount(codes) > 0) - 1)[codes]
    return number
