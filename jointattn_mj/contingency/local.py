"""Contingency value by value: which s with which a brings which r' about, given r.

That contingency is worth evaluating locally, for single values instead of whole variables, because few values carry
it and evidence for them comes sooner, is the idea of Mahzoon, Yoshikawa and Ishiguro (2016, doi
10.3389/frobt.2016.00010), who look for values that contribute in synergy. The estimates here are not theirs: an entry's
share of T^C or SAC, and an exact test of its count, corrected for the number of entries.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from jointattn_mj.contingency.combinations import SurrogateCounts
from jointattn_mj.contingency.information import CONTINGENCY, Measure
from jointattn_mj.contingency.names import OF_EVENTS, full_name
from jointattn_mj.contingency.series import Coded, Series, check_base
from jointattn_mj.contingency.significance import MEASURES, Adjust, adjust
from jointattn_mj.contingency.table import AXES, Entries, Steps, acted


@dataclass(frozen=True, repr=False)
class LocalContingency:
    """What one observed combination of values (r, s, a and the next r) adds to a measure."""

    before: int
    """Result before the step, r[t]."""
    sensor: int
    """Value of the sensor, s[t]."""
    action: int
    """Action, a[t]."""
    result: int
    """Result after the step, r[t + 1]."""
    count: int
    """How often it came."""
    occasions: int
    """How often r, s and a came, whatever followed."""
    expected: float
    """How often it would have come if s said nothing beyond r and a."""
    contribution: float
    """What the combination adds to the measure; over all combinations these add up to it."""
    z: float
    """Count less what it is by chance, in standard deviations by chance; 0 where there is no choice."""
    p: float
    """Chance of so high a count, or a higher one: with s permuted among transitions of the same r and a (exact), or in
    surrogates that move s as a whole, where looks are long."""
    p_adjusted: float
    """The same, corrected for the number of combinations."""
    known: str = "ra"
    """What else counts besides s and r': r, what the result was before, and a, the action. Others are 0."""

    def __repr__(self) -> str:
        values = f"r={self.before}, s={self.sensor}, a={self.action}, r'={self.result}"
        return (
            f"LocalContingency({values}: {self.contribution:.3g}, {self.count} of {self.occasions}, p = {self.p:.3g})"
        )

    @property
    def rate(self) -> float:
        """Share of the occasions on which the result came, p(r' | r, s, a)."""
        return self.count / self.occasions

    @property
    def usual(self) -> float:
        """The share that it has whatever the sensor says, p(r' | r, a)."""
        return self.expected / self.occasions

    def words(self, names: Sequence[str], labels: Mapping[str, Sequence[str]] | None = None) -> str:
        """Say it in words.

        Args:
            names: Of sensor, action and result.
            labels: What the codes of each are called, by these names; None: the codes stand for themselves.

        Returns:
            A line.

        Examples:
            >>> s, a, r = [0, 1, 1, 0, 1, 0, 0, 1], [0, 0, 1, 1, 0, 1, 0, 0], [0, 0, 1, 0, 1, 1, 1, 0]
            >>> local_contingency(s, a, r)[0].words(("face", "gaze", "toy"))
            'face 0 with gaze 0: toy 1 -> 0 in 1 of 1 (100%; 50% whatever face)'
        """
        called = [labels.get(name) if labels else None for name in names]
        sensor, action, before, result = (
            given[value] if given else str(value)
            for value, given in (
                (self.sensor, called[0]),
                (self.action, called[1]),
                (self.before, called[2]),
                (self.result, called[2]),
            )
        )
        acted = f" with {names[1]} {action}" if "a" in self.known else ""
        change = f"{before} -> {result}" if "r" in self.known else result
        return (
            f"{names[0]} {sensor}{acted}: {names[2]} {change} in {self.count} of "
            f"{self.occasions} ({self.rate:.0%}; {self.usual:.0%} whatever {names[0]})"
        )


