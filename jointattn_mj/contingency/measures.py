"""Contingency measures of whole series (sections 4.4 and 5.2.1), from histograms of what was observed.

Throughout, s is a source or sensor, a an action or other condition, r a result; what s[t] and a[t] say about r[t + 1].
Series are arrays (T,) or lists of them (see ``series``). Values are in units of the logarithm's ``base``: bits for 2.
Every function raises SeriesError for series that cannot be measured. What ``correction`` and ``normalise`` mean stands
in ``information``; ``shuffle`` takes the mean of ``surrogates`` permutations drawn with ``seed``.
"""

from typing import get_args

import numpy as np

from jointattn_mj.contingency import information
from jointattn_mj.contingency.information import Correction, Measure, Normalise
from jointattn_mj.contingency.series import Series, check_base
from jointattn_mj.contingency.significance import generator
from jointattn_mj.contingency.surrogates import plan
from jointattn_mj.contingency.table import Steps, acted, steps
from jointattn_mj.errors import SeriesError

LARGEST_SALIENCY = 2**26
"""Most cells of an array of contingent saliency."""


def transfer_entropy(
    source: Series,
    target: Series,
    condition: Series | None = None,
    base: float = 2,
    *,
    correction: Correction = "none",
    normalise: Normalise = "none",
    surrogates: int = 100,
    seed: int = 0,
) -> float:
    """T_{s -> r} = sum p(r', r, s) log p(r' | r, s) / p(r' | r) (eq. 4.1, 5.1), given the condition if there is one.

    Plug-in values are 0 or more.
    """
    measure = information.TRANSFER if condition is None else information.COMBINED
    return _measured(steps(source, target, condition), measure, base, correction, normalise, surrogates, seed)


def combined_transfer_entropy(
    s: Series,
    a: Series,
    r: Series,
    base: float = 2,
    *,
    correction: Correction = "none",
    normalise: Normalise = "none",
    surrogates: int = 100,
    seed: int = 0,
) -> float:
    """T^C = T_{s, a -> r} - T_{a -> r} = sum p(r', r, s, a) log p(r' | r, s, a) / p(r' | r, a) (eq. 4.3); 0 or more."""
    return _measured(acted(s, a, r), information.COMBINED, base, correction, normalise, surrogates, seed)


def state_action_contingency(
    s: Series,
    a: Series,
    r: Series,
    base: float = 2,
    *,
    correction: Correction = "none",
    normalise: Normalise = "none",
    surrogates: int = 100,
    seed: int = 0,
) -> float:
    """SAC = T_{s, a -> r} - T_{s -> r} - T_{a -> r} (eq. 5.2): what s and a say together beyond what each says alone.

    Negative where they say the same.
    """
    return _measured(acted(s, a, r), information.CONTINGENCY, base, correction, normalise, surrogates, seed)


def mutual_information(
    s: Series,
    r: Series,
    base: float = 2,
    *,
    correction: Correction = "none",
    normalise: Normalise = "none",
    surrogates: int = 100,
    seed: int = 0,
) -> float:
    """I(s[t]; r[t + 1]), whatever r[t]; for comparison."""
    return _measured(steps(s, r), information.MUTUAL, base, correction, normalise, surrogates, seed)


def conditional_mutual_information(
    s: Series,
    r: Series,
    condition: Series,
    base: float = 2,
    *,
    correction: Correction = "none",
    normalise: Normalise = "none",
    surrogates: int = 100,
    seed: int = 0,
) -> float:
    """I(s[t]; r[t + 1] | condition[t]), whatever r[t]; for comparison."""
    given = acted(s, condition, r)
    return _measured(given, information.CONDITIONAL_MUTUAL, base, correction, normalise, surrogates, seed)


def pointwise_transfer_entropy(
    source: Series, target: Series, condition: Series | None = None, base: float = 2
) -> np.ndarray | list[np.ndarray]:
    """Local values (T - 1,), transition by transition; a list of such arrays for several recordings.

    Their mean over all transitions is ``transfer_entropy``; single ones may be negative.
    """
    measure = information.TRANSFER if condition is None else information.COMBINED
    return _pointwise(steps(source, target, condition), measure, base)


