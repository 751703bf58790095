"""Maps of modules that follow what is learned later, and do not undo themselves.

A module that is used changes how often actions are done and situations come. A map that is made of raw counts anew
(``refresh_every``) then loses what it had. Here a map offers what gains most. The gain of action a and result r' in the
situation (r, s) is

    p(r' | r, s, a) - p(r' | r, not s, a)

the difference that s makes, known in the study of contingency judgement as delta P. It does not depend on how often an
action is done. What lasts for some steps, such as an object that stays, makes an offer that was right once look right
again; gains are therefore taken within what came of the same action the last time that it was done.
"""

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
    strata = np.zeros((outcomes, results, sensors, actions, outcomes))
    table = np.zeros((results, sensors, actions, outcomes))
    count_by_last(*series.columns, first, strata, table)
    gain, spread = gains(table, config.concentration)
    within, within_spread = _over_strata(strata, config.concentration)
    surest = (within - config.offer_deviations * within_spread).reshape(results, sensors, -1)
    surest[(gain <= config.offer_deviations * spread).reshape(surest.shape)] = -np.inf
    surest[..., :actions] = -np.inf
    flat = within.reshape(surest.shape)
    best = surest.argmax(axis=-1)
    gained = np.take_along_axis(flat, best[..., None], -1)[..., 0]
    sure = np.take_along_axis(surest, best[..., None], -1)[..., 0] > 0
    offered = sure & (gained > config.offer_gain * gained[sure].max(initial=0.0))
    z = np.divide(gained - flat.mean(axis=-1), flat.std(axis=-1), out=np.zeros_like(gained), where=offered)
    return Module(
        event=event,
        command=np.where(offered, best % actions, OFFERS_NOTHING),
        reliability=z,
        expected=np.where(offered, best // actions, OFFERS_NOTHING),
        saliency=np.where(table.sum(axis=(2, 3))[..., None, None] > 0, within, np.nan),
    )


def gains(table: np.ndarray, concentration: float) -> tuple[np.ndarray, np.ndarray]:
    """By how much more probable each result is after each action in a situation than under other values of s.

    Args:
        table: (..., R, S, A, R') counts.
        concentration: Transitions that the prior "s says nothing" is worth, for either side.

    Returns:
        (..., R, S, R', A) differences of probability, and their standard deviations; both are 0 where the action was
        not done on one of the two sides.
    """
    together = table.sum(axis=-3, keepdims=True)
    whole = together.sum(axis=-1, keepdims=True)
    q = np.divide(together, whole, out=np.zeros_like(together), where=whole > 0)
    here, elsewhere = _beta(table, q, concentration), _beta(together - table, q, concentration)
    compared = (table.sum(axis=-1, keepdims=True) > 0) & ((together - table).sum(axis=-1, keepdims=True) > 0)
    gain = np.where(compared, here[0] - elsewhere[0], 0.0)
    spread = np.where(compared, np.sqrt(here[1] + elsewhere[1]), 0.0)
    return gain.swapaxes(-1, -2), spread.swapaxes(-1, -2)


def _beta(counts: np.ndarray, q: np.ndarray, concentration: float) -> tuple[np.ndarray, np.ndarray]:
    """Posterior mean and variance of each probability, with a prior around q."""
    n = counts.sum(axis=-1, keepdims=True) + concentration
    p = (counts + concentration * q) / n
    return p, p * (1 - p) / (n + 1)


def _over_strata(strata: np.ndarray, concentration: float) -> tuple[np.ndarray, np.ndarray]:
    """Mean over the strata in which a gain is known, and its standard deviation; each stratum weighs the same."""
    gain, spread = gains(strata, concentration)
    known = np.maximum((spread > 0).sum(axis=0), 1)
    return gain.sum(axis=0) / known, np.sqrt((spread**2).sum(axis=0)) / known


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
