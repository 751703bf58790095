"""A scan over lags: at which delay does the source say most, and is that more than chance over all lags tried?"""

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass

import numpy as np

from jointattn_mj.contingency.displaced import displaced, moves
from jointattn_mj.contingency.information import Measure
from jointattn_mj.contingency.lagged import Timing, at_lags, timed
from jointattn_mj.contingency.memory import memory
from jointattn_mj.contingency.names import full_name
from jointattn_mj.contingency.series import Series, check_base
from jointattn_mj.contingency.significance import MEASURES, TestOptions, chosen_method, drawn, generator
from jointattn_mj.contingency.table import Steps, steps
from jointattn_mj.errors import SeriesError
from jointattn_mj.options import shown

AT_ONCE = 2**23
"""Transitions, of all lags together, that are prepared at a time. More lags are measured part by part, each with the
same surrogates: all 30 lags of ten million steps would take 3 GB."""


@dataclass(frozen=True, repr=False)
class LagScan:
    """A measure at several lags; values in units of the base, each (lags,)."""

    lags: np.ndarray
    """Steps from source to result."""
    value: np.ndarray
    """Plug-in."""
    effective: np.ndarray
    """Less the mean of the surrogates."""
    chance: np.ndarray
    """What the effective value stays below by chance, at this lag alone, in ``level`` of the surrogates."""
    chance_of_all: np.ndarray
    """The same for all lags together."""
    p: np.ndarray
    """For each lag alone."""
    p_adjusted: np.ndarray
    """For the lags together: share of surrogates whose largest z over all lags reaches this lag's (max-T, Westfall and
    Young 1993). Neighbouring lags that say the same are not counted twice."""
    level: float
    transitions: int
    surrogates: int
    method: str
    """How surrogates were made (see ``significance.Method``)."""
    recordings: int = 0
    """Recordings whose values were averaged; 0: all their steps were taken together."""

    @property
    def best(self) -> int:
        """Place of the lag whose value stands out most."""
        order = np.lexsort((-self.effective, self.p_adjusted))
        return int(order[0])

    def __repr__(self) -> str:
        at = self.best
        return (
            f"LagScan({len(self.lags)} lags, best {self.lags[at]}: {self.effective[at]:.3g} effective, adjusted p = "
            f"{self.p_adjusted[at]:.3g})"
        )

    def rows(self) -> list[dict[str, float | int]]:
        """Give the values as rows of a table.

        Returns:
            A mapping a lag, with the values of all columns of ``lags`` that ``jointattn measure --scan`` writes.

        Examples:
            >>> from jointattn_mj import contingency
            >>> source, target = [0, 1, 1, 0, 1, 0, 0, 1] * 20, [1, 0, 1, 1, 0, 1, 0, 0] * 20
            >>> scan = contingency.scan_lags("te", source, target, lags=[1, 2])
            >>> [row["lag"] for row in scan.rows()]
            [1, 2]
        """
        return [
            {
                "lag": int(self.lags[i]),
                "plug_in": float(self.value[i]),
                "effective": float(self.effective[i]),
                "chance": float(self.chance[i]),
                "chance_of_all_lags": float(self.chance_of_all[i]),
                "p": float(self.p[i]),
                "p_adjusted": float(self.p_adjusted[i]),
            }
            for i in range(len(self.lags))
        ]


def scan_lags(
    measure: str,
    source: Series,
    target: Series,
    condition: Series | None = None,
    *,
    lags: Sequence[int] = tuple(range(1, 31)),
    timing: Timing | None = None,
    options: TestOptions | None = None,
    base: float = 2,
    seed: int | np.random.SeedSequence | np.random.Generator = 0,
    groups: Sequence[int] | None = None,
    progress: Callable[[int], object] = lambda done: None,
) -> LagScan:
    """Measure what the source says about the target at several lags, and test them together.

    All lags have the same results, and the same surrogates: the source is moved as a whole, and measured at every lag.

    Args:
        measure: One of the names of a measure (``names.NAMES``).
        source: What may have an influence, (T,) integer codes, or a list of such arrays, one a recording.
        target: What may be influenced, of the same lengths.
        condition: The action, or what is known anyway; for the measures that have one. It has the lag of the source.
        lags: Steps from source to result, each 1 or more.
        timing: Histories; None: one value each.
        options: Number and method of surrogates. Permutations cannot be shared by lags: shifts take their place.
        base: Base of the logarithm: 2 for bits.
        seed: Seed of the surrogates, or a generator.
        groups: Numbers of the recordings (see ``assess``).
        progress: Called with the number of surrogates drawn since the last call.

    Returns:
        Value, chance level and p at each lag.

    Raises:
        SeriesError: Series that cannot be measured, no or bad lags, a condition missing or superfluous, or recordings
            shorter than the longest lag.

    Examples:
        >>> rng = np.random.default_rng(0)
        >>> source = rng.integers(0, 2, 300)
        >>> target = np.roll(source, 3)  # what the source was three steps before
        >>> scan = scan_lags("te", source, target, lags=range(1, 6), options=TestOptions(surrogates=99))
        >>> int(scan.lags[scan.best]), float(scan.p_adjusted[scan.best])
        (3, 0.01)
    """
    chosen = MEASURES[full_name(measure)]
    if ("a" in chosen.given) != (condition is not None):
        verb = "needs" if condition is None else "takes no"
        raise SeriesError(f"{measure} {verb} condition")
    given = steps(source, target, condition, groups)
    return scan_steps(
        given, chosen, lags, timing or Timing(), options or TestOptions(), check_base(base), generator(seed), progress
    )


