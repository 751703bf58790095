"""Values of events for stop rule ``local``: posterior draws of local contingency, and evidence that there is any.

Compiled, on tables (R, S, A, R') that count r, s, a and the r' that followed.
"""

import math
from typing import NamedTuple

import numpy as np

from jointattn_mj.io.compiled import njit

STRENGTHS = (1.0, 4.0, 16.0)
"""Concentrations of the priors that evidence is averaged over: how many transitions each is worth."""


class Draws(NamedTuple):
    """How values are drawn; see ``LocalConfig``."""

    number: int
    concentration: float
    smallest_share: float
    deviations: float
    actual: bool
    reference: bool
    doubt: float


@njit(cache=True)
def count(
    s: np.ndarray, a: np.ndarray, before: np.ndarray, after: np.ndarray, span: tuple[int, int], table: np.ndarray
) -> None:
    """Count transitions.

    Args:
        s: (n,) values of a sensor.
        a: (n,) values of an action.
        before: (n,) what the result is conditioned on.
        after: (n,) values of a result; that of the next step is counted.
        span: First step, and the one after the last.
        table: (R, S, A, R') counts, changed in place.
    """
    for t in range(span[0], min(span[1], len(s) - 1)):
        table[before[t], s[t], a[t], after[t + 1]] += 1.0


@njit(cache=True)
def event_values(
    s: np.ndarray, a: np.ndarray, before: np.ndarray, after: np.ndarray, first: int, since: int, sizes: np.ndarray,
    draws: Draws, random: np.random.Generator, lead: np.ndarray, hoped: np.ndarray,
) -> bool:  # fmt: skip
    """Draw the value of an event: as the first, and as a rival of the first.

    Args:
        s: (n,) values of its sensor.
        a: (n,) values of its action.
        before: (n,) what its result is conditioned on.
        after: (n,) values of its result.
        first: First step in which it could occur.
        since: Step at which the last module was made.
        sizes: (4,) number of values of before, s, a and after.
        draws: How to draw.
        random: Generator.
        lead: (draws,) is written: mean D of the situations that are surest to be contingent, nats.
        hoped: (draws,) is written: that of the situations that are best if luck will have it; 0 where there is no
            contingency at all.

    Returns:
        Whether the result becomes more frequent where the event is most contingent.
    """
    table = np.zeros((sizes[0], sizes[1], sizes[2], sizes[3]))
    surest, best, rises = -np.inf, -np.inf, True
    one, other = np.zeros(draws.number), np.zeros(draws.number)
    new = max(first, since)
    for by_reference in (False, True):
        count(s, a, before, after, (first, new) if by_reference else (new, len(s)), table)
        if not (draws.reference if by_reference else draws.actual):
            continue
        lower, upper, up = _draw(table, by_reference, draws, random, one, other)
        if lower > surest:
            surest, rises = lower, up
            lead[:] = one
        if upper > best:
            best = upper
            hoped[:] = other
    if draws.doubt > 0.0:
        chance = 1.0 / (1.0 + draws.doubt * math.exp(-min(max(log_evidence(table), -500.0), 500.0)))
        for d in range(draws.number):
            hoped[d] *= random.random() < chance
    return rises


@njit(cache=True)
def _draw(
    table: np.ndarray, by_reference: bool, draws: Draws, random: np.random.Generator, lead: np.ndarray,
    hoped: np.ndarray,
) -> tuple[float, float, bool]:  # fmt: skip
    """Draw the value of an event under one policy.

    Args:
        table: Counts.
        by_reference: Whether each action weighs the same, or as often as it was done.
        draws: How to draw.
        random: Generator.
        lead: (draws,) is written, see ``event_values``.
        hoped: (draws,) is written, likewise.

    Returns:
        Mean less ``deviations`` of ``lead``; mean and one deviation of ``hoped``; whether the result becomes more
        frequent in the situations of ``lead``.
    """
    results, sensors, _, _ = table.shape
    q = _pooled(table)
    value = np.zeros((results * sensors, draws.number))
    share, rise = np.zeros(len(value)), np.zeros(len(value))
    m = 0
    for r in range(results):
        base = _shares(table[r].sum(axis=0).sum(axis=0))
        for s in range(sensors):
            n = table[r, s].sum()
            if n > 0.0:
                share[m] = n
                rise[m] = _draw_situation(table[r, s], q[r], base, by_reference, draws, random, value[m])
                m += 1
    value, share = value[:m], share[:m] / share[:m].sum()
    order = np.argsort(-_means(value))
    lower, upper, rises, risen = -np.inf, -np.inf, True, 0.0
    filled, summed, now = 0.0, np.zeros(draws.number), np.zeros(draws.number)
    for i in order:
        filled += share[i]
        for d in range(draws.number):
            summed[d] += share[i] * value[i, d]
            now[d] = summed[d] / filled
        risen += share[i] * rise[i]
        if filled < draws.smallest_share - 1e-12:
            continue
        mean, spread = now.mean(), now.std()
        if mean - draws.deviations * spread > lower:
            lower, rises = mean - draws.deviations * spread, risen > 0.0
            lead[:] = now
        if mean + spread > upper:
            upper = mean + spread
            hoped[:] = now
    return lower, upper, rises


