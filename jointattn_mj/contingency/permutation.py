"""Permutations of a source, drawn and measured, as compiled functions.

A permutation within a context draws a table of (s, r') with the margins that were observed. Where a context holds many
transitions and few values, the table is drawn entry by entry from hypergeometric distributions, which costs little more
for a million transitions than for a thousand; elsewhere the source is shuffled.
"""

import numpy as np

from jointattn_mj.errors import ObservationError
from jointattn_mj.guards.border import checked_by
from jointattn_mj.io.compiled import njit

SHUFFLE = 6
"""Strata with fewer transitions than so many for each hypergeometric draw are shuffled: that is faster there."""


def shuffles(bounds: np.ndarray, source_bounds: np.ndarray, after_bounds: np.ndarray) -> np.ndarray:
    """Which strata (k,) are shuffled, and not drawn from their margins.

    Args:
        bounds: (k + 1,) where the transitions of each stratum begin.
        source_bounds: (k + 1,) where its values of s begin.
        after_bounds: (k + 1,) where its values of n begin.
    """
    choices = (np.diff(source_bounds) - 1) * (np.diff(after_bounds) - 1)
    shuffled: np.ndarray = (choices > 0) & (np.diff(bounds) < SHUFFLE * choices)
    return shuffled


Room = tuple[np.ndarray, np.ndarray]
"""A table, flat, and a list of its entries in use."""


def tables(n: int) -> np.ndarray:
    """c ln c and ln c! for c = 0..n: (2, n + 1)."""
    both = np.zeros((2, n + 1))  # filled in place, as n may be millions
    both[0, 1:] = np.arange(1, n + 1)
    np.log(both[0, 1:], out=both[1, 1:])
    both[0] *= both[1]
    np.cumsum(both[1], out=both[1])
    return both


def _check_draw(good: int, bad: int, drawn: int, log_factorial: np.ndarray, u: float) -> None:
    if not (min(good, bad, drawn) >= 0 and drawn <= good + bad < len(log_factorial) and 0 <= u <= 1):
        raise ObservationError(
            f"expected counts of 0 or more, at most {len(log_factorial) - 1} together, and u from 0 to 1; "
            f"got {good}, {bad}, {drawn}, {u}"
        )


