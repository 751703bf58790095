"""The table of counts behind every measure: how often (r', r, s, a) came together, as a list of observed entries."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from math import prod

import numpy as np

from jointattn_mj.contingency.series import SMALL, Coded, Series, aligned, combined, distinct
from jointattn_mj.errors import SeriesError
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import shown

AXES = "rasn"
"""r: result before, a: action or other condition, s: source, n: result next. Marginals are named by these letters."""

DENSE = 2**16
"""A table of so many entries, or of two for every transition, is counted in place; a larger one by sorting."""
MOST_DENSE = 2**31
"""No table that is counted in place has more entries."""
BLOCK = 512
"""Pairs of transitions whose entries are looked up at a time, so that they stay in the fastest memory."""
PAIRED = 2**12
"""A table of two transitions in a row that has no more entries is counted in place of one of single transitions."""
LONG = 2**14
"""In arrays of so many steps codes are checked while they are counted, so that they come from memory once."""
FIRST = 2**12
"""So many of these tell how many codes there are; where a higher one comes later, all are looked at first after all."""


@dataclass(frozen=True)
class Entries:
    """The m observed entries of the table."""

    columns: np.ndarray
    """int64 (4, m): codes of r, a, s, n."""
    counts: np.ndarray
    """float64 (m,), each at least 1."""
    sizes: tuple[int, int, int, int]
    """Codes of each axis lie below these."""

    @property
    def transitions(self) -> int:
        """Number of transitions that were counted."""
        return int(self.counts.sum())

    def ids(self, axes: str) -> tuple[np.ndarray, int]:
        """Marginal entry of each entry (m,), numbered from 0, and a bound for these numbers. Not all need to occur."""
        if not axes:
            return np.zeros(len(self.counts), np.int64), 1
        chosen = [AXES.index(axis) for axis in axes]
        keys, bound = combined([self.columns[i] for i in chosen], [self.sizes[i] for i in chosen])
        if bound <= max(DENSE, 4 * len(keys)):
            return keys, bound
        occupied, keys = np.unique(keys, return_inverse=True)
        return keys, len(occupied)

    def marginal(self, axes: str) -> np.ndarray:
        """Count (m,) of the marginal over ``axes`` to which each entry belongs; over no axes: all transitions."""
        keys, bound = self.ids(axes)
        counts: np.ndarray = np.bincount(keys, self.counts, bound)
        return np.take(counts, keys)

    def distribution(self, axes: str) -> np.ndarray:
        """Counts (k,) of the k observed entries of the marginal."""
        keys, bound = self.ids(axes)
        counts = np.bincount(keys, self.counts, bound)
        return counts[counts > 0]

    def entropy(self, axes: str, given: str = "") -> float:
        """H(axes | given) in nats."""
        inner, outer = (self.marginal(names) for names in (axes + given, given))
        return float(self.counts @ np.log(outer / inner)) / self.transitions

    def information(self, given: str) -> np.ndarray:
        """Local information (m,) in nats that s gives on n in each entry: log p(n | s, given) / p(n | given)."""
        both, alone = self.marginal(given + "sn"), self.marginal(given)
        local: np.ndarray = np.log(both * alone / (self.marginal(given + "s") * self.marginal(given + "n")))
        return local


@dataclass(frozen=True)
class Steps:
    """Series that belong together; a variable that is not there has the one value 0."""

    source: Coded
    target: Coded
    condition: Coded | None = None
    groups: np.ndarray | None = None
    """int64 (k,): recordings with the same number are pieces of one; they follow each other. None: each is its own."""
    history: Coded | None = None
    """What stands on axis r: several past values of the target as one. None: its last value."""

    @property
    def sizes(self) -> tuple[int, int, int, int]:
        """Bounds of the codes of r, a, s, n."""
        before = self.history or self.target
        return before.size, self.condition.size if self.condition else 1, self.source.size, self.target.size

    @property
    def transitions(self) -> int:
        """T less one for each recording."""
        return len(self.target.codes) - len(self.target.bounds) + 1

    def columns(self) -> list[np.ndarray]:
        """Codes of r, a, s, n at each transition, each (n,)."""
        bounds = self.target.bounds.tolist()

        def taken(series: Coded, ahead: int) -> np.ndarray:
            parts = [series.codes[start + ahead : stop - 1 + ahead] for start, stop in pairwise(bounds)]
            return parts[0] if len(parts) == 1 else np.concatenate(parts)

        source = taken(self.source, 0)
        action = np.zeros(len(source), np.int64) if self.condition is None else taken(self.condition, 0)
        return [taken(self.history or self.target, 0), action, source, taken(self.target, 1)]

    def spans(self, whole: bool) -> np.ndarray:
        """Where the transitions of each piece of a recording begin, or of each ``whole`` recording, and the end."""
        starts = self.target.bounds - np.arange(len(self.target.bounds))
        if not whole or self.groups is None:
            return starts
        first = np.concatenate([[True], np.diff(self.groups) != 0, [True]])
        return np.compress(first, starts)

    def recordings(self) -> np.ndarray:
        """Number of the whole recording of each transition (n,), from 0."""
        lengths = np.diff(self.spans(whole=True))
        return np.repeat(np.arange(len(lengths)), lengths)

    def dense(self) -> np.ndarray | None:
        """Counts as an array over (r, a, s, n), or None where that would be large."""
        sizes = self.sizes
        total = prod(sizes)
        if total > DENSE and total > min(2 * self.transitions, MOST_DENSE):
            return None
        target, source = self.target, self.source
        if self.history is not None:
            keys = combined(self.columns(), sizes)[0]
            return np.bincount(keys, minlength=int(total)).reshape(sizes)
        condition = source.codes[:0] if self.condition is None else self.condition.codes
        return _counted(source.codes, target.codes, condition, target.bounds, sizes)

    def entries(self, dense: np.ndarray | None = None) -> Entries:
        """Count everything; ``dense`` is what that function gave, if it was called already."""
        dense = self.dense() if dense is None else dense
        if dense is None:
            return _sorted(self.columns(), self.sizes)
        occupied = np.flatnonzero(dense)
        return Entries(
            np.array(np.unravel_index(occupied, self.sizes)), dense.ravel()[occupied].astype(float), self.sizes
        )

    def entries_by_step(self) -> tuple[Entries, np.ndarray]:
        """The entries, and for each transition the number of its entry (n,)."""
        columns = self.columns()
        entries = distinct(*combined(columns, self.sizes))
        counts = entries.counts.astype(float)
        return Entries(np.array([column[entries.first] for column in columns]), counts, self.sizes), entries.which


def steps(
    source: Series, target: Series, condition: Series | None = None, groups: Sequence[int] | None = None
) -> Steps:
    """Check series that belong together; ``groups`` as in ``Steps``.

    Args:
        source: Series of the source: (T,) codes, or a list of such arrays, one a recording.
        target: Of what may depend on it, as long.
        condition: Of what was done, or of what else is known; None for none.
        groups: Number of the group of each recording; recordings of one group belong together.

    Raises:
        SeriesError: See ``series.code`` and ``series.aligned``.
    """
    if source is None or target is None:
        raise SeriesError("a source and a target are needed; got None")
    first, second, third = aligned(source=source, target=target, condition=condition)
    assert first is not None and second is not None
    return Steps(first, second, third, None if groups is None else _checked_groups(groups, len(second.bounds) - 1))


def acted(source: Series, condition: Series, target: Series, groups: Sequence[int] | None = None) -> Steps:
    """``steps`` with a condition that must be there: what was done.

    Args:
        source: Series of the source: (T,) codes, or a list of such arrays, one a recording.
        condition: Of what was done, as long.
        target: Of what may depend on both, as long.
        groups: Number of the group of each recording.

    Raises:
        SeriesError: As ``steps``, or there is none.
    """
    return steps(source, target, needed(condition), groups)


def needed(condition: Series | None) -> Series:
    """The condition.

    Raises:
        SeriesError: There is none.
    """
    if condition is None:
        raise SeriesError("an action, or another condition, is needed; got None")
    return condition


def counted_at_once(source: Series, target: Series, condition: Series | None) -> np.ndarray | None:
    """What ``Steps.dense`` gives of long arrays, whose codes are checked block by block.

    Args:
        source: (T,) codes, or whatever else ``steps`` takes.
        target: Likewise.
        condition: Likewise, or None.

    Returns:
        Counts as an array over (r, a, s, n); None for all that needs another look: shorter series, recordings, arrays
        of different types, codes that are wrong, high, or higher later than at the beginning.
    """
    if type(target) is not np.ndarray or target.ndim != 1 or len(target) < LONG:
        return None
    if target.dtype.kind not in "iub" or not target.dtype.isnative:
        return None
    given = [target, source] if condition is None else [target, source, condition]
    for series in given:
        if type(series) is not np.ndarray or series.shape != target.shape or series.dtype != target.dtype:
            return None
    without_sign = f"u{target.itemsize}"  # of the same bytes those that were negative are the largest
    codes = [np.ascontiguousarray(series).view(without_sign) for series in given]
    sizes = [int(part[:FIRST].max()) + 1 for part in codes]
    highest = 1 if target.dtype == bool else np.iinfo(target.dtype).max  # of int8 even these are small
    if max(sizes) > min(SMALL, highest + 1) or prod(sizes) * sizes[0] > DENSE:
        return None
    targets, sources, conditions = (*sizes, 1)[:3]
    known = codes[2] if condition is not None else codes[1][:0]
    return _counted(codes[1], codes[0], known, np.array([0, len(target)]), (targets, conditions, sources, targets))


def _counted(
    source: np.ndarray, target: np.ndarray, condition: np.ndarray, bounds: np.ndarray, sizes: tuple[int, ...]
) -> np.ndarray | None:
    """Counts as an array over (r, a, s, n).

    Args:
        source: (T,) codes, of a type without sign or none of them negative.
        target: Likewise.
        condition: Likewise, or none.
        bounds: Where recordings begin, and the end.
        sizes: Codes of r, a, s, n lie below these.

    Returns:
        None where a code does not.
    """
    kind, total, transitions = np.int32 if len(target) < 2**31 else np.int64, prod(sizes), len(target) - len(bounds) + 1
    table: np.ndarray = np.zeros(total, kind)
    paired = total * total // sizes[3]
    pairs = np.zeros(paired if paired <= min(PAIRED, transitions // 4) else 0, kind)
    if not _count(table, pairs, target, condition, source, bounds, *sizes[1:]):
        return None
    if len(pairs):
        by_step = pairs.reshape(-1, sizes[3], sizes[1] * sizes[2], sizes[3])
        table += by_step.sum((2, 3), kind).ravel()  # the first transition of each pair
        table += by_step.sum(0, kind).ravel()  # the second
    return table.reshape(sizes)


def _checked_groups(groups: Sequence[int], recordings: int) -> np.ndarray:
    """Numbers of the recordings, those of a group side by side."""
    try:
        numbers = np.asarray(groups)
    except (TypeError, ValueError):  # ragged
        numbers = np.zeros(())
    if (
        numbers.dtype.kind not in "iu"
        or numbers.shape != (recordings,)
        or len(np.unique(numbers)) != 1 + np.count_nonzero(np.diff(numbers))
    ):
        raise SeriesError(
            f"groups must number the {recordings} recordings, pieces of one side by side; got {shown(groups)}"
        )
    return numbers


def _sorted(columns: list[np.ndarray], sizes: tuple[int, int, int, int]) -> Entries:
    entries = distinct(*combined(columns, sizes))
    return Entries(np.array([column[entries.first] for column in columns]), entries.counts.astype(float), sizes)


def dense_information(table: np.ndarray, given: str) -> float:
    """I(n; s | given) of a table over (r, a, s, n), times its number of transitions, in nats."""
    others = tuple(i for i, axis in enumerate("ra") if axis not in given and table.shape[i] > 1)
    blocks = table.sum(axis=others) if others else table
    return float(_information(blocks.reshape(-1, *table.shape[2:]), _logarithms()))


@cache
def _logarithms() -> np.ndarray:
    """ln c for small c; that of 0 is never asked for."""
    return np.log(np.maximum(np.arange(4096), 1))


@njit(cache=True)
def _logarithm(count: int, logarithms: np.ndarray) -> float:
    logarithm: float = logarithms[count] if count < len(logarithms) else np.log(count)
    return logarithm


@njit(cache=True)
def _information(blocks: np.ndarray, logarithms: np.ndarray) -> float:
    """Sum of c ln(c n / (row column)) over the entries of all blocks (k, rows, columns); n is a block's sum."""
    total = 0.0
    rows, columns = np.empty(blocks.shape[1], np.int64), np.empty(blocks.shape[2], np.int64)
    for block in blocks:
        columns[:] = 0
        whole = 0
        for i in range(len(rows)):
            rows[i] = 0
            for j in range(len(columns)):
                rows[i] += block[i, j]
                columns[j] += block[i, j]
            whole += rows[i]
        for i in range(len(rows)):
            if rows[i] > 0 and rows[i] < whole:
                for j in range(len(columns)):
                    count = block[i, j]
                    if count > 0:
                        total += count * (
                            _logarithm(count, logarithms)
                            + _logarithm(whole, logarithms)
                            - _logarithm(rows[i], logarithms)
                            - _logarithm(columns[j], logarithms)
                        )
    return total


