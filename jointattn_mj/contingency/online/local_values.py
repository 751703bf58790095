"""Values of events for stop rule ``local``: the posterior of local contingency, and evidence that there is any.

The values D(r, s) of ``contingency.situations`` have a posterior. Here its mean and variance are computed, so that
nothing is drawn. The divergence of one action from what is usual has moments in closed form, by the digamma function;
the mixture over actions is taken as beta distributed in the mean, and as linear in the variance. A sum over situations
is taken as normal.
Compiled: all events of a look in one call.
"""

import math
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from jointattn_mj.contingency.online.experience import EventColumns
from jointattn_mj.io.compiled import njit

STRENGTHS = (1.0, 4.0, 16.0)
"""Concentrations of the priors that evidence is averaged over: how many transitions each is worth."""
AFFECTED = (1.0, 0.25, 0.0625)
"""How probable it is, before anything is known, that s and a matter together in any one situation and action; evidence
is averaged over these as well. Contingency is carried by few of them, and those that carry none would speak against
those that do if all were believed to carry some."""
QUANTILES = tuple(NormalDist().inv_cdf((i + 0.5) / 64) for i in range(64))
"""Of the standard normal distribution, for means over it."""
NEGLIGIBLE = 1e-5
"""Probability of being higher below which a rival needs no doubt."""
IMPOSSIBLE = 1e-17
"""Such a probability that 1 less it is 1."""


