"""Which event is contingent? All events of some sensors, actions and results, ranked and tested (section 5.2.1)."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from jointattn_mj.contingency.information import CONTINGENCY, Measure
from jointattn_mj.contingency.lagged import Timing, timed
from jointattn_mj.contingency.lead import Lead, LeadOptions, lead_of_steps
from jointattn_mj.contingency.local import LocalContingency, carriers, local_of_steps
from jointattn_mj.contingency.names import LOCAL, OF_RECORDED_EVENTS, full_name
from jointattn_mj.contingency.series import Series, check_base
from jointattn_mj.contingency.significance import (
    MEASURES,
    Adjust,
    Significance,
    TestOptions,
    adjust,
    assess_steps,
    generator,
)
from jointattn_mj.contingency.table import acted
from jointattn_mj.errors import SeriesError


@dataclass(frozen=True, repr=False)
class Finding:
    """An event and what is known about its contingency.

    Examples:
        >>> face, gaze = np.random.default_rng(0).integers(0, 3, (2, 400))
        >>> data = {"face": face, "gaze": gaze, "toy": np.append(0, face == gaze)[:-1].astype(int)}
        >>> (found,) = discover(data, ["face"], ["gaze"], ["toy"], options=TestOptions(surrogates=99, resamples=0))
        >>> found.event, len(found.values)
        ('(face, gaze) -> toy', 3)
    """

    sensor: str
    action: str
    result: str
    significance: Significance
    p_adjusted: float
    """Corrected for the number of events."""
    normalised: float
    """Effective value, less the mean of surrogates, divided by the bound ``smallest`` (see ``information``)."""
    values: tuple[LocalContingency, ...] = ()
    """Values that carry the contingency, those that add most first; left out of events that are not significant."""
    lead: Lead | None = None
    """Measure local: where the event is surest to be contingent."""
    first: float | None = None
    """Measure local: probability, by the posterior, that no other event has a higher effective value."""

    @property
    def event(self) -> str:
        """The event in one line: ``(sensor, action) -> result``."""
        return f"({self.sensor}, {self.action}) -> {self.result}"

    def __repr__(self) -> str:
        return f"Finding({self.event}: {self.significance.corrected:.3g} effective, adjusted p = {self.p_adjusted:.3g})"


def discover(
    data: Mapping[str, Series],
    sensors: Sequence[str],
    actions: Sequence[str],
    results: Sequence[str],
    *,
    measure: str = "state_action_contingency",
    options: TestOptions | None = None,
    how: Adjust = "holm",
    alpha: float = 0.05,
    base: float = 2,
    seed: int | np.random.SeedSequence = 0,
    explain: int = 3,
    groups: Sequence[int] | None = None,
    timing: Timing | None = None,
    progress: Callable[[int], object] = lambda done: None,
    lead: LeadOptions | None = None,
) -> tuple[Finding, ...]:
    """Test every event (sensor, action) -> result, and rank them by their effective value (section 5.2.1).

    p-values come from permutations of the sensor within (r, a), or from shifts of it where it and the result stay the
    same for long (see ``significance.Method``). Each event has a random stream of its own: its p does not depend on the
    others.

    Args:
        data: A series for every name: (T,) integer codes, or a list of such arrays, one a recording.
        sensors: Names of what is sensed, S.
        actions: Names of what is done, A.
        results: Names of what may come of it, R.
        measure: ``sac`` or ``tc``, by any of their names (``names.NAMES``); or ``local``, SAC where an event is surest
            to be contingent (see ``lead``), so that strong and rare ones come before weak and frequent ones.
        options: Number and kind of surrogates and resamples; None: the defaults of ``TestOptions``.
        how: Correction of p for the number of events.
        alpha: Level of significance, after the correction.
        base: Base of the logarithm: 2 for bits.
        seed: Seed of surrogates and resamples.
        explain: So many of the first events, if significant, also tell which values carry them.
        groups: Numbers of the recordings (see ``assess``).
        timing: Delay from sensor and action to result, and histories; None: one step. Values are told only where
            histories are of one step.
        progress: Called with the number of surrogates or resamples drawn since the last call.
        lead: Measure local: how situations are weighed, and posterior draws; None: the defaults of ``LeadOptions``.

    Returns:
        The events, the highest effective value first.

    Raises:
        SeriesError: Unknown names, names that play two parts of one event, series that cannot be measured, or bad
            options.

    Examples:
        >>> rng = np.random.default_rng(0)
        >>> face, gaze = rng.integers(0, 3, (2, 400))  # where somebody looks, and where one looks oneself
        >>> found_object = np.append(0, face == gaze)[:-1].astype(int)  # a step later
        >>> data = {"face": face, "gaze": gaze, "object": found_object}
        >>> first = discover(data, ["face"], ["gaze"], ["object"], options=TestOptions(surrogates=99, resamples=0))[0]
        >>> first.event, first.p_adjusted
        ('(face, gaze) -> object', 0.01)
    """
    name = full_name(measure, OF_RECORDED_EVENTS)
    local, chosen = name == LOCAL.full, MEASURES.get(name, CONTINGENCY)
    _check(data, sensors, actions, results, alpha)
    given, unit, tested = options or TestOptions(), check_base(base), []
    timing = timing or Timing()
    if local and not timing.source_history == timing.target_history == 1:
        raise SeriesError(
            "measure local tells situations apart by one value each of sensor and result; got histories of "
            f"{timing.source_history} and {timing.target_history}. Leave these out, or take sac"
        )
    explain = explain if timing.source_history == timing.target_history == 1 else 0
    events = list(product(sensors, actions, results))
    for event, stream in zip(events, _seeds(seed).spawn(len(events)), strict=True):
        weighing = (lead or LeadOptions()) if local else None
        rng = generator(stream)
        tested.append(_tested(data, event, groups, timing, chosen, weighing, given, unit, rng, progress))
    adjusted = adjust([finding.significance.p for finding in tested], how)
    tested = [replace(finding, p_adjusted=float(p)) for finding, p in zip(tested, adjusted, strict=True)]
    tested = _with_chances(tested) if local else tested
    ranked = sorted(tested, key=lambda finding: -finding.significance.corrected)
    for i, finding in enumerate(ranked[:explain]):
        if finding.p_adjusted <= alpha:
            explained = timed(acted(data[finding.sensor], data[finding.action], data[finding.result], groups), timing)
            counts = None
            if finding.significance.method != "permutation":
                rng = generator(_seeds(seed).spawn(len(events) + 1)[-1])
                again = replace(given, resamples=0)  # the same method, as the memory is the same
                counts = assess_steps(explained, chosen, again, unit, rng, local=True).counts
            entries = local_of_steps(explained, chosen, unit, counts=counts)
            if finding.lead is not None:
                where = {(situation.result, situation.sensor) for situation in finding.lead.situations}
                entries = tuple(entry for entry in entries if (entry.before, entry.sensor) in where)
            ranked[i] = replace(finding, values=carriers(entries, alpha))
    return tuple(ranked)


def least_surrogates(events: int, alpha: float = 0.05) -> int:
    """Surrogates without which no event among so many can have a p of ``alpha`` by Holm's method."""
    return int(np.ceil(events / alpha)) - 1


