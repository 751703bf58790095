"""Local contingency of whole series: slow sums, what is strong but rare comes first, and chance is told as chance."""

import numpy as np
import pytest

from jointattn_mj.contingency import TestOptions, discover, situation_contingency
from jointattn_mj.contingency.lagged import Timing
from jointattn_mj.contingency.lead import LeadOptions, lead_of_steps, surest
from jointattn_mj.contingency.situations import PosteriorOptions
from jointattn_mj.contingency.table import acted
from jointattn_mj.errors import SeriesError

FEW = TestOptions(surrogates=99)


def rare_and_frequent(seed: int = 0, n: int = 4000) -> dict[str, np.ndarray]:
    """Half of the looks at a toy, found by the hand, say little; a look at the child, 6% of steps, says nearly all."""
    rng = np.random.default_rng(seed)
    face, hand, gaze = rng.choice(3, n, p=[0.47, 0.47, 0.06]), rng.integers(0, 2, n), rng.integers(0, 3, n)
    seen, smile = np.zeros((2, n), int)
    seen[1:] = rng.random(n - 1) < np.where((hand == 1) == (gaze == 0), 0.62, 0.38)[:-1]
    smile[1:] = rng.random(n - 1) < np.where((face == 2) & (gaze == 2), 0.7, 0.1)[:-1]
    return {"face": face, "hand": hand, "gaze": gaze, "seen": seen, "smile": smile}


EVENTS = (["face", "hand"], ["gaze"], ["seen", "smile"])


def test_what_is_strong_but_rare_comes_first():
    data = rare_and_frequent()
    whole = discover(data, *EVENTS, options=TestOptions(99, resamples=0))
    local = discover(data, *EVENTS, options=FEW, measure="local")
    assert [result.event for result in whole[:2]] == ["(hand, gaze) -> seen", "(face, gaze) -> smile"]
    assert [result.event for result in local[:2]] == ["(face, gaze) -> smile", "(hand, gaze) -> seen"]
    assert [result.p_adjusted <= 0.05 for result in local] == [True, True, False, False]
    assert local[0].first > 0.99 and sum(result.first for result in local) == pytest.approx(1)
    lead = local[0].lead
    assert {situation.sensor for situation in lead.situations} == {2} and 0.05 <= lead.share < 0.08
    assert {(value.sensor, value.action) for value in local[0].values} == {(2, 2)}, "which look answers which"
    low, high = local[0].significance.interval
    assert low < local[0].significance.value < high


def test_value_is_a_slow_sum():
    """Of the situations chosen by hand, with the posterior's mean in place of draws as these are many."""
    rng = np.random.default_rng(3)
    s, a = rng.integers(0, 3, (2, 300))
    r = np.append(0, ((s == 0) & (a == 1))[:-1]).astype(int)
    how = LeadOptions(draws=20_000, smallest_share=0.1)
    lead = lead_of_steps(acted(s, a, r), how, TestOptions(surrogates=9), 1.0, np.random.default_rng(1))
    rows = list(zip(r[:-1], s[:-1], a[:-1], r[1:], strict=True))
    value, whole = 0.0, 0
    for situation in lead.situations:
        here = [row for row in rows if row[:2] == (situation.result, situation.sensor)]
        assert len(here) == situation.transitions
        actions = sorted({row[2] for row in here})
        q = {x: np.mean([row[3] for row in rows if (row[0], row[2]) == (situation.result, x)]) for x in actions}
        n = {x: sum(row[2] == x for row in here) for x in actions}
        k = {x: sum(row[3] for row in here if row[2] == x) for x in actions}
        base = np.mean([row[3] for row in rows if row[0] == situation.result])
        total = 0.0
        for _ in range(2000):
            p = {x: rng.beta(k[x] + 2 * q[x], n[x] - k[x] + 2 * (1 - q[x])) if 0 < q[x] < 1 else q[x] for x in actions}
            total += sum(n[x] / len(here) * _kl(p[x], q[x]) for x in actions)
            total -= _kl(sum(n[x] / len(here) * p[x] for x in actions), base)
        value += total / 2000 * len(here)
        whole += len(here)
    assert lead.significance.value == pytest.approx(value / whole, rel=0.04)
    assert lead.share == pytest.approx(whole / len(rows))


def _kl(p: float, q: float) -> float:
    return sum(x * np.log(x / y) for x, y in ((p, q), (1 - p, 1 - q)) if x > 0 and y > 0)


def test_all_situations_are_sac():
    data = rare_and_frequent(1, 1000)
    found = situation_contingency(data["face"], data["gaze"], data["smile"], posterior=PosteriorOptions(draws=50))
    chosen = surest(found, LeadOptions(smallest_share=1.0))
    assert sorted(chosen) == list(range(len(found.value)))
    assert found.share[chosen] @ found.value[chosen] == pytest.approx(found.total())


@pytest.mark.parametrize("policy", ["actual", "reference"])
def test_looks_that_know_nothing_of_each_other(policy):
    """Looks of ten steps, shifted as a whole: p is small as often as it should be."""
    small = 0
    for seed in range(30):
        rng = np.random.default_rng(seed)
        s, a, r = (np.repeat(rng.integers(0, 2, 400), rng.integers(3, 18, 400))[:1500] for _ in range(3))
        how = LeadOptions(policy=policy, draws=20)
        shifts = TestOptions(surrogates=39, method="shift")
        lead = lead_of_steps(acted(s, a, r), how, shifts, 1.0, np.random.default_rng(seed))
        small += lead.significance.p <= 0.1
    assert small <= 8, "binomial, 30 cases at .1: 8 or fewer in 99.8%"


def test_refuses():
    data = rare_and_frequent(0, 200)
    with pytest.raises(SeriesError, match=r"by one value each .* got histories of 1 and 2"):
        discover(data, *EVENTS, measure="local", options=FEW, timing=Timing(target_history=2))
    many = np.arange(4000) % 1200
    with pytest.raises(SeriesError, match="at most 1,048,576 entries"):
        discover({"s": many, "a": many % 3, "r": many}, ["s"], ["a"], ["r"], measure="local", options=FEW)
