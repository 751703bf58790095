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
from typing import Any, NamedTuple

import numpy as np

from jointattn_mj.contingency.online.events import Event, Variables
from jointattn_mj.errors import ObservationError
from jointattn_mj.guards.border import checked_by, require_array
from jointattn_mj.io.compiled import njit

NONE = -1
ANY: Any = np.int64(0)
"""The only value of a variable that is no part of a context; for a plain 0, ``_share`` would be compiled once more."""
SENSOR, ACTION, RESULT, PER_SENSOR, PER_ACTION, PER_RESULT, WIDTH, OFFSET = range(8)
"""Columns of ``Counts.layout``.

SENSOR, ACTION, RESULT: variables of a context. PER_...: distance in ``Counts.entries`` between the counts under
neighbouring values of each; 0 for a variable that is no part of V. WIDTH: length 1 + R' of a row. OFFSET: where its
counts begin."""
OWN, OF_ACTION, OF_SENSOR, ALONE = range(4)
"""Columns of ``Counts.of_event``: (S, A), (A), (S) and nothing."""
LISTED = 1 << 18
"""Below this count (c+1) ln(c+1) - c ln c is looked up in a list; with logarithms a step at the table takes half
as long again."""


@cache
def _gains() -> np.ndarray:
    whole = np.arange(1, LISTED + 1)
    return np.diff(np.concatenate([[0.0], whole * np.log(whole)]))


class Counts(NamedTuple):
    """Tables of E events, that is of their C contexts, in flat arrays.

    An array for each kind of number, and unsigned ones where they are looked up by: counting a transition takes half
    the time that it takes with one structured array (6.4 nanoseconds an event instead of 13.4).
    """

    of_event: np.ndarray
    """(E, 4) contexts of each event, in the columns OWN, OF_ACTION, OF_SENSOR and ALONE."""
    layout: np.ndarray
    """(C, 8) where the counts of each context lie, in the columns SENSOR to OFFSET; uint32."""
    sums: np.ndarray
    """(C,) P of each context, nats."""
    n: np.ndarray
    """(C,) number of transitions, or the sum of their weights."""
    occupied: np.ndarray
    """(C,) number of (r, v, r') that have occurred, less that of (r, v)."""
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
    width = 1 + results[result]
    per_action = np.where(action == NONE, 0, width)
    per_sensor = np.where(sensor == NONE, 0, actions[action] * width)
    per_result = sensors[sensor] * actions[action] * width
    lengths = results[result] * per_result
    variables_of = np.maximum(of.T, 0)
    layout = (*variables_of, per_sensor, per_action, per_result, width, np.cumsum(lengths) - lengths)
    return Counts(
        of_event=np.array(of_event, np.uint32).reshape(-1, 4),
        layout=np.ascontiguousarray(np.array(layout).T, np.uint32),
        sums=np.zeros(len(of)),
        n=np.zeros(len(of)),
        occupied=np.zeros(len(of), np.int64),
        entries=np.zeros(int(lengths.sum())),
        gains=_gains(),
    )


def joined(first: Counts, second: Counts) -> Counts:
    """Tables of the events of both, with their counts."""
    later = second.layout.copy()
    later[:, OFFSET] += len(first.entries)
    return Counts(
        of_event=np.concatenate([first.of_event, second.of_event + np.uint32(len(first.n))]),
        layout=np.concatenate([first.layout, later]),
        sums=np.concatenate([first.sums, second.sums]),
        n=np.concatenate([first.n, second.n]),
        occupied=np.concatenate([first.occupied, second.occupied]),
        entries=np.concatenate([first.entries, second.entries]),
        gains=first.gains,
    )


