"""Discovery: the event that was put there comes first, alone, and by the right values."""

import numpy as np
import pytest

from jointattn_mj.contingency import TestOptions, discover
from jointattn_mj.contingency.discovery import least_surrogates
from jointattn_mj.errors import SeriesError

pytestmark = pytest.mark.integration

QUICK = TestOptions(199, resamples=20)


def world(seed=0, n=1500):
    """Gaze and turn together bring an object about; colour and hand do nothing; turn alone brings the face about."""
    rng = np.random.default_rng(seed)
    gaze, colour, turn, hand = (rng.integers(0, k, n) for k in (4, 10, 4, 10))
    told = rng.random(n) < 0.5
    found = np.where(told, gaze == turn, rng.integers(0, 2, n))
    return {
        "gaze": gaze,
        "colour": colour,
        "turn": turn,
        "hand": hand,
        "object": np.concatenate([[0], found[:-1]]),
        "face": np.concatenate([[0], turn[:-1] == 0]).astype(int),
    }


PARTS = (["gaze", "colour"], ["turn", "hand"], ["object", "face"])


@pytest.mark.parametrize("measure", ["state_action_contingency", "combined_transfer_entropy"])
def test_finds_the_event(measure):
    found = discover(world(), *PARTS, measure=measure, options=QUICK)
    assert len(found) == 8
    assert found[0].event == "(gaze, turn) -> object"
    assert found[0].p_adjusted == pytest.approx(8 / 200)
    assert [finding.p_adjusted <= 0.05 for finding in found] == [True] + [False] * 7
    assert 0 < found[0].normalised < 1
    assert found[0].significance.interval[0] > 0
    assert found[0].values
    assert all(value.sensor == value.action for value in found[0].values if value.result == 1)
    assert not any(finding.values for finding in found[1:])
    values = [finding.significance.corrected for finding in found]
    assert values == sorted(values, reverse=True)


def test_plug_in_is_misled_by_fine_variables():
    """Why events are ranked by effective values (section 4.6): of few steps, ten values seem to say more than four."""
    found = discover(world(1, 250), *PARTS, options=QUICK)
    by_plug_in = max(found, key=lambda finding: finding.significance.value)
    assert found[0].event == "(gaze, turn) -> object"
    assert by_plug_in.event != found[0].event


def test_each_event_has_its_own_randomness():
    data = world()
    alone = discover(data, ["gaze"], ["turn"], ["object"], options=QUICK)
    again = discover(data, ["gaze"], ["turn"], ["object"], options=QUICK)
    among = discover(data, *PARTS, options=QUICK)
    assert alone == again
    assert among[0].significance == alone[0].significance
    assert alone != discover(data, ["gaze"], ["turn"], ["object"], options=QUICK, seed=1)


def test_corrections():
    data = world()
    for how in ("holm", "benjamini_hochberg", "none"):
        found = discover(data, *PARTS, options=QUICK, how=how)
        assert all(finding.p_adjusted >= finding.significance.p for finding in found)
    assert all(finding.p_adjusted == finding.significance.p for finding in found)
    assert least_surrogates(8) == 159
    assert 8 / (least_surrogates(8) + 1) <= 0.05 < 8 / least_surrogates(8)


def test_few_false_alarms():
    alarms = 0
    rng = np.random.default_rng(2)
    for seed in range(40):
        data = {name: rng.integers(0, 3, 150) for name in world()}
        found = discover(data, *PARTS, options=TestOptions(199, resamples=0), seed=seed)
        alarms += any(finding.p_adjusted <= 0.05 for finding in found)
    assert alarms <= 6


BAD = {
    "unknown": ((["gaze", "smell"], ["turn"], ["object"]), {}, "smell"),
    "no sensor": (([], ["turn"], ["object"]), {}, "sensor"),
    "twice": ((["gaze", "gaze"], ["turn"], ["object"]), {}, "once"),
    "both": ((["gaze"], ["gaze"], ["object"]), {}, "both sensor and action"),
    "measure": ((["gaze"], ["turn"], ["object"]), {"measure": "transfer_entropy"}, "expected one of state_action"),
    "alpha": ((["gaze"], ["turn"], ["object"]), {"alpha": 1.5}, "alpha"),
    "how": ((["gaze"], ["turn"], ["object"]), {"how": "hope"}, "hope"),
    "seed": ((["gaze"], ["turn"], ["object"]), {"seed": -1}, "seed"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_use(case):
    parts, options, words = BAD[case]
    with pytest.raises(SeriesError, match=words):
        discover(world(n=100), *parts, **({"options": QUICK} | options))


def test_says_which_event_cannot_be_measured():
    data = world(n=100)
    data["turn"] = data["turn"][:-1]
    with pytest.raises(SeriesError, match=r"\(gaze, turn\) -> object: .*equally long"):
        discover(data, ["gaze"], ["turn"], ["object"], options=QUICK)
