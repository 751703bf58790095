"""Linear Granger causality of categories, for comparison (sections 4.6 and 7 ask how it would do)."""

import numpy as np

from jointattn_mj.contingency.series import Series, check_base
from jointattn_mj.contingency.table import AXES, Cells, steps
from jointattn_mj.errors import SeriesError

MOST_INDICATORS = 2000
"""Most indicator variables of one regression."""


def linear_granger(source: Series, target: Series, condition: Series | None = None, base: float = 2) -> float:
    """How much better least squares predicts r' with s than without, 0 or more; infinite where nothing remains.

    Codes have no order, so every variable enters by indicators, one for each value: r' is regressed on those of r (and
    of the condition) alone, and together with those of s, without products of them. The value is half the logarithm of
    the ratio of the residuals' generalised variances: for normal variables it would be the transfer entropy (Barnett,
    Barrett and Seth 2009), so units compare. An effect of s that depends on the condition is not linear and escapes.

    Raises:
        SeriesError: Series that cannot be measured, or more than ``MOST_INDICATORS`` values.
    """
    unit = check_base(base)
    cells = steps(source, target, condition).cells()
    after = _indicators(cells, "n")[:, 1:]
    context = np.concatenate([_indicators(cells, axis) for axis in ("r" if condition is None else "ra")], 1)
    both = np.concatenate([context, _indicators(cells, "s")], 1)
    if after.shape[1] == 0:
        return 0.0
    weights = np.sqrt(cells.counts / cells.transitions)[:, None]
    without, with_source = (_unexplained(x * weights, after * weights) for x in (context, both))
    spread, axes = np.linalg.eigh(without)
    left = spread > 1e-12
    if not left.any():
        return 0.0
    whitened = axes[:, left] / np.sqrt(spread[left])
    shares = np.linalg.eigvalsh(whitened.T @ with_source @ whitened)
    if shares.min() < 1e-10:
        return float("inf")
    return float(max(0.0, -0.5 * np.log(np.minimum(shares, 1)).sum())) / unit


def _indicators(cells: Cells, axis: str) -> np.ndarray:
    """(m, k) indicator variables of the k values that occur."""
    values, codes = np.unique(cells.columns[AXES.index(axis)], return_inverse=True)
    if len(values) > MOST_INDICATORS:
        raise SeriesError(
            f"linear Granger takes up to {MOST_INDICATORS} values a variable; got {len(values)}: use bins"
        )
    return np.eye(len(values))[codes]


def _unexplained(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Residual covariance (k, k) of y (m, k) after least squares on x (m, j)."""
    residual = y - x @ np.linalg.lstsq(x, y, rcond=1e-10)[0]
    return residual.T @ residual
