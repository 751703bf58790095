"""Agreement of two coders of the same recording: Cohen's kappa by units of time, with tolerance."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np

from jointattn_mj.errors import SeriesError
from jointattn_mj.io.progress import count
from jointattn_mj.options import Checked, Real, Seed, Whole
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.intervals import MISSING, at_times, intervals_of
from jointattn_mj.recordings.sampling import MOST_STEPS

UNKNOWN = -2
"""Number of a code that is missing."""


@dataclass(frozen=True)
class AgreementOptions(Checked):
    """Units of time, tolerance and interval."""

    step: Annotated[float, Real("[1e-3, 1e3]")] = 0.1
    """Unit of time in seconds."""
    tolerance_s: Annotated[float, Real("[0, 60]")] = 0.0
    """A unit counts as agreement if the other coder has the same code within so many seconds before or after."""
    resamples: Annotated[int, Whole("[0, 1e6]")] = 500
    """Bootstrap resamples behind the interval; 0 leaves it out."""
    block_s: Annotated[float, Real("(0, 1e5]")] = 30.0
    """Seconds of a block that is drawn: longer than looks last, as units within one look tell the same."""
    level: Annotated[float, Real("(0, 1)")] = 0.95
    """Coverage of the interval."""
    seed: Seed = 0
    """Random seed of the resamples."""


@dataclass(frozen=True, repr=False)
class Agreement:
    """How far two coders agree on one tier."""

    tier: str
    labels: tuple[str, ...]
    matrix: np.ndarray
    """Units (codes, codes): first coder's code, second coder's code. With tolerance the mean of both directions."""
    interval: tuple[float, float]
    """Of kappa; NaN where it was left out."""
    step: float
    tolerance_s: float
    outside_s: float
    """Seconds that only one of the two has coded: they are left out."""
    level: float = 0.95
    """Coverage of the interval."""
    alone: tuple[str, ...] = ()
    """Recordings that only one of the two has coded: they are left out."""
    other_tiers: tuple[str, ...] = ()
    """Tiers that only one of the two has, unless tiers were chosen: they are left out."""
    missing_s: float = 0.0
    """Seconds in which a coder's code is missing: they are left out."""
    moments: int = 0
    """Point events of both coders: they are left out, as they have no length."""

    def __repr__(self) -> str:
        return (
            f"Agreement({self.tier!r}, {len(self.labels)} codes, kappa {self.kappa:.2f}, {self.matrix.sum():g} units)"
        )

    @property
    def observed(self) -> float:
        """Share of units in which they agree."""
        return float(np.trace(self.matrix) / self.matrix.sum())

    @property
    def expected(self) -> float:
        """Share of units in which they would agree by chance, given how often each uses each code."""
        return _expected(self.matrix)

    @property
    def kappa(self) -> float:
        """Cohen's kappa (1960); NaN where both use one code alone."""
        return kappa(self.matrix)

    @property
    def kappa_max(self) -> float:
        """The highest kappa that is possible with these frequencies of codes."""
        shares = self.matrix / self.matrix.sum()
        most = float(np.minimum(shares.sum(0), shares.sum(1)).sum())
        return (most - self.expected) / (1 - self.expected) if self.expected < 1 else float("nan")

    def by_code(self) -> dict[str, float]:
        """Kappa of each code against all others."""
        kappas = {}
        for i, label in enumerate(self.labels):
            both, first, second = self.matrix[i, i], self.matrix[i].sum(), self.matrix[:, i].sum()
            rest = self.matrix.sum() - first - second + both
            kappas[label] = kappa(np.array([[both, first - both], [second - both, rest]]))
        return kappas

    def notes(self) -> tuple[str, ...]:
        """What was left out, and a tolerance that changes nothing. Those of several tiers may be the same."""
        notes = []
        left_out = [
            f"{count(len(names), what)} ({', '.join(names[:5])}{' ...' if len(names) > 5 else ''})"
            for what, names in (("recording", self.alone), ("tier", self.other_tiers))
            if names
        ]
        left_out += [f"{self.outside_s:.1f} s"] if self.outside_s else []
        if left_out:
            notes.append(f"left out, as only one coder has coded it: {' and '.join(left_out)}")
        if self.missing_s:
            notes.append(f"left out of the tier {self.tier!r}, as a code is missing: {self.missing_s:.1f} s")
        if self.moments:
            notes.append(
                f"left out of the tier {self.tier!r}, as they have no length: {count(self.moments, 'point event')}"
            )
        if 0 < self.tolerance_s < self.step * (1 - 1e-6):
            notes.append(
                f"a tolerance of {self.tolerance_s:g} s is less than a unit of {self.step:g} s: it changes nothing"
            )
        return tuple(notes)

    def row(self) -> dict[str, Any]:
        """The comparison as one row of a table."""
        return {
            "tier": self.tier, "kappa": self.kappa, "low": self.interval[0], "high": self.interval[1],
            "observed": self.observed, "expected": self.expected, "kappa_max": self.kappa_max,
            "units": float(self.matrix.sum()), "step": self.step, "tolerance_s": self.tolerance_s,
            "outside_s": self.outside_s, "missing_s": self.missing_s, "moments": self.moments,
            "left_out": ", ".join(self.alone),
        }  # fmt: skip


