"""Count tables of all events, kept up to date one transition at a time, and the sums that contingency is made of.

Let a context V be a sensor and an action, one of them, or nothing, and G the sum of c ln c over the cells c of a count
table. With r the result before and r' the one after,

    P(V) = G(r', r, v) - G(r, v)

is -n times the entropy of r' given r and v, and the measures of an event (S, A, R) are differences of four of these:

    n T^C = P(S, A) - P(A)                  eq. 4.3
    n T_S = P(S) - P()                      eq. 4.1
    n SAC = n T^C - n T_S                   eq. 5.2

A transition changes one cell of each table, so P changes by two differences of c ln c: the cost of a step is linear in
the number of events, whatever the number of values. Events that begin together share the tables of the contexts that
they have in common.
"""

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from jointattn_mj.contingency.online.events import Event, Variables
from jointattn_mj.errors import ObservationError
from jointattn_mj.guards.border import checked_by, require_array
from jointattn_mj.io.compiled import njit

NONE = -1
CONTEXT = np.dtype(
    [(name, np.int32) for name in ("sensor", "action", "result", "per_sensor", "per_action", "per_result", "width")]
    + [("offset", np.int64), ("sum", float), ("n", float), ("occupied", np.int64)],
    align=True,
)
"""A context in ``Counts.contexts``: which variables it looks at, how far apart in ``Counts.cells`` the counts under
neighbouring values of each lie (0 for one that is no part of V), the width 1 + R' of a row, and where its counts begin;
then P in nats, how many transitions were counted, or the sum of their weights, and how many (r, v, r') have been seen,
less how many (r, v)."""
OWN, OF_ACTION, OF_SENSOR, ALONE = range(4)
"""Columns of ``Counts.of_event``: (S, A), (A), (S) and nothing."""
LISTED = 1 << 18
"""Counts below this find (c+1) ln(c+1) - c ln c in a list: a third of the time of a logarithm."""


@cache
def _gains() -> np.ndarray:
    whole = np.arange(1, LISTED + 1)
    return np.diff(np.concatenate([[0.0], whole * np.log(whole)]))


class Counts(NamedTuple):
    """The tables of E events, that is of their C contexts, in flat arrays."""

    of_event: np.ndarray
    """(E, 4) the contexts of an event."""
    contexts: np.ndarray
    """(C,) of CONTEXT."""
    cells: np.ndarray
    """All counts, for each context (R, V, 1 + R'): of (r, v), and beside it of each (r, v, r'). Weights where old
    transitions fade."""
    gains: np.ndarray
    """(c+1) ln(c+1) - c ln c of whole counts c; the same list for all."""


def empty_counts(variables: Variables, events: Sequence[Event]) -> Counts:
    """Tables without a transition."""
    numbers: dict[tuple[int, int, int], int] = {}
    of_event = [
        [
            numbers.setdefault(context, len(numbers))
            for context in ((event.sensor, event.action, event.result), (NONE, event.action, event.result),
                            (event.sensor, NONE, event.result), (NONE, NONE, event.result))
        ]
        for event in events
    ]  # fmt: skip
    of = np.array(list(numbers), np.int64).reshape(-1, 3)
    sensors, actions, results = (
        np.array([len(variable.values) for variable in group] + [1])  # NONE, the last, has one value
        for group in (variables.sensors, variables.actions, variables.results)
    )
    sensor, action, result = of.T
    contexts = np.zeros(len(of), CONTEXT)
    contexts["sensor"], contexts["action"], contexts["result"] = np.maximum(of.T, 0)
    contexts["width"] = 1 + results[result]
    contexts["per_action"] = np.where(action == NONE, 0, contexts["width"])
    contexts["per_sensor"] = np.where(sensor == NONE, 0, actions[action] * contexts["width"])
    contexts["per_result"] = sensors[sensor] * actions[action] * contexts["width"]
    lengths = results[result] * contexts["per_result"]
    contexts["offset"] = np.cumsum(lengths) - lengths
    return Counts(
        of_event=np.array(of_event, np.int64).reshape(-1, 4),
        contexts=contexts,
        cells=np.zeros(int(lengths.sum())),
        gains=_gains(),
    )


