"""Modules against eq. 5.3 to 5.5 and the four rules below them, written out cell by cell."""

from math import log, sqrt

import numpy as np
import pytest

import jointattn_mj.contingency as c
from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING, ReproductionConfig, contingent_saliency, make_module
from jointattn_mj.errors import ConfigError

EVENT = Event(1, 0, 2)


def random_table(seed, shape=(2, 4, 3, 2), share=0.7):
    rng = np.random.default_rng(seed)
    return rng.integers(1, 40, shape) * (rng.random(shape) < share)


def slow_saliency(n, r, s, next_r, a):
    """Eq. 5.3 from probabilities, terms of probability 0 left out."""
    p_rs, p_r = n[r, s].sum(), n[r].sum()
    value = 0.0
    if n[r, s, a, next_r] > 0:
        with_a = n[r, s, a, next_r] / n[r, s, a].sum()
        without = n[r, s, :, next_r].sum() / p_rs
        value += n[r, s, a, next_r] / p_rs * log(with_a / without)
    if n[r, :, a, next_r].sum() > 0:
        with_a = n[r, :, a, next_r].sum() / n[r, :, a].sum()
        without = n[r, :, :, next_r].sum() / p_r
        value -= n[r, :, a, next_r].sum() / p_r * log(with_a / without)
    return value


def slow_module(n, config):
    """{(r, s): (command, reliability, expected)} of the pairs under which something is offered."""
    results, sensors, actions, _ = n.shape
    under = {
        (r, s): {(k, a): slow_saliency(n, r, s, k, a) for k in range(results) for a in range(actions)}
        for r in range(results)
        for s in range(sensors)
        if n[r, s].sum() > 0
    }
    averaged = [
        e for cells in under.values() for e in cells.values() if e > 0 or (e == 0 and config.mean_over != "positive")
    ]
    offered = {}
    for pair, cells in under.items():
        values = sorted(cells.values())
        mean = sum(values) / len(values)
        spread = sqrt(sum((value - mean) ** 2 for value in values) / len(values))
        if not averaged or values[-1] <= sum(averaged) / len(averaged) or spread == 0:
            continue
        highest, second = ((value - mean) / spread for value in values[:-3:-1])
        if highest - second > config.reliability_gap:
            expected, command = max(cells, key=cells.get)
            offered[pair] = command, highest, expected
    return offered


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("share", [1.0, 0.5, 0.15])
def test_saliency(seed, share):
    n = random_table(seed, (3, 3, 4, 3), share)
    found = contingent_saliency(n)
    assert found.shape == (3, 3, 3, 4)
    for (r, s, k, a), value in np.ndenumerate(found):
        assert value == pytest.approx(slow_saliency(n, r, s, k, a)) if n[r, s].sum() else np.isnan(value)


@pytest.mark.parametrize("seed", range(5))
def test_saliencies_add_up_to_the_contingency(seed):
    """The two lines of eq. 5.2."""
    rng = np.random.default_rng(seed)
    s, a, r = rng.integers(0, 4, 500), rng.integers(0, 3, 500), rng.integers(0, 2, 500)
    r[1:][s[:-1] == a[:-1]] = 1
    n = np.zeros((2, 4, 3, 2))
    np.add.at(n, (r[:-1], s[:-1], a[:-1], r[1:]), 1)
    saliency = contingent_saliency(n)
    total = (n.sum((2, 3)) / n.sum() * np.nan_to_num(saliency).sum((2, 3))).sum()
    assert total == pytest.approx(c.state_action_contingency(s, a, r, np.e), abs=1e-12)
    assert saliency == pytest.approx(c.contingent_saliency(s, a, r, np.e), nan_ok=True)


@pytest.mark.parametrize(
    "config", [ReproductionConfig(), ReproductionConfig(1.2), ReproductionConfig(0.0, "not_negative")]
)
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("share", [1.0, 0.6, 0.2])
def test_module(seed, share, config):
    n = random_table(seed, share=share)
    module, expected = make_module(EVENT, n, config), slow_module(n, config)
    assert module.event == EVENT
    for pair in np.ndindex(n.shape[:2]):
        command, reliability, result = expected.get(pair, (OFFERS_NOTHING, 0.0, OFFERS_NOTHING))
        assert (module.command[pair], module.expected[pair]) == (command, result)
        assert module.reliability[pair] == pytest.approx(reliability)


def test_some_pairs_offer_and_some_do_not():
    """Else the comparison above would compare nothing."""
    offers = [(make_module(EVENT, random_table(seed), ReproductionConfig()).command >= 0).mean() for seed in range(6)]
    assert 0.1 < np.mean(offers) < 0.9


def test_a_map_that_follows_the_gaze():
    """The result comes where the action is the sensor's value; nothing is to be learned from its last value."""
    n = np.full((2, 4, 3, 2), 20.0)
    for value in range(3):
        n[:, value, value] = 1, 39
    module = make_module(EVENT, n, ReproductionConfig())
    assert module.command.tolist() == [[0, 1, 2, OFFERS_NOTHING]] * 2
    assert module.expected.tolist() == [[1, 1, 1, OFFERS_NOTHING]] * 2
    assert (module.reliability[:, :3] > 1.5).all()


def test_a_wider_gap_lets_fewer_pairs_through():
    n = random_table(0, share=1.0)
    counts = [(make_module(EVENT, n, ReproductionConfig(gap)).command >= 0).sum() for gap in (0.0, 0.5, 1.0, 9.0)]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > counts[-1] == 0


@pytest.mark.parametrize("n", [np.zeros((2, 3, 2, 2)), np.ones((2, 3, 2, 2)), np.ones((2, 3, 1, 2))])
def test_nothing_to_offer(n):
    module = make_module(EVENT, n, ReproductionConfig())
    assert (module.command == OFFERS_NOTHING).all()
    assert (module.reliability == 0).all()


@pytest.mark.parametrize(
    "options", [{"mean_over": "all"}, {"reliability_gap": -0.5}, {"reliability_gap": float("nan")}]
)
def test_impossible_options(options):
    ((name, value),) = options.items()
    with pytest.raises(ConfigError, match=name) as refused:
        ReproductionConfig(**options)
    assert str(value) in str(refused.value)
