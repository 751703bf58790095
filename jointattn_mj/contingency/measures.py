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
from jointattn_mj.contingency.table import Steps, acted, counted_at_once, needed, steps
from jointattn_mj.errors import SeriesError
from jointattn_mj.options import shown

_CORRECTIONS, _NORMALISATIONS = get_args(Correction), get_args(Normalise)
LARGEST_SALIENCY = 2**26
"""Most entries of an array of contingent saliency."""


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
    """Transfer entropy: how much the source says about the target's next value.

    T_{s -> r} = sum p(r', r, s) log p(r' | r, s) / p(r' | r) (eq. 4.1, 5.1), given the condition if there is one.

    Args:
        source: What may have an influence, (T,) integer codes, or a list of such arrays, one a recording.
        target: What may be influenced, of the same lengths.
        condition: What is known anyway, likewise; None: nothing but the target's present value.
        base: Base of the logarithm: 2 for bits.
        correction: What is taken off the plug-in value (see ``information.Correction``).
        normalise: What the value is divided by (see ``information.Normalise``).
        surrogates: Permutations whose mean ``correction="shuffle"`` takes off.
        seed: Seed of these permutations.

    Returns:
        The value, in units of the base; the plug-in value is 0 or more.

    Raises:
        SeriesError: The series cannot be measured, or an option is none of its choices.

    Examples:
        >>> source = [0, 1, 1, 0, 1, 0, 0, 1]
        >>> target = [0, 0, 1, 1, 0, 1, 0, 0]  # what the source was a step before
        >>> round(transfer_entropy(source, target), 3)
        0.965
    """
    measure = information.TRANSFER if condition is None else information.COMBINED
    return _measured(source, target, condition, measure, base, correction, normalise, surrogates, seed)


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
    """Combined transfer entropy T^C: what the sensor adds to the action in telling the next result.

    T^C = T_{s, a -> r} - T_{a -> r} = sum p(r', r, s, a) log p(r' | r, s, a) / p(r' | r, a) (eq. 4.3).

    Args:
        s: What is sensed, (T,) integer codes, or a list of such arrays, one a recording.
        a: What is done, of the same lengths.
        r: What comes of it, likewise.
        base: Base of the logarithm: 2 for bits.
        correction: What is taken off the plug-in value (see ``information.Correction``).
        normalise: What the value is divided by (see ``information.Normalise``).
        surrogates: Permutations whose mean ``correction="shuffle"`` takes off.
        seed: Seed of these permutations.

    Returns:
        The value, in units of the base; the plug-in value is 0 or more.

    Raises:
        SeriesError: The series cannot be measured, or an option is none of its choices.

    Examples:
        >>> s, a = [0, 1, 1, 0, 1, 0, 0, 1], [0, 0, 1, 1, 0, 1, 0, 0]
        >>> r = [0, 0, 1, 0, 1, 1, 1, 0]  # whether s and a differed a step before
        >>> round(combined_transfer_entropy(s, a, r), 3)
        0.857
    """
    return _measured(s, r, needed(a), information.COMBINED, base, correction, normalise, surrogates, seed)


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
    """State-action contingency SAC: what sensor and action say together beyond what each says alone.

    SAC = T_{s, a -> r} - T_{s -> r} - T_{a -> r} (eq. 5.2).

    Args:
        s: What is sensed, (T,) integer codes, or a list of such arrays, one a recording.
        a: What is done, of the same lengths.
        r: What comes of it, likewise.
        base: Base of the logarithm: 2 for bits.
        correction: What is taken off the plug-in value (see ``information.Correction``).
        normalise: What the value is divided by (see ``information.Normalise``).
        surrogates: Permutations whose mean ``correction="shuffle"`` takes off.
        seed: Seed of these permutations.

    Returns:
        The value, in units of the base; negative where sensor and action say the same.

    Raises:
        SeriesError: The series cannot be measured, or an option is none of its choices.

    Examples:
        >>> s, a = [0, 1, 1, 0, 1, 0, 0, 1], [0, 0, 1, 1, 0, 1, 0, 0]
        >>> r = [0, 0, 1, 0, 1, 1, 1, 0]  # whether s and a differed a step before
        >>> round(state_action_contingency(s, a, r), 3)
        0.749
    """
    return _measured(s, r, needed(a), information.CONTINGENCY, base, correction, normalise, surrogates, seed)


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
    """Mutual information I(s[t]; r[t + 1]), whatever r[t]; for comparison.

    Args:
        s: The source, (T,) integer codes, or a list of such arrays, one a recording.
        r: The target, of the same lengths.
        base: Base of the logarithm: 2 for bits.
        correction: What is taken off the plug-in value (see ``information.Correction``).
        normalise: What the value is divided by (see ``information.Normalise``).
        surrogates: Permutations whose mean ``correction="shuffle"`` takes off.
        seed: Seed of these permutations.

    Returns:
        The value, in units of the base; the plug-in value is 0 or more.

    Raises:
        SeriesError: The series cannot be measured, or an option is none of its choices.

    Examples:
        >>> round(mutual_information([0, 1, 0, 1, 0], [1, 0, 1, 0, 1]), 3)
        1.0
    """
    return _measured(s, r, None, information.MUTUAL, base, correction, normalise, surrogates, seed)


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
    """Conditional mutual information I(s[t]; r[t + 1] | condition[t]), whatever r[t]; for comparison.

    Args:
        s: The source, (T,) integer codes, or a list of such arrays, one a recording.
        r: The target, of the same lengths.
        condition: What is known anyway, likewise.
        base: Base of the logarithm: 2 for bits.
        correction: What is taken off the plug-in value (see ``information.Correction``).
        normalise: What the value is divided by (see ``information.Normalise``).
        surrogates: Permutations whose mean ``correction="shuffle"`` takes off.
        seed: Seed of these permutations.

    Returns:
        The value, in units of the base; the plug-in value is 0 or more.

    Raises:
        SeriesError: The series cannot be measured, or an option is none of its choices.

    Examples:
        >>> round(conditional_mutual_information([0, 1, 0, 1, 0], [1, 0, 1, 0, 1], [0, 0, 0, 0, 0]), 3)
        1.0
    """
    measure = information.CONDITIONAL_MUTUAL
    return _measured(s, r, needed(condition), measure, base, correction, normalise, surrogates, seed)


