"""Intervals: they cover, shrink with n, and are defined where there is little to go by."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jointattn_mj.laboratory import statistics
from jointattn_mj.laboratory.statistics import mean_interval


@pytest.fixture(autouse=True)
def few_resamples(monkeypatch):
    monkeypatch.setattr(statistics, "RESAMPLES", 999)


def test_mean_and_sd_by_hand():
    estimate = mean_interval(np.array([1.0, 2.0, 3.0, 6.0, np.nan]))
    assert (estimate.mean, estimate.n) == (3.0, 4)
    assert estimate.sd == pytest.approx(np.sqrt((4 + 1 + 0 + 9) / 3))
    assert 1 <= estimate.low < 3 < estimate.high <= 6


def test_little_to_go_by():
    assert mean_interval(np.array([])).n == 0
    assert np.isnan(mean_interval(np.array([np.nan])).mean)
    one = mean_interval(np.array([2.5]))
    assert (one.mean, one.low, one.high, one.n) == (2.5, 2.5, 2.5, 1)
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


def test_in_words():
    assert str(mean_interval(np.array([0.5, 0.5]))) == "0.50 [0.50, 0.50]"
    assert str(mean_interval(np.array([302.0, 302.0]))) == "302.0 [302.0, 302.0]"
