"""Single values: shares that add up, exact tests, the values that carry a contingency come first."""

from itertools import permutations

import numpy as np
import pytest
from codings import looks
from slow_measures import every_case

import jointattn_mj.contingency as c
from jointattn_mj.contingency.information import CONTINGENCY, MUTUAL
from jointattn_mj.contingency.local import carriers, local_of_steps
from jointattn_mj.contingency.significance import TestOptions, assess_steps
from jointattn_mj.contingency.table import acted, steps
from jointattn_mj.errors import SeriesError


def planted(seed=0, n=3000):
    """Only s = 2 with a = 1 brings r' = 1 about more often than else."""
    rng = np.random.default_rng(seed)
    s, a = rng.integers(0, 4, n), rng.integers(0, 3, n)
    chance = np.where((s == 2) & (a == 1), 0.9, 0.3)
    r = np.concatenate([[0], rng.random(n - 1) < chance[:-1]]).astype(int)
    return s, a, r


@pytest.mark.parametrize("measure", ["state_action_contingency", "combined_transfer_entropy"])
def test_shares_add_up(measure):
    s, a, r = planted()
    found = c.local_contingency(s, a, r, measure)
    assert sum(value.contribution for value in found) == pytest.approx(getattr(c, measure)(s, a, r), abs=1e-12)
    assert sum(value.count for value in found) == len(r) - 1
    assert [value.contribution for value in found] == sorted((value.contribution for value in found), reverse=True)


def test_finds_the_values():
    found = carriers(c.local_contingency(*planted()), most=10)
    assert {(value.sensor, value.action, value.result) for value in found[:2]} == {(2, 1, 1)}
    assert {value.before for value in found[:2]} == {0, 1}
    for value in found[:2]:
        assert value.z > 5
        assert value.p <= value.p_adjusted < 1e-6
        assert value.rate > 0.8
        assert value.usual < 0.6
    assert all(value.action == 1 for value in found)  # the other values of s with it then bring 0 about


def test_by_enumeration():
    """p is the share of orders of s with so high a count; z its standard deviations."""
    s, r = [0, 1, 1, 2, 0, 1], [0, 1, 1, 0, 1, 0]
    pieces = [[v, 0] for v in s], [[0, 0]] * 6, [[0, v] for v in r]
    for value in c.local_contingency(*pieces):
        counts = [
            sum(x == value.sensor and y == value.result for x, y in zip(order, r, strict=True))
            for order in permutations(s)
        ]
        assert value.p == pytest.approx(np.mean(np.array(counts) >= value.count))
        assert value.expected == pytest.approx(np.mean(counts))
        assert value.z == pytest.approx((value.count - np.mean(counts)) / np.std(counts))


def test_few_false_alarms():
    alarms = 0
    rng = np.random.default_rng(0)
    for _ in range(60):
        s, a, r = rng.integers(0, 4, 300), rng.integers(0, 3, 300), rng.integers(0, 2, 300)
        alarms += min(value.p_adjusted for value in c.local_contingency(s, a, r)) <= 0.05
    assert alarms <= 8


def test_no_choice():
    """Where r' is certain, or s is, nothing is surprising."""
    s, a, r = every_case(lambda s, a: a)
    for value in c.local_contingency(s, a, r):
        assert (value.z, value.p, value.p_adjusted) == (0, 1, 1)
        assert value.contribution == pytest.approx(0)


def test_words():
    s, a, r = planted()
    first = c.local_contingency(s, a, r)[0]
    assert first.words(("gaze", "turn", "object")).startswith(f"gaze 2 with turn 1: object {first.before} -> 1 in ")
    labels = {"gaze": ("left", "right", "robot", "away"), "turn": ("left", "right", "face"), "object": ("no", "yes")}
    words = first.words(("gaze", "turn", "object"), labels)
    assert "gaze robot with turn right: object" in words
    assert "-> yes" in words
    assert f"{first.count} of {first.occasions}" in words


def test_codes_are_those_of_the_caller():
    s, a, r = planted()
    assert c.local_contingency(s * 10**12, a, r)[0].sensor == 2 * 10**12


def test_needs_an_action():
    with pytest.raises(SeriesError, match="transfer_entropy"):
        c.local_contingency(*planted(), "transfer_entropy")


def test_p_of_combinations_of_long_looks_comes_from_shifts():
    """Two people who do not know of each other: exact tests of what both look at call chance an effect."""
    alarms = np.zeros(2)
    for seed in range(16):
        rng = np.random.default_rng(seed)
        pair = steps(*(looks(1500, rng, 1) for _ in range(2)))
        options = TestOptions(99, resamples=0)
        tested = assess_steps(pair, MUTUAL, options, 1.0, np.random.default_rng(0), local=True)
        assert tested.method == "shift" and tested.counts is not None
        alarms += [bool(carriers(local_of_steps(pair, MUTUAL, counts=counts))) for counts in (None, tested.counts)]
    assert alarms[0] > 10
    assert alarms[1] <= 4


def test_counts_of_surrogates_are_those_of_the_shifted_series():
    rng = np.random.default_rng(0)
    s, a, r = (np.repeat(rng.integers(0, 3, 40), 5) for _ in range(3))
    given = acted(s, a, r)
    counts = assess_steps(
        given, CONTINGENCY, TestOptions(200, resamples=0, method="shift"), 1.0, rng, local=True
    ).counts
    assert counts is not None
    known = {tuple(column): i for i, column in enumerate(counts.columns.T.tolist())}
    shifts = set()
    for by in range(1, 199):
        shifted = np.roll(s[:-1], -by)
        table = np.zeros(len(known), np.float32)
        for combination in zip(r[:-1], a[:-1], shifted, r[1:], strict=True):
            table[known[tuple(map(int, combination))]] += 1
        shifts.add(table.tobytes())
    assert {row.tobytes() for row in counts.counts} <= shifts