def pointwise_transfer_entropy(
    source: Series, target: Series, condition: Series | None = None, base: float = 2
) -> np.ndarray | list[np.ndarray]:
    """Transfer entropy transition by transition.

    Args:
        source: What may have an influence, (T,) integer codes, or a list of such arrays, one a recording.
        target: What may be influenced, of the same lengths.
        condition: What is known anyway, likewise, or None.
        base: Base of the logarithm: 2 for bits.

    Returns:
        Local values (T - 1,), or a list of such arrays. Their mean over all transitions is ``transfer_entropy``;
        single ones may be negative.

    Raises:
        SeriesError: The series cannot be measured.

    Examples:
        >>> local = pointwise_transfer_entropy([0, 1, 1, 0, 1, 0, 0, 1], [0, 0, 1, 1, 0, 1, 0, 0])
        >>> local.shape, float(local.mean().round(3))
        ((7,), 0.965)
    """
    measure = information.TRANSFER if condition is None else information.COMBINED
    return _pointwise(steps(source, target, condition), measure, base)


def pointwise_combined_transfer_entropy(
    s: Series, a: Series, r: Series, base: float = 2
) -> np.ndarray | list[np.ndarray]:
    """Combined transfer entropy T^C transition by transition.

    Args:
        s: What is sensed, (T,) integer codes, or a list of such arrays, one a recording.
        a: What is done, of the same lengths.
        r: What comes of it, likewise.
        base: Base of the logarithm: 2 for bits.

    Returns:
        Local values (T - 1,), or a list of such arrays; their mean is ``combined_transfer_entropy``.

    Raises:
        SeriesError: The series cannot be measured.

    Examples:
        >>> s, a, r = [0, 1, 1, 0, 1, 0, 0, 1], [0, 0, 1, 1, 0, 1, 0, 0], [0, 0, 1, 0, 1, 1, 1, 0]
        >>> float(pointwise_combined_transfer_entropy(s, a, r).mean().round(3))
        0.857
    """
    return _pointwise(acted(s, a, r), information.COMBINED, base)


def pointwise_state_action_contingency(
    s: Series, a: Series, r: Series, base: float = 2
) -> np.ndarray | list[np.ndarray]:
    """State-action contingency SAC transition by transition.

    Args:
        s: What is sensed, (T,) integer codes, or a list of such arrays, one a recording.
        a: What is done, of the same lengths.
        r: What comes of it, likewise.
        base: Base of the logarithm: 2 for bits.

    Returns:
        Local values (T - 1,), or a list of such arrays; their mean is ``state_action_contingency``.

    Raises:
        SeriesError: The series cannot be measured.

    Examples:
        >>> s, a, r = [0, 1, 1, 0, 1, 0, 0, 1], [0, 0, 1, 1, 0, 1, 0, 0], [0, 0, 1, 0, 1, 1, 1, 0]
        >>> float(pointwise_state_action_contingency(s, a, r).mean().round(3))
        0.749
    """
    return _pointwise(acted(s, a, r), information.CONTINGENCY, base)


def pointwise_mutual_information(s: Series, r: Series, base: float = 2) -> np.ndarray | list[np.ndarray]:
    """Mutual information I(s[t]; r[t + 1]) transition by transition.

    Args:
        s: The source, (T,) integer codes, or a list of such arrays, one a recording.
        r: The target, of the same lengths.
        base: Base of the logarithm: 2 for bits.

    Returns:
        Local values (T - 1,), or a list of such arrays; their mean is ``mutual_information``.

    Raises:
        SeriesError: The series cannot be measured.

    Examples:
        >>> pointwise_mutual_information([0, 1, 0, 1, 0], [1, 0, 1, 0, 1]).round(3).tolist()
        [1.0, 1.0, 1.0, 1.0]
    """
    return _pointwise(steps(s, r), information.MUTUAL, base)


