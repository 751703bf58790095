"""Lag-sequential analysis: what follows what, how often, and whether more often than chance would have it.

As in Bakeman and Gottman (1997, Observing Interaction, chapters 7 and 8) and Bakeman and Quera (2011, Sequential
Analysis and Observational Methods for the Behavioral Sciences, chapters 9 to 11).
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, Literal

import numpy as np

from jointattn_mj.contingency.displaced import displaced, moves
from jointattn_mj.contingency.information import MUTUAL
from jointattn_mj.contingency.lagged import Timing, timed
from jointattn_mj.contingency.memory import memory
from jointattn_mj.contingency.table import steps
from jointattn_mj.errors import SeriesError
from jointattn_mj.options import Checked, Count, Real, Seed, Whole
from jointattn_mj.recordings.steps import Recordings

Unit = Literal["steps", "onsets", "events"]
"""What is counted. ``steps``: every step, and the one a lag later. ``onsets``: the steps in which a new value of the
target begins, and what the given tier had a lag before. ``events``: the values of one tier, each once however long it
lasts, and the one that comes a lag of events later."""


@dataclass(frozen=True)
class SequentialOptions(Checked):
    """What is counted, and how it is tested."""

    lag: Annotated[int, Whole("[0, 1e9]")] = 1
    """Steps, or events, from given to target; 0 counts what occurs together."""
    unit: Unit = "steps"
    """See ``Unit``."""
    level: Annotated[float, Real("(0, 1)")] = 0.95
    """Coverage of the intervals of odds ratios."""
    surrogates: Annotated[int, Whole("[0, 1e7]")] = 1000
    """Circular shifts of the given tier behind ``p_shift``, for units of steps; 0: none."""
    seed: Seed = 0
    """Random seed of the shifts."""
    least_shift: Count | None = None
    """Shortest shift in steps; by default until the given tier's autocorrelation is low."""