def kappa(matrix: np.ndarray) -> float:
    """Cohen's kappa of an agreement matrix (codes, codes); NaN where it is not defined.

    Examples:
        >>> round(kappa(np.array([[88, 14, 18], [10, 40, 10], [2, 6, 12]])), 3)  # .70 alike, .41 by chance
        0.492
    """
    matrix = np.asarray(matrix, float)
    expected = _expected(matrix)
    if not expected < 1:
        return float("nan")
    return float((np.trace(matrix) / matrix.sum() - expected) / (1 - expected))


def agreement(
    first: Events, second: Events, tiers: Sequence[str] | None = None, options: AgreementOptions | None = None
) -> tuple[Agreement, ...]:
    """Compare two coders, tier by tier. Recordings are matched by name, or one with one whatever their names.

    Nothing coded is a code of its own. What only one coder has coded, times at which a code is missing and point events
    are left out, and told.

    Args:
        first: Events of the first coder.
        second: Events of the second coder.
        tiers: Names of tiers that both have; None: all of these.
        options: Units, tolerance and interval; None: the defaults.

    Raises:
        SeriesError: No tier or recording in common, a tier that one of them lacks, or nothing to compare.
    """
    options = options or AgreementOptions()
    pairs = _matched(first, second)
    common = [name for name in first.tier_names if name in second.tier_names]
    chosen = common if tiers is None else list(tiers)
    for tier in chosen:
        if tier not in common:
            raise SeriesError(f"both coders need a tier {tier!r}; they share {', '.join(common) or 'none'}")
    if not chosen:
        raise SeriesError(
            f"the coders share no tier: {', '.join(first.tier_names)} against {', '.join(second.tier_names)}"
        )
    matched = {name for pair in pairs for name in pair}
    alone = tuple(name for coding in (first, second) for name in coding.recordings if name not in matched)
    others = () if tiers is not None else tuple(sorted({*first.tier_names} ^ {*second.tier_names}))
    return tuple(
        replace(_of_tier(first, second, pairs, tier, options), alone=alone, other_tiers=others) for tier in chosen
    )


def _of_tier(
    first: Events, second: Events, pairs: list[tuple[str, str]], tier: str, options: AgreementOptions
) -> Agreement:
    coded_pairs, outside = [], 0.0
    for names in pairs:
        ends = [_ends(events, name) for events, name in zip((first, second), names, strict=True)]
        start, stop = max(end[0] for end in ends), min(end[1] for end in ends)
        outside += max(end[1] for end in ends) - min(end[0] for end in ends) - max(stop - start, 0.0)
        units = int((stop - start) / options.step + 1e-6)
        if units > MOST_STEPS:
            raise SeriesError(
                f"recording {names[0]!r} has {units:,} units of {options.step:g} s, and no more than {MOST_STEPS:,} "
                "can be held; take a longer step, or look whether its times are right"
            )
        if units > 0:
            middles = start + (np.arange(units) + 0.5) * options.step
            coded_pairs.append(
                [_codes_at(events, name, tier, middles) for events, name in zip((first, second), names, strict=True)]
            )
    if not coded_pairs:
        raise SeriesError(f"the coders have no time of tier {tier!r} in common")
    labels = sorted({str(label) for pair in coded_pairs for codes in pair for label in np.unique(codes)} - {MISSING})
    number = {label: i for i, label in enumerate(labels)}
    reach = int(options.tolerance_s / options.step + 1e-6)
    coded = [[np.array([number.get(label, UNKNOWN) for label in codes]) for codes in pair] for pair in coded_pairs]
    known = [(a != UNKNOWN) & (b != UNKNOWN) for a, b in coded]
    if not any(both.any() for both in known):
        raise SeriesError(f"at no time do both coders say what is on the tier {tier!r}; its codes are missing")
    counted = [_tallied(a, b, reach)[both] for (a, b), both in zip(coded, known, strict=True)]
    matrix = sum(_matrix(pair, len(labels)) for pair in counted) / 2
    moments = sum(_moments(*coder, tier) for coder in zip((first, second), zip(*pairs, strict=True), strict=True))
    interval = _interval(counted, len(labels), options)
    return Agreement(
        tier, tuple(labels), np.asarray(matrix), interval, options.step, options.tolerance_s,
        float(max(outside, 0.0)), options.level, missing_s=sum(int((~both).sum()) for both in known) * options.step,
        moments=moments,
    )  # fmt: skip