def _tested(
    data: Mapping[str, Series],
    event: tuple[str, str, str],
    groups: Sequence[int] | None,
    timing: Timing,
    measure: Measure,
    how: LeadOptions | None,
    options: TestOptions,
    unit: float,
    rng: np.random.Generator,
    progress: Callable[[int], object],
) -> Finding:
    """Test one event: by a measure over all steps or, if ``how`` is given, by the situations where it is contingent."""
    sensor, action, result = event
    lead = None
    try:
        given = timed(acted(data[sensor], data[action], data[result], groups), timing)
        if how is None:
            significance = assess_steps(given, measure, options, unit, rng, progress)
        else:
            lead = lead_of_steps(given, how, options, unit, rng, progress)
            significance = lead.significance
    except SeriesError as error:
        raise SeriesError(f"({sensor}, {action}) -> {result}: {error}") from error
    bound = measure.bound(given.entries(), "smallest") / unit
    normalised = significance.corrected / bound if bound > 1e-12 else 0.0
    return Finding(sensor, action, result, significance, 1.0, normalised, lead=lead)


def _with_chances(tested: Sequence[Finding]) -> list[Finding]:
    """How often each is the first in posterior draws of all."""
    effective = np.array([
        finding.lead.draws - finding.significance.null_mean for finding in tested if finding.lead is not None
    ])  # fmt: skip
    wins = np.bincount(effective.argmax(axis=0), minlength=len(effective)) / effective.shape[1]
    return [replace(finding, first=float(chance)) for finding, chance in zip(tested, wins, strict=True)]


def _check(
    data: Mapping[str, Series], sensors: Sequence[str], actions: Sequence[str], results: Sequence[str], alpha: float
) -> None:
    for role, names in (("sensor", sensors), ("action", actions), ("result", results)):
        if not names:
            raise SeriesError(f"at least one {role} is needed")
        if len(set(names)) < len(names):
            raise SeriesError(f"every {role} must be named once; got {', '.join(names)}")
        unknown = [name for name in names if name not in data]
        if unknown:
            raise SeriesError(f"there is no variable {unknown[0]!r}; there are {', '.join(data)}")
    twice = set(sensors) & set(actions)
    if twice:
        raise SeriesError(f"{', '.join(sorted(twice))} cannot be both sensor and action")
    if not 0 < alpha < 1:
        raise SeriesError(f"alpha must lie between 0 and 1; got {alpha}")


def _seeds(seed: int | np.random.SeedSequence) -> np.random.SeedSequence:
    if isinstance(seed, np.random.SeedSequence):
        return seed
    generator(seed)
    return np.random.SeedSequence(seed)
