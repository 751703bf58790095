"""Intervals: transitions are drawn anew in blocks, so that what hangs together in time stays together."""

from collections.abc import Callable
from typing import Literal

import numpy as np

from jointattn_mj.contingency.information import Measure
from jointattn_mj.contingency.table import Entries, Steps
from jointattn_mj.io.compiled import njit

Resample = Literal["auto", "blocks", "recordings"]
"""``blocks``: of consecutive transitions, from anywhere, going on at a recording's start where it ends (circular block
bootstrap). ``recordings``: whole recordings. ``auto``: recordings where there are at least 10, otherwise blocks."""

ENOUGH_RECORDINGS = 10

MANY, MOST_COUNTS = 2**20, 2**22
"""Of more transitions, blocks are drawn that begin at multiples of their length: these are counted once, which takes a
hundredth of the time. Together they have at most so many counts."""

BATCH = 50
"""Resamples between two reports of progress."""


def chosen(steps: Steps, resample: Resample) -> Literal["blocks", "recordings"]:
    """What ``auto`` means for these series."""
    if resample != "auto":
        return resample
    return "recordings" if len(steps.spans(whole=True)) > ENOUGH_RECORDINGS else "blocks"


def default_block(transitions: int) -> int:
    """Transitions in a block: the cube root, at least 1."""
    return max(1, round(float(transitions ** (1 / 3))))


