"""Whether a measure says more than chance, how far it can be trusted, and what holds when many events are tested."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import islice
from typing import Annotated, Literal, Protocol, get_args

import numpy as np

from jointattn_mj.contingency import bootstrap, information
from jointattn_mj.contingency.bootstrap import Resample
from jointattn_mj.contingency.combinations import SurrogateCounts
from jointattn_mj.contingency.displaced import FEWEST_RECORDINGS, Displacement, displaced, moves
from jointattn_mj.contingency.information import Measure
from jointattn_mj.contingency.lagged import Timing, timed
from jointattn_mj.contingency.memory import Memory, memory
from jointattn_mj.contingency.names import full_name
from jointattn_mj.contingency.series import Series, check_base
from jointattn_mj.contingency.surrogates import Permute, plan
from jointattn_mj.contingency.table import Entries, Steps, steps
from jointattn_mj.errors import SeriesError
from jointattn_mj.options import Checked, Count, Real, Whole, shown

MEASURES: dict[str, Measure] = {
    "transfer_entropy": information.TRANSFER,
    "combined_transfer_entropy": information.COMBINED,
    "state_action_contingency": information.CONTINGENCY,
    "mutual_information": information.MUTUAL,
    "conditional_mutual_information": information.CONDITIONAL_MUTUAL,
}
"""By the names of the functions that compute them."""

Adjust = Literal["holm", "benjamini_hochberg", "none"]
"""For many tests: ``holm`` keeps the chance of any false alarm below alpha, ``benjamini_hochberg`` the share of false
ones among those that are called significant."""

Method = Literal["auto", "permutation", "shift", "bootstrap", "partners"]
"""How surrogates are made. ``permutation``: the source changes places among transitions of one context, which is right
where source or target is fresh at every step. ``shift``, ``bootstrap``, ``partners``: the source is moved as a whole
against the rest (see ``displaced.Displacement``), which is right for long looks, too. ``auto``: as the series' measured
memory says (see ``chosen_method``)."""

ENOUGH_PARTNERS = 8
"""Recordings from which on ``auto`` takes partners where looks are too long to be shifted."""
MOST_COUNTS = 10_000_000
"""Combinations times surrogates up to which counts of all are kept."""
MOST_THREADS, WORTH_THREADS = 8, 100_000
"""Threads that count surrogates, and transitions from which on they do."""
ENOUGH_SHIFTS = 20
"""Recordings are too short to be shifted if half of them last less than so many least shifts."""


@dataclass(frozen=True)
class TestOptions(Checked):
    """How a measure is tested.

    Examples:
        >>> TestOptions(surrogates=199, method="shift").resamples
        500
    """

    __test__ = False  # no test case, whatever its name looks like

    surrogates: Annotated[int, Whole("[1, 1e9]")] = 1000
    """Surrogates of the source; p cannot be smaller than 1 / (surrogates + 1)."""
    permute: Permute = "context"
    """See ``surrogates.Permute``."""
    across_recordings: bool = False
    """Permute among all recordings instead of within each: more powerful where they are short, wrong where they
    differ."""
    resamples: Annotated[int, Whole("[0, 1e9]")] = 500
    """Bootstrap resamples for the interval; 0 leaves it out."""
    resample: Resample = "auto"
    """See ``bootstrap.Resample``."""
    block: Count | None = None
    """Transitions in a block; none is the cube root of their number."""
    level: Annotated[float, Real("(0, 1)")] = 0.95
    """Coverage of the interval."""
    method: Method = "auto"
    """See ``Method``."""
    limit: Annotated[float, Real("[1, 1e6]")] = 1.02
    """``auto`` permutes where memory changes the variance by chance by less than this factor: at 1.05 permutations gave
    7% false alarms at .05."""


@dataclass(frozen=True, repr=False)
class Significance:
    """A measure and what is known about it; in units of the logarithm's base (bits for 2).

    Examples:
        >>> face = np.random.default_rng(0).integers(0, 3, 400)
        >>> tested = assess("te", face, np.append(0, face[:-1]), options=TestOptions(surrogates=99, resamples=0))
        >>> tested.p, tested.corrected > 1
        (0.01, True)
    """

    value: float
    """Plug-in."""
    corrected: float
    """Effective value: less the mean of the surrogates."""
    null_mean: float
    """Mean of the surrogates."""
    null_sd: float
    """Their standard deviation."""
    z: float
    """``corrected`` in such standard deviations; 0 where surrogates do not differ."""
    p: float
    """(1 + surrogates at or above the value) / (1 + surrogates)."""
    interval: tuple[float, float]
    """Bias-corrected bootstrap interval; NaN where it was left out."""
    level: float
    """Its coverage."""
    transitions: int
    exchangeable: int
    """Transitions that surrogates could change; where there are few of them, p says nothing."""
    surrogates: int
    resampled: str
    """What the interval comes from: blocks or recordings."""
    method: str = "permutation"
    """How the surrogates were made (see ``Method``)."""
    inflation: float = 1.0
    """How much more the measure varies by chance than it would with permutations (see ``memory``)."""
    null: np.ndarray = field(default_factory=lambda: np.zeros(0), repr=False, compare=False)
    """The surrogates' values, (surrogates,)."""
    counts: SurrogateCounts | None = field(default=None, repr=False, compare=False)
    """How often each combination of values came in the surrogates, where these are no permutations and it was asked
    for."""

    def __repr__(self) -> str:
        low, high = self.interval
        interval = "" if np.isnan(low) else f", {self.level:.0%} interval {low:.3g} to {high:.3g}"
        p = f"p = {self.p:.3g}, {self.transitions:,} transitions"
        return f"Significance({self.corrected:.3g} effective{interval}, {p})"