@njit(cache=True)
def _count(
    table: np.ndarray, pairs: np.ndarray, target: np.ndarray, condition: np.ndarray, source: np.ndarray,
    bounds: np.ndarray, conditions: int, sources: int, targets: int,
) -> bool:  # fmt: skip
    """Add every transition to ``table``, flat over (r, a, s, n); False, and counts of nothing, if a code is too high.

    Which entries they go to is worked out for a block of them, which the compiler does for several at once: half the
    time of one after the other, and a third with a condition.

    Args:
        table: Counts.
        pairs: Zeros, flat over (r, a, s, r', a', s', n) of two transitions in a row, which halve the time; or none.
        target: (T,) codes, of a type without sign or none of them negative.
        condition: (T,) likewise, or none.
        source: (T,) likewise.
        bounds: Where recordings begin, and the end.
        conditions: Codes of the condition lie below this.
        sources: Codes of the source lie below this.
        targets: Codes of the target lie below this.
    """
    step, two = np.uint64(1), np.uint64(2)  # unsigned: indices that compiled code need not test
    all_conditions, all_sources, all_targets = np.uint32(conditions), np.uint32(sources), np.uint32(targets)
    all_states = np.uint32(targets * conditions * sources)
    states, entries = np.empty(2 * BLOCK, np.uint32), np.empty(BLOCK, np.uint32)
    t, last = np.uint64(bounds[0]), np.uint64(bounds[-1] - 1)
    while t < last:
        n = min(np.uint64(2 * BLOCK), last - t)
        highest_target, highest_source = target[t + n], source[t + n]
        if len(condition):
            highest_condition = condition[t + n]
            for i in range(n):
                before, done, seen = target[t + i], condition[t + i], source[t + i]
                highest_target, highest_source = max(highest_target, before), max(highest_source, seen)
                highest_condition = max(highest_condition, done)
                state = np.uint32(before) * all_conditions + np.uint32(done)
                states[i] = state * all_sources + np.uint32(seen)
            if np.uint64(highest_condition) >= all_conditions:
                return False
        else:
            for i in range(n):
                before, seen = target[t + i], source[t + i]
                highest_target, highest_source = max(highest_target, before), max(highest_source, seen)
                states[i] = np.uint32(before) * all_sources + np.uint32(seen)
        if np.uint64(highest_target) >= all_targets or np.uint64(highest_source) >= all_sources:
            return False
        counted = np.uint64(0)
        if len(pairs):
            for pair in range(n // two):
                first = two * pair
                both = states[first] * all_states + states[first + step]
                entries[pair] = both * all_targets + np.uint32(target[t + first + two])
            for pair in range(n // two):
                pairs[entries[pair]] += 1
            counted = two * (n // two)
        for i in range(counted, n):
            table[np.uint64(states[i]) * all_targets + np.uint32(target[t + i + step])] += 1
        t += n
    for recording in range(1, len(bounds) - 1):  # what was counted from one recording into the next
        end = np.uint64(bounds[recording] - 1)
        row = np.uint64(target[end])
        if len(condition):
            row = row * all_conditions + np.uint32(condition[end])
        row = row * all_sources + np.uint32(source[end])
        table[row * all_targets + np.uint32(target[end + step])] -= 1
    return True
