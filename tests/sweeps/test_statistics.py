"""Intervals and sample sizes: as scipy and published tables have them, and defined where there is little to go by."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from jointattn_mj.sweeps import statistics
from jointattn_mj.sweeps.statistics import (
    Estimate,
    enough,
    mean_interval,
    median_interval,
    paired_difference,
    proportion,
    runs_needed,
    too_few,
)


@pytest.fixture(autouse=True)
def few_resamples(monkeypatch):
    monkeypatch.setattr(statistics, "RESAMPLES", 999)


def test_mean_and_sd_by_hand():
    estimate = mean_interval(np.array([1.0, 2.0, 3.0, 6.0, np.nan]))
    assert (estimate.mean, estimate.n) == (3.0, 4)
    assert estimate.sd == pytest.approx(np.sqrt((4 + 1 + 0 + 9) / 3))
    assert 1 <= estimate.low < 3 < estimate.high <= 6


@pytest.mark.parametrize("interval", [mean_interval, median_interval])
def test_nothing_to_go_by(interval):
    for values in ([], [np.nan]):
        assert interval(values).n == 0
        assert np.isnan(interval(values).mean)


def test_little_to_go_by():
    single = mean_interval(np.array([2.5]))
    assert (single.mean, single.low, single.high, single.n) == (2.5, 2.5, 2.5, 1)
    same = mean_interval(np.full(4, 0.1))
    assert (same.low, same.high) == (same.mean, same.mean)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(-5, 5), min_size=2, max_size=12))
def test_an_interval_holds_its_mean(values):
    """Few distinct values, many ties, where BCa is most easily undefined."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        estimate = mean_interval(np.array(values, float))
    assert min(values) <= estimate.low <= estimate.mean <= estimate.high <= max(values)


def test_coverage():
    """Of 200 intervals from 20 normal draws each, about 95% hold the true mean; bootstrap is a little narrow."""
    rng = np.random.default_rng(0)
    held = 0
    for _ in range(200):
        estimate = mean_interval(rng.normal(3.0, 2.0, 20))
        held += estimate.low <= 3.0 <= estimate.high
    assert 0.88 <= held / 200 <= 0.99


def test_more_runs_narrower_interval():
    rng = np.random.default_rng(1)
    values = rng.normal(0, 1, 400)
    few, many = mean_interval(values[:16]), mean_interval(values)
    assert many.high - many.low < 0.4 * (few.high - few.low)


def test_same_values_same_interval():
    values = np.random.default_rng(2).random(10)
    assert mean_interval(values) == mean_interval(values)


@pytest.mark.parametrize(
    ("successes", "n", "low", "high"),
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)],
)
def test_wilson_as_published(successes, n, low, high):
    """Newcombe (1998), Statistics in Medicine 17, table I, method 3."""
    estimate = proportion(successes, n)
    assert (round(estimate.low, 4), round(estimate.high, 4)) == (low, high)
    assert (estimate.mean, estimate.n) == (successes / n, n)


def test_share_is_a_mean_of_zeros_and_ones():
    assert proportion(3, 8).sd == pytest.approx(np.std([1] * 3 + [0] * 5, ddof=1))
    assert proportion(0, 0).n == 0
    with pytest.raises(ValueError, match="got 3 of 2"):
        proportion(3, 2)


@pytest.mark.parametrize(("n", "location"), [(6, 1), (8, 1), (9, 2), (10, 2), (15, 4), (20, 6), (25, 8), (40, 14)])
def test_median_as_in_tables_of_order_statistics(n, location):
    """The places that textbooks on the sign test give for 95%."""
    estimate = median_interval(np.random.default_rng(n).permutation(n) + 1.0)
    assert (estimate.low, estimate.high) == (location, n + 1 - location)
    assert estimate.mean == (n + 1) / 2


