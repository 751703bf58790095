"""Surrogates that move the source as a whole: what they keep, when they are chosen, and that p holds for long looks."""

from itertools import pairwise

import numpy as np
import pytest
from codings import looks

import jointattn_mj.contingency as c
from jointattn_mj.contingency import bootstrap, counting
from jointattn_mj.contingency.displaced import Moves, displaced, moves
from jointattn_mj.contingency.information import COMBINED, CONDITIONAL_MUTUAL, CONTINGENCY, MUTUAL, TRANSFER
from jointattn_mj.contingency.memory import memory
from jointattn_mj.contingency.significance import TestOptions, assess_measures
from jointattn_mj.contingency.table import steps
from jointattn_mj.errors import SeriesError

ALL = (TRANSFER, COMBINED, CONTINGENCY, MUTUAL, CONDITIONAL_MUTUAL)


def three(n, seed=0, spread=1.0):
    rng = np.random.default_rng(seed)
    return [looks(n, rng, spread) for _ in range(3)]


def taken(pieces, n):
    """From which transition each takes its source."""
    at = np.full(n, -1)
    for t, u, length in pieces:
        assert (at[t : t + length] == -1).all()
        at[t : t + length] = np.arange(u, u + length)
    return at


@pytest.mark.parametrize("sizes", [[700], [400, 3, 299]], ids=["one", "three recordings"])
def test_values_are_those_of_the_moved_series(sizes):
    s, r, a = three(sum(sizes))
    cuts = np.cumsum(sizes)[:-1]
    given = steps(*(np.split(series, cuts) for series in (s, r, a)))
    table = displaced(given, ALL)
    whole = np.array([[0, 0, given.transitions]])
    assert np.allclose(table.values(whole), [measure.value(given.entries()) for measure in ALL])
    for how in ("shift", "bootstrap"):
        pieces = next(moves(given, how, 1, 20).draw(1, np.random.default_rng(1)))
        columns = given.columns()
        columns[2] = columns[2][taken(pieces, given.transitions)]
        parts = [[column[[i]].repeat(2) for i in range(given.transitions)] for column in columns]  # one transition each
        results = [np.array([before[0], after[0]]) for before, after in zip(parts[0], parts[3], strict=True)]
        moved = steps(parts[2], results, parts[1])
        assert np.allclose(table.values(pieces), [measure.value(moved.entries()) for measure in ALL])


