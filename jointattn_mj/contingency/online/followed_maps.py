"""Maps of modules that follow what is learned later, and do not undo themselves.

A module that is used changes how often actions are done and situations come. A map that is made of raw counts anew
(``refresh_every``) then loses what it had. Here a map offers what gains most. The gain of action a and result r' in the
situation (r, s) is

    p(r' | r, s, a) - p(r' | r, not s, a)

the difference that s makes, known in the study of contingency judgement as delta P. It does not depend on how often an
action is done. What lasts for some steps, such as an object that stays, makes an offer that was right once look right
again; gains are therefore taken within what came of the same action the last time that it was done.
"""

import math

import numpy as np

from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.online.experience import EventSeries
from jointattn_mj.contingency.online.local import LocalConfig
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING, Module
from jointattn_mj.io.compiled import njit


def followed_map(event: Event, series: EventSeries, first: int, config: LocalConfig) -> Module:
    """The module of an event, from all steps.

    In each situation it offers the action and the result whose gain is surest, if that is above 0 by
    ``offer_deviations`` standard deviations, in all and within what came of the same action last time, and more than
    ``offer_gain`` of the largest gain of the map. Its reliability is the z-score of that gain (as in eq. 5.5).

    Args:
        event: The event.
        series: Its series.
        first: First step that counts.
        config: Thresholds, and strength of the prior.
    """
    results, sensors, actions, outcomes = (int(size) for size in series.sizes)
    command, expected = np.full((2, results, sensors), OFFERS_NOTHING)
    reliability = np.zeros((results, sensors))
    saliency = np.zeros((results, sensors, outcomes, actions))
    _read(
        *series.columns, first, (config.concentration, config.offer_deviations, config.offer_gain),
        command, expected, reliability, saliency,
    )  # fmt: skip
    return Module(event=event, command=command, reliability=reliability, expected=expected, saliency=saliency)


@njit(cache=True)
def _read(
    s: np.ndarray, a: np.ndarray, before: np.ndarray, after: np.ndarray, first: int,
    limits: tuple[float, float, float], command: np.ndarray, expected: np.ndarray, reliability: np.ndarray,
    saliency: np.ndarray,
) -> None:  # fmt: skip
    """See ``followed_map``.

    Args:
        s: (n,) values of a sensor.
        a: (n,) values of an action.
        before: (n,) what the result is conditioned on.
        after: (n,) values of a result.
        first: First step that counts.
        limits: ``concentration``, ``offer_deviations`` and ``offer_gain``.
        command: (R, S) is written where something is offered.
        expected: (R, S) likewise.
        reliability: (R, S) likewise.
        saliency: (R, S, R', A) is written: gain within what came of the same action last time; NaN where a situation
            was not seen.
    """
    results, sensors, outcomes, actions = saliency.shape
    concentration, deviations, least = limits
    strata = np.zeros((outcomes, results, sensors, actions, outcomes))
    table = np.zeros((results, sensors, actions, outcomes))
    count_by_last(s, a, before, after, first, strata, table)
    gain, spread = gains(table, concentration)
    within, spread_within = _mean_gains(strata, concentration)
    largest = 0.0
    for r in range(results):
        for s_value in range(sensors):
            best = 0.0
            for k in range(1, outcomes):  # the first value stands for the absence of a result, and is not offered
                for action in range(actions):
                    surest = within[r, s_value, k, action] - deviations * spread_within[r, s_value, k, action]
                    is_sure = gain[r, s_value, k, action] > deviations * spread[r, s_value, k, action]
                    if is_sure and surest > best:
                        best = surest
                        command[r, s_value], expected[r, s_value] = action, k
            if best > 0.0:
                largest = max(largest, within[r, s_value, expected[r, s_value], command[r, s_value]])
    for r in range(results):
        for s_value in range(sensors):
            if command[r, s_value] != OFFERS_NOTHING:
                gained = within[r, s_value, expected[r, s_value], command[r, s_value]]
                if gained > least * largest:
                    reliability[r, s_value] = _z_score(gained, within, r, s_value)
                else:
                    command[r, s_value] = expected[r, s_value] = OFFERS_NOTHING
            steps = 0.0
            for action in range(actions):
                for k in range(outcomes):
                    steps += table[r, s_value, action, k]
            for k in range(outcomes):
                for action in range(actions):
                    saliency[r, s_value, k, action] = within[r, s_value, k, action] if steps else np.nan