@checked_by(_check_draw)
@njit(cache=True)
def hypergeometric(good: int, bad: int, drawn: int, log_factorial: np.ndarray, u: float) -> int:
    """How many of ``drawn`` are good: the quantile for u in 0..1, counted from the mode outwards.

    Args:
        good: Number of good ones there are.
        bad: Number of others.
        drawn: How many are drawn of both.
        log_factorial: (n + 1,) log k! for k from 0 to the sum of both.
        u: Uniform in 0..1.
    """
    low, high = max(0, drawn - bad), min(good, drawn)
    if low == high:
        return low
    total = good + bad
    mode = min(max((drawn + 1) * (good + 1) // (total + 2), low), high)
    up = down = mode
    above = below = np.exp(
        log_factorial[good] - log_factorial[mode] - log_factorial[good - mode]
        + log_factorial[bad] - log_factorial[drawn - mode] - log_factorial[bad - drawn + mode]
        - log_factorial[total] + log_factorial[drawn] + log_factorial[total - drawn]
    )  # fmt: skip
    u -= above
    while u >= 0 and max(above, below) > 1e-18:
        if up < high:
            above *= (good - up) * (drawn - up) / ((up + 1) * (bad - drawn + up + 1))
            up += 1
            u -= above
            if u < 0:
                return up
        else:
            above = 0.0
        if down > low:
            below *= down * (bad - drawn + down) / ((good - down + 1) * (drawn - down + 1))
            down -= 1
            u -= below
            if u < 0:
                return down
        else:
            below = 0.0
    return mode


@njit(cache=True)
def _shuffle(values: np.ndarray, rng: np.random.Generator) -> None:
    for last in range(len(values) - 1, 0, -1):
        other = int(rng.random() * (last + 1))
        values[last], values[other] = values[other], values[last]


@njit(cache=True)
def _add(table: np.ndarray, touched: np.ndarray, used: int, entry: int, count: int) -> int:
    """Add to an entry; returns how many entries are in use."""
    if table[entry] == 0 and count > 0:
        touched[used] = entry
        used += 1
    table[entry] += count
    return used


@njit(cache=True)
def _settle(
    table: np.ndarray, touched: np.ndarray, used: int, rows: np.ndarray, afters: int, xlogx: np.ndarray
) -> float:
    """Sum of c ln c over the entries less that over their rows."""
    total = 0.0
    for i in range(used):
        count = table[touched[i]]
        total += xlogx[count]
        rows[touched[i] // afters] += count
    for i in range(used):
        row = touched[i] // afters
        total -= xlogx[rows[row]]
        rows[row] = 0
    return total


@njit(cache=True)
def _close(
    fine: Room, coarse: Room, used: np.ndarray, contexts: np.ndarray, stratum: int, with_less: bool,
    rows: np.ndarray, afters: int, xlogx: np.ndarray,
) -> float:  # fmt: skip
    """After a stratum: settle the contexts that end with it. Returns what they add, and entries in use."""
    total = 0.0
    last = stratum + 1 == len(contexts)
    if last or contexts[stratum + 1, 0] != contexts[stratum, 0]:
        table, touched = fine
        total += _settle(table, touched, used[0], rows, afters, xlogx)
        for i in range(used[0]):
            entry = touched[i]
            if with_less:
                used[1] = _add(coarse[0], coarse[1], used[1], entry, table[entry])
            table[entry] = 0
        used[0] = 0
        if with_less and (last or contexts[stratum + 1, 1] != contexts[stratum, 1]):
            table, touched = coarse
            total -= _settle(table, touched, used[1], rows, afters, xlogx)
            for i in range(used[1]):
                table[touched[i]] = 0
            used[1] = 0
    return total


@njit(cache=True)
def _room(n: int, sources: int, afters: int) -> Room:
    """An empty table and a list of its entries in use."""
    entries = sources * afters
    return np.zeros(entries, np.int64), np.empty(min(n, entries) + 1, np.int64)


@njit(cache=True)
def within(
    values: np.ndarray, rng: np.random.Generator, source: np.ndarray, after: np.ndarray, sources: int, afters: int,
    bounds: np.ndarray, contexts: np.ndarray, fixed: float, with_less: bool, tables: np.ndarray,
    source_values: np.ndarray, source_counts: np.ndarray, source_bounds: np.ndarray,
    after_values: np.ndarray, after_counts: np.ndarray, after_bounds: np.ndarray,
) -> None:  # fmt: skip
    """Fill ``values`` with surrogates permuted within the strata.

    Args:
        values: (count,) is filled: plug-in values, nats.
        rng: Draws the surrogates.
        source: (n,) values of s, sorted by stratum.
        after: (n,) values of the next r, likewise.
        sources: Number of values of s.
        afters: Number of values of the next r.
        bounds: (k + 1,) where the strata begin and end.
        contexts: (k, 2) finer and coarser context of each stratum.
        fixed: The part that no permutation changes, nats times transitions.
        with_less: Whether the measure takes the coarser context away.
        tables: As ``tables`` gives them, for tables drawn from their margins.
        source_values: Values of s that occur in each stratum, one stratum after the other.
        source_counts: How often each of them does.
        source_bounds: (k + 1,) where those of a stratum begin and end.
        after_values: Likewise of the next r.
        after_counts: Likewise.
        after_bounds: Likewise.
    """
    n = bounds[-1]
    fine, coarse = _room(n, sources, afters), _room(n, sources, afters)
    rows, used, shuffled = np.zeros(sources, np.int64), np.zeros(2, np.int64), source.copy()
    left = np.empty(afters, np.int64)
    for i in range(len(values)):
        total = fixed
        for k in range(len(contexts)):
            s0, s1, n0, n1 = source_bounds[k], source_bounds[k + 1], after_bounds[k], after_bounds[k + 1]
            start, stop = bounds[k], bounds[k + 1]
            if s1 - s0 > 1 and n1 - n0 > 1 and stop - start < SHUFFLE * (s1 - s0 - 1) * (n1 - n0 - 1):
                _shuffle(shuffled[start:stop], rng)
                for t in range(start, stop):
                    used[0] = _add(fine[0], fine[1], used[0], shuffled[t] * afters + after[t], 1)
            else:
                left[: n1 - n0] = after_counts[n0:n1]
                remain = stop - start
                for s in range(s0, s1):
                    drawn, others = source_counts[s], remain
                    for j in range(n1 - n0):
                        others -= left[j]
                        count = left[j]
                        if s + 1 < s1:
                            count = hypergeometric(left[j], others, drawn, tables[1], rng.random())
                        entry = source_values[s] * afters + after_values[n0 + j]
                        used[0] = _add(fine[0], fine[1], used[0], entry, count)
                        left[j] -= count
                        drawn -= count
                        if drawn == 0:
                            break
                    remain -= source_counts[s]
            total += _close(fine, coarse, used, contexts, k, with_less, rows, afters, tables[0])
        values[i] = total / n


@njit(cache=True)
def plain(
    values: np.ndarray, rng: np.random.Generator, source: np.ndarray, after: np.ndarray, sources: int, afters: int,
    bounds: np.ndarray, contexts: np.ndarray, fixed: float, with_less: bool, tables: np.ndarray,
    groups: np.ndarray, group_bounds: np.ndarray,
) -> None:  # fmt: skip
    """Fill ``values`` with surrogates permuted within the groups, whatever their contexts.

    Args:
        values: (count,) is filled: plug-in values, nats.
        rng: Draws the surrogates.
        source: (n,) values of s, sorted by stratum.
        after: (n,) values of the next r, likewise.
        sources: Number of values of s.
        afters: Number of values of the next r.
        bounds: (k + 1,) where the strata begin and end.
        contexts: (k, 2) finer and coarser context of each stratum.
        fixed: The part that no permutation changes, nats times transitions.
        with_less: Whether the measure takes the coarser context away.
        tables: As ``tables`` gives them, for tables drawn from their margins.
        groups: (n,) positions of the transitions that change places with each other, group by group.
        group_bounds: (m + 1,) where the groups begin and end.
    """
    n = len(source)
    fine, coarse = _room(n, sources, afters), _room(n, sources, afters)
    rows, used = np.zeros(sources, np.int64), np.zeros(2, np.int64)
    shuffled, grouped = source.copy(), source[groups]
    for i in range(len(values)):
        total = fixed
        for g in range(len(group_bounds) - 1):
            _shuffle(grouped[group_bounds[g] : group_bounds[g + 1]], rng)
        for t in range(n):
            shuffled[groups[t]] = grouped[t]
        for k in range(len(contexts)):
            for t in range(bounds[k], bounds[k + 1]):
                used[0] = _add(fine[0], fine[1], used[0], shuffled[t] * afters + after[t], 1)
            total += _close(fine, coarse, used, contexts, k, with_less, rows, afters, tables[0])
        values[i] = total / n
