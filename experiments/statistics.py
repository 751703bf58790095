"""Intervals for what experiments report."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

RESAMPLES = 9999


@dataclass(frozen=True)
class Estimate:
    """A mean over independent runs with its 95% bootstrap interval."""

    mean: float
    low: float
    high: float
    sd: float
    n: int

    def __str__(self) -> str:
        digits = 1 if abs(self.mean) >= 10 else 2
        return f"{self.mean:.{digits}f} [{self.low:.{digits}f}, {self.high:.{digits}f}]"


def mean_interval(values: np.ndarray) -> Estimate:
    """Mean of ``values`` (n,) with a BCa bootstrap interval; NaN are left out.

    With fewer than two values, or none that differ, the interval is the mean itself.
    """
    values = np.asarray(values, float)
    values = values[~np.isnan(values)]
    if len(values) == 0:
        return Estimate(np.nan, np.nan, np.nan, np.nan, 0)
    mean = float(values.mean())
    if len(values) < 2 or np.ptp(values) == 0:
        return Estimate(mean, mean, mean, 0.0, len(values))
    interval = stats.bootstrap(
        (values,), np.mean, n_resamples=RESAMPLES, method="BCa", rng=np.random.default_rng(0)
    ).confidence_interval
    return Estimate(mean, float(interval.low), float(interval.high), float(values.std(ddof=1)), len(values))
