"""Count tables of all events, updated one transition at a time, and the sums that contingency consists of.

Let a context V be a sensor and an action, one of them, or nothing, and G the sum of c ln c over the entries c of a
table. With r the result before and r' the one after,

    P(V) = G(r', r, v) - G(r, v)

is -n times the entropy of r' given r and v, and the measures of an event (S, A, R) are differences of four of these:

    n T^C = P(S, A) - P(A)                  eq. 4.3
    n T_S = P(S) - P()                      eq. 4.1
    n SAC = n T^C - n T_S                   eq. 5.2

A transition changes one entry of each table, so P changes by two differences of c ln c: the cost of a step is linear in
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
"""Fields of a context in ``Counts.contexts``.

``sensor``, ``action``, ``result``: its variables. ``per_...``: distance in ``Counts.entries`` between the counts under
neighbouring values of each; 0 for a variable that is no part of V. ``width``: length 1 + R' of a row. ``offset``: where
its counts begin. ``sum``: P in nats. ``n``: number of transitions, or the sum of their weights. ``occupied``: number of
(r, v, r') that have occurred, less that of (r, v)."""
OWN, OF_ACTION, OF_SENSOR, ALONE = range(4)
"""Columns of ``Counts.of_event``: (S, A), (A), (S) and nothing."""
LISTED = 1 << 18
"""Below this count (c+1) ln(c+1) - c ln c is looked up in a list; with logarithms a step at the table takes 2.6 to 3.1
microseconds instead of 1.7 to 1.9."""


@cache
def _gains() -> np.ndarray:
    whole = np.arange(1, LISTED + 1)
    return np.diff(np.concatenate([[0.0], whole * np.log(whole)]))


class Counts(NamedTuple):
    """Tables of E events, that is of their C contexts, in flat arrays."""

    of_event: np.ndarray
    """(E, 4) contexts of each event, in the columns OWN, OF_ACTION, OF_SENSOR and ALONE."""
    contexts: np.ndarray
    """(C,) of CONTEXT."""
    entries: np.ndarray
    """All counts; for each context (R, V, 1 + R'): of (r, v), then of each (r, v, r'). Weights where old transitions
    fade."""
    gains: np.ndarray
    """(LISTED,) (c+1) ln(c+1) - c ln c of whole counts c."""


def empty_counts(variables: Variables, events: Sequence[Event]) -> Counts:
    """Tables without a transition.

    Args:
        variables: What is sensed and done.
        events: Events among them.
    """
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
        entries=np.zeros(int(lengths.sum())),
        gains=_gains(),
    )


def joined(first: Counts, second: Counts) -> Counts:
    """Tables of the events of both, with their counts."""
    later = second.contexts.copy()
    later["offset"] += len(first.entries)
    return Counts(
        of_event=np.concatenate([first.of_event, second.of_event + len(first.contexts)]),
        contexts=np.concatenate([first.contexts, later]),
        entries=np.concatenate([first.entries, second.entries]),
        gains=first.gains,
    )


def joint_table(counts: Counts, event: int) -> np.ndarray:
    """Counts (R, S, A, R') of the event with that number: r, s, a and the result r' that followed."""
    context = counts.contexts[counts.of_event[event, OWN]]
    actions, results = context["per_sensor"] // context["width"], context["width"] - 1
    return _entries(counts, context)[..., 1:].reshape(results, -1, actions, results)


def _entries(counts: Counts, context: np.void) -> np.ndarray:
    """A view on the counts (R, V, 1 + R') of a context."""
    width, begin = context["width"], context["offset"]
    results = width - 1
    return counts.entries[begin : begin + results * context["per_result"]].reshape(results, -1, width)


def set_joint_table(counts: Counts, event: int, table: np.ndarray) -> None:
    """Replace the counts of an event, and compute its sums anew.

    Args:
        counts: Tables, changed in place.
        event: Number of the event.
        table: (R, S, A, R') counts.

    Raises:
        ObservationError: Another shape, or counts that are negative, NaN or infinite.
    """
    require_array("counts", table, joint_table(counts, event).shape, "iuf", 0, np.finfo(float).max)
    by_context = (table, table.sum(1), table.sum(2), table.sum((1, 2)))
    for number, followed in zip(counts.of_event[event], by_context, strict=True):
        context = counts.contexts[number]
        entries = _entries(counts, context)
        entries[..., 1:] = followed.reshape(entries[..., 1:].shape)
        entries[..., 0] = entries[..., 1:].sum(-1)
        both, visible = (part[part > 0] for part in (entries[..., 1:], entries[..., 0]))
        context["sum"] = (both * np.log(both)).sum() - (visible * np.log(visible)).sum()
        context["occupied"] = len(both) - len(visible)
        context["n"] = visible.sum()