@pytest.mark.parametrize("n", [7, 12, 20, 51])
def test_median_as_scipy(n):
    values = np.random.default_rng(n).normal(size=n)
    theirs = stats.quantile_test(values, p=0.5).confidence_interval()
    ours = median_interval(values)
    assert (ours.low, ours.high) == (theirs.low, theirs.high)


def test_median_of_what_may_never_come():
    estimate = median_interval([3, 1, np.inf, 5, 2, 4, np.inf, np.inf, 6, np.nan])
    assert (estimate.mean, estimate.low, estimate.high, estimate.n) == (5, 2, np.inf, 9)
    assert median_interval([1, np.inf]).mean == np.inf
    assert median_interval([np.inf] * 9).mean == np.inf


def test_five_values_bound_no_median():
    assert (median_interval(range(5)).low, median_interval(range(5)).high) == (-np.inf, np.inf)


def test_pairs():
    rng = np.random.default_rng(3)
    runs = rng.normal(0, 10, 20)
    better = runs + 1 + rng.normal(0, 0.1, 20)
    paired = paired_difference(better, runs)
    assert paired.mean == pytest.approx(1, abs=0.1)
    assert paired.high - paired.low < 0.2  # what the runs share does not count
    assert paired_difference([1, np.nan, 3], [0, 0, np.nan]).n == 1
    with pytest.raises(ValueError, match="same runs"):
        paired_difference([1, 2], [1])


def test_runs_for_shares_as_in_r():
    """The examples of R's power.prop.test, and the sentence of this project: ten runs cannot tell 85% from 95%."""
    assert runs_needed(0.5, 0.75, power=0.9) == pytest.approx(76.7, abs=0.1)
    assert runs_needed(0.5, 0.75, power=0.740) == pytest.approx(50, abs=0.2)
    assert not enough(10, 0.85, 0.95)
    assert too_few(10, 0.85, 0.95) == "10 runs a side cannot tell 85% from 95%; 141 would"
    assert enough(141, 0.85, 0.95)
    assert too_few(141, 0.85, 0.95) == ""


def test_runs_for_means_as_in_r():
    """The examples of R's power.t.test."""
    assert runs_needed(0, 1, sd=1, power=0.9) == pytest.approx(22.02, abs=0.01)
    assert runs_needed(0, 1, sd=1, power=0.8690) == pytest.approx(20, abs=0.01)
    assert too_few(1, 3, 4, sd=0.5) == "1 run a side cannot tell 3 from 4; 6 would"


def test_runs_at_the_edges():
    assert runs_needed(0.5, 0.5) == np.inf
    assert too_few(9, 0.5, 0.5) == "no number of runs tells 50% from 50%"
    assert runs_needed(0, 1, sd=0) == 2
    assert runs_needed(0, 100, sd=1) == 2


@pytest.mark.parametrize(
    ("estimate", "text"),
    [
        (mean_interval([0.5, 0.5]), "0.50 [0.50, 0.50]"),
        (mean_interval([302.0, 302.0]), "302.0 [302.0, 302.0]"),
        (Estimate(28268.3, 28212.0, 28324.6, 1.0, 2), "28,268 [28,212, 28,325]"),
        (Estimate(0.0012345, 0.001, 0.002, 1.0, 2), "0.00123 [0.00100, 0.00200]"),
        (Estimate(np.inf, 12.0, np.inf, np.nan, 7), "not in half of the runs [12.0, ∞]"),
        (median_interval([5.0, np.inf, np.inf]), "not in half of the runs"),
        (median_interval([5.0, 6.0, np.inf]), "6.00 [too few runs for an interval]"),
        (median_interval([5.0] * 4 + [np.inf] * 4), "not in half of the runs [5.00, ∞]"),
        (proportion(0, 0), "-"),
        (Estimate(0.0, -0.1, 0.1, 1.0, 7), "0.00 [-0.10, 0.10]"),
        (proportion(9, 10), "90% [60%, 98%]"),
    ],
)
def test_in_words(estimate, text):
    assert str(estimate) == text
