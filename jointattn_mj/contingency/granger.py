"""Linear Granger causality of categories, for comparison (sections 4.6 and 7 ask how it would do)."""

import numpy as np

from jointattn_mj.contingency.series import Series, check_base
from jointattn_mj.contingency.table import AXES, Entries, steps
from jointattn_mj.errors import SeriesError

MOST_VALUES = 1000
"""Most values of all variables together: each is a column of the regression."""


def linear_granger(source: Series, target: Series, condition: Series | None = None, base: float = 2) -> float:
    """Linear Granger causality: how much better least squares predicts the target with the source than without.

    Codes have no order, so every variable enters by indicators, one for each value: r' is regressed on those of r (and
    of the condition) alone, and together with those of s, without products of them. The value is half the logarithm of
    the ratio of the residuals' generalised variances: for normal variables it would be the transfer entropy (Barnett,
    Barrett and Seth 2009), so units compare. An effect of s that depends on the condition is not linear and escapes.

    Args:
        source: What may have an influence, (T,) integer codes, or a list of such arrays, one a recording.
        target: What may be influenced, of the same lengths.
        condition: What is known anyway, likewise, or None.
        base: Base of the logarithm: 2 for bits.

    Returns:
        0 or more, in units of the base; infinite where the source leaves nothing unexplained.

    Raises:
        SeriesError: Series that cannot be measured, or variables of more than ``MOST_VALUES`` values together.

    Examples:
        >>> linear_granger([0, 1, 1, 0, 1, 0, 0, 1], [0, 0, 1, 1, 0, 1, 0, 0])
        inf
    """
    unit = check_base(base)
    entries = steps(source, target, condition).entries()
    products, column = _products(entries, "nrs" if condition is None else "nras")
    after = column["n"][1:]
    if len(after) == 0:
        return 0.0
    context = np.concatenate([column["r"], column.get("a", column["r"][:0])])
    without = _unexplained(products, context, after)
    with_source = _unexplained(products, np.concatenate([context, column["s"]]), after)
    spread, directions = np.linalg.eigh(without)
    left = spread > 1e-10
    if not left.any():
        return 0.0
    whitened = directions[:, left] / np.sqrt(spread[left])
    shares = np.linalg.eigvalsh(whitened.T @ with_source @ whitened)
    if shares.min() < 1e-8:
        return float("inf")
    return float(max(0.0, -0.5 * np.log(np.minimum(shares, 1)).sum())) / unit


def _products(entries: Entries, axes: str) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Mean products (k, k) of the indicators of all values that occur, and which of the k belong to each axis."""
    codes, column, start = {}, {}, 0
    for axis in axes:
        values, codes[axis] = np.unique(entries.columns[AXES.index(axis)], return_inverse=True)
        column[axis] = np.arange(start, start + len(values))
        start += len(values)
    if start > MOST_VALUES:
        raise SeriesError(f"linear Granger takes up to {MOST_VALUES} values of all variables; got {start}: use bins")
    products = np.empty((start, start))
    for axis in axes:
        for other in axes:
            shape = len(column[axis]), len(column[other])
            counts = np.bincount(codes[axis] * shape[1] + codes[other], entries.counts, shape[0] * shape[1])
            products[np.ix_(column[axis], column[other])] = counts.reshape(shape)
    return products / entries.transitions, column


def _unexplained(products: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Residual covariance of columns y after least squares on columns x."""
    inner = np.linalg.pinv(products[np.ix_(x, x)], rcond=1e-10, hermitian=True)
    across = products[np.ix_(x, y)]
    unexplained: np.ndarray = products[np.ix_(y, y)] - across.T @ inner @ across
    return unexplained