def assess(
    measure: str,
    source: Series,
    target: Series,
    condition: Series | None = None,
    *,
    options: TestOptions | None = None,
    base: float = 2,
    seed: int | np.random.SeedSequence | np.random.Generator = 0,
    groups: Sequence[int] | None = None,
    timing: Timing | None = None,
    progress: Callable[[int], object] = lambda done: None,
) -> Significance:
    """Test a measure: does the source say more about the target's next value than chance would?

    A permutation test takes the transitions of one context as exchangeable. They are not where the source stays the
    same for long and the result remembers more than one step, as with people's looks: p would be too small. The memory
    of both is therefore measured, and by default the source is then shifted in a circle instead.

    Args:
        measure: One of the names of a measure (``names.NAMES``).
        source: What may have an influence, (T,) integer codes, or a list of such arrays, one a recording.
        target: What may be influenced, of the same lengths.
        condition: The action, or what is known anyway; for the measures that have one.
        options: Number and kind of surrogates and resamples; None: the defaults of ``TestOptions``.
        base: Base of the logarithm: 2 for bits.
        seed: Seed of surrogates and resamples, or a generator.
        groups: (k,) numbers of the k recordings given. Those with the same number are pieces of one that was cut at
            gaps: the source is permuted among them, and they are resampled together. None: each is its own.
        timing: Delay from source and condition to result, and histories; None: one step.
        progress: Called with the number of surrogates or resamples drawn since the last call.

    Returns:
        The value with its null distribution, p and interval, in units of the base.

    Raises:
        SeriesError: Series that cannot be measured, an unknown measure, or a condition missing or superfluous.

    Examples:
        >>> rng = np.random.default_rng(0)
        >>> source = rng.integers(0, 2, 200)
        >>> target = np.roll(source, 1)  # what the source was a step before
        >>> tested = assess("transfer_entropy", source, target, options=TestOptions(surrogates=99, resamples=0))
        >>> round(tested.value, 2), tested.p
        (0.99, 0.01)
    """
    chosen = MEASURES[full_name(measure)]
    if ("a" in chosen.given) != (condition is not None):
        verb = "needs" if condition is None else "takes no"
        raise SeriesError(f"{measure} {verb} condition")
    given = timed(steps(source, target, condition, groups), timing or Timing())
    return assess_steps(given, chosen, options or TestOptions(), check_base(base), generator(seed), progress)


def assess_steps(
    given: Steps,
    measure: Measure,
    options: TestOptions,
    unit: float,
    rng: np.random.Generator,
    progress: Callable[[int], object] = lambda done: None,
    local: bool = False,
) -> Significance:
    """Test a measure on series that are checked (see ``assess``).

    Args:
        given: The transitions.
        measure: What is tested.
        options: Number and kind of surrogates and resamples.
        unit: Natural logarithm of the base.
        rng: Draws surrogates, then resamples.
        progress: Called with the number of surrogates or resamples drawn since the last call.
        local: Also keep how often each combination of values comes in the surrogates.
    """
    return assess_measures(given, [measure], options, unit, [rng], progress, local)[0]


