"""The contingency detector (section 5.2.1, Fig. 5.1): ranks all events, and says when the first of them is found."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np

from jointattn_mj.contingency.names import LOCAL, OF_EVENTS, measure_choice
from jointattn_mj.contingency.online.counts import ALONE, OF_ACTION, OF_SENSOR, OWN, Counts, local_variance
from jointattn_mj.errors import ObservationError
from jointattn_mj.guards.border import checked_by
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked, Count, NotNegative, Positive, Real, Whole

NOTHING = -1


@dataclass(frozen=True)
class DetectorConfig(Checked):
    """Which measure ranks the events, and when the first of them counts as found.

    Stop rule ``convergence`` is the dissertation's: the estimates hardly change any more. A step changes an estimate by
    an amount proportional to 1/n. The rule is therefore a waiting time, whatever the world is like.

    Stop rule ``confidence`` uses standard errors. The plug-in estimate of the measure is a mean over transitions; the
    variance of its terms, divided by n, is the square of its standard error. An event is found when the highest
    estimate is known to ``precision`` of itself, and no other can be higher by more than ``tolerance`` of it, both
    within ``deviations`` standard errors. All three have no unit: nothing in the rule depends on the size of the
    contingency in a world, or on the number of values of its variables.
    """

    measure: Annotated[str, measure_choice(OF_EVENTS)] = "sac"
    """Measure that ranks the events: ``sac`` (eq. 5.2) or ``tc`` (eq. 4.3)."""
    correction: Literal["none", "miller_madow"] = "none"
    """Correction of the bias of estimates from few transitions: ``none`` or ``miller_madow``."""
    base: Annotated[float, Real("(1, 1e6]")] = 2.0
    """Base of the logarithm; the text does not say. With 2, theta of stop rule ``convergence`` gives the
    dissertation's times."""
    stop_rule: Literal["convergence", "confidence", "local"] = "convergence"
    """When an event is found. ``convergence``: the estimates change by less than ``threshold`` for ``hold`` steps.
    ``confidence``: the standard errors say that the first event is the first. ``local``: events are ranked by how
    contingent they are in the situations where they hold; the options of this rule are ``--agent.local.*``."""
    modelled: Literal["keep", "drop"] = "keep"
    """What happens to an event that has a module. ``keep``: it stays in the ranking and can keep others from being
    found. ``drop``: it leaves the ranking; the agent then makes modules of all other events, one after the other. Stop
    rule local always drops it."""
    warm_up: Annotated[int, Whole("[0, 1e10]")] = 100
    """Transitions before anything can be found; estimates from next to nothing do not change either. Stop rule local
    has its first look instead."""
    threshold: Annotated[float, Real("(0, 1e9]")] = 5e-5
    """Stop rule convergence: theta (section 5.3.1), the largest change of an estimate in a step, in units of the
    measure."""
    hold: Count = 30
    """Stop rule convergence: T^C (section 5.3.1), steps in a row with the same first event and no larger change."""
    stability_of: Literal["all", "gap"] = "all"
    """Stop rule convergence: what must change by less than theta in a step. ``all``: every event's measure, as in
    chapter 4. ``gap``: the difference of the two highest, which the words of chapter 5 may mean."""
    deviations: Positive = 3.0
    """Stop rule confidence: standard errors to either side; 3 is one error in a thousand for one comparison."""
    precision: Positive = 0.5
    """Stop rule confidence: largest relative error of the first estimate. The module's map splits the estimate among
    many entries, each of which must be more than noise."""
    tolerance: NotNegative = 0.25
    """Stop rule confidence: share of the first estimate by which another event may be higher. Telling nearly equal
    events apart takes for ever."""
    look_again: Positive = 0.1
    """Stop rule confidence: share of further transitions after which the rule is tested again. The number of tests,
    and with it the chance of an error, then grows with the logarithm of time."""

    RENAMED: ClassVar[Mapping[str, str]] = {"rule": "stop_rule", "claimed": "modelled", "of": "stability_of"}
    OLD_CHOICES: ClassVar[Mapping[str, Mapping[str, str]]] = {
        "stop_rule": {"still": "convergence", "certain": "confidence"},
        "modelled": {"block": "keep"},
    }

    @property
    def ranks_by(self) -> str:
        """Short name of the measure that ranks the events: that of stop rule local, or else ``measure``."""
        return LOCAL.short if self.stop_rule == "local" else self.measure


class Rule(NamedTuple):
    """A ``DetectorConfig`` as numbers, for compiled code."""

    single: int
    corrected: int
    per_nat: float
    confidence: bool
    warm_up: int
    threshold: float
    hold: int
    gap: bool
    deviations: float
    precision: float
    tolerance: float
    look_again: float
    drops: bool


class Watch(NamedTuple):
    """State of the detector of E events."""

    rule: Rule
    values: np.ndarray
    """(E,) current estimate of each event's measure, in the config's base."""
    modelled: np.ndarray
    """(E,) whether an event was found before: it has its module, unless there were as many as there can be."""
    first: np.ndarray
    """(2,) the event with the highest estimate, and for how many steps in a row it has been the first without a change
    of ``threshold`` or more."""
    gap: np.ndarray
    """(1,) difference of the two highest estimates."""
    time: np.ndarray
    """(2,) transitions so far, and at how many stop rule confidence is tested next."""