@dataclass(frozen=True, repr=False)
class LagTable:
    """A table of given and target codes, with the statistics of each combination; arrays are (given, target)."""

    given: tuple[str, ...]
    target: tuple[str, ...]
    counts: np.ndarray
    """Joint frequencies."""
    possible: np.ndarray
    """False where a combination cannot occur (structural zero), as where a code cannot follow itself."""
    level: float = 0.95
    p_shift: np.ndarray | None = None
    """Two-sided p of the joint frequency from circular shifts, which holds for long looks, too; None: not drawn."""

    def __repr__(self) -> str:
        return f"LagTable({len(self.given)} given codes, {len(self.target)} target codes, {self.total} pairs)"

    @property
    def total(self) -> int:
        """Number of pairs that were counted."""
        return int(self.counts.sum())

    @property
    def conditional(self) -> np.ndarray:
        """Probability of the target, given what came before; NaN for what never came before."""
        return _ratio(self.counts, self.counts.sum(1, keepdims=True))

    @cached_property
    def expected(self) -> np.ndarray:
        """Frequencies without association. Where there are structural zeros, by iterative proportional fitting."""
        rows, columns = self.counts.sum(1, keepdims=True), self.counts.sum(0, keepdims=True)
        if self.possible.all():
            whole: np.ndarray = rows * columns / max(self.total, 1)
            return whole
        fitted = self.possible.astype(float)
        for _ in range(10_000):
            fitted = fitted * _ratio(rows, fitted.sum(1, keepdims=True), 0.0)
            fitted = fitted * _ratio(columns, fitted.sum(0, keepdims=True), 0.0)
            if np.abs(fitted.sum(1, keepdims=True) - rows).max() < 1e-9 * max(self.total, 1):
                break
        return fitted

    @cached_property
    def adjusted_residuals(self) -> np.ndarray:
        """(Observed - expected) in standard deviations (Haberman 1973); NaN where a combination cannot vary.

        With structural zeros by the leverages of the log-linear model of independence (Haberman 1979; Christensen 1997,
        p. 357).
        """
        share = 1 - self._leverage()
        variance = self.expected * share
        sound = self.possible & (self.expected > 0) & (share > 1e-9)
        deviation = np.sqrt(np.where(sound, variance, 1.0))
        return np.where(sound, (self.counts - self.expected) / deviation, np.nan)

    @property
    def p(self) -> np.ndarray:
        """Two-sided p of the adjusted residuals, as if pairs were independent: too small where looks last long."""
        from scipy.stats import norm

        p: np.ndarray = 2 * norm.sf(np.abs(self.adjusted_residuals))
        return p

    @property
    def odds_ratio(self) -> np.ndarray:
        """Odds of the target after the given code, to its odds after others. 0 and infinity where a count is 0.

        NaN in a table with structural zeros, whose two-by-two tables are not even where there is no association.
        """
        a, b, c, d = self._fourfold()
        ratio = _ratio(a * d, b * c, np.inf)
        return np.where(self._whole & (a * d + b * c > 0), ratio, np.nan)

    @property
    def yules_q(self) -> np.ndarray:
        """Yule's Q, (ad - bc) / (ad + bc), from -1 to 1; NaN as the odds ratio."""
        a, b, c, d = self._fourfold()
        return np.where(self._whole, _ratio(a * d - b * c, a * d + b * c), np.nan)

    @property
    def odds_ratio_interval(self) -> tuple[np.ndarray, np.ndarray]:
        """Woolf's interval of the odds ratio; half a pair is added to each count where one of the four is 0."""
        from scipy.stats import norm

        four = np.stack(self._fourfold()).astype(float)
        four += 0.5 * (four == 0).any(0)
        center = np.log(four[0] * four[3] / (four[1] * four[2]))
        half = norm.ppf((1 + self.level) / 2) * np.sqrt((1 / four).sum(0))
        low, high = (np.where(self._whole, np.exp(center + sign * half), np.nan) for sign in (-1, 1))
        return low, high

    @property
    def degrees_of_freedom(self) -> int:
        """Of the test of the whole table."""
        rows, columns = self.counts.sum(1) > 0, self.counts.sum(0) > 0
        zeros = int((~self.possible[np.ix_(rows, columns)]).sum())
        return max(int((rows.sum() - 1) * (columns.sum() - 1)) - zeros, 0)

    @property
    def chi_squared(self) -> tuple[float, float]:
        """Pearson's and the likelihood-ratio chi-squared of the whole table."""
        sound = self.possible & (self.expected > 0)
        observed, expected = self.counts[sound], self.expected[sound]
        pearson = float(((observed - expected) ** 2 / expected).sum())
        occurs = observed > 0
        return pearson, float(2 * (observed[occurs] * np.log(observed[occurs] / expected[occurs])).sum())

    def rows(self) -> list[dict[str, Any]]:
        """A row a combination that can occur."""
        low, high = self.odds_ratio_interval
        columns = {
            "count": self.counts, "conditional": self.conditional, "expected": self.expected,
            "adjusted_residual": self.adjusted_residuals, "p": self.p, "odds_ratio": self.odds_ratio,
            "odds_ratio_low": low, "odds_ratio_high": high, "yules_q": self.yules_q,
        }  # fmt: skip
        if self.p_shift is not None:
            columns["p_shift"] = self.p_shift
        return [
            {"given": given, "target": target, **{name: values[i, j].item() for name, values in columns.items()}}
            for i, given in enumerate(self.given)
            for j, target in enumerate(self.target)
            if self.possible[i, j]
        ]

    @property
    def _whole(self) -> bool:
        """Whether every combination can occur."""
        return bool(self.possible.all())

    def _fourfold(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The 2 x 2 table of each combination: both, given alone, target alone, neither."""
        a = self.counts
        b, c = a.sum(1, keepdims=True) - a, a.sum(0, keepdims=True) - a
        return a, b, c, self.total - a - b - c

    def _leverage(self) -> np.ndarray:
        if self.possible.all():
            rows, columns = (self.counts.sum(axis, keepdims=True) / max(self.total, 1) for axis in (1, 0))
            leverage: np.ndarray = 1 - (1 - rows) * (1 - columns)
            return leverage
        kept = self.possible & (self.expected > 0)
        i, j = np.nonzero(kept)
        design = np.zeros((len(i), sum(kept.shape)))
        design[np.arange(len(i)), i] = 1
        design[np.arange(len(i)), kept.shape[0] + j] = 1
        weighted = design * np.sqrt(self.expected[kept])[:, None]
        leverages = np.zeros(kept.shape)
        leverages[kept] = np.einsum("ij,ji->i", weighted, np.linalg.pinv(weighted))
        return leverages


@dataclass(frozen=True)
class OverRecordings:
    """Yule's Q of each combination, recording by recording; arrays are (recordings, given, target)."""

    values: np.ndarray
    """NaN where a recording lacks a code."""
    level: float

    def rows(self, possible: np.ndarray) -> list[dict[str, Any]]:
        """A row a combination that can occur: mean, Student's interval and two-sided p, and how often Q is above 0."""
        from scipy.stats import t

        rows = []
        for i, j in np.argwhere(possible):
            known = self.values[np.isfinite(self.values[:, i, j]), i, j]
            n = len(known)
            mean, low, high, p = (float("nan"),) * 4
            if n:
                mean = float(known.mean())
            if n > 1:
                error = float(known.std(ddof=1)) / np.sqrt(n)
                half = float(t.ppf((1 + self.level) / 2, n - 1)) * error
                low, high = mean - half, mean + half
                p = float(2 * t.sf(abs(mean) / error, n - 1)) if error else float(mean == 0)
            rows.append(
                {"recordings": n, "positive": int((known > 0).sum()), "q_mean": mean, "q_low": low, "q_high": high,
                 "q_p": p}
            )  # fmt: skip
        return rows


def yules_q_over(
    recordings: Recordings,
    given: str,
    target: str,
    options: SequentialOptions,
    impossible: Sequence[tuple[str, str]] = (),
) -> OverRecordings:
    """Yule's Q recording by recording, so that no recording's steps are put together with another's.

    Args:
        recordings: Steps.
        given: Name of the tier or column of the earlier code.
        target: Name of that of the later code.
        options: Lag and unit.
        impossible: Pairs of labels that cannot occur, as for ``lag_table``.

    Raises:
        SeriesError: As ``lag_table``.
    """
    alone = replace(options, surrogates=0)
    values = []
    for number in dict.fromkeys(recordings.groups):
        kept = [i for i, group in enumerate(recordings.groups) if group == number]
        columns = {name: [parts[i] for i in kept] for name, parts in recordings.columns.items()}
        single = replace(recordings, columns=columns, groups=[number] * len(kept))
        if max(len(part) for part in columns[given]) > options.lag:
            with suppress(SeriesError):  # nothing to count in this recording
                values.append(lag_table(single, given, target, alone, impossible).yules_q)
    size = len(recordings.labels[given]), len(recordings.labels[target])
    return OverRecordings(np.array(values).reshape(-1, *size), options.level)


def lag_table(
    recordings: Recordings,
    given: str,
    target: str,
    options: SequentialOptions | None = None,
    impossible: Sequence[tuple[str, str]] = (),
) -> LagTable:
    """Count what follows what.

    Args:
        recordings: Steps.
        given: Name of the tier or column of the earlier code.
        target: Name of that of the later code; for ``events`` the same.
        options: Lag, unit and test; None: the defaults.
        impossible: Pairs of labels (given, target) that cannot occur. For ``events`` at lag 1 no code can follow
            itself: these pairs are impossible anyway.

    Returns:
        Joint frequencies and what follows from them.

    Raises:
        SeriesError: No such variable or label, two variables for ``events``, an impossible pair that occurred, or
            nothing to count.

    Examples:
        >>> import numpy as np
        >>> from jointattn_mj.recordings.steps import Recordings
        >>> gaze = Recordings({"gaze": [np.array([0, 0, 1, 2, 2, 1, 0])]}, {"gaze": ("face", "toy", "away")}, [0], 7)
        >>> lag_table(gaze, "gaze", "gaze", SequentialOptions(unit="events")).counts.tolist()
        [[0, 1, 0], [1, 0, 1], [0, 1, 0]]
    """
    options = options or SequentialOptions()
    for name in (given, target):
        if name not in recordings.columns:
            raise SeriesError(f"there is no variable {name!r}; there are {', '.join(recordings.columns)}")
    labels = recordings.labels[given], recordings.labels[target]
    pairs = [_pairs(*parts, options) for parts in _parts(recordings, given, target, options.unit)]
    counts = np.zeros([len(names) for names in labels], np.int64)
    for earlier, later in pairs:
        np.add.at(counts, (earlier, later), 1)
    if not counts.any():
        raise SeriesError(
            f"no {options.unit} of {given!r} and {target!r} lie {options.lag} apart; choose a shorter lag"
        )
    possible = np.ones(counts.shape, bool)
    if options.unit == "events" and options.lag == 1:
        np.fill_diagonal(possible, False)
    for pair in impossible:
        for label, known, name in zip(pair, labels, (given, target), strict=True):
            if label not in known:
                raise SeriesError(f"{name!r} has no value {label!r}; there are {', '.join(known)}")
        possible[labels[0].index(pair[0]), labels[1].index(pair[1])] = False
    if (counts[~possible] > 0).any():
        i, j = np.argwhere(~possible & (counts > 0))[0]
        raise SeriesError(f"{labels[0][i]!r} then {labels[1][j]!r} occurred {counts[i, j]} times; it is not impossible")
    p = None
    if options.unit == "steps" and options.lag and options.surrogates and given != target:
        p = _p_by_shifts(recordings, given, target, counts, options)
    return LagTable(*labels, counts, possible, options.level, p)


def _parts(recordings: Recordings, given: str, target: str, unit: Unit) -> list[tuple[np.ndarray, np.ndarray]]:
    """Given and target (T,) of each piece."""
    if unit != "events":
        return list(zip(recordings.columns[given], recordings.columns[target], strict=True))
    if given != target:
        raise SeriesError(
            f"events are counted on one tier; got {given!r} and {target!r}. Combine them, or count onsets"
        )
    parts = recordings.columns[given]
    runs = [part[np.concatenate([[True], np.diff(part) != 0])] for part in parts]
    return [(run, run) for run in runs]


def _pairs(given: np.ndarray, target: np.ndarray, options: SequentialOptions) -> tuple[np.ndarray, np.ndarray]:
    lag = options.lag
    earlier, later = given[: len(given) - lag or None], target[lag:]
    earlier = earlier[: len(later)]
    if options.unit == "onsets":
        begins = np.concatenate([[False], np.diff(target) != 0])[lag:]
        earlier, later = earlier[begins], later[begins]
    return earlier, later


def _p_by_shifts(
    recordings: Recordings, given: str, target: str, counts: np.ndarray, options: SequentialOptions
) -> np.ndarray:
    """Two-sided p of each count: twice the smaller tail of the surrogates."""
    whole = steps(recordings.columns[given], recordings.columns[target], groups=recordings.groups)
    moved = timed(whole, Timing(options.lag))
    least = options.least_shift or memory(moved, MUTUAL).fresh_after
    table = displaced(moved, [MUTUAL])
    columns = moved.columns()
    sources, afters = np.unique(columns[2]), np.unique(columns[3])
    entries = np.ix_(sources, afters)
    tails = np.zeros((2, *counts.shape))
    drawn = 0
    own = np.zeros(counts.shape, np.int64)
    np.add.at(own, (columns[2], columns[3]), 1)
    group = table.groups[table.names.index("n")]
    for pieces in moves(moved, "shift", least, 1).draw(options.surrogates, np.random.default_rng(options.seed)):
        of_result = np.zeros((len(afters), len(sources)), np.int64)
        np.add.at(of_result, group, table.counter.table(pieces))
        surrogate = np.zeros(counts.shape, np.int64)
        surrogate[entries] = of_result.T
        tails += np.stack([surrogate >= own, surrogate <= own])
        drawn += 1
    p: np.ndarray = np.minimum(1, 2 * (1 + tails.min(0)) / (1 + drawn))
    return p


def _ratio(above: np.ndarray, below: np.ndarray, otherwise: float = float("nan")) -> np.ndarray:
    above, below = np.broadcast_arrays(np.asarray(above, float), np.asarray(below, float))
    ratio: np.ndarray = np.divide(above, below, out=np.full(above.shape, otherwise), where=below != 0)
    return ratio