def assess_measures(
    given: Steps,
    measures: Sequence[Measure],
    options: TestOptions,
    unit: float,
    rngs: Sequence[np.random.Generator],
    progress: Callable[[int], object] = lambda done: None,
    local: bool = False,
) -> list[Significance]:
    """Test several measures of the same series. Those whose surrogates move the source as a whole share these.

    Args:
        given: The transitions.
        measures: What is tested.
        options: Number and kind of surrogates and resamples.
        unit: Natural logarithm of the base.
        rngs: One for each measure: draws its surrogates, then its resamples; shared ones come from the first's.
        progress: Called with the number of surrogates or resamples drawn since the last call.
        local: Also keep how often each combination of values comes in the surrogates.
    """
    remembered = [memory(given, measure) for measure in measures]
    methods = [chosen_method(given, columns, options) for columns in remembered]
    moved: dict[int, tuple[np.ndarray, int, SurrogateCounts | None]] = {}
    for how in dict.fromkeys(methods):
        if how == "permutation":
            continue
        at = [i for i, method in enumerate(methods) if method == how]
        table = displaced(given, [measures[i] for i in at])
        ways = moves(given, how, max(remembered[i].fresh_after for i in at), max(remembered[i].block for i in at))
        told = _told(progress, len(at))
        counted = local and sum(table.cells) * options.surrogates <= MOST_COUNTS
        values = table.values_and_counts if counted else table.values
        null = drawn(ways, values, table.transitions, options.surrogates, rngs[at[0]], told)
        bounds = np.cumsum([len(at), *table.cells])
        for column, i in enumerate(at):
            kept = null[:, bounds[column] : bounds[column + 1]].astype(np.float32)
            counts = SurrogateCounts(table.combinations(column), kept) if counted else None
            moved[i] = null[:, column], table.exchangeable, counts
    entries = given.entries_by_step() if options.resamples else (given.entries(), np.zeros(0, np.int64))
    return [
        _assessed(given, entries, measure, options, unit, rngs[i], progress, methods[i], remembered[i], moved.get(i))
        for i, measure in enumerate(measures)
    ]


def _assessed(
    given: Steps,
    counted: tuple[Entries, np.ndarray],
    measure: Measure,
    options: TestOptions,
    unit: float,
    rng: np.random.Generator,
    progress: Callable[[int], object],
    method: Method,
    remembered: Memory,
    moved: tuple[np.ndarray, int, SurrogateCounts | None] | None,
) -> Significance:
    """One measure; ``moved``: its surrogates, exchangeable transitions and counts, where these are no permutations."""
    entries = counted[0]
    value = measure.value(entries)
    block = options.block
    if moved is None:
        surrogates = plan(given, measure, options.permute, options.across_recordings)
        null, exchangeable = surrogates.draw(options.surrogates, rng, progress), surrogates.exchangeable
        counts = None
    else:
        null, exchangeable, counts = moved
        block = block or max(remembered.block, bootstrap.default_block(given.transitions))
    mean, sd = float(null.mean()), float(null.std())
    rounding = 1e-12 * max(1.0, abs(value))
    resampled = bootstrap.chosen(given, options.resample)
    low = high = float("nan")
    if options.resamples:
        values = bootstrap.resampled(given, measure, options.resamples, rng, resampled, block, progress, counted)
        bias = measure.bias(entries, "degrees_of_freedom") if moved is None else mean
        low, high = bootstrap.interval(value, values, bias, options.level)
        if moved is not None:
            low = bootstrap.agreeing(low, value - rounding, null, 1 - options.level)
            high = max(low, high)
    return Significance(
        value=value / unit,
        corrected=(value - mean) / unit,
        null_mean=mean / unit,
        null_sd=sd / unit,
        z=(value - mean) / sd if sd > rounding else 0.0,
        p=float((1 + np.sum(null >= value - rounding)) / (1 + len(null))),
        interval=(low / unit, high / unit),
        level=options.level,
        transitions=given.transitions,
        exchangeable=exchangeable,
        surrogates=len(null),
        resampled=resampled,
        method=method,
        inflation=remembered.inflation,
        null=null / unit,
        counts=counts,
    )


def chosen_method(given: Steps, remembered: Memory, options: TestOptions) -> Literal["permutation"] | Displacement:
    """What ``auto`` means for these series.

    Permutations where memory hardly changes the variance; otherwise shifts. Where looks are so long that half of the
    recordings have no room for shifts, and there are ``ENOUGH_PARTNERS`` recordings, partners.

    Args:
        given: The transitions.
        remembered: Their memory.
        options: The method asked for, and the limit.
    """
    if options.method != "auto":
        return options.method
    if remembered.exchangeable(options.limit):
        return "permutation"
    lengths = np.diff(given.spans(whole=True))
    short = float(np.median(lengths)) < ENOUGH_SHIFTS * remembered.fresh_after
    return "partners" if short and len(lengths) >= max(ENOUGH_PARTNERS, FEWEST_RECORDINGS) else "shift"


class Surrogate(Protocol):
    """Makes surrogates of a source."""

    def draw(self, count: int, rng: np.random.Generator) -> Iterator[np.ndarray]:
        """See ``displaced.Moves``."""
        ...