def scan_steps(
    given: Steps,
    measure: Measure,
    lags: Sequence[int],
    timing: Timing,
    options: TestOptions,
    unit: float,
    rng: np.random.Generator,
    progress: Callable[[int], object] = lambda done: None,
) -> LagScan:
    """Scan lags of series that are checked (see ``scan_lags``).

    Args:
        given: The series.
        measure: What is measured.
        lags: Steps from source to result.
        timing: Histories.
        options: Number and method of surrogates.
        unit: Natural logarithm of the base.
        rng: Draws the surrogates.
        progress: Called with the number of surrogates drawn since the last call.
    """
    return lag_scan(lags, scan_surrogates(given, measure, lags, timing, options, unit, rng, progress), options.level)


@dataclass(frozen=True)
class ScanSurrogates:
    """Values at several lags, in units of the base, and those of surrogates that all lags share."""

    value: np.ndarray
    """Plug-in (lags,)."""
    null: np.ndarray
    """(surrogates, lags)."""
    transitions: int
    method: str


def scan_surrogates(
    given: Steps,
    measure: Measure,
    lags: Sequence[int],
    timing: Timing,
    options: TestOptions,
    unit: float,
    rng: np.random.Generator,
    progress: Callable[[int], object] = lambda done: None,
) -> ScanSurrogates:
    """Measure series, and surrogates of them, at several lags; arguments as of ``scan_steps``.

    Raises:
        SeriesError: No or bad lags, or recordings shorter than the longest one.
    """
    _check_lags(lags)
    timings = at_lags(lags, timing)
    reach = max(delay.reach for delay in timings)
    first = timed(given, timings[0], reach)
    remembered = memory(first, measure)
    method = chosen_method(first, remembered, options)
    how = "shift" if method == "permutation" else method
    moved = moves(first, how, max(remembered.fresh_after, max(lags) - min(lags)), remembered.block)
    size = max(1, AT_ONCE // first.transitions)
    parts = [timings[start : start + size] for start in range(0, len(timings), size)]
    told, same = in_turn(progress, len(parts)), [deepcopy(rng) for _ in parts[1:]]

    def measured(part: Sequence[Timing], draws: np.random.Generator) -> tuple[list[float], np.ndarray]:
        value, tables = [], []
        for delay in part:
            shifted = timed(given, delay, reach)
            value.append(measure.value(shifted.entries()))
            tables.append(displaced(shifted, [measure]))

        def values(pieces: np.ndarray) -> np.ndarray:
            return np.concatenate([table.values(pieces) for table in tables])

        return value, drawn(moved, values, first.transitions * len(part), options.surrogates, draws, told)

    value, null = zip(*(measured(part, draws) for part, draws in zip(parts, [*same, rng], strict=True)), strict=True)
    return ScanSurrogates(np.concatenate(value) / unit, np.concatenate(null, 1) / unit, first.transitions, how)


def in_turn(progress: Callable[[int], object], parts: int) -> Callable[[int], object]:
    """Give a function that tells ``progress`` of a surrogate when so many parts have drawn one."""
    done = 0

    def tell(more: int) -> None:
        nonlocal done
        told, done = done // parts, done + more
        progress(done // parts - told)

    return tell


def _check_lags(lags: Sequence[int]) -> None:
    try:
        numbers = [int(lag) for lag in lags]
        sound = numbers == list(lags) and min(numbers) >= 1 and len(set(numbers)) == len(numbers)
    except (TypeError, ValueError, OverflowError):  # no numbers, or none at all
        sound = False
    if not sound:
        raise SeriesError(f"lags must be different whole numbers of 1 or more; got {shown(lags)}")


def lag_scan(lags: Sequence[int], surrogates: ScanSurrogates, level: float, recordings: int = 0) -> LagScan:
    """Chance levels and p at each lag.

    Args:
        lags: Steps from source to result.
        surrogates: Values and surrogates at these lags.
        level: Share of surrogates that stay below chance levels.
        recordings: Recordings whose values were averaged; 0: all their steps were taken together.
    """
    value, null = surrogates.value, surrogates.null
    mean, sd = null.mean(0), null.std(0)
    rounding = 1e-12 * np.maximum(1, np.abs(value))
    sound = np.where(sd > rounding, sd, 1.0)
    z, of_null = (value - mean) / sound, (null - mean) / sound
    highest = of_null.max(1)
    return LagScan(
        lags=np.array(lags, np.int64),
        value=value,
        effective=value - mean,
        chance=np.quantile(null, level, axis=0) - mean,
        chance_of_all=np.quantile(highest, level) * np.where(sd > rounding, sd, 0.0),
        p=(1 + np.sum(null >= value - rounding, axis=0)) / (1 + len(null)),
        p_adjusted=(1 + np.sum(highest[:, None] >= z - 1e-9, axis=0)) / (1 + len(null)),
        level=level,
        transitions=surrogates.transitions,
        surrogates=len(null),
        method=surrogates.method,
        recordings=recordings,
    )
