"""Joint attention derived from looks, and agreement of two coders."""

from itertools import pairwise

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError, SeriesError
from jointattn_mj.recordings.agreement import AgreementOptions, agreement, kappa
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.intervals import intervals_of
from jointattn_mj.recordings.joint_attention import JointAttentionRules, joint_attention

LOOKS = [
    ("mother", "cup", 2, 8), ("mother", "face", 8, 10), ("mother", "ball", 10, 20), ("mother", "door", 20, 24),
    ("infant", "face", 0, 3.5), ("infant", "cup", 3.5, 7), ("infant", "face", 7, 9.5), ("infant", "ball", 9.5, 14),
    ("infant", "face", 14, 15), ("infant", "ball", 15, 19), ("infant", "door", 23.5, 26),
]  # fmt: skip


def events(rows=LOOKS, **more):
    tier, code, onset, offset = zip(*rows, strict=True)
    return Events.of(tier, code, onset, offset, **more)


def rows(found, tier):
    intervals = intervals_of(found.events, found.events.recordings[0], tier)
    return list(zip(intervals.code, intervals.onset, intervals.offset, strict=True))


class TestJointAttention:
    def test_tiers(self):
        found = joint_attention(events())
        assert rows(found, "mutual gaze") == [("mutual", 8, 9.5)]
        assert rows(found, "shared attention") == [
            ("cup", 3.5, 7), ("ball", 10, 14), ("ball", 15, 19), ("door", 23.5, 24),
        ]  # fmt: skip
        assert [code for code, *_ in rows(found, "leader")] == ["mother", "infant", "mother", "mother"]
        assert rows(found, "engagement") == [("supported", 3.5, 7), ("coordinated", 10, 19)]
        assert rows(found, "infant follows") == [("cup", 3.5, 7)]
        assert rows(found, "mother follows") == [("ball", 10, 20)]

    def test_latencies_and_chances(self):
        found = joint_attention(events())
        chances = [(chance.follower, chance.target, chance.latency) for chance in found.opportunities]
        assert chances[:2] == [("infant", "cup", 1.5), ("infant", "door", pytest.approx(float("nan"), nan_ok=True))]
        row = found.rows()[0]
        assert (row["infant could follow"], row["infant follows"], row["infant, median latency (s)"]) == (2, 1, 1.5)
        assert row["mutual gaze, share of time"] == pytest.approx(1.5 / 26)
        assert row["mother leads"] == 3

    def test_rules(self):
        slow = joint_attention(events(), JointAttentionRules(follow_within_s=4))
        assert slow.rows()[0]["infant follows"] == 2
        gone = joint_attention(
            events([("mother", "cup", 0, 1), ("infant", "cup", 2, 3)]), JointAttentionRules(still_looking=True)
        )
        assert gone.rows()[0]["infant follows"] == 0
        both = joint_attention(events(), JointAttentionRules(together_s=0.6))
        assert "together" in [code for code, *_ in rows(both, "leader")]
        strict = joint_attention(events(), JointAttentionRules(glances=2, bridge_s=0.5, least_mutual_s=2))
        assert rows(strict, "engagement") == [("supported", 3.5, 7), ("supported", 10, 14), ("supported", 15, 19)]
        assert rows(strict, "mutual gaze") == []
        with pytest.raises(ConfigError, match="tiers of their own"):
            JointAttentionRules(infant="mother")
        with pytest.raises(SeriesError, match="no tier 'baby'"):
            joint_attention(events(), JointAttentionRules(infant="baby"))

    def test_missing_codes_share_nothing(self):
        """Where nobody knows what either looks at, nobody knows that it is the same."""
        found = joint_attention(events([("mother", None, 0, 5), ("infant", None, 1, 6)]))
        assert rows(found, "shared attention") == rows(found, "infant follows") == []
        assert found.opportunities == ()

    def test_derived_tiers_are_steps_like_others(self):
        steps = joint_attention(events()).events.steps(0.5)
        assert set(steps.labels["engagement"]) == {"(none)", "supported", "coordinated"}
        nothing = joint_attention(events(LOOKS[:1] + LOOKS[4:5]))
        assert set(nothing.events.steps(0.5).labels["mutual gaze"]) == {"(none)"}

    def test_recordings_apart(self):
        twice = events([*LOOKS, *LOOKS], recording=["a"] * 11 + ["b"] * 11)
        first, second = joint_attention(twice).rows()
        assert {**first, "recording": "b"} == pytest.approx(second, nan_ok=True)


