"""Delays and histories, and scans over lags with one correction for all."""

import numpy as np
import pytest

import jointattn_mj.contingency as c
from jointattn_mj.contingency import scan
from jointattn_mj.contingency.information import COMBINED, TRANSFER
from jointattn_mj.contingency.lagged import timed
from jointattn_mj.contingency.series import joint
from jointattn_mj.contingency.significance import TestOptions
from jointattn_mj.contingency.table import steps
from jointattn_mj.errors import ConfigError, SeriesError

FEW = TestOptions(99, resamples=0)


def bits(given, measure=TRANSFER):
    return measure.value(given.entries()) / np.log(2)


def later(n, lag, share=0.6, seed=0):
    """A result that tells, in this share of the steps, whether the source was 1 so many steps before."""
    rng = np.random.default_rng(seed)
    s, r = rng.integers(0, 3, n), rng.integers(0, 2, n)
    told = rng.random(n - lag) < share
    r[lag:][told] = (s == 1)[:-lag][told]
    return s, r


def test_a_lag_is_a_shifted_source():
    s, r = later(3000, 2)
    a = np.random.default_rng(1).integers(0, 2, 3000)
    assert bits(timed(steps(s, r), c.Timing(lag=2))) == pytest.approx(c.transfer_entropy(s[:-1], r[1:]))
    given = timed(steps(s, r, a), c.Timing(lag=3))
    assert bits(given, COMBINED) == pytest.approx(c.combined_transfer_entropy(s[:-2], a[:-2], r[2:]))
    assert timed(given, c.Timing()) is given


def test_histories_are_several_values_as_one():
    s, r = later(3000, 2)
    given = timed(steps(s, r), c.Timing(source_history=2, target_history=3))
    source, before = joint(s[2:], s[1:-1]), joint(r[2:], r[1:-1], r[:-2])
    known = c.conditional_mutual_information(source, r[2:], before)
    assert bits(given) == pytest.approx(known)
    assert np.isclose(given.dense().sum(), given.transitions)
    table = given.entries_by_step()[0]
    assert TRANSFER.value(table) == pytest.approx(TRANSFER.value(given.entries()))


def test_what_the_target_remembers_is_not_what_the_source_says():
    """The result repeats itself after two steps, and the source repeats the result: only its own past explains it."""
    rng = np.random.default_rng(0)
    r = np.empty(4000, int)
    r[:2] = 0
    for t in range(2, 4000):
        r[t] = r[t - 2] if rng.random() < 0.9 else rng.integers(2)
    s = np.append(0, r[:-1])
    assert c.assess("te", s, r, options=FEW).p == 0.01
    assert c.assess("te", s, r, options=FEW, timing=c.Timing(target_history=2)).p > 0.05


def test_recordings_are_never_crossed():
    s, r = [0, 1, 2, 0, 1], [0, 1, 1, 0, 1]
    given = timed(steps([s, s[:2], s[:4]], [r, r[:2], r[:4]], groups=[0, 0, 1]), c.Timing(lag=3))
    assert given.transitions == 2 + 1
    assert given.groups.tolist() == [0, 1]
    assert given.columns()[2].tolist() == [0, 1, 0]
    with pytest.raises(SeriesError, match="longest recording has 5"):
        timed(steps([s], [r]), c.Timing(lag=5))


def test_an_effect_two_steps_later_is_found_there():
    """0.318 bits two steps later, which a single lag of one step does not see."""
    s, r = later(4000, 2, 0.665)
    found = c.scan_lags("te", s, r, lags=range(1, 8), options=FEW)
    assert found.lags[found.best] == 2
    assert found.value[1] == pytest.approx(0.318, abs=0.02)
    assert found.value[0] < 0.01
    assert found.p_adjusted[1] == 0.01
    assert found.p_adjusted[np.arange(7) != 1].min() > 0.05
    assert found.effective[1] > found.chance_of_all[1] > found.chance[1]
    assert found.transitions == 4000 - 7
    assert [row["lag"] for row in found.rows()] == list(range(1, 8))


@pytest.mark.parametrize("method", ["shift", "bootstrap", "partners"])
def test_lags_that_are_measured_part_by_part_have_the_same_surrogates(method, monkeypatch):
    """Bit for bit, and what is drawn next from the same generator, too."""
    s, r = later(400, 3)
    cut = [slice(0, 90), slice(90, 210), slice(210, 400)]
    scans, told, following = [], [], []
    for most in (2**23, 1000, 1):
        monkeypatch.setattr(scan, "AT_ONCE", most)
        rng, done = np.random.default_rng(5), []
        options = TestOptions(60, method=method)
        series = [s[rows] for rows in cut], [r[rows] for rows in cut]
        scans.append(c.scan_lags("te", *series, lags=range(1, 9), options=options, seed=rng, progress=done.append))
        told.append(sum(done))
        following.append(rng.random())
    for other in scans[1:]:
        assert other.rows() == scans[0].rows()
    assert told == [60] * 3
    assert len(set(following)) == 1


def test_many_lags_do_not_find_more_by_chance():
    alarms = alone = 0
    for seed in range(60):
        s, r = np.random.default_rng(seed).integers(0, 3, (2, 300))
        found = c.scan_lags("te", s, r, lags=range(1, 13), options=FEW, seed=seed)
        assert (found.p_adjusted >= found.p - 1e-9).all()
        alarms += found.p_adjusted.min() <= 0.05
        alone += found.p.min() <= 0.05
    assert alarms <= 8
    assert alone > 12


def test_bad_use():
    s, r = later(100, 2)
    for lags in ((), (0, 1), (1, 1), (1.5,)):
        with pytest.raises(SeriesError, match="lags must be"):
            c.scan_lags("te", s, r, lags=lags)
    with pytest.raises(SeriesError, match="needs condition"):
        c.scan_lags("sac", s, r)
    with pytest.raises(ConfigError, match="lag"):
        c.Timing(lag=0)


def test_values_of_every_measure_add_up_to_it():
    from jointattn_mj.contingency.local import local_of_steps
    from jointattn_mj.contingency.significance import MEASURES

    rng = np.random.default_rng(0)
    s, a, r = rng.integers(0, 3, (3, 500))
    for measure in MEASURES.values():
        given = steps(s, r, a)
        local = local_of_steps(given, measure)
        assert sum(value.contribution for value in local) == pytest.approx(measure.value(given.entries()))
        assert sum(value.count for value in local) == given.transitions
        assert {value.known for value in local} == {measure.given}
    words = local_of_steps(steps(s, r), MEASURES["mutual_information"])[0].words(("gaze", "", "toy"))
    assert "with" not in words
    assert "->" not in words