def local_contingency(
    s: Series,
    a: Series,
    r: Series,
    measure: str = "state_action_contingency",
    base: float = 2,
    how: Adjust = "holm",
) -> tuple[LocalContingency, ...]:
    """Find the values that carry a contingency: every observed combination (r, s, a, r') and what it adds.

    p takes steps as exchangeable, which they are not where people's looks are long. ``jointattn measure`` and
    ``discover`` then take p of combinations from the same surrogates as that of the measure.

    Args:
        s: What is sensed, (T,) integer codes, or a list of such arrays, one a recording.
        a: What is done, of the same lengths.
        r: What comes of it, likewise.
        measure: ``sac`` or ``tc``, by any of their names (``names.NAMES``).
        base: Base of the logarithm: 2 for bits.
        how: Correction of p for the number of combinations.

    Returns:
        The combinations, those first that add most to the measure.

    Raises:
        SeriesError: Series that cannot be measured, or a measure without an action.

    Examples:
        >>> s, a, r = [0, 1, 1, 0, 1, 0, 0, 1], [0, 0, 1, 1, 0, 1, 0, 0], [0, 0, 1, 0, 1, 1, 1, 0]
        >>> first = local_contingency(s, a, r)[0]
        >>> first.sensor, first.action, first.result, first.count
        (0, 0, 0, 1)
    """
    chosen = MEASURES[full_name(measure, OF_EVENTS)]
    return local_of_steps(acted(s, a, r), chosen, check_base(base), how)


def local_of_steps(
    given: Steps,
    measure: Measure = CONTINGENCY,
    unit: float = 1.0,
    how: Adjust = "holm",
    counts: SurrogateCounts | None = None,
) -> tuple[LocalContingency, ...]:
    """Find the values that carry a measure in series that are checked (see ``local_contingency``).

    Args:
        given: The transitions.
        measure: Any. Combinations are of s, r' and what the measure takes as known.
        unit: Natural logarithm of the base.
        how: Correction of p for the number of combinations.
        counts: What counts are by chance, from surrogates that move s as a whole; None: p is exact, for steps that can
            change places. ``holm`` is then max-T, which keeps the same.
    """
    entries = _of_axes(given.entries(), measure.given + "sn")
    contribution = entries.counts * measure.local(entries) / entries.transitions / unit
    expected, z, p = _tested(entries)
    histories = (given.history or given.target, given.condition, given.source, given.target)
    before, action, source, after = (
        _named(column, coded) if axis in measure.given + "sn" else column
        for axis, column, coded in zip(AXES, entries.columns, histories, strict=True)
    )
    occasions, adjusted = entries.marginal("ras"), adjust(p, how)
    if counts is not None:
        z, p, together = counts.tested(entries.columns, entries.counts)
        adjusted = together if how == "holm" else adjust(p, how)
    combinations = [
        LocalContingency(
            before=int(before[i]),
            sensor=int(source[i]),
            action=int(action[i]),
            result=int(after[i]),
            count=int(entries.counts[i]),
            occasions=int(occasions[i]),
            expected=float(expected[i]),
            contribution=float(contribution[i]),
            z=float(z[i]),
            p=float(p[i]),
            p_adjusted=float(adjusted[i]),
            known=measure.given,
        )
        for i in np.argsort(-contribution, kind="stable")
    ]
    return tuple(combinations)


def carriers(
    combinations: Sequence[LocalContingency], alpha: float = 0.05, most: int = 3
) -> tuple[LocalContingency, ...]:
    """Pick the combinations that carry the measure.

    Args:
        combinations: All combinations, those that add most first.
        alpha: Level of significance, after the correction.
        most: So many at most.
    """
    return tuple(
        combination for combination in combinations if combination.contribution > 0 and combination.p_adjusted <= alpha
    )[:most]


def _of_axes(entries: Entries, axes: str) -> Entries:
    """The table over some axes; the others have the one value 0."""
    if set(axes) == set(AXES):
        return entries
    keys, bound = entries.ids("".join(axis for axis in AXES if axis in axes))
    occupied, first = np.unique(keys, return_index=True)
    counts = np.bincount(keys, entries.counts, bound)[occupied]
    kept = np.array([axis in axes for axis in AXES])
    return Entries(
        np.where(kept[:, None], entries.columns[:, first], 0),
        counts,
        tuple(size if keep else 1 for size, keep in zip(entries.sizes, kept, strict=True)),  # type: ignore[arg-type]
    )


def _tested(entries: Entries) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Expected count, z and one-sided p of each entry, (m,) each."""
    from scipy.stats import hypergeom  # takes longer to import than most tables to test

    context, with_source, with_result = (entries.marginal(axes) for axes in ("ra", "ras", "ran"))
    expected = with_source * with_result / context
    others = np.maximum(context - 1, 1)
    variance = expected * (context - with_source) * (context - with_result) / context / others
    z = np.where(variance > 0, (entries.counts - expected) / np.sqrt(np.where(variance > 0, variance, 1)), 0.0)
    p = hypergeom.sf(entries.counts - 1, context, with_result, with_source)
    return expected, z, np.clip(p, 0, 1)


def _named(column: np.ndarray, coded: Coded | None) -> np.ndarray:
    """Codes as the caller gave them."""
    return column if coded is None or coded.values is None else coded.values[column]