def joint_table(counts: Counts, event: int) -> np.ndarray:
    """Counts (R, S, A, R') of the event with that number: r, s, a and the result r' that followed."""
    context = counts.of_event[event, OWN]
    _, _, _, per_sensor, _, _, width, _ = counts.layout[context].tolist()
    return _entries(counts, context)[..., 1:].reshape(width - 1, -1, per_sensor // width, width - 1)


def _entries(counts: Counts, context: int) -> np.ndarray:
    """A view on the counts (R, V, 1 + R') of the context with that number."""
    *_, per_result, width, begin = counts.layout[context].tolist()
    return counts.entries[begin : begin + (width - 1) * per_result].reshape(width - 1, -1, width)


def check_add_up(counts: Counts) -> None:
    """Refuse whole counts of which those of (r, v, r') are not together those of (r, v), or these not n.

    Raises:
        ObservationError: They do not add up; ``gains`` would be read beyond its end.
    """
    for context, n in enumerate(counts.n):
        entries = _entries(counts, context)
        if not np.array_equal(entries[..., 0], entries[..., 1:].sum(-1)) or entries[..., 0].sum() != n:
            raise ObservationError(f"the counts of context {context} do not add up")


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
        entries = _entries(counts, number)
        entries[..., 1:] = followed.reshape(entries[..., 1:].shape)
        entries[..., 0] = entries[..., 1:].sum(-1)
        both, visible = (part[part > 0] for part in (entries[..., 1:], entries[..., 0]))
        counts.sums[number] = (both * np.log(both)).sum() - (visible * np.log(visible)).sum()
        counts.occupied[number] = len(both) - len(visible)
        counts.n[number] = visible.sum()


@njit(cache=True, borrows=True)
def _series(count: float) -> float:
    """(c+1) ln(c+1) - c ln c of a whole count c beyond the list, exact to the last digits."""
    series: float = np.log(count) + 1.0 + (0.5 - (1.0 / 6.0 - 1.0 / (12.0 * count)) / count) / count
    return series


@njit(cache=True, borrows=True)
def one_more(count: float, gains: np.ndarray) -> float:
    """(c+1) ln(c+1) - c ln c of a whole count c."""
    return gains[np.uint64(np.int64(count))] if count < LISTED else _series(count)


@njit(cache=True, borrows=True, forceinline=True)
def _c_ln_c(count: float) -> float:
    value: float = count * np.log(count) if count > 0.0 else 0.0
    return value


@njit(cache=True, borrows=True, forceinline=True)
def _location(layout: np.ndarray, context: int, r: int, s: int, a: int) -> np.uint64:
    """Where in ``entries`` the row of (r, v) begins. Unsigned: no test for negative ones."""
    location = np.uint64(layout[context, OFFSET])
    location += np.uint64(r) * np.uint64(layout[context, PER_RESULT])
    location += np.uint64(s) * np.uint64(layout[context, PER_SENSOR])
    location += np.uint64(a) * np.uint64(layout[context, PER_ACTION])
    return location


def check_add(
    counts: Counts, s: np.ndarray, a: np.ndarray, r: np.ndarray, r_next: np.ndarray, weight: float, contexts: int
) -> None:
    """Refuse what ``add`` cannot count.

    Args:
        counts: Tables.
        s: Of ``add``, as the others.
        a: Likewise.
        r: Likewise.
        r_next: Likewise.
        weight: Likewise.
        contexts: Likewise.

    Raises:
        ObservationError: Compiled code would count it elsewhere.
    """
    if not 0 <= contexts <= len(counts.layout):
        raise ObservationError(f"there are {len(counts.layout)} contexts; got {contexts}")
    of = counts.layout[: int(contexts)].astype(np.int64).T
    outer = np.where(of[PER_SENSOR] > 0, of[PER_SENSOR], of[PER_RESULT])
    sizes = {  # 0 where a context does not look at any
        SENSOR: np.where(of[PER_SENSOR] > 0, of[PER_RESULT] // np.maximum(of[PER_SENSOR], 1), 0),
        ACTION: np.where(of[PER_ACTION] > 0, outer // of[WIDTH], 0),
        RESULT: of[WIDTH] - 1,
    }
    for name, kind, values in (("s", SENSOR, s), ("a", ACTION, a), ("r", RESULT, r), ("r_next", RESULT, r_next)):
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
        locations = of[OFFSET] + r[of[RESULT]] * of[PER_RESULT]
        locations += s[of[SENSOR]] * of[PER_SENSOR] + a[of[ACTION]] * of[PER_ACTION]
        if (counts.entries[locations + 1 + r_next[of[RESULT]]] < 1).any():
            raise ObservationError("a transition that was never counted cannot be taken out again")


@checked_by(check_add)
@njit(cache=True, borrows=True, forceinline=True)
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
    entries, layout, sums, gains = counts.entries, counts.layout, counts.sums, counts.gains
    for c in range(np.uint64(contexts)):
        result = layout[c, RESULT]
        row = _location(layout, c, r[result], s[layout[c, SENSOR]], a[layout[c, ACTION]])
        entry = row + np.uint64(1) + np.uint64(r_next[result])
        before, row_before = entries[entry], entries[row]
        after, row_after = before + weight, row_before + weight
        entries[entry], entries[row] = after, row_after
        if isinstance(weight, int):  # decided at compile time: whole counts need no logarithm
            less = before if weight > 0 else after
            row_less = row_before if weight > 0 else row_after
            if less < LISTED and row_less < LISTED:
                gain = gains[np.uint64(np.int64(less))] - gains[np.uint64(np.int64(row_less))]
            else:
                gain = one_more(less, gains) - one_more(row_less, gains)
            sums[c] += weight * gain
        else:
            sums[c] += (_c_ln_c(after) - _c_ln_c(before)) - (_c_ln_c(row_after) - _c_ln_c(row_before))
        if before == 0.0 or after == 0.0:  # rare, and then the row may be new or empty too
            counts.occupied[c] += int(after != 0.0) - int(before != 0.0)
            counts.occupied[c] -= int(row_after != 0.0) - int(row_before != 0.0)
    for c in range(np.uint64(contexts)):
        counts.n[c] += weight


def _check_divide(counts: Counts, weight: float) -> None:
    if not 0 < weight < np.inf:
        raise ObservationError(f"weight: expected a number above 0; got {weight!r}")


@checked_by(_check_divide)
@njit(cache=True, borrows=True)
def divide(counts: Counts, weight: float) -> None:
    """Divide all counts by ``weight``; the measures stay, since its logarithms cancel in each difference."""
    for location in range(len(counts.entries)):
        counts.entries[location] /= weight
    for c in range(len(counts.n)):
        counts.sums[c] /= weight
        counts.n[c] /= weight


def _check_event(counts: Counts, event: int, single: int) -> None:
    if not (isinstance(event, (int, np.integer)) and 0 <= event < len(counts.of_event)):
        raise ObservationError(f"events are numbered from 0 to {len(counts.of_event) - 1}; got {event!r}")


@checked_by(_check_event)
@njit(cache=True, borrows=True)
def local_variance(counts: Counts, event: int, single: int) -> float:
    """Variance of the measure's value from transition to transition, nats squared: n times that of the estimate.

    Args:
        counts: Tables.
        event: Number of the event.
        single: 1 for SAC; 0 for T^C, which leaves T_S out.
    """
    layout, of_event = counts.layout, counts.of_event
    own, of_action = of_event[event, OWN], of_event[event, OF_ACTION]
    of_sensor, alone = of_event[event, OF_SENSOR], of_event[event, ALONE]
    width, per_sensor = np.int64(layout[own, WIDTH]), np.int64(layout[own, PER_SENSOR])
    results, actions, sensors = width - 1, per_sensor // width, np.int64(layout[own, PER_RESULT]) // per_sensor
    mean = square = 0.0
    for k in range(results):
        for k_next in range(results):
            chance = _share(counts, alone, k, ANY, ANY, k_next)
            for i in range(sensors):
                of_s = _share(counts, of_sensor, k, i, ANY, k_next)
                if of_s == 0.0:
                    continue
                for j in range(actions):
                    both = _share(counts, own, k, i, j, k_next)
                    if both == 0.0:
                        continue
                    local = np.log(both / _share(counts, of_action, k, ANY, j, k_next))
                    if single:
                        local -= np.log(of_s / chance)
                    count = counts.entries[_location(layout, own, k, i, j) + np.uint64(1 + k_next)]
                    mean += count * local
                    square += count * local * local
    variance: float = square / counts.n[own] - (mean / counts.n[own]) ** 2
    return variance


@njit(cache=True, borrows=True, forceinline=True)
def _share(counts: Counts, context: int, r: int, s: int, a: int, r_next: int) -> float:
    """p(r' | r, v); 0 where it never occurred."""
    row, entries = _location(counts.layout, context, r, s, a), counts.entries
    share: float = entries[row + np.uint64(1 + r_next)] / entries[row] if entries[row] > 0.0 else 0.0
    return share
