"""Estimates with 95% intervals, paired differences, and the number of runs that a comparison needs.

scipy is imported where it is used, for half a second is long for a command that ends in its help.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

RESAMPLES = 9999
CONFIDENCE = 0.95
POWER = 0.8


@dataclass(frozen=True)
class Estimate:
    """A mean, share or median over independent runs with its 95% interval."""

    mean: float
    """The mean, share or median."""
    low: float
    high: float
    sd: float
    """Standard deviation of single runs."""
    n: int
    share: bool = False
    """Whether it is a share of a whole, shown in per cent."""

    def __str__(self) -> str:
        if self.share:
            return f"{self.mean:.0%} [{self.low:.0%}, {self.high:.0%}]"
        if self.n == 0:
            return "-"
        if self.mean == np.inf and not np.isfinite(self.low):
            return "not in half of the runs"
        size = next((abs(value) for value in (self.mean, self.low, self.high) if np.isfinite(value)), 0.0)
        tiny = 0 < size < 0.1
        digits = 2 - (int(np.floor(np.log10(size))) if tiny else sum(size >= limit for limit in (10, 1000)))
        low, high = _number(self.low, digits), _number(self.high, digits)
        if self.low == -np.inf and self.high == np.inf:
            return f"{_number(self.mean, digits)} [too few runs for an interval]"
        if self.mean == np.inf:
            return f"not in half of the runs [{low}, {high}]"
        return f"{_number(self.mean, digits)} [{low}, {high}]"


def _number(value: float, digits: int) -> str:
    if np.isinf(value):
        return "∞" if value > 0 else "-∞"
    return f"{value:,.{digits}f}"


NOTHING = Estimate(np.nan, np.nan, np.nan, np.nan, 0)


def mean_interval(values: Sequence[float] | np.ndarray) -> Estimate:
    """Mean of ``values`` (n,) with a BCa bootstrap interval of 9,999 resamples. NaN are left out.

    With fewer than two values, or if all are equal, the interval is the mean itself.
    """
    values = _known(values)
    if len(values) == 0:
        return NOTHING
    mean = float(values.mean())
    if len(values) < 2 or np.ptp(values) == 0:
        return Estimate(mean, mean, mean, 0.0, len(values))
    from scipy import stats

    interval = stats.bootstrap(
        (values,), np.mean, n_resamples=RESAMPLES, method="BCa", rng=np.random.default_rng(0)
    ).confidence_interval
    return Estimate(mean, float(interval.low), float(interval.high), float(values.std(ddof=1)), len(values))


def proportion(successes: int, n: int) -> Estimate:
    """Share of ``successes`` among ``n`` with Wilson's interval.

    Raises:
        ValueError: ``successes`` is not in [0, n].
    """
    if not 0 <= successes <= n:
        raise ValueError(f"proportion needs 0 <= successes <= n; got {successes} of {n}")
    if n == 0:
        return NOTHING
    from scipy import stats

    share = successes / n
    interval = stats.binomtest(int(successes), int(n)).proportion_ci(CONFIDENCE, method="wilson")
    sd = float(np.sqrt(share * (1 - share) * n / (n - 1))) if n > 1 else 0.0
    return Estimate(share, float(interval.low), float(interval.high), sd, int(n), share=True)


def median_interval(values: Sequence[float] | np.ndarray) -> Estimate:
    """Median of ``values`` (n,) with a distribution-free interval.

    The interval is the narrowest symmetric pair of order statistics that holds the median with 95%. Five values or
    fewer bound no median at this level; their interval is infinite. An infinite value stands for an event that never
    happened. NaN are left out.
    """
    values = np.sort(_known(values))
    n = len(values)
    if n == 0:
        return NOTHING
    from scipy import stats

    middle = values[(n - 1) // 2], values[n // 2]
    median = float(middle[0]) if middle[0] == middle[1] else float(middle[0] + middle[1]) / 2
    sd = float(values.std(ddof=1)) if n > 1 and np.isfinite(values).all() else np.nan
    outside = int(stats.binom.ppf((1 - CONFIDENCE) / 2, n, 0.5))  # fewer than this many on one side: below 2.5%
    if outside == 0:
        return Estimate(median, -np.inf, np.inf, sd, n)
    return Estimate(median, float(values[outside - 1]), float(values[n - outside]), sd, n)


def paired_difference(a: Sequence[float] | np.ndarray, b: Sequence[float] | np.ndarray) -> Estimate:
    """Mean of ``a - b`` with its interval. Pairs with a NaN are left out.

    Args:
        a: Values (n,), one for each run.
        b: Values (n,) of the same runs in the same order.

    Raises:
        ValueError: The lengths differ.
    """
    a, b = np.asarray(a, float), np.asarray(b, float)
    if a.shape != b.shape:
        raise ValueError(f"paired_difference needs the same runs on either side; got {a.shape} and {b.shape}")
    return mean_interval(a - b)


def runs_needed(first: float, second: float, sd: float | None = None, power: float = POWER) -> float:
    """Runs on each side that a two-sided test at 5% needs to tell two values apart; not rounded.

    Without ``sd`` the values are shares, compared by the normal approximation; with it they are means, compared by t.

    Args:
        first: A share or mean.
        second: The other; if it equals the first, the result is infinite.
        sd: Standard deviation of single runs around their mean.
        power: Probability with which the test finds the difference.
    """
    if first == second:
        return np.inf
    from scipy import optimize, stats

    if sd is None:
        pooled = (first + second) / 2
        wide = stats.norm.ppf((1 + CONFIDENCE) / 2) * np.sqrt(2 * pooled * (1 - pooled))
        return float(((wide + stats.norm.ppf(power) * _binomial_sd(first, second)) / (first - second)) ** 2)
    if sd == 0:
        return 2.0

    def lack(n: float) -> float:
        freedom, shift = 2 * (n - 1), np.sqrt(n / 2) * abs(first - second) / sd
        critical = stats.t.ppf((1 + CONFIDENCE) / 2, freedom)
        return float(stats.nct.sf(critical, freedom, shift)) - power

    if lack(2.0) >= 0:
        return 2.0
    normal = 2 * ((stats.norm.ppf((1 + CONFIDENCE) / 2) + stats.norm.ppf(power)) * sd / (first - second)) ** 2
    return float(optimize.brentq(lack, 2.0, normal + 10))


def enough(n: int, first: float, second: float, sd: float | None = None) -> bool:
    """Whether ``n`` runs on each side tell two values apart with a power of 0.8; see :func:`runs_needed`.

    Args:
        n: Runs on each side.
        first: A share or mean.
        second: The other one.
        sd: Standard deviation of means; None for shares.
    """
    return n >= runs_needed(first, second, sd)


def too_few(n: int, first: float, second: float, sd: float | None = None) -> str:
    """A sentence saying that ``n`` runs on each side cannot tell two values apart; empty if they can.

    See :func:`runs_needed` for the arguments.

    Args:
        n: Runs on each side.
        first: A share or mean.
        second: The other one.
        sd: Standard deviation of means; None for shares.
    """
    needed = runs_needed(first, second, sd)
    if n >= needed:
        return ""
    a, b = (f"{first:.0%}", f"{second:.0%}") if sd is None else (f"{first:.3g}", f"{second:.3g}")
    if needed == np.inf:
        return f"no number of runs tells {a} from {b}"
    return f"{n} run{'s' * (n != 1)} a side cannot tell {a} from {b}; {int(np.ceil(needed))} would"


def _binomial_sd(first: float, second: float) -> float:
    return float(np.sqrt(first * (1 - first) + second * (1 - second)))


def _known(values: Sequence[float] | np.ndarray) -> np.ndarray:
    numbers: np.ndarray = np.asarray(values, float)
    known: np.ndarray = numbers[~np.isnan(numbers)]
    return known