@pytest.mark.parametrize("how", ["shift", "bootstrap", "partners"])
@pytest.mark.parametrize("values", [1, 2, 5])
def test_both_ways_of_counting_are_one(how, values):
    rng = np.random.default_rng(values)
    rest, source = (np.repeat(rng.integers(0, values, 900), rng.integers(1, 60, 900)).astype(np.int32) for _ in "rs")
    n = min(len(rest), len(source))
    rest = np.where(rng.random(n) < 0.01, values + 1, rest[:n]).astype(np.int32)  # a rare value
    source = source[:n]
    words = counting.counter(rest, source, values + 2, values)
    assert isinstance(words, counting.Words)
    runs = counting.Runs(counting._runs(rest), counting._runs(source), (values + 2, values))
    spans = np.array([0, n // 3, n // 3 + 70, n // 2, n])
    for pieces in Moves(how, spans, 5, 90).draw(20, rng):
        assert np.array_equal(words.table(pieces), runs.table(pieces))
    assert not isinstance(counting.counter(rest[:999], source[:999], values + 2, values), counting.Words)


def test_shifts_stay_within_their_recording_and_away_from_the_truth():
    spans = np.array([0, 100, 101, 161])
    drawn = Moves("shift", spans, least=20)
    for pieces in drawn.draw(50, np.random.default_rng(0)):
        at = taken(pieces, 161)
        for start, stop, least in ((0, 100, 20), (100, 101, 0), (101, 161, 15)):
            inside = at[start:stop]
            assert sorted(inside) == list(range(start, stop))
            shift = (inside[0] - start) % (stop - start)
            assert least <= shift <= stop - start - least
    assert drawn.distinct() == 61 * 1 * 31


def test_few_shifts_are_all_taken_once():
    drawn = list(Moves("shift", np.array([0, 7]), least=1).draw(100, np.random.default_rng(0)))
    assert len({tuple(taken(piece, 7)) for piece in drawn}) == len(drawn) == 6
    s, r, _ = three(30)
    found = c.assess("te", s, r, options=TestOptions(1000, method="shift", resamples=0))
    assert found.surrogates < 30
    assert found.p >= 1 / (1 + found.surrogates)


def test_partners_are_those_of_others():
    spans = np.array([0, 10, 14, 40])
    for pieces in Moves("partners", spans).draw(20, np.random.default_rng(0)):
        at = taken(pieces, 40)
        for i, (start, stop) in enumerate(pairwise(spans)):
            homes = set(np.searchsorted(spans, at[start:stop], "right") - 1)
            assert len(homes) == 1
            assert homes != {i}
            home = homes.pop()
            length = spans[home + 1] - spans[home]
            assert (at[start:stop] - spans[home] == np.arange(stop - start) % length).all()
    with pytest.raises(SeriesError, match="at least 3 recordings"):
        s, r, _ = three(100)
        c.assess("te", s, r, options=TestOptions(method="partners"))


def test_blocks_last_as_long_as_asked():
    spans = np.array([0, 20_000, 60_000])
    pieces = next(Moves("bootstrap", spans, block=50).draw(1, np.random.default_rng(0)))
    at = taken(pieces, 60_000)
    assert (np.searchsorted(spans, at, "right") == np.searchsorted(spans, np.arange(60_000), "right")).all()
    assert len(pieces) == pytest.approx(60_000 / 50, rel=0.1)


class TestMemory:
    def test_of_fresh_series(self):
        s, r = np.random.default_rng(0).integers(0, 3, (2, 5000))
        found = memory(steps(s, r), TRANSFER)
        assert found.inflation == pytest.approx(1, abs=0.02)
        assert found.exchangeable(1.02)
        assert found.fresh_after == 1

    def test_grows_with_the_spread_of_looks(self):
        """Looks of geometric lengths have no memory beyond a step; more and less even ones do."""
        found = []
        for spread in (0.5, 1.0, 1.5):
            s, r, _ = three(20_000, 1, spread)
            found.append(memory(steps(s, r), TRANSFER))
        assert found[0].inflation < 0.98 < 1.02 < found[1].inflation < found[2].inflation
        assert found[0].fresh_after < found[1].fresh_after < found[2].fresh_after
        assert not any(memory.exchangeable(1.02) for memory in found)

    def test_of_one_value_and_of_two_steps(self):
        flat = np.zeros(50, int)
        assert memory(steps(flat, flat), TRANSFER).inflation == 1
        assert memory(steps([0, 1], [1, 0]), TRANSFER).inflation == 1

    def test_of_many_steps_only_the_first(self, monkeypatch):
        monkeypatch.setattr("jointattn_mj.contingency.memory.MOST_STEPS", 1000)
        s, r, a = three(3000)
        parts = [[series[:400], series[400:1400], series[1400:]] for series in (s, r, a)]
        cut = [[series[:400], series[400:1000]] for series in (s, r, a)]
        assert memory(steps(*parts), COMBINED) == memory(steps(*cut), COMBINED)


def test_the_method_follows_the_memory():
    fresh = np.random.default_rng(0).integers(0, 3, (2, 2000))
    s, r, _ = three(4000, 2, 1.5)
    options = TestOptions(99, resamples=0)
    assert c.assess("te", *fresh, options=options).method == "permutation"
    slow = c.assess("te", s, r, options=options)
    assert (slow.method, slow.inflation > 1.1) == ("shift", True)
    short = [np.split(series, 40) for series in (s, r)]
    assert c.assess("mi", *short, options=options).method == "partners"
    assert c.assess("te", s, r, options=TestOptions(99, resamples=0, method="permutation")).method == "permutation"


def test_unrelated_looks_are_no_finding():
    """At 30 steps a second, 28 of 100 such pairs once were."""
    p = []
    for seed in range(60):
        s, r, _ = three(5400, 1000 + seed, 1.5)
        p.append(c.assess("te", s, r, options=TestOptions(99, resamples=0), seed=seed).p)
    assert np.mean(np.array(p) <= 0.05) <= 0.12
    assert np.mean(np.array(p) <= 0.5) == pytest.approx(0.5, abs=0.2)


def test_interval_and_p_agree():
    inside = 0
    for seed in range(40):
        s, r, _ = three(2000, seed, 1.5)
        follows = np.random.default_rng(seed).random(2000) < 0.03
        r[1:][follows[1:]] = s[:-1][follows[1:]]
        found = c.assess("te", s, r, options=TestOptions(199, resamples=99, method="shift"), seed=seed)
        assert (found.interval[0] > 0) == (found.p <= 0.05)
        assert found.interval[0] <= found.interval[1]
        inside += found.interval[0] <= found.corrected <= found.interval[1]
    assert inside >= 36


@pytest.mark.parametrize("alpha", [0.05, 0.001])
def test_the_lower_end_agrees_with_any_null(alpha):
    rng = np.random.default_rng(0)
    for _ in range(300):
        null, value, low = rng.random(int(rng.integers(5, 300))), rng.random() * 1.2, rng.normal()
        p = (1 + np.sum(null >= value)) / (1 + len(null))
        assert (bootstrap.agreeing(low, value, null, alpha) > 0) == (p <= alpha)


def test_measures_share_surrogates_and_threads_change_nothing(monkeypatch):
    s, r, a = three(3000, 3, 1.5)
    given, options = steps(s, r, a), TestOptions(60, resamples=20, method="shift")
    found = []
    for worth in (10**9, 1):
        monkeypatch.setattr("jointattn_mj.contingency.significance.WORTH_THREADS", worth)
        rngs = [np.random.default_rng(i) for i in range(2)]
        told = []
        found.append(assess_measures(given, (TRANSFER, MUTUAL), options, 1.0, rngs, told.append))
        assert sum(told) == 2 * 80
    assert found[0] == found[1]


def test_long_series_are_resampled_by_blocks_that_are_counted_once(monkeypatch):
    s, r, _ = three(30_000, 4)
    given = steps([s[:20_000], s[20_000:]], [r[:20_000], r[20_000:]])
    exact = bootstrap.resampled(given, TRANSFER, 300, np.random.default_rng(0), block=60)
    monkeypatch.setattr(bootstrap, "MANY", 1000)
    quick = bootstrap.resampled(given, TRANSFER, 300, np.random.default_rng(0), block=60)
    assert quick.mean() == pytest.approx(exact.mean(), rel=0.1)
    assert quick.std() == pytest.approx(exact.std(), rel=0.25)
