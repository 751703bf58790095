"""Surrogates keep what they should and nothing else; p-values, intervals and corrections for many tests hold."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

import jointattn_mj.contingency as c
from jointattn_mj.contingency import permutation
from jointattn_mj.contingency.bootstrap import resampled
from jointattn_mj.contingency.information import COMBINED, CONTINGENCY, TRANSFER
from jointattn_mj.contingency.significance import MEASURES, generator
from jointattn_mj.contingency.surrogates import plan
from jointattn_mj.contingency.table import steps
from jointattn_mj.errors import ConfigError, SeriesError


def independent(seed, n, values=(5, 3, 2)):
    rng = np.random.default_rng(seed)
    return [rng.integers(0, k, n) for k in values]


def contingent(seed, n, share=0.4):
    """r' is whether s equals a, in this share of the steps."""
    s, a, r = independent(seed, n, (3, 3, 2))
    told = np.random.default_rng(seed + 1).random(n - 1) < share
    r[1:][told] = (s == a)[:-1][told]
    return s, a, r


def permuted_in_python(s, a, r, measure, permute, count, seed):
    """The same by numpy alone."""
    rng = np.random.default_rng(seed)
    contexts = [a * 0, r, r * 10 + a][len(measure.given)] if permute == "context" else a * 0
    values = []
    for _ in range(count):
        shuffled = s.copy()
        for context in np.unique(contexts):
            at = np.flatnonzero(contexts[:-1] == context)
            shuffled[at] = s[rng.permutation(at)]
        values.append(measure.value(steps(shuffled, r, a).entries()))
    return np.array(values)


@pytest.mark.parametrize("permute", ["context", "plain"])
@pytest.mark.parametrize("measure", [TRANSFER, COMBINED, CONTINGENCY], ids=lambda measure: measure.name)
@pytest.mark.parametrize("n", [60, 2000], ids=["shuffled", "drawn from margins"])
def test_surrogates_are_distributed_as_permutations(measure, permute, n):
    s, a, r = contingent(3, n)
    s = (s + (np.random.default_rng(9).random(n) < 0.3) * a) % 3  # a tie between s and a, which plain ones break
    fast = plan(steps(s, r, a), measure, permute).draw(800, np.random.default_rng(0))
    slow = permuted_in_python(s, a, r, measure, permute, 800, 1)
    assert stats.ks_2samp(fast, slow).pvalue > 1e-3


def test_every_permutation_is_equally_likely():
    """Four transitions of one context: all orders, by enumeration."""
    s, r = [0, 1, 1, 2], [0, 0, 1, 1]
    source, target = [[v, 0] for v in s], [[0, v] for v in r]
    exact = [c.transfer_entropy([[v, 0] for v in order], target) for order in permutations(s)]
    drawn = plan(steps(source, target), TRANSFER, across_recordings=True).draw(
        20_000, np.random.default_rng(0)
    ) / np.log(2)
    for value in np.unique(np.round(exact, 9)):
        expected = np.mean(np.isclose(exact, value))
        assert np.isclose(drawn, value).mean() == pytest.approx(expected, abs=0.015)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 60), st.integers(0, 60), st.data())
def test_hypergeometric(good, bad, data):
    """The quantiles of a fine grid are distributed as they should."""
    drawn = data.draw(st.integers(0, good + bad))
    log_factorial = permutation.tables(good + bad + 1)[1]
    grid = (np.arange(2000) + 0.5) / 2000
    values = [permutation.hypergeometric(good, bad, drawn, log_factorial, u) for u in grid]
    expected = stats.hypergeom(good + bad, good, drawn) if good + bad else None
    for value in set(values):
        share = expected.pmf(value) if expected else 1
        assert values.count(value) / 2000 == pytest.approx(share, abs=0.002)


def test_hypergeometric_of_millions():
    log_factorial = permutation.tables(2_000_000)[1]
    values = [permutation.hypergeometric(700_000, 1_300_000, 500_000, log_factorial, u) for u in (0.0, 0.5, 1 - 1e-16)]
    assert all(abs(value - 175_000) < 4000 for value in values)


def test_permuted_within_recordings():
    """Recordings that differ as a whole: nothing is contingent within them, but much across."""
    rng = np.random.default_rng(0)
    s = [rng.choice(2, 40, p=[0.5 + d, 0.5 - d]) for d in (0.4, -0.4) * 5]
    r = [rng.choice(2, 40, p=[0.5 + d, 0.5 - d]) for d in (0.4, -0.4) * 5]
    across = c.assess("mutual_information", s, r, options=c.TestOptions(199, across_recordings=True, resamples=0))
    within = c.assess("mutual_information", s, r, options=c.TestOptions(199, resamples=0))
    assert across.p == 1 / 200
    assert within.p > 0.05
    assert abs(within.corrected) < 0.2 * across.corrected


@pytest.mark.parametrize("measure", ["transfer_entropy", "combined_transfer_entropy", "state_action_contingency"])
def test_false_alarms(measure):
    """p is uniform where nothing is contingent, also where the result depends on the action and s on a."""
    p = []
    rng = np.random.default_rng(0)
    for seed in range(200):
        s, a, r = rng.integers(0, 4, 150), rng.integers(0, 3, 150), rng.integers(0, 2, 150)
        follows = rng.random(149) < 0.5
        r[1:][follows] = (a == 1)[:-1][follows]
        condition = None if measure == "transfer_entropy" else a
        if condition is not None:
            s = (s + a) % 4
        p.append(c.assess(measure, s, r, condition, options=c.TestOptions(99, resamples=0), seed=seed).p)
    assert 0.015 <= np.mean(np.array(p) <= 0.05) <= 0.095
    assert stats.kstest(p, "uniform").pvalue > 1e-3


