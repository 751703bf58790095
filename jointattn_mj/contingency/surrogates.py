"""Surrogates: what a measure is worth by chance, with the source permuted among transitions of the same context.

Which transitions change places is decided here; the drawing itself is in ``permutation``.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from jointattn_mj.contingency.information import Measure
from jointattn_mj.contingency.permutation import plain, tables, within
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

    source: np.ndarray
    after: np.ndarray
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
    """Positions of the transitions that are permuted among each other, group by group."""
    group_bounds: np.ndarray

    permute: Permute

    @property
    def exchangeable(self) -> int:
        """Transitions whose source can change places with another value; where there are few, nothing can be shown."""
        bounds = self.bounds if self.permute == "context" else self.group_bounds
        source = self.source if self.permute == "context" else self.source[self.groups]
        lowest, highest = (extreme.reduceat(source, bounds[:-1]) for extreme in (np.minimum, np.maximum))
        return int(np.diff(bounds)[highest > lowest].sum())

    def draw(
        self, count: int, rng: np.random.Generator, progress: Callable[[int], object] = lambda done: None
    ) -> np.ndarray:
        """Plug-in values (count,), in nats, of so many surrogates.

        ``progress`` is told how many were done since its last call.
        """
        values = np.empty(count)
        shared = (
            self.source, self.after, self.sizes[0], self.sizes[1], self.bounds, self.contexts, self.fixed,
            self.with_less, tables(len(self.source)),
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

    Raises:
        SeriesError: Source and target have too many values.
    """
    columns, sizes = steps.columns(), steps.sizes
    which = np.zeros(steps.transitions, np.int64) if across_recordings else steps.recordings()

    def keys(axes: str) -> np.ndarray:
        chosen = [AXES.index(axis) for axis in axes]
        if not chosen:
            return np.zeros(len(which), np.int64)
        return distinct(*combined([columns[i] for i in chosen], [sizes[i] for i in chosen])).which

    fine, coarse = keys(measure.given), keys(measure.less or "")
    strata = fine if permute == "plain" else combined([fine, which], [fine.max() + 1, which.max() + 1])[0]
    order = _stable_order(strata)
    values = [distinct(columns[i][order], sizes[i]) for i in (2, 3)]
    (sources, source), (afters, after) = ((one.keys, one.which) for one in values)
    if len(sources) * len(afters) > MOST_CELLS:
        raise SeriesError(
            f"a source of {len(sources)} and a target of {len(afters)} values have too many combinations for "
            "surrogates; sort the values into fewer bins"
        )
    bounds = _edges(strata[order])
    contexts = np.stack([fine, coarse])[:, order[bounds[:-1]]].T.copy()
    fixed = _fixed(fine[order], after) - (0.0 if measure.less is None else _fixed(coarse[order], after))
    groups = _stable_order(which[order])
    stratum = np.repeat(np.arange(len(bounds) - 1), np.diff(bounds))
    margins = (*_margin(stratum, source, len(sources)), *_margin(stratum, after, len(afters)))
    return Surrogates(
        source, after, (len(sources), len(afters)), bounds, contexts, fixed, measure.less is not None, margins,
        groups, _edges(which[order][groups]), permute,
    )  # fmt: skip


def _stable_order(numbers: np.ndarray) -> np.ndarray:
    """As ``numpy.argsort``, stable; few different numbers are sorted by radix, which takes a fifth of the time."""
    small = numbers.astype(np.uint16) if numbers.max() < 2**16 else numbers
    return np.argsort(small, kind="stable")


def _edges(ordered: np.ndarray) -> np.ndarray:
    """Where runs of equal values begin, and the end."""
    return np.concatenate([[0], np.flatnonzero(np.diff(ordered)) + 1, [len(ordered)]])


def _fixed(context: np.ndarray, after: np.ndarray) -> float:
    """Sum of c ln c over the contexts, less that over (context, n)."""
    afters = int(after.max()) + 1
    inner = distinct(context * afters + after, (int(context.max()) + 1) * afters).counts
    outer = np.bincount(context)
    outer = outer[outer > 0]
    return float(outer @ np.log(outer) - inner @ np.log(inner))


def _margin(stratum: np.ndarray, value: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values and counts in each stratum, and where each stratum's begin."""
    entries = distinct(stratum * size + value, (int(stratum[-1]) + 1) * size)
    keys, counts = entries.keys, entries.counts
    bounds = np.searchsorted(keys, np.arange(stratum[-1] + 2) * size)
    return keys % size, counts, bounds