def pointwise_combined_transfer_entropy(
    s: Series, a: Series, r: Series, base: float = 2
) -> np.ndarray | list[np.ndarray]:
    """Local values of ``combined_transfer_entropy``, in the shape of ``pointwise_transfer_entropy``."""
    return _pointwise(acted(s, a, r), information.COMBINED, base)


def pointwise_state_action_contingency(
    s: Series, a: Series, r: Series, base: float = 2
) -> np.ndarray | list[np.ndarray]:
    """Local values of ``state_action_contingency``, in the shape of ``pointwise_transfer_entropy``."""
    return _pointwise(acted(s, a, r), information.CONTINGENCY, base)


def pointwise_mutual_information(s: Series, r: Series, base: float = 2) -> np.ndarray | list[np.ndarray]:
    """Local values of ``mutual_information``, in the shape of ``pointwise_transfer_entropy``."""
    return _pointwise(steps(s, r), information.MUTUAL, base)


def pointwise_conditional_mutual_information(
    s: Series, r: Series, condition: Series, base: float = 2
) -> np.ndarray | list[np.ndarray]:
    """Local values of ``conditional_mutual_information``, in the shape of ``pointwise_transfer_entropy``."""
    return _pointwise(acted(s, condition, r), information.CONDITIONAL_MUTUAL, base)


def contingent_saliency(s: Series, a: Series, r: Series, base: float = 2) -> np.ndarray:
    """e(r', a; r, s) of eq. 5.3 as an array [r, s, r', a], indexed by the codes themselves.

    NaN for pairs (r, s) that were never observed. Under an observed pair, a cell (r', a) that did not occur there has a
    first term of 0 and keeps its second. The sum over r', a, weighted with p(r, s), is ``state_action_contingency``.

    Raises:
        SeriesError: Also where the array would be huge, or codes are: number them anew with ``recode`` first.
    """
    given, unit = acted(s, a, r), check_base(base)
    results, actions, sources, _ = given.sizes
    renumbered = any(
        one is not None and one.values is not None for one in (given.source, given.target, given.condition)
    )
    if renumbered or results * results * actions * sources > LARGEST_SALIENCY:
        raise SeriesError("codes are too large to index an array of saliencies; number them anew with recode() first")
    cells = given.cells()
    before, action, source, after = cells.columns
    counts = cells.counts
    pairs = cells.marginal("rs")
    joint = counts / pairs * np.log(counts * pairs / (cells.marginal("ras") * cells.marginal("rsn")))
    saliency = np.zeros((results, sources, results, actions))
    saliency[before, source, after, action] = joint
    ran, ra, rn, r_only = (cells.marginal(axes) for axes in ("ran", "ra", "rn", "r"))
    alone = np.zeros((results, results, actions))
    alone[before, after, action] = ran / r_only * np.log(ran * r_only / (ra * rn))
    saliency -= alone[:, None]
    observed = np.zeros((results, sources), bool)
    observed[before, source] = True
    saliency[~observed] = np.nan
    return saliency / unit


def _measured(
    given: Steps,
    measure: Measure,
    base: float,
    correction: Correction,
    normalise: Normalise,
    surrogates: int,
    seed: int,
) -> float:
    unit = check_base(base)
    for name, choice, known in (("correction", correction, Correction), ("normalise", normalise, Normalise)):
        if choice not in get_args(known):
            raise SeriesError(f"{name} must be one of {', '.join(get_args(known))}; got {choice!r}")
    table = given.dense()
    if table is not None and correction == normalise == "none":
        return measure.dense_value(table) / unit
    cells = given.cells(table)
    value = measure.value(cells)
    if correction == "shuffle":
        if not isinstance(surrogates, (int, np.integer)) or surrogates < 1:
            raise SeriesError(f"surrogates must be a whole number of 1 or more; got {surrogates!r}")
        value -= float(plan(given, measure).draw(surrogates, generator(seed)).mean())
    elif correction != "none":
        value -= measure.bias(cells, correction)
    if normalise == "none":
        return value / unit
    bound = measure.bound(cells, normalise)
    return value / bound if bound > 1e-12 else 0.0


def _pointwise(given: Steps, measure: Measure, base: float) -> np.ndarray | list[np.ndarray]:
    unit = check_base(base)
    cells, which = given.cells_by_step()
    local = measure.local(cells)[which] / unit
    bounds = given.target.bounds
    return local if len(bounds) == 2 else np.split(local, bounds[1:-1] - np.arange(1, len(bounds) - 1))