def test_finds_what_is_there():
    s, a, r = contingent(5, 400)
    found = c.assess("state_action_contingency", s, r, a, seed=1)
    assert found.p == 1 / 1001
    assert found.z > 5
    assert found.value == pytest.approx(c.state_action_contingency(s, a, r), abs=1e-12)
    assert found.corrected == pytest.approx(found.value - found.null_mean)
    assert found.interval[0] > 0
    assert found.interval[0] < found.corrected < found.interval[1]
    assert (found.transitions, found.exchangeable, found.surrogates) == (399, 399, 1000)


def test_intervals_cover():
    """Of 60 series, the 95% interval holds the value of a very long one nearly always."""
    truth = c.combined_transfer_entropy(*contingent(100, 400_000))
    covered = 0
    for seed in range(60):
        s, a, r = contingent(seed, 800)
        options = c.TestOptions(1, resamples=300)
        low, high = c.assess("combined_transfer_entropy", s, r, a, options=options, seed=seed).interval
        covered += low <= truth <= high
    assert covered >= 53


def test_what_resampling_draws():
    given = steps([[0, 1, 2, 0]] * 3 + [[2, 2, 1]], [[0, 1, 1, 0]] * 3 + [[1, 1, 1]])
    whole = resampled(given, TRANSFER, 20, np.random.default_rng(0), "blocks", 11)
    assert np.allclose(whole[0], TRANSFER.value(given.entries())) or len(np.unique(whole)) > 1
    long = contingent(0, 300)
    single = steps(long[0], long[2], long[1])
    circle = resampled(single, CONTINGENCY, 5, np.random.default_rng(0), "blocks", single.transitions)
    assert np.allclose(circle, CONTINGENCY.value(single.entries()))  # one block all round is the series itself
    recordings = resampled(given, TRANSFER, 50, np.random.default_rng(0), "recordings")
    assert len(np.unique(recordings.round(9))) <= 5  # as many as ways to draw how often the last one comes


def test_auto_resampling():
    few = [part[:30] for part in independent(0, 90)]
    assert c.assess("transfer_entropy", few[0], few[2]).resampled == "blocks"
    many = [np.split(part, 12) for part in independent(0, 120)]
    assert c.assess("transfer_entropy", many[0], many[2]).resampled == "recordings"


def test_seeds():
    s, a, r = contingent(7, 200)
    options = c.TestOptions(50, resamples=50)

    def with_seed(seed):
        return c.assess("state_action_contingency", s, r, a, options=options, seed=seed)

    assert with_seed(3) == with_seed(3) == with_seed(np.random.SeedSequence(3)) == with_seed(np.random.default_rng(3))
    assert with_seed(3) != with_seed(4)
    for wrong in (-1, 1.5, None, True):
        with pytest.raises(SeriesError, match="seed"):
            generator(wrong)


def test_nothing_to_permute():
    """A source that is a function of its context; and one value."""
    s, _, r = contingent(8, 100)
    found = c.assess("state_action_contingency", s, r, s)
    assert (found.p, found.z, found.exchangeable) == (1, 0, 0)
    assert found.corrected == pytest.approx(0, abs=1e-12)
    flat = c.assess("transfer_entropy", np.zeros(100, int), r)
    assert (flat.value, flat.p, flat.interval) == (pytest.approx(0), 1, pytest.approx((0, 0)))


def test_progress():
    s, a, r = contingent(8, 100)
    told = []
    c.assess("state_action_contingency", s, r, a, options=c.TestOptions(120, resamples=70), progress=told.append)
    assert sum(told) == 190


def test_bad_use():
    s, a, r = contingent(9, 50)
    with pytest.raises(SeriesError, match="granger"):
        c.assess("granger", s, r)
    with pytest.raises(SeriesError, match="needs condition"):
        c.assess("state_action_contingency", s, r)
    with pytest.raises(SeriesError, match="takes no condition"):
        c.assess("transfer_entropy", s, r, a)
    assert all(hasattr(c, name) for name in MEASURES)
    for wrong in ({"surrogates": 0}, {"resamples": -1}, {"block": 0}, {"level": 1.0}):
        with pytest.raises(ConfigError, match=next(iter(wrong))):
            c.TestOptions(**wrong)
    n = 6000
    with pytest.raises(SeriesError, match="fewer bins"):
        c.assess("transfer_entropy", np.arange(n), np.arange(n))


class TestManyTests:
    def test_by_hand(self):
        p = [0.01, 0.04, 0.03, 0.5]
        assert c.holm(p) == pytest.approx([0.04, 0.09, 0.09, 0.5])
        assert c.benjamini_hochberg(p) == pytest.approx([0.04, 0.04 * 4 / 3, 0.04 * 4 / 3, 0.5])
        assert c.adjust(p, "none").tolist() == p
        assert c.adjust(p).tolist() == c.holm(p).tolist()
        with pytest.raises(SeriesError, match="bonferroni"):
            c.adjust(p, "bonferroni")

    @pytest.mark.parametrize("wrong", [-0.1, 1.5, float("nan")])
    @pytest.mark.parametrize("adjusted", [c.holm, c.benjamini_hochberg])
    def test_what_is_no_p(self, adjusted, wrong):
        with pytest.raises(SeriesError, match="from 0 to 1"):
            adjusted([0.01, wrong])

    @given(st.lists(st.floats(0, 1), max_size=12))
    def test_agrees_with_scipy(self, p):
        assert c.benjamini_hochberg(p) == pytest.approx(stats.false_discovery_control(p) if p else [])
        adjusted = c.holm(p)
        assert np.all(adjusted >= np.array(p))
        assert np.all(adjusted >= c.benjamini_hochberg(p) - 1e-12)
        assert np.all(adjusted <= np.minimum(1, np.array(p) * len(p)) + 1e-12)