def drawn(
    moved: Surrogate,
    values: Callable[[np.ndarray], np.ndarray],
    transitions: int,
    count: int,
    rng: np.random.Generator,
    progress: Callable[[int], object] = lambda done: None,
) -> np.ndarray:
    """Values of surrogates. Those of long series are counted by several threads, with the same result.

    Args:
        moved: Makes the surrogates.
        values: Plug-in values (measures,) of a surrogate.
        transitions: How many a surrogate has.
        count: Surrogates.
        rng: Draws them.
        progress: Called with the number drawn since the last call.

    Returns:
        (m, measures); m is ``count``, or fewer where there are no more different shifts.
    """
    rows: list[np.ndarray] = []
    surrogates = moved.draw(count, rng)
    threads = min(MOST_THREADS, os.cpu_count() or 1) if transitions >= WORTH_THREADS else 1
    with ThreadPoolExecutor(threads) as pool:
        while batch := list(islice(surrogates, bootstrap.BATCH)):
            rows += pool.map(values, batch) if threads > 1 else map(values, batch)
            progress(len(batch))
    progress(count - len(rows))
    return np.array(rows)


def adjust(p: Sequence[float] | np.ndarray, how: Adjust = "holm") -> np.ndarray:
    """Correct p-values for their number.

    Args:
        p: (k,) p-values.
        how: ``holm``, ``benjamini_hochberg`` or ``none`` (see ``Adjust``).

    Returns:
        Adjusted p-values (k,), in the same order.

    Raises:
        SeriesError: ``how`` is unknown, or a p-value lies outside 0 to 1.

    Examples:
        >>> adjust([0.01, 0.04, 0.03]).tolist()
        [0.03, 0.06, 0.06]
    """
    if not isinstance(how, str) or how not in get_args(Adjust):
        raise SeriesError(f"adjust must be one of {', '.join(get_args(Adjust))}; got {shown(how)}")
    if how == "none":
        return _p_values(p).copy()
    return holm(p) if how == "holm" else benjamini_hochberg(p)


def holm(p: Sequence[float] | np.ndarray) -> np.ndarray:
    """Adjust p-values (k,) by Holm's step-down method, which keeps the chance of any false alarm below alpha.

    Args:
        p: The p-values, 0 to 1.

    Returns:
        (k,) adjusted p-values in the same order.

    Raises:
        SeriesError: One of them lies outside 0 to 1.

    Examples:
        >>> holm([0.01, 0.04, 0.03]).tolist()
        [0.03, 0.06, 0.06]
    """
    given = _p_values(p)
    order = np.argsort(given, kind="stable")
    steps_down = np.maximum.accumulate(given[order] * np.arange(len(given), 0, -1))
    return _put_back(np.minimum(steps_down, 1), order)


def benjamini_hochberg(p: Sequence[float] | np.ndarray) -> np.ndarray:
    """Adjust p-values (k,) by Benjamini and Hochberg's step-up method, which keeps the rate of false discoveries.

    Args:
        p: The p-values, 0 to 1.

    Returns:
        (k,) adjusted p-values in the same order.

    Raises:
        SeriesError: One of them lies outside 0 to 1.

    Examples:
        >>> benjamini_hochberg([0.01, 0.04, 0.03]).round(3).tolist()
        [0.03, 0.04, 0.04]
    """
    given = _p_values(p)
    order = np.argsort(given, kind="stable")
    scaled = given[order] * len(given) / np.arange(1, len(given) + 1)
    return _put_back(np.minimum(np.minimum.accumulate(scaled[::-1])[::-1], 1), order)


def _p_values(p: Sequence[float] | np.ndarray) -> np.ndarray:
    try:
        given = np.asarray(p, float)
    except (TypeError, ValueError) as error:
        raise SeriesError(f"p-values must be a list of numbers; got {shown(p)}") from error
    if given.ndim != 1:
        raise SeriesError(f"p-values must be a list of numbers; got an array of {given.ndim} dimensions")
    wrong = given[~((given >= 0) & (given <= 1))]  # NaN, too
    if len(wrong):
        raise SeriesError(f"p-values must lie from 0 to 1; got {wrong[0]:g}")
    return given


def generator(seed: int | np.random.SeedSequence | np.random.Generator) -> np.random.Generator:
    """A generator as it is, or a new one of a seed.

    Raises:
        SeriesError: A negative seed, or none at all.
    """
    if isinstance(seed, np.random.Generator):
        return seed
    wrong = isinstance(seed, (bool, float)) or seed is None
    try:
        if not wrong:
            return np.random.default_rng(seed)
    except (TypeError, ValueError):  # negative, or no number
        pass
    raise SeriesError(f"seed must be a whole number of 0 or more; got {shown(seed)}")


def _told(progress: Callable[[int], object], tests: int) -> Callable[[int], object]:
    """Tells of every surrogate once for each of the tests that share it."""
    return lambda done: progress(done * tests)


def _put_back(values: np.ndarray, order: np.ndarray) -> np.ndarray:
    result = np.empty(len(values))
    result[order] = values
    return result