@njit(cache=True)
def _draw_situation(
    counts: np.ndarray, q: np.ndarray, base: np.ndarray, by_reference: bool, draws: Draws,
    random: np.random.Generator, value: np.ndarray,
) -> float:  # fmt: skip
    """Draw D(r, s) of one situation.

    Args:
        counts: (A, R') of the situation.
        q: (A, R') p(r' | r, a).
        base: (R',) p(r' | r).
        by_reference: Whether each action weighs the same.
        draws: How to draw.
        random: Generator.
        value: (draws,) is written.

    Returns:
        What the actions contribute to D by making a result more frequent, less what they contribute by making it rarer,
        nats. The first value of a result stands for its absence.
    """
    actions, outcomes = counts.shape
    number, k0 = len(value), draws.concentration
    times = np.zeros(actions)
    for a in range(actions):
        times[a] = counts[a].sum()
    seen, n = (times > 0.0).sum(), times.sum()
    mixed, p = np.zeros((number, outcomes)), np.zeros(outcomes)
    center = np.zeros(outcomes)
    rise = 0.0
    for a in range(actions):
        if times[a] == 0.0:
            continue
        weight = 1.0 / seen if by_reference else times[a] / n
        center += weight * q[a]
        if (q[a] > 0.0).sum() == 1:  # the action has always had this result, whatever was sensed
            for d in range(number):
                mixed[d] += weight * q[a]
            continue
        for k in range(outcomes):
            p[k] = (counts[a, k] + k0 * q[a, k]) / (times[a] + k0)
        rise += weight * _divergence(p, q[a]) * (1.0 if p[0] < q[a, 0] else -1.0)
        for d in range(number):
            whole = 0.0
            for k in range(outcomes):
                p[k] = random.standard_gamma(counts[a, k] + k0 * q[a, k]) if q[a, k] > 0.0 else 0.0
                whole += p[k]
            for k in range(outcomes):
                p[k] = p[k] / whole if whole > 0.0 else q[a, k]
                mixed[d, k] += weight * p[k]
            value[d] += weight * _divergence(p, q[a])
    for d in range(number):
        value[d] -= _divergence(mixed[d], center if by_reference else base)
    return rise


@njit(cache=True)
def log_evidence(table: np.ndarray) -> float:
    """Log of how much better the counts are explained with s and a together than with either alone.

    Each p(r' | r, s, a) has a prior around p(r' | r, a), or around p(r' | r, s), which are taken from the same counts.
    The factor is averaged over priors of different strength, STRENGTHS; the smaller of the two is returned.
    """
    results, sensors, actions, outcomes = table.shape
    q = _pooled(table)
    total = np.zeros((2, len(STRENGTHS)))
    for r in range(results):
        for s in range(sensors):
            n_s = table[r, s].sum()
            if n_s == 0.0:
                continue
            of_s = table[r, s].sum(axis=0) / n_s
            for a in range(actions):
                n = table[r, s, a].sum()
                if n == 0.0:
                    continue
                for i, strength in enumerate(STRENGTHS):
                    constant = math.lgamma(strength) - math.lgamma(n + strength)
                    for part in range(2):
                        total[part, i] += constant
                        for k in range(outcomes):
                            c = table[r, s, a, k]
                            if c > 0.0:
                                p = q[r, a, k] if part == 0 else of_s[k]
                                b = strength * p
                                total[part, i] += math.lgamma(c + b) - math.lgamma(b) - c * math.log(p)
    return min(_log_mean_exp(total[0]), _log_mean_exp(total[1]))


@njit(cache=True)
def predictive_evidence(
    s: np.ndarray, a: np.ndarray, before: np.ndarray, after: np.ndarray, first: int, sizes: np.ndarray
) -> float:
    """Log of how much better the results are foreseen with s and a together than with either alone.

    Each result is foreseen from those before it only: p(r' | r, s, a) with a prior around p(r' | r, a), or around
    p(r' | r, s). Averaged over priors of different strength, STRENGTHS; the smaller of the two is returned.

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
    total = np.zeros((2, len(STRENGTHS)))
    for t in range(first, len(s) - 1):
        counts, k = own[before[t], s[t], a[t]], after[t + 1]
        for part in range(2):
            alone = by_action[before[t], a[t]] if part == 0 else by_sensor[before[t], s[t]]
            p0 = (alone[k] + 1.0 / outcomes) / (alone[outcomes] + 1.0)
            for i, strength in enumerate(STRENGTHS):
                total[part, i] += math.log((counts[k] + strength * p0) / (counts[outcomes] + strength) / p0)
            alone[k] += 1.0
            alone[outcomes] += 1.0
        counts[k] += 1.0
        counts[outcomes] += 1.0
    return min(_log_mean_exp(total[0]), _log_mean_exp(total[1]))


@njit(cache=True)
def _log_mean_exp(values: np.ndarray) -> float:
    highest = values.max()
    mean: float = highest + math.log(np.exp(values - highest).mean())
    return mean


@njit(cache=True)
def _pooled(table: np.ndarray) -> np.ndarray:
    """(R, A, R') p(r' | r, a); 0 where an action was never done."""
    results, _, actions, outcomes = table.shape
    q = np.zeros((results, actions, outcomes))
    for r in range(results):
        together = table[r].sum(axis=0)
        for a in range(actions):
            q[r, a] = _shares(together[a])
    return q


@njit(cache=True)
def _shares(counts: np.ndarray) -> np.ndarray:
    """Counts divided by their sum; 0 where there are none."""
    whole = counts.sum()
    return counts / whole if whole > 0.0 else np.zeros(len(counts))


@njit(cache=True)
def _means(rows: np.ndarray) -> np.ndarray:
    means = np.zeros(len(rows))
    for i in range(len(rows)):
        means[i] = rows[i].mean()
    return means


@njit(cache=True, forceinline=True)
def _divergence(p: np.ndarray, q: np.ndarray) -> float:
    """KL(p || q), nats."""
    total = 0.0
    for k in range(len(p)):
        if p[k] > 0.0 and q[k] > 0.0:
            total += p[k] * math.log(p[k] / q[k])
    return total