def _moments(events: Events, recordings: Sequence[str], tier: str) -> int:
    """Number of point events of a tier."""
    table = events.table
    of_tier = (table["tier"] == tier) & np.isin(table["recording"], recordings)
    return int((of_tier & (table["onset"] == table["offset"])).sum())


def _tallied(first: np.ndarray, second: np.ndarray, reach: int) -> np.ndarray:
    """(units, 4): first's and second's code as tallied from the first, and from the second.

    In a unit where one coder has the other's code within ``reach`` units, it counts as this.
    """
    return np.stack([first, _nearby(first, second, reach), _nearby(second, first, reach), second], 1)


def _nearby(own: np.ndarray, other: np.ndarray, reach: int) -> np.ndarray:
    """The other's codes (units,), replaced by this one's wherever the other has that within ``reach``."""
    taken = other.copy()
    for shift in range(1, reach + 1):
        for direction in (shift, -shift):
            moved = np.full(len(other), -1)
            if shift < len(other):
                if direction > 0:
                    moved[shift:] = other[:-shift]
                else:
                    moved[:-shift] = other[shift:]
            taken = np.where(moved == own, own, taken)
    return np.where(other == own, own, taken)


def _matrix(tallied: np.ndarray, size: int) -> np.ndarray:
    both = [np.bincount(tallied[:, i] * size + tallied[:, i + 1], minlength=size * size) for i in (0, 2)]
    return (both[0] + both[1]).reshape(size, size).astype(float)


def _interval(counted: list[np.ndarray], size: int, options: AgreementOptions) -> tuple[float, float]:
    if not options.resamples:
        return float("nan"), float("nan")
    length = max(1, round(options.block_s / options.step))
    blocks = np.array(
        [_matrix(pair[at : at + length], size) for pair in counted for at in range(0, len(pair), length)]
    )  # (blocks, codes, codes)
    rng = np.random.default_rng(options.seed)
    draws = rng.multinomial(len(blocks), np.full(len(blocks), 1 / len(blocks)), options.resamples)
    values = np.array([kappa(np.tensordot(draw, blocks, 1)) for draw in draws])
    values = values[np.isfinite(values)]
    if not len(values):
        return float("nan"), float("nan")
    low, high = np.quantile(values, [(1 - options.level) / 2, (1 + options.level) / 2])
    return float(low), float(high)


def _expected(matrix: np.ndarray) -> float:
    shares = matrix / matrix.sum()
    return float(shares.sum(0) @ shares.sum(1))


def _matched(first: Events, second: Events) -> list[tuple[str, str]]:
    common = [name for name in first.recordings if name in second.recordings]
    if common:
        return [(name, name) for name in common]
    if len(first.recordings) == len(second.recordings) == 1:
        return [(first.recordings[0], second.recordings[0])]
    raise SeriesError(
        f"the coders share no recording: {', '.join(first.recordings[:5])} against {', '.join(second.recordings[:5])}"
    )


def _ends(events: Events, recording: str) -> tuple[float, float]:
    """When coding began and ended."""
    if recording in events.spans:
        return events.spans[recording]
    rows = events.table["recording"] == recording
    if not rows.any():
        return 0.0, 0.0
    return float(events.table["onset"][rows].min()), float(events.table["offset"][rows].max())


def _codes_at(events: Events, recording: str, tier: str, times: np.ndarray) -> np.ndarray:
    """Codes (units,) at some times, ``(none)`` where nothing is coded."""
    return at_times(intervals_of(events, recording, tier), times)
