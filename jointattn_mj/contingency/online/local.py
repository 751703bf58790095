"""Stop rule ``local``: finds the event that is most contingent where it holds, situation by situation.

SAC (eq. 5.2) of an event weighs every situation (r, s) by how often it comes. What is strong but rare then looks weak:
looking back after having followed a gaze is ten times as contingent as other events, in a tenth of all steps. Here an
event's value is the mean of the local values D(r, s) (see ``contingency.situations``) over those of its situations that
are surest to be contingent, as long as these fill a share of the time. Draws from the posterior of D say how much is
known. The largest value is claimed when it is above 0, when it is the largest in most draws, and when a Bayes factor
says that what is sensed tells something about the result at all.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import numpy as np

from jointattn_mj.contingency.online.detector import NOTHING
from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.online.experience import Steps
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked, Count, NotNegative, Positive, Real, Share, Whole

EVIDENCE_OF = (1.0, 4.0, 16.0)
"""Concentrations that the Bayes factor averages over: how many transitions the prior "s says nothing" is worth."""


@dataclass(frozen=True)
class LocalConfig(Checked):
    """How stop rule ``local`` ranks events and when it claims the first; how maps follow what is learned later."""

    condition: Literal["joint", "own"] = "joint"
    """What r stands for where p(r' | r, s, a) is asked for. ``own``: the event's own result, as in the text. ``joint``:
    all results together. What lasts, such as a gaze that stays, is then known from r and no longer looks contingent."""
    policy: Literal["both", "actual", "reference"] = "both"
    """Over which actions a situation's contingency is taken. ``actual``: as often as each was done since the last
    module. ``reference``: each equally, in the whole run. ``both``: what is surer to be contingent."""
    smallest_share: Annotated[float, Real("(0, 1]")] = 0.05
    """Share of steps that an event's situations must fill together. 1 ranks by SAC of the whole."""
    draws: Annotated[int, Whole("[2, 10000]")] = 30
    """Posterior draws of every value at each look."""
    concentration: Positive = 2.0
    """Transitions that the prior "s says nothing" is worth."""
    doubt: NotNegative = 0.1
    """Prior odds that an event is not contingent"""
    deviations: NotNegative = 3.0
    """A value is claimed if it is above 0 by so many standard deviations of the posterior."""
    best: Share = 0.97
    """Share of draws in which no rival is higher by more than ``tolerance``."""
    tolerance: NotNegative = 0.25
    """Share of the first value by which a rival may be higher. Telling nearly equal events apart takes for ever."""
    false_alarm: Annotated[float, Real("(0, 1]")] = 0.01
    """Accepted chance that an event is ever claimed in which s says nothing. The Bayes factor of a claim, for "s tells
    something" against "s says nothing", must reach the number of events divided by this."""
    unserved_first: bool = False
    """Whether an event must wait whose result a module brings about already, until every result has a module."""
    given_modules: bool = True
    """Whether the result is conditioned on the use of all modules that bring it about, too."""
    increasing_first: bool = True
    """Whether an event that makes its result rarer must wait for events of the same sensor and action that make another
    result more frequent. Results that exclude each other mirror each other: what brings one about takes one away."""
    hindsight: bool = True
    """Whether a module counts as used (S_Pi) wherever the robot did what its present map offers, even before it was
    made. In the text it counts as used where it drove."""
    maps: Literal["follow", "frozen"] = "follow"
    """Whether maps are read anew at each look, from all steps, with every action weighed equally, or stay as made."""
    offer_gain: Annotated[float, Real("[0, 1]")] = 0.25
    """An offer must gain more than this share of what the map's best offer gains; 0 turns the test off with
    ``offer_deviations`` 0."""
    offer_deviations: NotNegative = 1.0
    """An offer must gain more than so many standard deviations, also within what came of the same action last time."""
    when_served: Literal["go_on", "stop"] = "go_on"
    """What happens when every result has its module: search on, or stop."""
    first_look: Count = 150
    """Steps before the first look."""
    look_every: Count = 40
    """Fewest steps from one look to the next."""
    look_again: Positive = 0.04
    """Share of further steps after which to look again, if that is more."""


class Search(NamedTuple):
    """The numbers of a ``LocalConfig`` for compiled code."""

    draws: int
    concentration: float
    doubt: float
    smallest_share: float
    deviations: float
    actual: bool
    reference: bool


def search_of(config: LocalConfig) -> Search:
    """The config as numbers."""
    return Search(
        draws=int(config.draws),
        concentration=float(config.concentration),
        doubt=float(config.doubt),
        smallest_share=float(config.smallest_share),
        deviations=float(config.deviations),
        actual=config.policy != "reference",
        reference=config.policy != "actual",
    )


def search(
    steps: Steps,
    events: Sequence[Event],
    served: Sequence[Event],
    since: int,
    config: LocalConfig,
    random: np.random.Generator,
    offers: Callable[[Event], bool],
) -> tuple[int, np.ndarray]:
    """Look for the most contingent event.

    Args:
        steps: All steps so far.
        events: The E events that are ranked.
        served: Events that have a module.
        since: Step at which the last module was made.
        config: Settings.
        random: Of the draws.
        offers: Whether the module of an event would offer anything. One that would not is no event to find.

    Returns:
        Number of the event that is found, or NOTHING; and every event's value (E,), nats.
    """
    numbers, draws = search_of(config), config.draws
    world = max(event.sensor for event in events) + 1 - len(served)

    def given(event: Event) -> list[int]:
        alike = [world + number for number, one in enumerate(served) if one.result == event.result]
        return alike if config.given_modules else []

    lead, hoped = np.zeros((len(events), draws)), np.zeros((len(events), draws))
    rises = np.zeros(len(events), np.bool_)
    for number, event in enumerate(events):
        series, first = steps.of(event, given(event)), steps.begin(event)
        rises[number] = event_values(*series.columns, since, series.sizes, first, numbers, random, lead[number], hoped[number])
    values = lead.mean(axis=1)
    every = {event.result for event in events}
    done = {event.result for event in served}
    all_served = done >= every
    if all_served and config.when_served == "stop":
        return NOTHING, values
    open_ = [event not in served and (all_served or not config.unserved_first or event.result not in done) for event in events]
    if config.increasing_first:
        up = {event[:2] for event, is_up in zip(events, rises, strict=True) if is_up and event not in served}
        waits = [not is_up and event[:2] in up for event, is_up in zip(events, rises, strict=True)]
        open_ = [is_open and not wait for is_open, wait in zip(open_, waits, strict=True)]
    ranked = list(np.flatnonzero(open_)[np.argsort(-values[open_], kind="stable")])
    while ranked and not offers(events[ranked[0]]):
        ranked.pop(0)
    if not ranked:
        return NOTHING, values
    first, rivals = ranked[0], ranked[1:]
    if lead[first].mean() <= config.deviations * lead[first].std():
        return NOTHING, values
    ahead = (hoped[rivals] <= (1 + config.tolerance) * lead[first]).all(axis=0)
    if ahead.mean() < config.best:
        return NOTHING, values
    series = steps.of(events[first], given(events[first]))
    begin = max(since, steps.begin(events[first]))
    if log_bayes_factor(*series.columns, begin, series.sizes) < np.log(len(events) / config.false_alarm):
        return NOTHING, values
    return int(first), values


@njit(cache=True)
def count(
    s: np.ndarray, a: np.ndarray, before: np.ndarray, after: np.ndarray, first: int, table: np.ndarray
) -> None:
    """Count transitions.

    Args:
        s: (n,) values of a sensor.
        a: (n,) values of an action.
        before: (n,) what the result is conditioned on.
        after: (n,) values of a result; that of the next step is counted.
        first: First step.
        table: (R, S, A, R') counts, changed in place.
    """
    for t in range(first, len(s) - 1):
        table[before[t], s[t], a[t], after[t + 1]] += 1.0


@njit(cache=True)
def _pooled(table: np.ndarray) -> np.ndarray:
    """(R, A, R') p(r' | r, a) of counts (R, S, A, R'); 0 where an action was never done."""
    results, sensors, actions, outcomes = table.shape
    q = np.zeros((results, actions, outcomes))
    for r in range(results):
        for a in range(actions):
            total = 0.0
            for s in range(sensors):
                for k in range(outcomes):
                    q[r, a, k] += table[r, s, a, k]
                    total += table[r, s, a, k]
            if total > 0.0:
                for k in range(outcomes):
                    q[r, a, k] /= total
    return q


@njit(cache=True, forceinline=True)
def _divergence(p: np.ndarray, q: np.ndarray) -> float:
    """KL(p || q), nats."""
    total = 0.0
    for k in range(len(p)):
        if p[k] > 0.0 and q[k] > 0.0:
            total += p[k] * np.log(p[k] / q[k])
    return total


@njit(cache=True)
def _log_evidence(table: np.ndarray) -> float:
    """Log of how much better the counts are explained with s and a together than with either alone.

    Each p(r' | r, s, a) has a prior around what the one alone says, which is taken from the same counts. The factor is
    averaged over priors of different strength, EVIDENCE_OF.
    """
    results, sensors, actions, outcomes = table.shape
    by_action = _pooled(table)
    total = np.zeros((2, len(EVIDENCE_OF)))
    of_s, counts = np.zeros(outcomes), np.zeros(outcomes)
    for r in range(results):
        for s in range(sensors):
            of_s[:] = 0.0
            for a in range(actions):
                for k in range(outcomes):
                    of_s[k] += table[r, s, a, k]
            whole = of_s.sum()
            if whole == 0.0:
                continue
            for a in range(actions):
                counts[:] = table[r, s, a]
                n = counts.sum()
                if n == 0.0:
                    continue
                for i in range(len(EVIDENCE_OF)):
                    k0 = EVIDENCE_OF[i]
                    constant = math.lgamma(k0) - math.lgamma(n + k0)
                    for part in range(2):
                        total[part, i] += constant
                        for k in range(outcomes):
                            if counts[k] > 0.0:
                                q = by_action[r, a, k] if part == 0 else of_s[k] / whole
                                b = k0 * q
                                total[part, i] += math.lgamma(counts[k] + b) - math.lgamma(b) - counts[k] * math.log(q)
    return min(_log_mean_exp(total[0]), _log_mean_exp(total[1]))


@njit(cache=True)
def _value(
    table: np.ndarray, by_reference: bool, search: Search, random: np.random.Generator, lead: np.ndarray,
    hoped: np.ndarray,
) -> tuple[float, float, bool]:  # fmt: skip
    """Value of an event under one policy.

    Args:
        table: (R, S, A, R') counts.
        by_reference: Whether each action weighs the same.
        search: Settings.
        random: Of the draws.
        lead: (draws,) is written.
        hoped: (draws,) is written.

    Returns:
        Mean less ``deviations`` of ``lead``, mean and one deviation of ``hoped``, and whether the result rises.
    """
    results, sensors, actions, outcomes = table.shape
    draws, k0 = search.draws, search.concentration
    q = _pooled(table)
    cells = results * sensors
    value, share, rise = np.zeros((cells, draws)), np.zeros(cells), np.zeros((cells, 2))
    p, mixed = np.zeros(outcomes), np.zeros((draws, outcomes))
    weight, base = np.zeros(actions), np.zeros(outcomes)
    m, total = 0, 0.0
    for r in range(results):
        of_r = 0.0
        base[:] = 0.0
        for s in range(sensors):
            for a in range(actions):
                for k in range(outcomes):
                    base[k] += table[r, s, a, k]
                    of_r += table[r, s, a, k]
        if of_r == 0.0:
            continue
        if not by_reference:
            for k in range(outcomes):
                base[k] /= of_r
        for s in range(sensors):
            n, seen = 0.0, 0
            for a in range(actions):
                weight[a] = 0.0
                for k in range(outcomes):
                    weight[a] += table[r, s, a, k]
                n += weight[a]
                seen += weight[a] > 0.0
            if n == 0.0:
                continue
            if by_reference:
                base[:] = 0.0
            mixed[:] = 0.0
            strongest = -1.0
            for a in range(actions):
                if weight[a] == 0.0:
                    continue
                times = weight[a]
                weight[a] = 1.0 / seen if by_reference else weight[a] / n
                if by_reference:
                    for k in range(outcomes):
                        base[k] += weight[a] * q[r, a, k]
                possible = 0
                for k in range(outcomes):
                    possible += q[r, a, k] > 0.0
                if possible == 1:  # nothing is left to chance
                    for k in range(outcomes):
                        for d in range(draws):
                            mixed[d, k] += weight[a] * q[r, a, k]
                    continue
                for k in range(outcomes):
                    p[k] = (table[r, s, a, k] + k0 * q[r, a, k]) / (times + k0)
                strength = weight[a] * _divergence(p, q[r, a])
                if strength > strongest:
                    strongest = strength
                    rise[m, 0], rise[m, 1] = strength, q[r, a, 0] - p[0]
                for d in range(draws):
                    whole = 0.0
                    for k in range(outcomes):
                        p[k] = 0.0
                        if q[r, a, k] > 0.0:
                            p[k] = random.standard_gamma(table[r, s, a, k] + k0 * q[r, a, k])
                            whole += p[k]
                    if whole == 0.0:
                        continue
                    for k in range(outcomes):
                        p[k] /= whole
                        mixed[d, k] += weight[a] * p[k]
                    value[m, d] += weight[a] * _divergence(p, q[r, a])
            for d in range(draws):
                value[m, d] -= _divergence(mixed[d], base)
            share[m] = n
            total += n
            m += 1
    means = np.zeros(m)
    for i in range(m):
        means[i] = value[i].mean()
    order = np.argsort(-means)
    lower, upper, rises, strongest = -np.inf, -np.inf, True, -1.0
    filled = 0.0
    summed, now = np.zeros(draws), np.zeros(draws)
    up, strength = True, -1.0
    for i in order:
        filled += share[i]
        for d in range(draws):
            summed[d] += share[i] * value[i, d]
            now[d] = summed[d] / filled
        if rise[i, 0] > strength:
            strength, up = rise[i, 0], rise[i, 1] > 0.0
        if filled < search.smallest_share * total:
            continue
        mean, spread = now.mean(), now.std()
        if mean - search.deviations * spread > lower:
            lower, rises = mean - search.deviations * spread, up
            lead[:] = now
        if mean + spread > upper:
            upper = mean + spread
            hoped[:] = now
    return lower, upper, rises


@njit(cache=True)
def event_values(
    s: np.ndarray, a: np.ndarray, before: np.ndarray, after: np.ndarray, since: int, sizes: np.ndarray, first: int,
    search: Search, random: np.random.Generator, lead: np.ndarray, hoped: np.ndarray,
) -> bool:  # fmt: skip
    """Draw an event's values.

    Args:
        s: (n,) values of its sensor.
        a: (n,) values of its action.
        before: (n,) what its result is conditioned on.
        after: (n,) values of its result.
        since: Step of the last module.
        sizes: (4,) number of values of before, s, a and after.
        first: First step that counts at all.
        search: Settings.
        random: Of the draws.
        lead: (draws,) is written.
        hoped: (draws,) is written.

    Returns:
        Whether the result rises where the event is most contingent.
    """
    table = np.zeros((sizes[0], sizes[1], sizes[2], sizes[3]))
    best, most, rises = -np.inf, -np.inf, True
    one, other = np.zeros(search.draws), np.zeros(search.draws)
    if search.actual:
        count(s, a, before, after, max(since, first), table)
        lower, upper, up = _value(table, False, search, random, one, other)
        best, most, rises = lower, upper, up
        lead[:], hoped[:] = one, other
    if search.reference:
        if search.actual:
            for t in range(first, min(max(since, first), len(s) - 1)):
                table[before[t], s[t], a[t], after[t + 1]] += 1.0
        else:
            count(s, a, before, after, first, table)
        lower, upper, up = _value(table, True, search, random, one, other)
        if lower > best:
            best, rises = lower, up
            lead[:] = one
        if upper > most:
            hoped[:] = other
    if search.doubt > 0.0:
        chance = 1.0 / (1.0 + search.doubt * np.exp(-max(-500.0, min(_log_evidence(table), 500.0))))
        for d in range(search.draws):
            hoped[d] *= random.random() < chance
    return rises


@njit(cache=True)
def log_bayes_factor(
    s: np.ndarray, a: np.ndarray, before: np.ndarray, after: np.ndarray, first: int, sizes: np.ndarray
) -> float:
    """Log of how much better the results are predicted with s than without, one after the other.

    Each result is predicted from those before it, p(r' | r, s, a) with a prior around p(r' | r, a). The factor is
    averaged over priors of different strength, EVIDENCE_OF.

    Args:
        s: (n,) values of the sensor.
        a: (n,) values of the action.
        before: (n,) what the result is conditioned on.
        after: (n,) values of the result.
        first: First step.
        sizes: (4,) number of values of before, s, a and after.
    """
    outcomes = sizes[3]
    own = np.zeros((sizes[0], sizes[1], sizes[2], outcomes + 1))
    by_action = np.zeros((sizes[0], sizes[2], outcomes + 1))
    by_sensor = np.zeros((sizes[0], sizes[1], outcomes + 1))
    total = np.zeros((2, len(EVIDENCE_OF)))
    for t in range(first, len(s) - 1):
        counts, k = own[before[t], s[t], a[t]], after[t + 1]
        for part in range(2):
            chance = by_action[before[t], a[t]] if part == 0 else by_sensor[before[t], s[t]]
            p0 = (chance[k] + 1.0 / outcomes) / (chance[outcomes] + 1.0)
            for i in range(len(EVIDENCE_OF)):
                p1 = (counts[k] + EVIDENCE_OF[i] * p0) / (counts[outcomes] + EVIDENCE_OF[i])
                total[part, i] += np.log(p1 / p0)
            chance[k] += 1.0
            chance[outcomes] += 1.0
        counts[k] += 1.0
        counts[outcomes] += 1.0
    return min(_log_mean_exp(total[0]), _log_mean_exp(total[1]))


@njit(cache=True)
def _log_mean_exp(values: np.ndarray) -> float:
    highest = values.max()
    mean: float = highest + np.log(np.exp(values - highest).mean())
    return mean