class TestAgreement:
    def test_of_published_tables(self):
        """By hand: .70 of units alike, .41 by chance; and an example of the R package Delta (GetKappa)."""
        assert kappa(np.array([[50, 10], [10, 20]])) == pytest.approx(0.5)
        assert kappa(np.array([[0.44, 0.07, 0.09], [0.05, 0.20, 0.05], [0.01, 0.03, 0.06]])) == pytest.approx(
            0.492, abs=5e-4
        )

    def test_of_two_coders(self):
        first = events([("gaze", "face", 0, 10), ("gaze", "toy", 10, 20)])
        second = events([("gaze", "face", 0, 11), ("gaze", "toy", 11, 20)])
        (found,) = agreement(first, second, options=AgreementOptions(step=0.5))
        assert found.matrix.tolist() == [[20, 0], [2, 18]]
        assert found.observed == 0.95
        assert found.kappa == pytest.approx(0.9)
        assert found.kappa_max == pytest.approx(0.9)
        assert found.by_code() == pytest.approx({"face": 0.9, "toy": 0.9})
        (near,) = agreement(first, second, options=AgreementOptions(step=0.5, tolerance_s=0.5))
        (nearer,) = agreement(first, second, options=AgreementOptions(step=0.5, tolerance_s=1))
        assert nearer.kappa == 1
        assert near.matrix.tolist() == [[20.5, 0], [1, 18.5]]  # each coder's last unit of the two is near enough
        assert near.kappa == pytest.approx((0.975 - 801.5 / 1600) / (1 - 801.5 / 1600))
        (same,) = agreement(first, second, options=AgreementOptions(step=0.5, tolerance_s=0.4))
        assert same.kappa == found.kappa
        assert same.notes() == ("a tolerance of 0.4 s is less than a unit of 0.5 s: it changes nothing",)

    def test_tolerance_is_the_same_from_both_sides(self):
        rng = np.random.default_rng(0)
        coders = []
        for _ in range(2):
            times = np.append(0, np.cumsum(rng.uniform(0.4, 2, 60)))
            coders.append(events([("gaze", "abc"[rng.integers(3)], a, b) for a, b in pairwise(times)]))
        options = AgreementOptions(step=0.1, tolerance_s=0.5)
        (forward,), (backward,) = agreement(*coders, options=options), agreement(*coders[::-1], options=options)
        assert forward.kappa == pytest.approx(backward.kappa)
        assert forward.outside_s == pytest.approx(backward.outside_s)
        assert forward.outside_s > 0
        assert forward.interval[0] < forward.kappa < forward.interval[1]
        assert forward.row()["kappa"] == forward.kappa

    def test_missing_codes_and_point_events_are_left_out_and_told(self):
        first = events([("gaze", None, 0, 4), ("gaze", "face", 4, 8), ("gaze", "toy", 8, 10), ("gaze", "wink", 9, 9)])
        second = events([("gaze", "face", 0, 6), ("gaze", None, 6, 7), ("gaze", "toy", 7, 10)])
        (found,) = agreement(first, second, options=AgreementOptions(step=0.5))
        assert (found.labels, found.matrix.tolist()) == (("face", "toy"), [[4, 2], [0, 4]])
        assert (found.missing_s, found.moments) == (5, 1)
        assert found.notes() == (
            "left out of the tier 'gaze', as a code is missing: 5.0 s",
            "left out of the tier 'gaze', as they have no length: 1 point event",
        )
        with pytest.raises(SeriesError, match="its codes are missing"):
            agreement(first, events([("gaze", None, 0, 10)]))

    def test_recordings_of_one_coder_alone_are_told_of(self):
        both = events([("gaze", "face", 0, 5), ("gaze", "toy", 5, 9)] * 2, recording=["a", "a", "b", "b"])
        (found,) = agreement(both, events([("gaze", "face", 0, 6), ("gaze", "toy", 6, 8)], recording=["b", "b"]))
        assert found.notes() == ("left out, as only one coder has coded it: 1 recording (a) and 1.0 s",)
        assert (found.alone, found.row()["left_out"]) == (("a",), "a")
        more = both.joined(events([("hand", "rest", 0, 1)], recording="a"))
        assert agreement(both, more)[0].notes() == ("left out, as only one coder has coded it: 1 tier (hand)",)

    def test_what_cannot_be_compared(self):
        first = events([("gaze", "face", 0, 10)])
        with pytest.raises(SeriesError, match="share no tier"):
            agreement(first, events([("hand", "rest", 0, 10)]))
        with pytest.raises(SeriesError, match="share gaze"):
            agreement(first, first, ["hand"])
        with pytest.raises(SeriesError, match="no time"):
            agreement(first, events([("gaze", "face", 20, 30)]))
        with pytest.raises(SeriesError, match="look whether its times are right"):
            agreement(long := events([("gaze", "face", 0, 9e8)]), long)
        (alone,) = agreement(first, first)
        assert np.isnan(alone.kappa)
