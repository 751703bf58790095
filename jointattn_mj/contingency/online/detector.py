"""The contingency detector: which event is the most contingent, and since when that can be said (section 5.2.1)."""

from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import numpy as np

from jointattn_mj.contingency.online.counts import ALONE, OF_ACTION, OF_SENSOR, OWN, Counts, local_variance
from jointattn_mj.errors import ObservationError
from jointattn_mj.guards.border import checked_by
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked, Count, NotNegative, Positive, Real, Whole

NOTHING = -1


@dataclass(frozen=True)
class DetectorConfig(Checked):
    """Which measure ranks the events, and when the first of them has been found.

    Rule ``still`` is the dissertation's: the estimates hardly move any more. How much an estimate moves in a step goes
    with 1/n, so that this rule is a waiting time in disguise, whatever the world is like.

    Rule ``certain`` asks what the estimates are worth. The plug-in estimate of the measure is a mean over transitions;
    the variance of its terms, divided by n, is the square of its standard error. An event is found when the highest
    estimate is known to ``precision`` of itself, and no other can be higher by more than ``tolerance`` of it, both
    within ``deviations`` standard errors. All three have no unit: nothing in the rule depends on how large contingency
    is in some world, or on how many values its variables have.
    """

    measure: Literal["sac", "tc"] = "sac"
    """``sac`` (eq. 5.2) or ``tc`` (eq. 4.3)."""
    correction: Literal["none", "miller_madow"] = "none"
    """``none``, or ``miller_madow`` against the bias of estimates from few transitions."""
    base: Annotated[float, Real("(1, 1e6]")] = 2.0
    """Of the logarithm; the text does not say. With 2, theta of rule ``still`` gives the dissertation's times."""
    rule: Literal["still", "certain"] = "still"
    """``still`` or ``certain``, see above."""
    claimed: Literal["block", "drop"] = "block"
    """What becomes of an event that has its module: it stays in the ranking and can ``block`` others, or they ``drop``
    out, and the mind then makes modules of whatever is left, one after the other."""
    warm_up: Annotated[int, Whole("[0, 1e10]")] = 100
    """Transitions before anything can be found: of next to nothing, nothing changes either."""
    threshold: Annotated[float, Real("(0, 1e9]")] = 5e-5
    """Rule still: theta, section 5.3.1."""
    hold: Count = 30
    """Rule still: T^C, section 5.3.1, steps on end for which the same event is the first, and all is still."""
    of: Literal["all", "gap"] = "all"
    """Rule still: what changes by less than theta in a step; ``all`` measures, as in chapter 4, or the ``gap`` between
    the two highest, which the words of chapter 5 may mean."""
    deviations: Positive = 3.0
    """Rule certain: standard errors to either side, one in a thousand for one look at one pair of estimates."""
    precision: Positive = 0.5
    """Rule certain: the map that is read off the event splits it among many cells; each must be more than noise."""
    tolerance: NotNegative = 0.25
    """Rule certain: an event that is nearly as contingent may come second; telling such apart takes for ever."""
    look_again: Positive = 0.1
    """Rule certain: it looks when there are more transitions by this share than at the last look, so that the number of
    looks, and with it that of chances to be wrong, grows only with the logarithm of time."""


class Rule(NamedTuple):
    """A ``DetectorConfig`` for compiled code."""

    single: int
    corrected: int
    per_nat: float
    certain: bool
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
    """What the detector remembers from step to step."""

    rule: Rule
    values: np.ndarray
    """(E,) the measure of each event now, in the config's base."""
    claimed: np.ndarray
    """(E,) whether an event has its module."""
    first: np.ndarray
    """(2,) the event with the highest value, and for how many steps on end all has been still with it as the first."""
    gap: np.ndarray
    """(1,) between the two highest values."""
    time: np.ndarray
    """(2,) transitions seen, and with how many to look next."""


def new_watch(config: DetectorConfig, events: int) -> Watch:
    """A detector that has seen nothing."""
    return Watch(
        rule=Rule(
            single=int(config.measure == "sac"),
            corrected=int(config.correction == "miller_madow"),
            per_nat=float(1 / np.log(config.base)),
            certain=config.rule == "certain",
            warm_up=int(config.warm_up),
            threshold=float(config.threshold),
            hold=int(config.hold),
            gap=config.of == "gap",
            deviations=float(config.deviations),
            precision=float(config.precision),
            tolerance=float(config.tolerance),
            look_again=float(config.look_again),
            drops=config.claimed == "drop",
        ),
        values=np.zeros(events),
        claimed=np.zeros(events, np.bool_),
        first=np.array([NOTHING, 0], np.int64),
        gap=np.zeros(1),
        time=np.array([0, config.warm_up], np.int64),
    )


