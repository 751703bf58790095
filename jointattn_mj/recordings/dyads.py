"""Many dyads: a value for each, their mean with an interval over dyads, and groups of dyads compared.

The dyad is the unit: steps of different dyads are never put into one table.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from math import comb, factorial, prod
from typing import Any

import numpy as np

from jointattn_mj.contingency.information import Measure
from jointattn_mj.contingency.lagged import Timing
from jointattn_mj.contingency.scan import LagScan, ScanSurrogates, in_turn, lag_scan, scan_surrogates
from jointattn_mj.contingency.series import Coded
from jointattn_mj.contingency.significance import Significance, TestOptions, assess_steps
from jointattn_mj.contingency.table import Steps
from jointattn_mj.errors import SeriesError
from jointattn_mj.io.results import bracket, number

FEWEST = 2
"""Dyads of a group that can be compared."""
DRAWS = 49_999
"""Times that a surrogate of each dyad is put together to a group by chance."""
LEAST_P = 2 / (1 + DRAWS)
"""No two-sided p over dyads is lower."""
LEVEL = 0.95
"""Coverage of intervals over dyads."""
ALL = "all"
"""Name of the group of all dyads."""
MOST_EXACT = 20_000
"""Up to so many ways to part dyads into two groups, all are tried."""


@dataclass(frozen=True)
class Group:
    """The dyads of one group, or all."""

    name: str
    dyads: int
    mean: float
    """Mean of the effective values."""
    sd: float
    interval: tuple[float, float]
    """Of the mean, over dyads (see ``over_dyads``); NaN for one dyad."""
    p: float
    """Two-sided, of the mean: at most .05 exactly where 0 lies outside the interval. Of one dyad its own."""


@dataclass(frozen=True)
class GroupComparison:
    """Two groups, or all of them at once."""

    first: str
    second: str
    """``all`` for a test of all groups at once."""
    difference: float
    """Of the means; of all groups: the share of variance between them (eta squared)."""
    p: float
    """Two-sided, by permutation of the dyads over the groups."""


@dataclass(frozen=True, repr=False)
class DyadResult:
    """A measure dyad by dyad."""

    measure: str
    names: tuple[str, ...]
    values: tuple[Significance, ...]
    groups: tuple[Group, ...]
    """All dyads together, then each group."""
    comparisons: tuple[GroupComparison, ...]
    group_of: tuple[str, ...] = ()
    by: str = "group"
    """What groups are called together."""

    def of_group(self, group: Group) -> list[Significance]:
        """Values of the recordings of a group."""
        of = [f"{self.by} {name}" for name in self.group_of] if group.name != ALL else [ALL] * len(self.values)
        return [value for value, name in zip(self.values, of, strict=True) if name == group.name]

    def __repr__(self) -> str:
        return f"DyadResult({self.measure}, {len(self.names)} recordings, {len(self.groups)} groups)"

    def rows(self) -> list[dict[str, Any]]:
        """Value, interval and p of each dyad, a row each."""
        return [
            {
                "measure": self.measure, "recording": name, **({"group": self.group_of[i]} if self.group_of else {}),
                "plug_in": value.value, "effective": value.corrected,
                "low": value.interval[0], "high": value.interval[1],
                "z": value.z, "p": value.p, "transitions": value.transitions, "method": value.method,
            }
            for i, (name, value) in enumerate(zip(self.names, self.values, strict=True))
        ]  # fmt: skip

    def out_of_reach(self, alpha: float) -> list[str]:
        """Why no comparison can be significant: there are too few ways to part so few dyads into these groups."""
        sizes = [group.dyads for group in self.groups[1:]]
        if len(sizes) < 2 or min(sizes) < FEWEST or least_p_of_groups(sizes) <= alpha:
            return []
        counts = f"{', '.join(map(str, sizes[:-1]))} and {sizes[-1]}"
        return [
            f"groups of {counts} recordings can be parted in so few ways that no p of their comparison is below "
            f"{least_p_of_groups(sizes):.2g}; more recordings are needed"
        ]

    def lines(self) -> list[str]:
        """The groups and their comparison, in words."""
        lines = [
            f"{self.measure}, {group.name}: mean effective value {number(group.mean)} {bracket(group.interval)} over "
            f"{group.dyads} recordings, p {_p(group.p)}"
            for group in self.groups
        ]
        for comparison in self.comparisons:
            what = (
                f"{comparison.first} against {comparison.second}"
                if comparison.second != "all"
                else f"all by {comparison.first}"
            )
            size = "difference" if comparison.second != "all" else "eta squared"
            lines.append(f"{self.measure}, {what}: {size} {number(comparison.difference)}, p {_p(comparison.p)}")
        return lines


def by_dyad(
    given: Steps,
    measure: Measure,
    names: Mapping[int, str],
    options: TestOptions,
    unit: float,
    seed: np.random.SeedSequence,
    group_of: Mapping[str, str] | None = None,
    by: str = "group",
    progress: Callable[[int], object] = lambda done: None,
) -> DyadResult:
    """Measure each dyad on its own, and compare groups of dyads.

    Args:
        given: The transitions; ``groups`` says which pieces are of one recording.
        measure: What is measured.
        names: Name of each recording by its number in ``given.groups``.
        options: How each dyad is tested; partners are not possible within one.
        unit: Natural logarithm of the base.
        seed: Of surrogates, resamples and permutations.
        group_of: Group of each recording by its name; None: no comparison.
        by: What the groups are called together, such as ``age``.
        progress: Called with the number of surrogates or resamples drawn since the last call.

    Raises:
        SeriesError: There is one recording only, or a recording without a group.
    """
    dyads = split(given)
    if len(dyads) < FEWEST:
        raise SeriesError(
            f"values by recording need at least {FEWEST} recordings; got {len(dyads)}. Each file of a folder is "
            "one, and `recording` names a column that tells them apart"
        )
    streams = seed.spawn(len(dyads) + 2)
    called = tuple(names.get(number, str(number)) for number, _ in dyads)
    values = tuple(
        assess_steps(dyad, measure, options, unit, np.random.default_rng(stream), progress)
        for (_, dyad), stream in zip(dyads, streams, strict=False)
    )
    of: tuple[str, ...] = ()
    if group_of is not None:
        without = [name for name in called if name not in group_of]
        if without:
            raise SeriesError(f"recording {without[0]!r} has no {by}; there is one for {', '.join(list(group_of)[:5])}")
        of = tuple(group_of[name] for name in called)
    effective = np.array([value.corrected for value in values])
    kinds = kinds_of(of)
    labels = np.array(of)
    members = {ALL: np.ones(len(values), bool)}
    if len(kinds) > 1:
        members |= {f"{by} {kind}": labels == kind for kind in kinds}
    chance, permuted = (np.random.default_rng(stream) for stream in streams[-2:])
    groups = [
        _group(name, [value for value, its in zip(values, of_group, strict=True) if its], chance)
        for name, of_group in members.items()
    ]
    comparisons = compare(effective, labels, kinds, by, options.surrogates, permuted)
    return DyadResult(measure.name, called, values, tuple(groups), tuple(comparisons), of, by)


def split(given: Steps) -> list[tuple[int, Steps]]:
    """The recordings of some transitions, each with its number."""
    bounds = given.target.bounds
    numbers = np.arange(len(bounds) - 1) if given.groups is None else given.groups
    first = np.flatnonzero(np.concatenate([[True], np.diff(numbers) != 0]))
    last = np.append(first[1:], len(numbers))
    parts = []
    for start, stop in zip(first.tolist(), last.tolist(), strict=True):
        cut = partial(_cut, bounds=bounds[start : stop + 1])
        condition = None if given.condition is None else cut(given.condition)
        history = None if given.history is None else cut(given.history)
        groups = np.zeros(stop - start, np.int64)
        parts.append((int(numbers[start]), Steps(cut(given.source), cut(given.target), condition, groups, history)))
    return parts


def _cut(coded: Coded, bounds: np.ndarray) -> Coded:
    return replace(coded, codes=coded.codes[bounds[0] : bounds[-1]], bounds=bounds - bounds[0])


def kinds_of(groups: Iterable[str]) -> list[str]:
    """The different groups in their order: numbers ascending, then words."""
    return sorted({str(group) for group in groups}, key=_numeric)


def compare(
    values: np.ndarray,
    labels: np.ndarray,
    kinds: Sequence[str],
    by: str,
    permutations: int,
    rng: np.random.Generator,
) -> list[GroupComparison]:
    """Compare groups of dyads by permuting dyads over them.

    Args:
        values: One for each dyad (n,).
        labels: Group of each dyad (n,).
        kinds: The groups.
        by: What they are called together.
        permutations: Number of permutations, where there are too many to try all.
        rng: Draws them.

    Returns:
        With two groups their difference; with more, all at once and then each pair, not corrected for their number.
    """
    if len(kinds) < 2:
        return []
    comparisons = []
    if len(kinds) > 2:
        member = (labels[:, None] == np.array(kinds)).astype(float)
        observed = float(_eta(values[None], member)[0])
        drawn = _eta(rng.permuted(np.tile(values, (permutations, 1)), axis=1), member)
        comparisons.append(
            GroupComparison(by, "all", observed, float((1 + np.sum(drawn >= observed - 1e-12)) / (1 + len(drawn))))
        )
    for first, second in combinations(kinds, 2):
        a, b = values[labels == first], values[labels == second]
        p = _two_sided(a, b, permutations, rng) if min(len(a), len(b)) >= FEWEST else float("nan")
        comparisons.append(GroupComparison(first, second, float(a.mean() - b.mean()), p))
    return comparisons


def least_p_of_groups(sizes: Sequence[int]) -> float:
    """The lowest p of a comparison of groups of these sizes, where each way of parting the dyads counts once.

    Args:
        sizes: Dyads of each group.
    """
    ways, left = 1, sum(sizes)
    for size in sizes:
        ways, left = ways * comb(left, size), left - size
    same = prod(factorial(sizes.count(size)) for size in set(sizes))  # groups of one size can change their names
    return same / ways


def _two_sided(a: np.ndarray, b: np.ndarray, permutations: int, rng: np.random.Generator) -> float:
    """p of the difference of two means; all ways are tried where they are few."""
    both, size = np.concatenate([a, b]), len(a)
    exact = comb(len(both), size) <= MOST_EXACT
    if exact:
        sums = both[np.array(list(combinations(range(len(both)), size)))].sum(1)
    else:
        sums = rng.permuted(np.tile(both, (permutations, 1)), axis=1)[:, :size].sum(1)
    differences = np.abs(sums / size - (both.sum() - sums) / len(b))
    extreme = int(np.sum(differences >= abs(a.mean() - b.mean()) - 1e-12))
    return extreme / len(sums) if exact else (1 + extreme) / (1 + permutations)


def _eta(values: np.ndarray, member: np.ndarray) -> np.ndarray:
    """Share of the variance between groups (k,), for values (k, n) and membership (n, groups)."""
    deviations = values - values.mean(1, keepdims=True)
    whole = (deviations**2).sum(1)
    between = ((deviations @ member) ** 2 / member.sum(0)).sum(1)
    share: np.ndarray = np.divide(between, whole, out=np.zeros(len(values)), where=whole > 0)
    return share


def over_dyads(
    values: np.ndarray, nulls: Sequence[np.ndarray], rng: np.random.Generator, level: float = LEVEL
) -> tuple[tuple[float, float], float]:
    """Interval of the mean over dyads, and p of a mean so far from 0 by chance; both say the same.

    Both come from t, the mean in its standard errors over dyads. What t is by chance is known from the dyads' own
    surrogates, one of each put together at random. Student's t would be too seldom large: contingency by chance is
    often a little below its mean and seldom far above. ``pytest -m slow tests/contingency/test_calibration.py``
    measures false alarms and what intervals hold.

    Args:
        values: Effective values (n,).
        nulls: Surrogates of each dyad, each (m,), less their mean.
        rng: Puts them together.
        level: Coverage of the interval; p is at most 1 - level exactly where 0 lies outside it.

    Returns:
        Interval and p, two-sided.
    """
    drawn = np.stack([rng.choice(null, DRAWS) for null in nulls])
    error, observed = _standard_error(values), _in_errors(values[:, None])[0]
    by_chance = np.sort(_in_errors(drawn))
    above = DRAWS - np.searchsorted(by_chance, observed, "left")
    below = np.searchsorted(by_chance, observed, "right")
    allowed = max(int((1 - level) / 2 * (DRAWS + 1) + 1e-9), 1)
    low, high = by_chance[DRAWS - allowed], by_chance[allowed - 1]
    mean = float(values.mean())
    interval = float(mean - low * error), float(mean - high * error)
    return interval, min(1.0, 2 * (1 + int(min(above, below))) / (1 + DRAWS))


def scan_over_dyads(
    given: Steps,
    measure: Measure,
    lags: Sequence[int],
    timing: Timing,
    options: TestOptions,
    unit: float,
    seed: np.random.SeedSequence,
    progress: Callable[[int], object] = lambda done: None,
) -> LagScan:
    """Means over dyads at several lags; steps of different dyads are never put into one table.

    The means are held against means of the dyads' surrogates: p is of means so high if no dyad were contingent at any
    lag. A few dyads are enough for that, while what holds for dyads in general needs more of them (``over_dyads``).

    Args:
        given: The series.
        measure: What is measured.
        lags: Steps from source to result.
        timing: Histories.
        options: How each dyad is tested.
        unit: Natural logarithm of the base.
        seed: Of surrogates.
        progress: Called with the number of surrogates drawn since the last call.

    Raises:
        SeriesError: Bad lags, or a dyad that is shorter than the longest one.
    """
    dyads = split(given)
    streams = seed.spawn(len(dyads) + 1)
    told = in_turn(progress, len(dyads))
    scans = [
        scan_surrogates(dyad, measure, lags, timing, options, unit, np.random.default_rng(stream), told)
        for (_, dyad), stream in zip(dyads, streams, strict=False)
    ]
    count = max(len(scan.null) for scan in scans)
    rng = np.random.default_rng(streams[-1])
    nulls = [scan.null if len(scan.null) == count else rng.choice(scan.null, count) for scan in scans]
    together = ScanSurrogates(
        np.mean([scan.value for scan in scans], 0), np.mean(nulls, 0), sum(scan.transitions for scan in scans),
        " or ".join(sorted({scan.method for scan in scans})),
    )  # fmt: skip
    return lag_scan(lags, together, options.level, len(scans))


def _standard_error(values: np.ndarray) -> np.ndarray:
    """Of the mean over the first axis."""
    error: np.ndarray = values.std(0, ddof=1) / np.sqrt(len(values))
    return error


def _in_errors(values: np.ndarray) -> np.ndarray:
    """Means over dyads in their standard errors, for values (n, k); where these are 0, infinite or 0 as the mean is."""
    mean, error = values.mean(0), _standard_error(values)
    with np.errstate(divide="ignore"):
        t: np.ndarray = np.divide(mean, error, out=np.zeros(len(mean)), where=(error > 0) | (mean != 0))
    return t


def _group(name: str, dyads: Sequence[Significance], rng: np.random.Generator) -> Group:
    values = np.array([dyad.corrected for dyad in dyads])
    if len(dyads) == 1:
        return Group(name, 1, float(values[0]), float("nan"), (float("nan"), float("nan")), dyads[0].p)
    interval, p = over_dyads(values, [dyad.null - dyad.null_mean for dyad in dyads], rng)
    return Group(name, len(dyads), float(values.mean()), float(values.std(ddof=1)), interval, p)


def _p(p: float) -> str:
    return "< 0.0001" if p < 0.0001 else f"{p:.4f}"


def _numeric(label: str) -> tuple[int, float, str]:
    """Numbers ascending, then words."""
    try:
        return 0, float(label), label
    except ValueError:
        return 1, 0.0, label
