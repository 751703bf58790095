"""Surrogates: what a measure is worth by chance, with the source permuted among transitions of the same context.

Which transitions change places is decided here; the drawing itself is in ``permutation``.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from jointattn_mj.contingency.information import Measure
from jointattn_mj.contingency.permutation import plain, shuffles, tables, within
from jointattn_mj.contingency.series import combined, distinct
from jointattn_mj.contingency.table import AXES, Steps
from jointattn_mj.errors import SeriesError

Permute = Literal["context", "plain"]
"""``context``: among transitions with the same r and, where the measure has a condition, the same a: ties between
source and context stay, and only what the source adds goes. ``plain``: among all, which breaks those ties too."""

MOST_CELLS = 2**25
"""Largest product of numbers of values of s and r that is drawn."""

BATCH = 50
"""Surrogates between two reports of progress."""


@dataclass(frozen=True)
class Surrogates:
    """What surrogates of one measure of some series are drawn from; ``plan`` makes it.

    Transitions are sorted by stratum; strata of one context lie together, and contexts of one coarser context.
    """

    transitions: int
    source: np.ndarray
    """Sorted by stratum; empty where tables are drawn in all strata, which needs no more than the margins."""
    after: np.ndarray
    """The same of n."""
    sizes: tuple[int, int]
    bounds: np.ndarray
    """(k + 1,) of the strata."""
    contexts: np.ndarray
    """(k, 2) finer and coarser context of each stratum."""
    fixed: float
    """The part that no permutation changes, nats times transitions."""
    with_less: bool
    margins: tuple[np.ndarray, ...]
    """Values of s and their counts in each stratum, and of n, as flat arrays with bounds."""
    groups: np.ndarray
    """For plain permutations: positions of the transitions that change places with each other, group by group."""
    group_bounds: np.ndarray

    permute: Permute

    @property
    def exchangeable(self) -> int:
        """Transitions whose source can change places with another value; where there are few, nothing can be shown."""
        if self.permute == "context":
            return int(np.diff(self.bounds)[np.diff(self.margins[2]) > 1].sum())
        source = self.source[self.groups]
        lowest, highest = (extreme.reduceat(source, self.group_bounds[:-1]) for extreme in (np.minimum, np.maximum))
        return int(np.diff(self.group_bounds)[highest > lowest].sum())

    def draw(
        self, count: int, rng: np.random.Generator, progress: Callable[[int], object] = lambda done: None
    ) -> np.ndarray:
        """Plug-in values (count,), in nats, of so many surrogates.

        ``progress`` is told how many were done since its last call.

        Args:
            count: Number of surrogates.
            rng: Draws them.
            progress: Is told how many were drawn since its last call.
        """
        values = np.empty(count)
        shared = (
            self.source, self.after, self.sizes[0], self.sizes[1], self.bounds, self.contexts, self.fixed,
            self.with_less, tables(self.transitions),
        )  # fmt: skip
        for start in range(0, count, BATCH):
            batch = values[start : start + BATCH]
            if self.permute == "context":
                within(batch, rng, *shared, *self.margins)
            else:
                plain(batch, rng, *shared, self.groups, self.group_bounds)
            progress(len(batch))
        return values


def plan(steps: Steps, measure: Measure, permute: Permute = "context", across_recordings: bool = False) -> Surrogates:
    """Sort transitions for ``measure``. The source is permuted within each recording, or among all of them.

    Args:
        steps: Transitions of all recordings.
        measure: What the surrogates are for.
        permute: Among which transitions the source changes places: those of one context, or all.
        across_recordings: Whether it may change places between recordings.

    Raises:
        SeriesError: Source and target have too many values.
    """
    columns, sizes = steps.columns(), steps.sizes
    n = steps.transitions
    recording = np.zeros(n, np.int32) if across_recordings else steps.recordings()
    # everything but the order of transitions follows from how often each combination comes
    entries = distinct(*combined([recording, *columns], [int(recording[-1]) + 1, *sizes]))
    combinations, weights, parts = (
        [column[entries.first] for column in columns],
        entries.counts,
        recording[entries.first],
    )

    def contexts_of(axes: str) -> np.ndarray:
        chosen = [AXES.index(axis) for axis in axes]
        if not chosen:
            return np.zeros(len(weights), np.int64)
        return distinct(*combined([combinations[i] for i in chosen], [sizes[i] for i in chosen])).which

    fine, coarse = contexts_of(measure.given), contexts_of(measure.less or "")
    strata = fine if permute == "plain" else combined([fine, parts], [int(fine.max()) + 1, int(parts.max()) + 1])[0]
    _, first, stratum = np.unique(strata, return_index=True, return_inverse=True)
    (sources, source), (afters, after) = (np.unique(combinations[i], return_inverse=True) for i in (2, 3))
    if len(sources) * len(afters) > MOST_CELLS:
        raise SeriesError(
            f"a source of {len(sources)} and a target of {len(afters)} values have too many combinations for "
            "surrogates; sort the values into fewer bins"
        )
    bounds = np.concatenate([[0], np.cumsum(_summed(stratum, weights))])
    contexts = np.stack([fine, coarse])[:, first].T.copy()
    fixed = _fixed(fine, after, weights) - (0.0 if measure.less is None else _fixed(coarse, after, weights))
    of_source, of_after = (_margin(stratum, codes, weights) for codes in (source, after))
    in_order = groups = np.zeros(0, np.int64)
    if permute == "plain" or shuffles(bounds, of_source[2], of_after[2]).any():
        in_order = _stable_order(stratum[entries.which])
        source, after = (codes[entries.which[in_order]] for codes in (source, after))
    if permute == "plain":
        groups = _stable_order(recording[in_order])
    empty = not len(in_order)
    return Surrogates(
        n, in_order if empty else source, in_order if empty else after, (len(sources), len(afters)), bounds, contexts,
        fixed, measure.less is not None, (*of_source, *of_after), groups, _edges(recording[in_order][groups]), permute,
    )  # fmt: skip


def _stable_order(numbers: np.ndarray) -> np.ndarray:
    """As ``numpy.argsort``, stable; few different numbers are sorted by radix, which takes a fifth of the time."""
    small = numbers.astype(np.uint16) if numbers.max() < 2**16 else numbers
    return np.argsort(small, kind="stable")


def _edges(ordered: np.ndarray) -> np.ndarray:
    """Where runs of equal values begin, and the end."""
    return np.concatenate([[0], np.flatnonzero(np.diff(ordered)) + 1, [len(ordered)]])


def _fixed(context: np.ndarray, after: np.ndarray, weights: np.ndarray) -> float:
    """Sum of c ln c over the contexts, less that over (context, n)."""
    afters = int(after.max()) + 1
    inner = _summed(np.unique(context * afters + after, return_inverse=True)[1], weights)
    outer = _summed(context, weights)
    return float(outer @ np.log(outer) - inner @ np.log(inner))


def _margin(stratum: np.ndarray, value: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values and counts in each stratum, and where each stratum's begin."""
    size = int(value.max()) + 1
    keys, which = np.unique(stratum * size + value, return_inverse=True)
    bounds = np.searchsorted(keys, np.arange(int(stratum.max()) + 2) * size)
    return keys % size, _summed(which, weights), bounds


def _summed(which: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Sums (k,), int64, of weights (m,) by number."""
    sums: np.ndarray = np.bincount(which, weights).astype(np.int64)
    return sums