def joined(first: Counts, second: Counts) -> Counts:
    """The events of both, with their counts."""
    later = second.contexts.copy()
    later["offset"] += len(first.cells)
    return Counts(
        of_event=np.concatenate([first.of_event, second.of_event + len(first.contexts)]),
        contexts=np.concatenate([first.contexts, later]),
        cells=np.concatenate([first.cells, second.cells]),
        gains=first.gains,
    )


def joint_table(counts: Counts, event: int) -> np.ndarray:
    """Counts (R, S, A, R') of an event: r, s, a and the result r' that followed."""
    context = counts.contexts[counts.of_event[event, OWN]]
    actions, results = context["per_sensor"] // context["width"], context["width"] - 1
    return _cells(counts, context)[..., 1:].reshape(results, -1, actions, results)


def _cells(counts: Counts, context: np.void) -> np.ndarray:
    """The counts (R, V, 1 + R') of a context, to be read or changed."""
    width, begin = context["width"], context["offset"]
    results = width - 1
    return counts.cells[begin : begin + results * context["per_result"]].reshape(results, -1, width)


def set_joint_table(counts: Counts, event: int, table: np.ndarray) -> None:
    """Give an event the counts (R, S, A, R'), and work out all that follows from them anew.

    Raises:
        ObservationError: Another shape, or counts that are negative, NaN or infinite.
    """
    require_array("counts", table, joint_table(counts, event).shape, "iuf", 0, np.finfo(float).max)
    by_context = (table, table.sum(1), table.sum(2), table.sum((1, 2)))
    for number, followed in zip(counts.of_event[event], by_context, strict=True):
        context = counts.contexts[number]
        cells = _cells(counts, context)
        cells[..., 1:] = followed.reshape(cells[..., 1:].shape)
        cells[..., 0] = cells[..., 1:].sum(-1)
        both, visible = (part[part > 0] for part in (cells[..., 1:], cells[..., 0]))
        context["sum"] = (both * np.log(both)).sum() - (visible * np.log(visible)).sum()
        context["occupied"] = len(both) - len(visible)
        context["n"] = visible.sum()


@njit(cache=True, forceinline=True)
def _one_more(count, gains):
    """(c+1) ln(c+1) - c ln c of a whole count c; beyond the list the series is exact to the last digits."""
    if count < LISTED:
        return gains[np.uint64(np.int64(count))]  # unsigned numbers are looked up, signed ones converted, faster
    return np.log(count) + 1.0 + (0.5 - (1.0 / 6.0 - 1.0 / (12.0 * count)) / count) / count


@njit(cache=True, forceinline=True)
def _c_ln_c(count):
    return count * np.log(count) if count > 0.0 else 0.0


@njit(cache=True, forceinline=True)
def _change(cells, location, weight, gains):
    """Put ``weight`` into a cell; returns the change of c ln c and of the number of occupied cells."""
    before = cells[np.uint64(location)]
    after = before + weight
    cells[np.uint64(location)] = after
    occupied = int(after != 0.0) - int(before != 0.0)
    if isinstance(weight, int):  # known when this is compiled: whole counts pay nothing for the others
        return weight * _one_more(before if weight > 0 else after, gains), occupied
    return _c_ln_c(after) - _c_ln_c(before), occupied


@njit(cache=True, forceinline=True)
def _location(context, r, s, a):
    """Where in ``cells`` the row of (r, v) begins."""
    return context.offset + r * context.per_result + s * context.per_sensor + a * context.per_action