def grown(watch: Watch, events: int, claimed: int, anew: bool) -> Watch:
    """The detector with further events, one of the old ones claimed; ``anew`` where its time starts again."""
    more = events - len(watch.values)
    claims = np.append(watch.claimed, np.zeros(more, np.bool_))
    claims[claimed] = True
    return watch._replace(
        values=np.append(watch.values, np.zeros(more)),
        claimed=claims,
        first=np.array([watch.first[0], 0]),
        time=np.array([0, watch.rule.warm_up]) if anew else watch.time.copy(),
    )


@njit(cache=True)
def _squared_error(counts, event, single):
    """Squared standard error of an event's estimate, nats squared; 0 without a transition."""
    n = counts.contexts[counts.of_event[event, OWN]].n
    return local_variance(counts, event, single) / n if n > 0.0 else 0.0


@njit(cache=True)
def _is_certain(watch, counts):
    """Whether the first event's estimate is good enough, and no other's can be much higher (rule ``certain``)."""
    rule, values, first = watch.rule, watch.values, watch.first[0]
    scale = rule.deviations * rule.per_nat
    spread = _squared_error(counts, first, rule.single)
    if scale * np.sqrt(spread) > rule.precision * values[first]:
        return False
    for e in range(len(values)):
        ahead = values[first] * (1.0 + rule.tolerance) - values[e]
        rival = e != first and not (rule.drops and watch.claimed[e])
        if rival and ahead < scale * np.sqrt(spread + _squared_error(counts, e, rule.single)):
            return False
    return True


def _check_look(watch, counts):
    if not len(watch.values) == len(watch.claimed) == len(counts.of_event):
        raise ObservationError(f"a detector of {len(watch.values)} events looks at counts of {len(counts.of_event)}")


@checked_by(_check_look)
@njit(cache=True, forceinline=True)
def look(watch: Watch, counts: Counts) -> int:
    """Work out all measures after a transition; the number of an event that has just been found, or NOTHING."""
    rule, values = watch.rule, watch.values
    of_event, contexts = counts.of_event, counts.contexts
    single, half, per_nat = rule.single, 0.5 * rule.corrected, rule.per_nat
    first, highest, second, change = NOTHING, -np.inf, -np.inf, 0.0
    for e in range(len(values)):
        own, of_action = contexts[of_event[e, OWN]], contexts[of_event[e, OF_ACTION]]
        of_sensor, alone = contexts[of_event[e, OF_SENSOR]], contexts[of_event[e, ALONE]]
        value = 0.0
        if own.n > 0.0:
            total = own.sum - of_action.sum - single * (of_sensor.sum - alone.sum)
            if half > 0.0:
                cells = own.occupied - of_action.occupied - single * (of_sensor.occupied - alone.occupied)
                total -= half * cells
            value = total / own.n * per_nat
        moved = abs(value - values[e])
        if moved > change:
            change = moved
        values[e] = value
        if rule.drops and watch.claimed[e]:
            continue
        if value > highest:
            first, highest, second = e, value, highest
        elif value > second:
            second = value
    gap = highest - second if len(values) > 1 else highest
    if rule.gap:
        change = abs(gap - watch.gap[0])
    watch.gap[0] = gap
    watch.first[1] = watch.first[1] + 1 if first == watch.first[0] and change < rule.threshold else 0
    watch.first[0] = first
    watch.time[0] += 1
    waiting = (
        watch.time[0] <= watch.time[1] if rule.certain else watch.time[0] <= rule.warm_up or watch.first[1] < rule.hold
    )
    if waiting:
        return NOTHING
    if rule.certain:
        watch.time[1] = np.int64(watch.time[0] * (1.0 + rule.look_again))
    if watch.claimed[first] or highest <= 0.0 or (rule.certain and not _is_certain(watch, counts)):
        return NOTHING
    watch.first[1] = 0
    return first