@njit(cache=True, forceinline=True)
def _one_more(count: float, gains: np.ndarray) -> float:
    """(c+1) ln(c+1) - c ln c of a whole count c; beyond the list by a series that is exact to the last digits."""
    if count < LISTED:
        gain: float = gains[np.uint64(np.int64(count))]  # unsigned: no test for negative ones, 0.1 microseconds a step
        return gain
    series: float = np.log(count) + 1.0 + (0.5 - (1.0 / 6.0 - 1.0 / (12.0 * count)) / count) / count
    return series


@njit(cache=True, forceinline=True)
def _c_ln_c(count: float) -> float:
    value: float = count * np.log(count) if count > 0.0 else 0.0
    return value


@njit(cache=True, forceinline=True)
def _change(entries: np.ndarray, location: int, weight: float, gains: np.ndarray) -> tuple[float, int]:
    """Add ``weight`` to an entry; returns the change of c ln c and of the number of entries above 0."""
    before = entries[np.uint64(location)]
    after = before + weight
    entries[np.uint64(location)] = after
    occupied = int(after != 0.0) - int(before != 0.0)
    if isinstance(weight, int):  # decided at compile time: whole counts need no logarithm
        return weight * _one_more(before if weight > 0 else after, gains), occupied
    return _c_ln_c(after) - _c_ln_c(before), occupied


@njit(cache=True, forceinline=True)
def _location(context: np.record, r: int, s: int, a: int) -> int:
    """Where in ``entries`` the row of (r, v) begins."""
    location: int = context.offset + r * context.per_result + s * context.per_sensor + a * context.per_action
    return location


def _check_add(
    counts: Counts, s: np.ndarray, a: np.ndarray, r: np.ndarray, r_next: np.ndarray, weight: float, contexts: int
) -> None:
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
        if (counts.entries[locations + 1 + r_next[of["result"]]] < 1).any():
            raise ObservationError("a transition that was never counted cannot be taken out again")


@checked_by(_check_add)
@njit(cache=True, forceinline=True)
def add(
    counts: Counts, s: np.ndarray, a: np.ndarray, r: np.ndarray, r_next: np.ndarray, weight: float, contexts: int
) -> None:
    """Count a transition.

    Args:
        counts: Tables, changed in place.
        s: (sensors,) values at step t.
        a: (actions,) values at step t.
        r: (results,) values at step t.
        r_next: (results,) values at step t + 1.
        weight: Int 1 for a transition, -1 to take one out again; a float where old ones fade.
        contexts: Only so many contexts count it: later ones did not exist when an old transition was counted.
    """
    entries, gains = counts.entries, counts.gains
    for number in range(contexts):
        c = counts.contexts[number]
        location = _location(c, r[c.result], s[c.sensor], a[c.action])
        gain, more = _change(entries, location + 1 + r_next[c.result], weight, gains)
        less_gain, less = _change(entries, location, weight, gains)
        c.sum += gain - less_gain
        c.occupied += more - less
        c.n += weight


def _check_divide(counts: Counts, weight: float) -> None:
    if not 0 < weight < np.inf:
        raise ObservationError(f"weight: expected a number above 0; got {weight!r}")


@checked_by(_check_divide)
@njit(cache=True)
def divide(counts: Counts, weight: float) -> None:
    """Divide all counts by ``weight``; the measures stay, since its logarithms cancel in each difference."""
    for location in range(len(counts.entries)):
        counts.entries[location] /= weight
    for number in range(len(counts.contexts)):
        counts.contexts[number].sum /= weight
        counts.contexts[number].n /= weight


def _check_event(counts: Counts, event: int, single: int) -> None:
    if not (isinstance(event, (int, np.integer)) and 0 <= event < len(counts.of_event)):
        raise ObservationError(f"events are numbered from 0 to {len(counts.of_event) - 1}; got {event!r}")


@checked_by(_check_event)
@njit(cache=True)
def local_variance(counts: Counts, event: int, single: int) -> float:
    """Variance of the measure's value from transition to transition, nats squared: n times that of the estimate.

    Args:
        counts: Tables.
        event: Number of the event.
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
            chance = _share(counts.entries, alone, k, 0, 0, k_next)
            for i in range(sensors):
                of_s = _share(counts.entries, of_sensor, k, i, 0, k_next)
                if of_s == 0.0:
                    continue
                for j in range(actions):
                    both = _share(counts.entries, own, k, i, j, k_next)
                    if both == 0.0:
                        continue
                    local = np.log(both / _share(counts.entries, of_action, k, 0, j, k_next))
                    if single:
                        local -= np.log(of_s / chance)
                    count = counts.entries[_location(own, k, i, j) + 1 + k_next]
                    mean += count * local
                    square += count * local * local
    variance: float = square / own.n - (mean / own.n) ** 2
    return variance


@njit(cache=True, forceinline=True)
def _share(entries: np.ndarray, context: np.record, r: int, s: int, a: int, r_next: int) -> float:
    """p(r' | r, v); 0 where it never occurred."""
    location = _location(context, r, s, a)
    share: float = entries[location + 1 + r_next] / entries[location] if entries[location] > 0.0 else 0.0
    return share