@njit(cache=True)
def _mean_gains(strata: np.ndarray, concentration: float) -> tuple[np.ndarray, np.ndarray]:
    """Gains within what came of the same action last time, and their standard deviations, both (R, S, R', A).

    Args:
        strata: (R', R, S, A, R') counts by what came last time.
        concentration: Transitions that the prior is worth.
    """
    outcomes, results, sensors, actions, _ = strata.shape
    within = np.zeros((results, sensors, outcomes, actions))
    spread, known = np.zeros(within.shape), np.zeros(within.shape)
    for stratum in range(outcomes):
        gain_here, spread_here = gains(strata[stratum], concentration)
        for r in range(results):
            for s in range(sensors):
                for k in range(outcomes):
                    for a in range(actions):
                        within[r, s, k, a] += gain_here[r, s, k, a]
                        spread[r, s, k, a] += spread_here[r, s, k, a] * spread_here[r, s, k, a]
                        known[r, s, k, a] += spread_here[r, s, k, a] > 0.0
    for r in range(results):
        for s in range(sensors):
            for k in range(outcomes):
                for a in range(actions):
                    parts = max(known[r, s, k, a], 1.0)
                    within[r, s, k, a] /= parts
                    spread[r, s, k, a] = math.sqrt(spread[r, s, k, a]) / parts
    return within, spread


@njit(cache=True)
def _z_score(value: float, within: np.ndarray, r: int, s: int) -> float:
    """How far a value lies above the mean of a situation's gains (R, S, R', A), in their standard deviations."""
    _, _, outcomes, actions = within.shape
    total, squares = 0.0, 0.0
    for k in range(outcomes):
        for a in range(actions):
            total += within[r, s, k, a]
    mean = total / (outcomes * actions)
    for k in range(outcomes):
        for a in range(actions):
            squares += (within[r, s, k, a] - mean) ** 2
    z: float = (value - mean) / math.sqrt(squares / (outcomes * actions))
    return z


@njit(cache=True)
def gains(table: np.ndarray, concentration: float) -> tuple[np.ndarray, np.ndarray]:
    """By how much more probable each result is after each action in a situation than under other values of s.

    Args:
        table: (R, S, A, R') counts.
        concentration: Transitions that the prior "s says nothing" is worth, for either side.

    Returns:
        (R, S, R', A) differences of probability, and their standard deviations; both are 0 where the action was not
        done on one of the two sides.
    """
    results, sensors, actions, outcomes = table.shape
    gain = np.zeros((results, sensors, outcomes, actions))
    spread = np.zeros(gain.shape)
    together = np.zeros(outcomes)
    for r in range(results):
        for a in range(actions):
            together[:] = 0.0
            for s in range(sensors):
                together += table[r, s, a]
            whole = together.sum()
            for s in range(sensors):
                here = table[r, s, a].sum()
                if here == 0.0 or here == whole:
                    continue
                n, m = here + concentration, whole - here + concentration
                for k in range(outcomes):
                    prior = concentration * together[k] / whole
                    p = (table[r, s, a, k] + prior) / n
                    q = (together[k] - table[r, s, a, k] + prior) / m
                    gain[r, s, k, a] = p - q
                    variance = p * (1.0 - p) / (n + 1.0) + q * (1.0 - q) / (m + 1.0)
                    spread[r, s, k, a] = math.sqrt(max(variance, 0.0))
    return gain, spread


@njit(cache=True)
def count_by_last(
    s: np.ndarray,
    a: np.ndarray,
    before: np.ndarray,
    after: np.ndarray,
    first: int,
    strata: np.ndarray,
    table: np.ndarray,
) -> None:
    """Count transitions, and count them by what came of the same action the last time that it was done.

    Args:
        s: (n,) values of a sensor.
        a: (n,) values of an action.
        before: (n,) what the result is conditioned on.
        after: (n,) values of a result.
        first: First step.
        strata: (R', R, S, A, R') counts, changed in place; a transition whose action had not been done does not count.
        table: (R, S, A, R') counts, changed in place.
    """
    last = np.full(strata.shape[3], -1)
    for t in range(first, len(s) - 1):
        table[before[t], s[t], a[t], after[t + 1]] += 1.0
        if last[a[t]] >= 0:
            strata[last[a[t]], before[t], s[t], a[t], after[t + 1]] += 1.0
        last[a[t]] = after[t + 1]
