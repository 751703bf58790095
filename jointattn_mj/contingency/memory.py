"""Memory of series: how long a source and the changes of a target hang together, and what that does to a test.

A permutation within a context takes transitions as exchangeable. They are, if either the source or the target's next
value is fresh at every step. Where both have a memory, as two people's long looks do, the measure varies more by chance
than permutations of the source do.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from jointattn_mj.contingency.information import Measure
from jointattn_mj.contingency.series import Coded, combined, distinct
from jointattn_mj.contingency.table import AXES, Steps

MOST_STEPS = 2**19
"""Transitions that are looked at; of longer recordings the first ones."""
MOST_PAIRS = 24
"""Values of a variable, or pairs of one with a context, that are looked at: the most frequent ones."""
SMALL = 0.5
"""Autocorrelation below which a source counts as new."""


@dataclass(frozen=True)
class Memory:
    """How long a source and a result hang together in time, and what that does to a measure of the two."""

    inflation: float
    """Variance of the measure's score by chance, in units of what it would be if transitions were exchangeable: 1 and
    twice the sum over lags of the product of both autocorrelations (Bartlett 1935)."""
    noise: float
    """Standard deviation of ``inflation`` where nothing hangs together."""
    fresh_after: int
    """Transitions after which the source's autocorrelation is below ``SMALL``."""
    block: int
    """Mean length of blocks, in transitions, that keep the source's memory (Politis and White 2004)."""

    def exchangeable(self, limit: float) -> bool:
        """Whether the inflation differs from 1 by less than a factor ``limit``, or by no more than by chance (3 sd)."""
        return abs(self.inflation - 1) <= max(limit - 1, 3 * self.noise)


def memory(steps: Steps, measure: Measure) -> Memory:
    """Measure the memory of a source, and of the target's next value given its context, within recordings.

    Args:
        steps: The transitions.
        measure: Gives the context.
    """
    steps = _head(steps)
    columns, sizes, spans = steps.columns(), steps.sizes, steps.spans(whole=True)
    n = len(columns[0])
    chosen = [AXES.index(axis) for axis in measure.given]
    recording = steps.recordings()
    keys = [recording, *(columns[i] for i in chosen)]
    context = distinct(*combined(keys, [int(recording[-1]) + 1, *(sizes[i] for i in chosen)])).which
    source, after = columns[2], columns[3]
    longest = int(np.diff(spans).max())
    lags = max(1, min(longest // 4, 4096))
    whole = np.zeros(n, np.int64)
    situation = whole
    if chosen:
        situation = distinct(*combined(keys[1:], [sizes[i] for i in chosen])).which
    of_source, source_values = _autocorrelation(whole, source, context, spans, lags)
    of_after, after_values = _autocorrelation(situation, after, context, spans, lags)
    share = 1 - np.arange(1, lags + 1) / longest
    inflation = 1 + 2 * float(np.sum(share * of_source[1:] * of_after[1:]))
    freedom = max(1, source_values - 1) * max(1, after_values - 1)
    alone, _ = _autocorrelation(whole, source, recording, spans, lags)
    low = np.flatnonzero(alone < SMALL)
    return Memory(
        max(inflation, 0.0),
        2 * float(np.sqrt(lags / freedom)) / n,
        int(low[0]) if len(low) else lags,
        _block(alone, n),
    )


def _head(steps: Steps) -> Steps:
    """The first ``MOST_STEPS`` of a recording's steps, which tell its memory well enough."""
    bounds = steps.target.bounds
    if bounds[-1] <= MOST_STEPS:
        return steps
    last = int(np.searchsorted(bounds, MOST_STEPS - 1))
    bounds = np.append(bounds[:last], MOST_STEPS)

    def cut(coded: Coded) -> Coded:
        return replace(coded, codes=coded.codes[:MOST_STEPS], bounds=bounds)

    return Steps(
        cut(steps.source),
        cut(steps.target),
        None if steps.condition is None else cut(steps.condition),
        None if steps.groups is None else steps.groups[:last],
        None if steps.history is None else cut(steps.history),
    )


def _autocorrelation(
    within: np.ndarray, codes: np.ndarray, context: np.ndarray, spans: np.ndarray, lags: int
) -> tuple[np.ndarray, int]:
    """Autocorrelation of the values of ``codes`` less what the context leads to expect, and the number of values.

    Args:
        within: (n,) numbers from 0; only transitions with the same one are multiplied with each other.
        codes: (n,) values.
        context: (n,) numbers from 0; each value's mean in a context is taken off.
        spans: (k + 1,) where recordings begin, and the end.
        lags: Longest lag.

    Returns:
        (lags + 1,): the values' autocovariances are added up, each in units of its frequency, as in a chi-squared
        statistic, and divided by that at lag 0. Where nothing varies it is 0 at all other lags.
    """
    from scipy.fft import irfft, next_fast_len, rfft  # takes .1 s to import, and few recordings are tested

    values, codes = np.unique(codes, return_inverse=True)
    pairs, counts = np.unique(within * len(values) + codes, return_counts=True)
    order = np.argsort(-counts, kind="stable")[:MOST_PAIRS]
    sizes = np.maximum(np.bincount(context), 1)
    room = next_fast_len(int(np.diff(spans).max()) + lags + 1, real=True)
    power = np.zeros(room // 2 + 1)
    for pair, count in zip(pairs[order], counts[order], strict=True):
        indicator = (codes == pair % len(values)).astype(np.float64)
        indicator -= (np.bincount(context, indicator) / sizes)[context]
        indicator[within != pair // len(values)] = 0.0
        for start, stop in pairwise(spans.tolist()):
            power += np.abs(rfft(indicator[start:stop], room)) ** 2 / count
    total = irfft(power, room)[: lags + 1]
    if total[0] <= 1e-9:
        total = np.zeros(lags + 1)
        total[0] = 1.0
    correlation: np.ndarray = total / total[0]
    return correlation, len(values)


def _block(correlation: np.ndarray, n: int) -> int:
    """Mean block of a stationary bootstrap, by Politis and White (2004, with the correction of 2009)."""
    band = 2 * np.sqrt(np.log10(max(n, 2)) / n)
    quiet = max(5, int(np.sqrt(np.log10(max(n, 2)))))
    small = np.abs(correlation[1:]) < band
    last = len(correlation) - 1
    for lag in range(len(small) - quiet + 1):
        if small[lag : lag + quiet].all():
            last = lag
            break
    width = min(2 * max(last, 1), len(correlation) - 1)
    lags = np.arange(1, width + 1)
    taper = np.minimum(1, 2 * (1 - lags / width)) if width > 1 else np.ones(1)
    weighted = taper * correlation[1 : width + 1]
    slope, spectrum = 2 * np.sum(lags * weighted), 1 + 2 * np.sum(weighted)
    if spectrum <= 0:
        return 1
    length = (slope**2 / spectrum**2) ** (1 / 3) * n ** (1 / 3)
    return int(max(1, min(round(length), np.ceil(min(3 * np.sqrt(n), n / 3)))))
