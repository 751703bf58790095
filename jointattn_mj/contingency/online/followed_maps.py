"""Maps of modules that are read anew while the modules are used, without undoing themselves.

A module that is used changes how often actions are done. Maps that follow the raw counts (``refresh_every``) then lose
what they had. Here a map is made of the table

    share(r, s) u(a) p(r' | r, s, a)

in which every action that was done under (r, s) weighs the same, however often the module chose it. In addition each
offer is tested. What lasts for some steps, such as an object that stays, makes an offer that was right once look right
again. The gain of an offer is therefore also taken within what came of the same action the last time that it was done.
"""

import numpy as np

from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.online.experience import EventSeries
from jointattn_mj.contingency.online.local import LocalConfig, count
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING, Module, ReproductionConfig, make_module
from jointattn_mj.io.compiled import njit


def followed_map(
    event: Event, series: EventSeries, first: int, config: LocalConfig, reproduction: ReproductionConfig
) -> Module:
    """The module of an event, from all steps.

    Args:
        event: The event.
        series: Its series.
        first: First step that counts.
        config: Test of offers, and strength of the prior.
        reproduction: Thresholds of the rules of section 5.2.2.
    """
    results, sensors, actions, outcomes = series.sizes
    strata = np.zeros((outcomes, results, sensors, actions, outcomes))
    count_by_last(*series.columns, first, strata)
    table = np.zeros((results, sensors, actions, outcomes))
    count(*series.columns, first, table)
    module = make_module(event, reference_table(table, config.concentration), reproduction)
    offered = np.argwhere(module.command != OFFERS_NOTHING)
    if not len(offered) or (config.offer_gain == 0 and config.offer_deviations == 0):
        return module
    r, s = offered.T
    a, k = module.command[r, s], module.expected[r, s]
    gain, spread = _gain(table, r, s, a, k, config.concentration)
    of_last = [_gain(part, r, s, a, k, config.concentration, pooled_over_results=True) for part in strata]
    occurred = (strata.sum(axis=4)[:, r, s, a] > 0) / 1.0
    weight = occurred / np.maximum(occurred.sum(axis=0), 1)
    within = sum(share * one for share, (one, _) in zip(weight, of_last, strict=True))
    within_spread = np.sqrt(sum((share * error) ** 2 for share, (_, error) in zip(weight, of_last, strict=True)))
    right = (within > config.offer_deviations * within_spread) & (within > config.offer_gain * within.max())
    right &= gain > config.offer_deviations * spread
    command, reliability, expected = module.command.copy(), module.reliability.copy(), module.expected.copy()
    command[r[~right], s[~right]] = OFFERS_NOTHING
    expected[r[~right], s[~right]] = OFFERS_NOTHING
    reliability[r[~right], s[~right]] = 0.0
    return Module(event, command, reliability, expected, module.saliency)


def reference_table(table: np.ndarray, concentration: float) -> np.ndarray:
    """The counts as they would be if each action that was done in a situation had been done equally often.

    Args:
        table: (R, S, A, R') counts.
        concentration: Transitions that the prior "s says nothing" is worth; 0 for none.
    """
    n = table.sum(axis=3, keepdims=True)
    q = _shares(table.sum(axis=1, keepdims=True))
    with np.errstate(invalid="ignore", divide="ignore"):
        p = np.where(n > 0, (table + concentration * q) / (n + concentration), 0.0)
        weight = (n > 0) / (n > 0).sum(axis=2, keepdims=True)
    return np.nan_to_num(table.sum(axis=(2, 3), keepdims=True) * weight * p)


def _shares(counts: np.ndarray) -> np.ndarray:
    """Counts divided by their sum over the last axis; 0 where there are none."""
    total = counts.sum(axis=-1, keepdims=True)
    shares: np.ndarray = np.divide(counts, total, out=np.zeros_like(counts), where=total > 0)
    return shares


def _gain(
    table: np.ndarray, r: np.ndarray, s: np.ndarray, a: np.ndarray, k: np.ndarray, concentration: float,
    pooled_over_results: bool = False,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """By how much more often a result follows an offer than the same action anyway.

    Args:
        table: (R, S, A, R') counts.
        r: (n,) situations of the offers.
        s: (n,) likewise.
        a: (n,) commands.
        k: (n,) expected results.
        concentration: Transitions that the prior is worth.
        pooled_over_results: Whether "anyway" means whatever r was, too.

    Returns:
        (n,) gains of probability, and their standard deviations (n,).
    """
    anyway = table.sum(axis=(0, 1) if pooled_over_results else 1, keepdims=True)
    q = np.broadcast_to(_shares(anyway), table.shape)[r, s, a, k]
    n = table.sum(axis=3)[r, s, a]
    p = (table[r, s, a, k] + concentration * q) / (n + concentration)
    return p - q, np.sqrt(p * (1 - p) / (n + concentration + 1))


@njit(cache=True)
def count_by_last(
    s: np.ndarray, a: np.ndarray, before: np.ndarray, after: np.ndarray, first: int, strata: np.ndarray
) -> None:
    """Count transitions by what came of the same action the last time that it was done.

    Args:
        s: (n,) values of a sensor.
        a: (n,) values of an action.
        before: (n,) what the result is conditioned on.
        after: (n,) values of a result.
        first: First step.
        strata: (R', R, S, A, R') counts, changed in place; a transition whose action had not been done does not count.
    """
    last = np.full(strata.shape[3], -1)
    for t in range(first, len(s) - 1):
        if last[a[t]] >= 0:
            strata[last[a[t]], before[t], s[t], a[t], after[t + 1]] += 1.0
        last[a[t]] = after[t + 1]
