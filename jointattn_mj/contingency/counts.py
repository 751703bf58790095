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
from numba import njit

from jointattn_mj.contingency.events import Event, Variables

NONE = -1
OWN, OF_ACTION, OF_SENSOR, ALONE = range(4)
"""Columns of ``Counts.contexts``: (S, A), (A), (S) and nothing."""
LISTED = 1 << 18
"""Counts below this find (c+1) ln(c+1) - c ln c in a list: a third of the time of a logarithm."""


@cache
def _gains() -> np.ndarray:
    whole = np.arange(1, LISTED + 1)
    return np.diff(np.concatenate([[0.0], whole * np.log(whole)]))


class Counts(NamedTuple):
    """The tables of E events, that is of their C contexts, in flat arrays."""

    contexts: np.ndarray
    """(E, 4) the contexts of an event."""
    of: np.ndarray
    """(C, 3) sensor or NONE, action or NONE, and result of a context."""
    size: np.ndarray
    """(C, 3) values of the context, of its action (1 without), and of the result."""
    offset: np.ndarray
    """(C,) where its counts begin in ``cells``."""
    cells: np.ndarray
    """All counts, for each context (R, V, 1 + R'): of (r, v), and beside it of each (r, v, r'). Weights where old
    transitions fade."""
    sums: np.ndarray
    """(C,) P in nats."""
    occupied: np.ndarray
    """(C,) how many (r, v, r') have been seen, less how many (r, v)."""
    n: np.ndarray
    """(C,) transitions counted, or the sum of their weights."""
    gains: np.ndarray
    """(c+1) ln(c+1) - c ln c of whole counts c; the same list for all."""