def new_watch(config: DetectorConfig, events: int) -> Watch:
    """The state of a detector before the first transition.

    Args:
        config: Measure and stop rule.
        events: E, how many events are ranked.
    """
    return Watch(
        rule=Rule(
            single=int(config.measure == "sac"),
            corrected=int(config.correction == "miller_madow"),
            per_nat=float(1 / np.log(config.base)),
            confidence=config.stop_rule == "confidence",
            warm_up=int(config.warm_up),
            threshold=float(config.threshold),
            hold=int(config.hold),
            gap=config.stability_of == "gap",
            deviations=float(config.deviations),
            precision=float(config.precision),
            tolerance=float(config.tolerance),
            look_again=float(config.look_again),
            drops=config.modelled == "drop",
        ),
        values=np.zeros(events),
        modelled=np.zeros(events, np.bool_),
        first=np.array([NOTHING, 0], np.int64),
        gap=np.zeros(1),
        time=np.array([0, config.warm_up], np.int64),
    )


def grown(watch: Watch, events: int, event: int, anew: bool) -> Watch:
    """The state after a module was made: more events, one of them modelled.

    Args:
        watch: The state before.
        events: How many events there are now; the new ones come last.
        event: Number of the event that has just got its module.
        anew: Whether the counts begin anew, so that transitions are counted from 0 again.
    """
    more = events - len(watch.values)
    modelled = np.append(watch.modelled, np.zeros(more, np.bool_))
    modelled[event] = True
    return watch._replace(
        values=np.append(watch.values, np.zeros(more)),
        modelled=modelled,
        first=np.array([watch.first[0], 0]),
        time=np.array([0, watch.rule.warm_up]) if anew else watch.time.copy(),
    )


@njit(cache=True, borrows=True)
def _squared_error(counts: Counts, event: int, single: int) -> float:
    """Squared standard error of the estimate of ``event``, nats squared; 0 without a transition."""
    n = counts.n[counts.of_event[event, OWN]]
    square: float = local_variance(counts, event, single) / n if n > 0.0 else 0.0
    return square


@njit(cache=True, borrows=True)
def _is_confident(watch: Watch, counts: Counts) -> bool:
    """Stop rule confidence: whether the first estimate is precise enough and no other can be much higher."""
    rule, values, first = watch.rule, watch.values, watch.first[0]
    scale = rule.deviations * rule.per_nat
    spread = _squared_error(counts, first, rule.single)
    if scale * np.sqrt(spread) > rule.precision * values[first]:
        return False
    for e in range(len(values)):
        ahead = values[first] * (1.0 + rule.tolerance) - values[e]
        rival = e != first and not (rule.drops and watch.modelled[e])
        if rival and ahead < scale * np.sqrt(spread + _squared_error(counts, e, rule.single)):
            return False
    return True


@njit(cache=True, borrows=True, forceinline=True)
def judge(watch: Watch, counts: Counts, first: int, highest: float, second: float, change: float) -> int:
    """Test the stop rule after a transition.

    Args:
        watch: State of the detector, its estimates included; the rest is changed in place.
        counts: Counts of its events.
        first: Event with the highest estimate, or NOTHING.
        highest: Its estimate.
        second: The next highest.
        change: Largest change of an estimate by the transition.

    Returns:
        Number of the event that has just been found, or NOTHING.
    """
    rule = watch.rule
    gap = highest - second if len(watch.values) > 1 else highest
    if rule.gap:
        change = abs(gap - watch.gap[0])
    watch.gap[0] = gap
    watch.first[1] = watch.first[1] + 1 if first == watch.first[0] and change < rule.threshold else 0
    watch.first[0] = first
    watch.time[0] += 1
    waiting = (
        watch.time[0] <= watch.time[1]
        if rule.confidence
        else watch.time[0] <= rule.warm_up or watch.first[1] < rule.hold
    )
    if waiting:
        return NOTHING
    if rule.confidence:
        watch.time[1] = np.int64(watch.time[0] * (1.0 + rule.look_again))
    if watch.modelled[first] or highest <= 0.0 or (rule.confidence and not _is_confident(watch, counts)):
        return NOTHING
    watch.first[1] = 0
    return first


def _check_update(watch: Watch, counts: Counts) -> None:
    if not len(watch.values) == len(watch.modelled) == len(counts.of_event):
        raise ObservationError(
            f"a detector of {len(watch.values)} events needs their counts; got those of {len(counts.of_event)}"
        )


@checked_by(_check_update)
@njit(cache=True, borrows=True, forceinline=True)
def update(watch: Watch, counts: Counts) -> int:
    """Estimate all measures after a transition, and test the stop rule.

    Args:
        watch: State of the detector, changed in place.
        counts: Counts of its events, the transition included.

    Returns:
        Number of the event that has just been found, or NOTHING.
    """
    rule, values = watch.rule, watch.values
    of_event, sums, occupied = counts.of_event, counts.sums, counts.occupied
    single, half, per_nat = rule.single, 0.5 * rule.corrected, rule.per_nat
    first: Any = np.int64(NOTHING)  # of an event's type: for a plain number ``judge`` would be compiled once more
    highest, second, change = -np.inf, -np.inf, 0.0
    for e in range(np.uint64(len(values))):
        own, of_action = of_event[e, OWN], of_event[e, OF_ACTION]
        of_sensor, alone = of_event[e, OF_SENSOR], of_event[e, ALONE]
        value, n = 0.0, counts.n[own]
        if n > 0.0:
            total = sums[own] - sums[of_action] - single * (sums[of_sensor] - sums[alone])
            if half > 0.0:
                entries = occupied[own] - occupied[of_action] - single * (occupied[of_sensor] - occupied[alone])
                total -= half * entries
            value = total / n * per_nat
        moved = abs(value - values[e])
        if moved > change:
            change = moved
        values[e] = value
        if rule.drops and watch.modelled[e]:
            continue
        if value > highest:
            first, highest, second = np.int64(e), value, highest  # signed again
        elif value > second:
            second = value
    return judge(watch, counts, first, highest, second, change)