class Weighing(NamedTuple):
    """How situations are weighed; see ``LocalConfig``."""

    concentration: float
    smallest_share: float
    deviations: float
    actual: bool
    reference: bool


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
        table: (R, S, A, R') counts, changed in place. Row by row and with one index that cannot be negative, a
            transition takes half of the time.
    """
    _, sensors, actions, outcomes = table.shape
    flat = table.reshape(-1)
    for t in range(span[0], min(span[1], len(s) - 1)):
        entry = ((before[t] * sensors + s[t]) * actions + a[t]) * outcomes + after[t + 1]
        flat[np.uint64(entry)] += 1.0


@njit(cache=True)
def event_values(
    columns: EventColumns, since: int, how: Weighing, lead: np.ndarray, hoped: np.ndarray, rise: np.ndarray
) -> None:
    """The value of each event: as the first, and as a rival of the first.

    Args:
        columns: Of the E events.
        since: Step at which the last module was made.
        how: How situations are weighed.
        lead: (E, 2) is written: mean and standard deviation of D, over the situations that are surest to be
            contingent, nats.
        hoped: (E, 2) is written: those over the situations that are best if luck will have it.
        rise: (E,) is written: whether the result becomes more frequent where the event is most contingent, or rarer:
            from 1, only more frequent, to -1, only rarer.
    """
    for e in range(len(columns.events)):
        sensor, action, result, first = columns.events[e]
        sizes, new = columns.sizes[e], max(first, since)
        table = np.zeros((sizes[0], sizes[1], sizes[2], sizes[3]))
        own, rival = np.zeros(2), np.zeros(2)
        surest, best = -np.inf, -np.inf
        for by_reference in (False, True):
            count(
                columns.s.T[sensor], columns.a.T[action], columns.before.T[result], columns.r.T[result],
                (first, new) if by_reference else (new, len(columns.s)), table,
            )  # fmt: skip
            if not (how.reference if by_reference else how.actual):
                continue
            up = value_of(table, by_reference, how, own, rival)
            lower, upper = own[0] - how.deviations * own[1], rival[0] + rival[1]
            if lower > surest:
                surest, rise[e] = lower, up
                lead[e] = own
            if upper > best:
                best = upper
                hoped[e] = rival


@njit(cache=True)
def value_of(table: np.ndarray, by_reference: bool, how: Weighing, lead: np.ndarray, hoped: np.ndarray) -> float:
    """The value of an event under one policy.

    Args:
        table: (R, S, A, R') counts.
        by_reference: Whether each action weighs the same, or as often as it was done.
        how: How situations are weighed.
        lead: (2,) is written, see ``event_values``.
        hoped: (2,) is written, likewise.

    Returns:
        Whether the result becomes more frequent in the situations of ``lead``, or rarer, see ``event_values``.
    """
    results, sensors, actions, outcomes = table.shape
    value = np.zeros((results * sensors, 5))  # share, mean, variance, rise, and the rise whatever its sign
    q, base, times = np.zeros((actions, outcomes)), np.zeros(outcomes), np.zeros((sensors, actions))
    p, room = np.zeros((2, actions, outcomes)), np.zeros((3, outcomes))
    m, total = 0, 0.0
    for r in range(results):
        if _pool(table[r], q, base, times) == 0.0:
            continue
        for s in range(sensors):
            n = times[s].sum()
            if n > 0.0:
                _situation(table[r, s], times[s], q, base, by_reference, how.concentration, p, room, value[m])
                value[m, 0] = n
                total += n
                m += 1
    order = np.argsort(-value[:m, 1])
    lower, upper, up = -np.inf, -np.inf, 1.0
    lead[:], hoped[:] = 0.0, 0.0
    filled = mean = variance = risen = moved = 0.0
    for i in order:
        share = value[i, 0] / total
        filled += share
        mean += share * value[i, 1]
        variance += share * share * value[i, 2]
        risen += share * value[i, 3]
        moved += share * value[i, 4]
        if filled < how.smallest_share - 1e-12:
            continue
        now, spread = mean / filled, math.sqrt(variance) / filled
        if now - how.deviations * spread > lower:
            lower, up = now - how.deviations * spread, risen / moved if moved > 0.0 else np.sign(risen)
            lead[0], lead[1] = now, spread
        if now + spread > upper:
            upper = now + spread
            hoped[0], hoped[1] = now, spread
    return up


@njit(cache=True)
def _pool(table: np.ndarray, q: np.ndarray, base: np.ndarray, times: np.ndarray) -> float:
    """Shares of results over all values of s, under one r.

    Args:
        table: (S, A, R') counts.
        q: (A, R') is written: p(r' | r, a).
        base: (R',) is written: p(r' | r).
        times: (S, A) is written: how often each action was done.

    Returns:
        Number of transitions.
    """
    sensors, actions, outcomes = table.shape
    whole = 0.0
    base[:] = 0.0
    for a in range(actions):
        n = 0.0
        q[a] = 0.0
        for s in range(sensors):
            here = 0.0
            for k in range(outcomes):
                c = table[s, a, k]
                here += c
                q[a, k] += c
            times[s, a] = here
            n += here
        for k in range(outcomes):
            base[k] += q[a, k]
            if n > 0.0:
                q[a, k] /= n
        whole += n
    if whole > 0.0:
        base /= whole
    return whole


@njit(cache=True)
def _situation(
    counts: np.ndarray, times: np.ndarray, q: np.ndarray, base: np.ndarray, by_reference: bool, concentration: float,
    p: np.ndarray, room: np.ndarray, value: np.ndarray,
) -> None:  # fmt: skip
    """Posterior of D(r, s) of one situation.

    Args:
        counts: (A, R') of the situation.
        times: (A,) how often each action was done in it.
        q: (A, R') p(r' | r, a).
        base: (R',) p(r' | r).
        by_reference: Whether each action weighs the same.
        concentration: Transitions that the prior is worth.
        p: (2, A, R') working space: the posterior's mean, and digamma functions of its parameters.
        room: (3, R') working space.
        value: (5,) its second is the mean of D, nats, its third the variance, its fourth what the actions contribute
            to D by making a result more frequent, less what they contribute by making it rarer, its fifth the sum of
            both. The first value of a result stands for its absence.
    """
    actions, outcomes = counts.shape
    n, tried = 0.0, 0
    for a in range(actions):
        n += times[a]
        tried += times[a] > 0.0
    mean, rise, moved, variance = 0.0, 0.0, 0.0, 0.0
    mixed, center, scatter = room[0], room[1], room[2]
    mixed[:] = 0.0
    scatter[:] = 0.0
    if by_reference:
        center[:] = 0.0
    else:
        center[:] = base
    for a in range(actions):
        if times[a] == 0.0:
            continue
        weight, total = 1.0 / tried if by_reference else times[a] / n, times[a] + concentration
        divergence, top = 0.0, digamma(total + 1.0)
        for k in range(outcomes):
            x = p[0, a, k] = (counts[a, k] + concentration * q[a, k]) / total
            mixed[k] += weight * x
            scatter[k] += weight * weight * x * (1.0 - x) / (total + 1.0)
            if by_reference:
                center[k] += weight * q[a, k]
            if 0.0 < q[a, k] < 1.0:
                divergence += x * math.log(x / q[a, k])
                p[1, a, k] = digamma(total * x + 1.0)
                mean += weight * x * (p[1, a, k] - top - math.log(q[a, k]))
        rise += weight * divergence * (1.0 if p[0, a, 0] < q[a, 0] else -1.0)
        moved += weight * divergence
    for k in range(outcomes):
        x = mixed[k]
        if x > 0.0:
            expected = math.log(x)
            if scatter[k] > 0.0:
                strength = x * (1.0 - x) / scatter[k] - 1.0
                expected = digamma(strength * x + 1.0) - digamma(strength + 1.0)
            mean -= x * (expected - math.log(center[k]))
            center[k] = math.log(x / center[k])
    for a in range(actions):
        if times[a] == 0.0:
            continue
        weight, total = 1.0 / tried if by_reference else times[a] / n, times[a] + concentration
        variance += weight * weight * _scatter(p[0, a], p[1, a], q[a], center, total, (1.0 - weight) ** 2)
    value[1], value[2], value[3], value[4] = mean, variance, rise, moved


@njit(cache=True)
def _scatter(
    p: np.ndarray, expected: np.ndarray, q: np.ndarray, center: np.ndarray, total: float, rest: float
) -> float:
    """Variance of sum_k x_k (log(x_k / q_k) - c_k), where x has a Dirichlet distribution.

    Args:
        p: (R',) mean of x.
        expected: (R',) digamma(total p + 1).
        q: (R',) see above.
        center: (R',) c.
        total: Sum of the distribution's parameters.
        rest: Share of what is not linear in x that counts.
    """
    square = mean = first = second = 0.0
    low, top, slope = digamma(total + 1.0), digamma(total + 2.0), trigamma(total + 2.0)
    for k in range(len(p)):
        x = p[k]
        if not 0.0 < x < 1.0:
            continue
        shift, a = math.log(q[k]) + center[k], total * x
        linear = math.log(x) - shift
        first += x * linear
        second += x * linear * linear
        mean += x * (expected[k] - low - shift)
        d = digamma(a + 2.0) - top - shift
        square += x * (a + 1.0) / (total + 1.0) * (d * d + trigamma(a + 2.0) - slope)
        for j in range(k):
            y = p[j]
            if 0.0 < y < 1.0:
                term = expected[k] - top - shift
                other_term = expected[j] - top - math.log(q[j]) - center[j]
                square += 2.0 * x * y * total / (total + 1.0) * (term * other_term - slope)
    linear = (second - first * first) / (total + 1.0)
    whole = square - mean * mean
    return whole - (1.0 - rest) * max(whole - linear, 0.0)


@njit(cache=True)
def digamma(x: float) -> float:
    """Derivative of the logarithm of the gamma function, for x >= 1."""
    value = 0.0
    while x < 6.0:
        value -= 1.0 / x
        x += 1.0
    y = 1.0 / (x * x)
    return value + math.log(x) - 0.5 / x - y * (1.0 / 12.0 - y * (1.0 / 120.0 - y * (1.0 / 252.0 - y / 240.0)))


@njit(cache=True)
def trigamma(x: float) -> float:
    """Second derivative of the logarithm of the gamma function, for x >= 1."""
    value = 0.0
    while x < 6.0:
        value += 1.0 / (x * x)
        x += 1.0
    y = 1.0 / (x * x)
    return value + 1.0 / x + 0.5 * y + y / x * (1.0 / 6.0 - y * (1.0 / 30.0 - y * (1.0 / 42.0 - y / 30.0)))


@njit(cache=True)
def next_first(
    columns: EventColumns,
    tried: np.ndarray,
    at: int,
    rivals: np.ndarray,
    lead: np.ndarray,
    hoped: np.ndarray,
    evidence: np.ndarray,
    limits: tuple[float, float, float],
) -> int:
    """The next of some events of which no other is higher, surely enough.

    Args:
        columns: Of all E events.
        tried: Numbers of the events, in the order in which they are tried.
        at: Place in ``tried`` of the one with which to begin.
        rivals: Numbers of the events that are rivals of each other, those tried among them.
        lead: (E, 2) values of the events as the first.
        hoped: (E, 2) their values as rivals.
        evidence: (E,) log evidence of each event as far as it was needed before, NaN else; more is written.
        limits: ``tolerance``, ``doubt`` and ``best`` of ``LocalConfig``.

    Returns:
        Its place in ``tried``; the number of these if there is none.
    """
    while at < len(tried) and not _is_first(columns, tried[at], rivals, lead, hoped, evidence, limits):
        at += 1
    return at


@njit(cache=True)
def _is_first(
    columns: EventColumns, number: int, rivals: np.ndarray, lead: np.ndarray, hoped: np.ndarray, evidence: np.ndarray,
    limits: tuple[float, float, float],
) -> bool:  # fmt: skip
    """Whether no rival of an event is higher; most fall by one whose evidence is known, before more is counted."""
    tolerance, doubt, best = limits
    below, higher = np.ones(len(QUANTILES)), np.zeros(len(QUANTILES))
    for with_evidence in (True, False):
        for rival in rivals:
            known = doubt == 0.0 or not math.isnan(evidence[rival])
            if rival == number or known != with_evidence:
                continue
            lowest = (1.0 + tolerance) * (lead[number, 0] + QUANTILES[0] * lead[number, 1])
            if _above(hoped[rival], lowest) < IMPOSSIBLE:
                continue
            exceeding(lead[number], hoped[rival], tolerance, higher)
            if doubt > 0.0 and higher.mean() > NEGLIGIBLE:
                if not known:
                    evidence[rival] = evidence_of(columns, rival)
                higher /= 1.0 + doubt * math.exp(-min(max(evidence[rival], -500.0), 500.0))
            below *= 1.0 - higher
            if below.mean() < best - 1e-9:
                return False
    enough: bool = below.mean() >= best
    return enough


@njit(cache=True)
def exceeding(first: np.ndarray, hoped: np.ndarray, tolerance: float, higher: np.ndarray) -> None:
    """How probable it is that a rival is higher than the first, for each of some values that the first may have.

    Args:
        first: (2,) mean and standard deviation of the first.
        hoped: (2,) those of the rival.
        tolerance: Share of the first's value by which a rival may be higher.
        higher: (quantiles,) is written.
    """
    for j, quantile in enumerate(QUANTILES):
        higher[j] = _above(hoped, (1.0 + tolerance) * (first[0] + quantile * first[1]))


@njit(cache=True, forceinline=True)
def _above(value: np.ndarray, bound: float) -> float:
    """Probability that a normal value, mean and standard deviation (2,), is above a bound."""
    above, spread = value[0] - bound, value[1]
    if spread > 0.0:
        return 0.5 * math.erfc(-above / spread * math.sqrt(0.5))
    return 1.0 if above > 0.0 else 0.0


@njit(cache=True)
def evidence_of(columns: EventColumns, number: int) -> float:
    """Log evidence of an event (its number), from all steps; see ``log_evidence``."""
    sensor, action, result, first = columns.events[number]
    sizes = columns.sizes[number]
    table = np.zeros((sizes[0], sizes[1], sizes[2], sizes[3]))
    count(
        columns.s.T[sensor], columns.a.T[action], columns.before.T[result], columns.r.T[result],
        (first, len(columns.s)), table,
    )  # fmt: skip
    logs: float = log_evidence(table)
    return logs


@njit(cache=True)
def log_evidence(table: np.ndarray) -> float:
    """Log of how much better the counts are explained with s and a together than with either alone.

    Each p(r' | r, s, a) is p(r' | r, a), or p(r' | r, s), which are taken from the same counts; or else it has a prior
    around it. The factor is averaged over strengths of the prior and over how probable it is that there is anything but
    the former, STRENGTHS and AFFECTED; the smaller of the two is returned.
    """
    results, sensors, actions, outcomes = table.shape
    q = _pooled(table)
    total, factor = np.zeros((2, len(STRENGTHS), len(AFFECTED))), np.zeros((2, len(STRENGTHS)))
    of_a, of_s = np.zeros((actions, outcomes, 1 + len(STRENGTHS))), np.zeros((outcomes, 1 + len(STRENGTHS)))
    for r in range(results):
        for a in range(actions):
            _logs(q[r, a], of_a[a])
        for s in range(sensors):
            n_s = table[r, s].sum()
            if n_s == 0.0:
                continue
            p_s = table[r, s].sum(axis=0) / n_s
            _logs(p_s, of_s)
            for a in range(actions):
                n = table[r, s, a].sum()
                if n == 0.0:
                    continue
                for i, strength in enumerate(STRENGTHS):
                    factor[:, i] = math.lgamma(strength) - math.lgamma(n + strength)
                    for k in range(outcomes):
                        c = table[r, s, a, k]
                        if c > 0.0:
                            b, d = strength * q[r, a, k], strength * p_s[k]
                            factor[0, i] += math.lgamma(c + b) - of_a[a, k, 1 + i] - c * of_a[a, k, 0]
                            factor[1, i] += math.lgamma(c + d) - of_s[k, 1 + i] - c * of_s[k, 0]
                _add(factor, total)
    return min(_log_mean_exp(total[0]), _log_mean_exp(total[1]))


@njit(cache=True)
def _logs(p: np.ndarray, logs: np.ndarray) -> None:
    """Logarithms that are the same for all counts.

    Args:
        p: (R',) probabilities.
        logs: (R', 1 + strengths) is written where p is above 0: log(p), and log gamma(strength p).
    """
    for k in range(len(p)):
        if p[k] > 0.0:
            logs[k, 0] = math.log(p[k])
            for i, strength in enumerate(STRENGTHS):
                logs[k, 1 + i] = math.lgamma(strength * p[k])


@njit(cache=True)
def predictive_evidence(
    s: np.ndarray, a: np.ndarray, before: np.ndarray, after: np.ndarray, first: int, sizes: np.ndarray
) -> float:
    """Log of how much better the results are foreseen with s and a together than with either alone.

    As ``log_evidence``, but each result is foreseen from those before it only.

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
    factor = np.zeros((sizes[0], sizes[1], sizes[2], 2, len(STRENGTHS)))
    for t in range(first, len(s) - 1):
        counts, k = own[before[t], s[t], a[t]], after[t + 1]
        for part in range(2):
            alone = by_action[before[t], a[t]] if part == 0 else by_sensor[before[t], s[t]]
            p0 = (alone[k] + 1.0 / outcomes) / (alone[outcomes] + 1.0)
            for i, strength in enumerate(STRENGTHS):
                gain = math.log((counts[k] + strength * p0) / (counts[outcomes] + strength) / p0)
                factor[before[t], s[t], a[t], part, i] += gain
            alone[k] += 1.0
            alone[outcomes] += 1.0
        counts[k] += 1.0
        counts[outcomes] += 1.0
    total = np.zeros((2, len(STRENGTHS), len(AFFECTED)))
    for i in range(sizes[0]):
        for j in range(sizes[1]):
            for k in range(sizes[2]):
                if own[i, j, k, outcomes] > 0.0:
                    _add(factor[i, j, k], total)
    return min(_log_mean_exp(total[0]), _log_mean_exp(total[1]))


@njit(cache=True)
def _add(factor: np.ndarray, total: np.ndarray) -> None:
    """Add the evidence of one situation and action, which may or may not be affected.

    Args:
        factor: (2, strengths) log of how much better its results are explained if it is.
        total: (2, strengths, shares) log of the evidence of all; changed in place.
    """
    for part in range(2):
        for i in range(len(STRENGTHS)):
            x = factor[part, i]
            for j, share in enumerate(AFFECTED):
                if share == 1.0:
                    total[part, i, j] += x
                elif x > 0.0:
                    total[part, i, j] += x + math.log(share + (1.0 - share) * math.exp(-x))
                else:
                    total[part, i, j] += math.log(1.0 - share + share * math.exp(x))


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