def _check_add(counts, s, a, r, r_next, weight, contexts):
    if not 0 <= contexts <= len(counts.contexts):
        raise ObservationError(f"there are {len(counts.contexts)} contexts; got {contexts}")
    of = counts.contexts[: int(contexts)]
    outer = np.where(of["per_sensor"] > 0, of["per_sensor"], of["per_result"])
    sizes = {  # 0 where a context does not look at any
        "sensor": np.where(of["per_sensor"] > 0, of["per_result"] // np.maximum(of["per_sensor"], 1), 0),
        "action": np.where(of["per_action"] > 0, outer // of["width"], 0),
        "result": of["width"] - 1,
    }
    for name, kind, values in (
        ("s", "sensor", s),
        ("a", "action", a),
        ("r", "result", r),
        ("r_next", "result", r_next),
    ):
        require_array(name, values, (-1,), "iub")
        if of[kind].max(initial=-1) >= len(values):
            raise ObservationError(f"{name}: expected {of[kind].max() + 1} values or more; got {len(values)}")
        looks = sizes[kind] > 0
        codes = values[of[kind][looks]].astype(np.int64)
        require_array(name, codes, codes.shape, "i", 0, sizes[kind][looks] - 1)
    whole = isinstance(weight, (int, np.integer))
    if not (weight in (1, -1) if whole else 0 < weight < np.inf):
        raise ObservationError(f"weight: expected 1, -1, or a float above 0; got {weight!r}")
    if whole and weight < 0:
        locations = of["offset"] + r[of["result"]] * of["per_result"]
        locations += s[of["sensor"]] * of["per_sensor"] + a[of["action"]] * of["per_action"]
        if (counts.cells[locations + 1 + r_next[of["result"]]] < 1).any():
            raise ObservationError("a transition that was never counted cannot be taken out again")


@checked_by(_check_add)
@njit(cache=True, forceinline=True)
def add(counts, s, a, r, r_next, weight, contexts):
    """Count a transition in the first ``contexts`` contexts.

    Args:
        counts: The tables, changed in place.
        s: Values (sensors,) at step t.
        a: Values (actions,) at step t.
        r: Values (results,) at step t.
        r_next: Values (results,) at step t + 1.
        weight: Int 1 for a transition, -1 to take one out again; a float where old ones fade.
        contexts: How many take part: those that came later do not know older transitions.
    """
    cells, gains = counts.cells, counts.gains
    for number in range(contexts):
        c = counts.contexts[number]
        location = _location(c, r[c.result], s[c.sensor], a[c.action])
        gain, more = _change(cells, location + 1 + r_next[c.result], weight, gains)
        less_gain, less = _change(cells, location, weight, gains)
        c.sum += gain - less_gain
        c.occupied += more - less
        c.n += weight


def _check_divide(counts, weight):
    if not 0 < weight < np.inf:
        raise ObservationError(f"weight: expected a number above 0; got {weight!r}")


@checked_by(_check_divide)
@njit(cache=True)
def divide(counts, weight):
    """Make all weights smaller; the measures stay, since the logarithms of ``weight`` cancel in each difference."""
    for location in range(len(counts.cells)):
        counts.cells[location] /= weight
    for number in range(len(counts.contexts)):
        counts.contexts[number].sum /= weight
        counts.contexts[number].n /= weight


def _check_event(counts, event, single):
    if not (isinstance(event, (int, np.integer)) and 0 <= event < len(counts.of_event)):
        raise ObservationError(f"events are numbered from 0 to {len(counts.of_event) - 1}; got {event!r}")


@checked_by(_check_event)
@njit(cache=True)
def local_variance(counts, event, single):
    """Variance, nats squared, of the measure's value from transition to transition: n times that of the estimate.

    Args:
        counts: The tables.
        event: Which event.
        single: 1 for SAC; 0 for T^C, which leaves T_S out.
    """
    own, of_action = counts.contexts[counts.of_event[event, OWN]], counts.contexts[counts.of_event[event, OF_ACTION]]
    of_sensor, alone = (
        counts.contexts[counts.of_event[event, OF_SENSOR]],
        counts.contexts[counts.of_event[event, ALONE]],
    )
    results, actions, sensors = own.width - 1, own.per_sensor // own.width, own.per_result // own.per_sensor
    mean = square = 0.0
    for k in range(results):
        for k_next in range(results):
            chance = _share(counts.cells, alone, k, 0, 0, k_next)
            for i in range(sensors):
                of_s = _share(counts.cells, of_sensor, k, i, 0, k_next)
                if of_s == 0.0:
                    continue
                for j in range(actions):
                    both = _share(counts.cells, own, k, i, j, k_next)
                    if both == 0.0:
                        continue
                    local = np.log(both / _share(counts.cells, of_action, k, 0, j, k_next))
                    if single:
                        local -= np.log(of_s / chance)
                    count = counts.cells[_location(own, k, i, j) + 1 + k_next]
                    mean += count * local
                    square += count * local * local
    return square / own.n - (mean / own.n) ** 2


@njit(cache=True, forceinline=True)
def _share(cells, context, r, s, a, r_next):
    """p(r' | r, v); 0 where it was never seen."""
    location = _location(context, r, s, a)
    return cells[location + 1 + r_next] / cells[location] if cells[location] > 0.0 else 0.0