def resampled(
    steps: Steps,
    measure: Measure,
    count: int,
    rng: np.random.Generator,
    resample: Literal["blocks", "recordings"] = "blocks",
    block: int | None = None,
    progress: Callable[[int], object] = lambda done: None,
    counted: tuple[Entries, np.ndarray] | None = None,
) -> np.ndarray:
    """Plug-in values (count,), in nats, of so many resamples; ``block`` transitions at a time.

    ``counted`` is what ``steps.entries_by_step`` gave, where it was called already.

    Args:
        steps: Transitions of all recordings.
        measure: What is resampled.
        count: Number of resamples.
        rng: Draws them.
        resample: Draw blocks of neighbouring transitions, or whole recordings.
        block: Transitions in a block; by default chosen from the series.
        progress: Is told of the number of resamples drawn since its last call.
        counted: What ``steps.entries_by_step`` gave, where it was called already.
    """
    entries, which = counted or steps.entries_by_step()
    ids, signs = [], []
    for given, sign in [(measure.given, 1), (measure.less, -1)]:
        if given is not None:
            ids += [np.unique(entries.ids(given + axes)[0], return_inverse=True)[1] for axes in ("sn", "", "s", "n")]
            signs += [sign, sign, -sign, -sign]
    spans = steps.spans(whole=resample == "recordings")
    length = 0 if resample == "recordings" else block or default_block(steps.transitions)
    values = np.empty(count)
    if length and steps.transitions > MANY:
        length = max(length, len(entries.counts) * steps.transitions // MOST_COUNTS + 1)
        which = _by_blocks(which, spans, length, len(entries.counts))
    for start in range(0, count, BATCH):
        batch = values[start : start + BATCH]
        if which.ndim == 2:
            _resample_blocks(batch, rng, which, np.array(ids), np.array(signs))
            progress(len(batch))
            continue
        _resample(batch, rng, which, spans, length, np.array(ids), np.array(signs), len(entries.counts))
        progress(len(batch))
    return values


def interval(value: float, values: np.ndarray, bias: float, level: float) -> tuple[float, float]:
    """Bias-corrected interval of a measure with plug-in ``value`` and resampled ``values``.

    Quantiles of the resamples, moved down twice: by what resampling adds to the plug-in, and by the plug-in's own
    ``bias`` (degrees of freedom). Over simulated data, 95% intervals covered the truth in 88% to 100% of cases, lowest
    where most combinations were seen a few times only.

    Args:
        value: Plug-in value of the measure.
        values: (m,) values of resamples, in the same unit.
        bias: What the plug-in value is too high by, from the degrees of freedom.
        level: Of the interval, 0 to 1.
    """
    tail = (1 - level) / 2
    low, high = np.quantile(values, [tail, 1 - tail]) - (values.mean() - value) - bias
    return float(low), float(high)


@njit(cache=True)
def _by_blocks(which: np.ndarray, spans: np.ndarray, length: int, entries: int) -> np.ndarray:
    """How often each entry comes in each block of ``length`` transitions, int32 (blocks, entries)."""
    blocks = 0
    for recording in range(len(spans) - 1):
        blocks += (spans[recording + 1] - spans[recording] + length - 1) // length
    counts = np.zeros((blocks, entries), np.int32)
    block = 0
    for recording in range(len(spans) - 1):
        start, stop = spans[recording], spans[recording + 1]
        for t in range(start, stop):
            counts[block + (t - start) // length, which[t]] += 1
        block += (stop - start + length - 1) // length
    return counts


@njit(cache=True)
def _resample_blocks(
    values: np.ndarray, rng: np.random.Generator, blocks: np.ndarray, ids: np.ndarray, signs: np.ndarray
) -> None:
    """Fill ``values``: as many blocks as there are, with replacement."""
    entries = blocks.shape[1]
    counts, sums = np.empty(entries, np.int64), np.zeros(entries, np.int64)
    for i in range(len(values)):
        counts[:] = 0
        for _ in range(len(blocks)):
            block = int(rng.random() * len(blocks))
            for entry in range(entries):
                counts[entry] += blocks[block, entry]
        values[i] = _information(counts, sums, ids, signs)


@njit(cache=True)
def _information(counts: np.ndarray, sums: np.ndarray, ids: np.ndarray, signs: np.ndarray) -> float:
    """Plug-in value of counts of the entries; ``sums`` is room, all 0 before and after."""
    total = 0.0
    for term in range(len(signs)):
        for entry in range(len(counts)):
            sums[ids[term, entry]] += counts[entry]
        for entry in range(len(counts)):
            if sums[entry] > 0:
                total += signs[term] * sums[entry] * np.log(sums[entry])
                sums[entry] = 0
    value: float = total / counts.sum()
    return value


def agreeing(low: float, value: float, null: np.ndarray, alpha: float) -> float:
    """The lower end of an interval such that it is above 0 exactly where the one-sided p is at most ``alpha``.

    Where the bootstrap and the test disagree, the test's own bound takes its place: the value less the critical value
    of the surrogates.

    Args:
        low: Lower end by the bootstrap.
        value: Plug-in value.
        null: Surrogates (m,).
        alpha: Level of the test.
    """
    allowed = int(np.floor(alpha * (1 + len(null)) + 1e-9)) - 1
    if allowed < 0:
        return min(low, 0.0)
    bound = value - float(np.sort(null)[::-1][allowed])
    return bound if (bound > 0) != (low > 0) else low


@njit(cache=True)
def _resample(
    values: np.ndarray, rng: np.random.Generator, which: np.ndarray, spans: np.ndarray, length: int,
    ids: np.ndarray, signs: np.ndarray, entries: int,
) -> None:  # fmt: skip
    """Fill ``values``; ``length`` 0 draws whole recordings."""
    n, recordings = len(which), len(spans) - 1
    counts, sums = np.empty(entries, np.int64), np.zeros(entries, np.int64)
    home = np.empty(n, np.int64)
    for recording in range(recordings):
        home[spans[recording] : spans[recording + 1]] = recording
    for i in range(len(values)):
        counts[:] = 0
        drawn = 0
        if length == 0:
            for _ in range(recordings):
                recording = int(rng.random() * recordings)
                for t in range(spans[recording], spans[recording + 1]):
                    counts[which[t]] += 1
                drawn += spans[recording + 1] - spans[recording]
        else:
            while drawn < n:
                t = int(rng.random() * n)
                start, stop = spans[home[t]], spans[home[t] + 1]
                for _ in range(min(length, n - drawn)):
                    counts[which[t]] += 1
                    drawn += 1
                    t += 1
                    if t == stop:
                        t = start
        values[i] = _information(counts, sums, ids, signs)