def empty_counts(variables: Variables, events: Sequence[Event]) -> Counts:
    """Tables without a transition."""
    numbers: dict[tuple[int, int, int], int] = {}
    contexts = [
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
    values = sensors[of[:, 0]] * actions[of[:, 1]]
    size = np.column_stack([values, actions[of[:, 1]], results[of[:, 2]]])
    lengths = values * size[:, 2] * (1 + size[:, 2])
    return Counts(
        contexts=np.array(contexts, np.int64).reshape(-1, 4),
        of=of,
        size=size,
        offset=np.cumsum(lengths) - lengths,
        cells=np.zeros(int(lengths.sum())),
        sums=np.zeros(len(of)),
        occupied=np.zeros(len(of), np.int64),
        n=np.zeros(len(of)),
        gains=_gains(),
    )


def joined(first: Counts, second: Counts) -> Counts:
    """The events of both, with their counts."""
    pairs = {name: (getattr(first, name), getattr(second, name)) for name in Counts._fields if name != "gains"}
    pairs["contexts"] = (first.contexts, second.contexts + len(first.of))
    pairs["offset"] = (first.offset, second.offset + len(first.cells))
    return Counts(**{name: np.concatenate(pair) for name, pair in pairs.items()}, gains=_gains())


def joint_table(counts: Counts, event: int) -> np.ndarray:
    """Counts (R, S, A, R') of an event: r, s, a and the result r' that followed."""
    context = counts.contexts[event, OWN]
    values, actions, results = counts.size[context]
    return _cells(counts, context)[..., 1:].reshape(results, values // actions, actions, results)


def _cells(counts: Counts, context: int) -> np.ndarray:
    """The counts (R, V, 1 + R') of a context, to be read or changed."""
    values, _, results = counts.size[context]
    begin = counts.offset[context]
    return counts.cells[begin : begin + results * values * (1 + results)].reshape(results, values, 1 + results)


def set_joint_table(counts: Counts, event: int, table: np.ndarray) -> None:
    """Give an event the counts (R, S, A, R'), and work out all that follows from them anew."""
    by_context = (table, table.sum(1), table.sum(2), table.sum((1, 2)))
    for context, followed in zip(counts.contexts[event], by_context, strict=True):
        cells = _cells(counts, context)
        cells[..., 1:] = followed.reshape(cells[..., 1:].shape)
        cells[..., 0] = cells[..., 1:].sum(-1)
        both, seen = (part[part > 0] for part in (cells[..., 1:], cells[..., 0]))
        counts.sums[context] = (both * np.log(both)).sum() - (seen * np.log(seen)).sum()
        counts.occupied[context] = len(both) - len(seen)
        counts.n[context] = seen.sum()


@njit(cache=True, forceinline=True)
def _one_more(count, gains):
    """(c+1) ln(c+1) - c ln c of a whole count c; beyond the list the series is exact to the last digits."""
    if count < LISTED:
        return gains[np.uint64(count)]
    return np.log(count) + 1.0 + (0.5 - (1.0 / 6.0 - 1.0 / (12.0 * count)) / count) / count


@njit(cache=True, forceinline=True)
def _c_ln_c(count):
    return count * np.log(count) if count > 0.0 else 0.0


@njit(cache=True, forceinline=True)
def _change(cells, place, weight, gains):
    """Put ``weight`` into a cell; returns the change of c ln c and of the number of occupied cells."""
    before = cells[np.uint64(place)]
    after = before + weight
    cells[np.uint64(place)] = after
    occupied = int(after != 0.0) - int(before != 0.0)
    if isinstance(weight, int):  # known when this is compiled: whole counts pay nothing for the others
        return weight * _one_more(before if weight > 0 else after, gains), occupied
    return _c_ln_c(after) - _c_ln_c(before), occupied


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
    of, size, offset, cells, gains = counts.of, counts.size, counts.offset, counts.cells, counts.gains
    sums, occupied, n = counts.sums, counts.occupied, counts.n
    for c in range(contexts):
        v = 0
        if of[c, 0] >= 0:
            v = s[of[c, 0]] * size[c, 1]
        if of[c, 1] >= 0:
            v += a[of[c, 1]]
        place = offset[c] + (r[of[c, 2]] * size[c, 0] + v) * (1 + size[c, 2])
        gain, more = _change(cells, place + 1 + r_next[of[c, 2]], weight, gains)
        less_gain, less = _change(cells, place, weight, gains)
        sums[c] += gain - less_gain
        occupied[c] += more - less
        n[c] += weight


@njit(cache=True)
def divide(counts, weight):
    """Make all weights smaller; the measures stay, since the logarithms of ``weight`` cancel in each difference."""
    for place in range(len(counts.cells)):
        counts.cells[place] /= weight
    for c in range(len(counts.n)):
        counts.sums[c] /= weight
        counts.n[c] /= weight


@njit(cache=True)
def local_variance(counts, event, single):
    """Variance, nats squared, of the measure's value from transition to transition: n times that of the estimate.

    Args:
        counts: The tables.
        event: Which event.
        single: 1 for SAC; 0 for T^C, which leaves T_S out.
    """
    own, of_action, of_sensor, alone = counts.contexts[event]
    values, actions, results = counts.size[own]
    sensors = values // actions
    mean = square = 0.0
    for k in range(results):
        for k_next in range(results):
            chance = _share(counts, alone, k, 0, k_next)
            for i in range(sensors):
                of_s = _share(counts, of_sensor, k, i, k_next)
                if of_s == 0.0:
                    continue
                for j in range(actions):
                    both = _share(counts, own, k, i * actions + j, k_next)
                    if both == 0.0:
                        continue
                    local = np.log(both / _share(counts, of_action, k, j, k_next))
                    if single:
                        local -= np.log(of_s / chance)
                    place = counts.offset[own] + (k * values + i * actions + j) * (1 + results)
                    count = counts.cells[place + 1 + k_next]
                    mean += count * local
                    square += count * local * local
    n = counts.n[own]
    return square / n - (mean / n) ** 2


@njit(cache=True, forceinline=True)
def _share(counts, context, r, v, r_next):
    """p(r' | r, v); 0 where it was never seen."""
    place = counts.offset[context] + (r * counts.size[context, 0] + v) * (1 + counts.size[context, 2])
    seen = counts.cells[place]
    return counts.cells[place + 1 + r_next] / seen if seen > 0.0 else 0.0