def pointwise_conditional_mutual_information(
    s: Series, r: Series, condition: Series, base: float = 2
) -> np.ndarray | list[np.ndarray]:
    """Conditional mutual information I(s[t]; r[t + 1] | condition[t]) transition by transition.

    Args:
        s: The source, (T,) integer codes, or a list of such arrays, one a recording.
        r: The target, of the same lengths.
        condition: What is known anyway, likewise.
        base: Base of the logarithm: 2 for bits.

    Returns:
        Local values (T - 1,), or a list of such arrays; their mean is ``conditional_mutual_information``.

    Raises:
        SeriesError: The series cannot be measured.

    Examples:
        >>> pointwise_conditional_mutual_information([0, 1, 0, 1], [1, 0, 1, 0], [0, 0, 0, 0]).shape
        (3,)
    """
    return _pointwise(acted(s, condition, r), information.CONDITIONAL_MUTUAL, base)


def contingent_saliency(s: Series, a: Series, r: Series, base: float = 2) -> np.ndarray:
    """Contingent saliency e(r', a; r, s): which next result and action carry SAC, given result and sensor (eq. 5.3).

    NaN for pairs (r, s) that were never observed. Under an observed pair, an entry (r', a) that did not occur there
    has a first term of 0 and keeps its second. The sum over r', a, weighted with p(r, s), is
    ``state_action_contingency``.

    Args:
        s: What is sensed, (T,) integer codes, or a list of such arrays, one a recording.
        a: What is done, of the same lengths.
        r: What comes of it, likewise.
        base: Base of the logarithm: 2 for bits.

    Returns:
        An array [r, s, r', a], indexed by the codes themselves.

    Raises:
        SeriesError: The series cannot be measured, or their codes are so large that the array would be huge: number
            them anew with ``recode`` first.

    Examples:
        >>> s, a, r = [0, 1, 1, 0, 1, 0, 0, 1], [0, 0, 1, 1, 0, 1, 0, 0], [0, 0, 1, 0, 1, 1, 1, 0]
        >>> contingent_saliency(s, a, r).shape
        (2, 2, 2, 2)
    """
    given, unit = acted(s, a, r), check_base(base)
    results, actions, sources, _ = given.sizes
    renumbered = any(
        coded is not None and coded.values is not None for coded in (given.source, given.target, given.condition)
    )
    if renumbered or results * results * actions * sources > LARGEST_SALIENCY:
        raise SeriesError("codes are too large to index an array of saliencies; number them anew with recode() first")
    entries = given.entries()
    before, action, source, after = entries.columns
    counts = entries.counts
    pairs = entries.marginal("rs")
    joint = counts / pairs * np.log(counts * pairs / (entries.marginal("ras") * entries.marginal("rsn")))
    saliency = np.zeros((results, sources, results, actions))
    saliency[before, source, after, action] = joint
    ran, ra, rn, r_only = (entries.marginal(axes) for axes in ("ran", "ra", "rn", "r"))
    alone = np.zeros((results, results, actions))
    alone[before, after, action] = ran / r_only * np.log(ran * r_only / (ra * rn))
    saliency -= alone[:, None]
    observed = np.zeros((results, sources), bool)
    observed[before, source] = True
    saliency[~observed] = np.nan
    return saliency / unit


def _measured(
    source: Series,
    target: Series,
    condition: Series | None,
    measure: Measure,
    base: float,
    correction: Correction,
    normalise: Normalise,
    surrogates: int,
    seed: int,
) -> float:
    unit = check_base(base)
    for name, choice, known in (("correction", correction, _CORRECTIONS), ("normalise", normalise, _NORMALISATIONS)):
        if not isinstance(choice, str) or choice not in known:
            raise SeriesError(f"{name} must be one of {', '.join(known)}; got {shown(choice)}")
    plain = correction == normalise == "none"
    if plain and (table := counted_at_once(source, target, condition)) is not None:
        return measure.dense_value(table, len(target) - 1) / unit
    given = steps(source, target, condition)
    table = given.dense()
    if plain and table is not None:
        return measure.dense_value(table, given.transitions) / unit
    entries = given.entries(table)
    value = measure.value(entries)
    if correction == "shuffle":
        if not isinstance(surrogates, (int, np.integer)) or surrogates < 1:
            raise SeriesError(f"surrogates must be a whole number of 1 or more; got {shown(surrogates)}")
        value -= float(plan(given, measure).draw(surrogates, generator(seed)).mean())
    elif correction != "none":
        value -= measure.bias(entries, correction)
    if normalise == "none":
        return value / unit
    bound = measure.bound(entries, normalise)
    return value / bound if bound > 1e-12 else 0.0


def _pointwise(given: Steps, measure: Measure, base: float) -> np.ndarray | list[np.ndarray]:
    unit = check_base(base)
    entries, which = given.entries_by_step()
    local = measure.local(entries)[which] / unit
    bounds = given.target.bounds
    return local if len(bounds) == 2 else np.split(local, bounds[1:-1] - np.arange(1, len(bounds) - 1))
