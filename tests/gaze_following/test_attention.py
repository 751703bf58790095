"""The attention selector against the text: eq. 6.1 to 6.7, Table 6.1, (a, d, T) of section 6.4.1."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.attention import AttentionConfig, AttentionSelector, motion_saliency

FACE = 4
ALL_VISIBLE = np.ones(5, bool)
STILL = np.zeros(5, bool)


def selector(seed: int = 0, **options) -> AttentionSelector:
    return AttentionSelector(AttentionConfig(**options), FACE, np.random.default_rng(seed))


class Oracle:
    """The equations in plain Python, one candidate at a time."""

    def __init__(self, objects: int, recovery: str, cues: bool):
        self.preference = [800.0] * objects + [1500.0]
        self.decay = [math.exp(-1e-2)] * objects + [math.exp(-2e-2)]
        self.growth = [math.exp(2e-3)] * objects + [math.exp(1.2e-2)]
        self.saliency, self.motion = list(self.preference), [0] * (objects + 1)
        self.bound, self.gain = {"min": min, "max": max}[recovery], 4.5 if cues else 0.0

    def advance(self, attended: int | None, moves: list[bool]) -> list[float]:
        interest = []
        for i, moving in enumerate(moves):
            self.motion[i] = self.motion[i] + 1 if moving else max(self.motion[i] - 1, 0)
            if i == attended:
                self.saliency[i] = self.decay[i] * self.saliency[i]
            else:
                self.saliency[i] = self.bound(self.preference[i], self.growth[i] * self.saliency[i])
            interest.append(self.saliency[i] * (1 + self.gain / (1 + math.exp((20 - self.motion[i]) / 1.4))))
        return interest


def test_defaults_are_those_of_the_text():
    config = AttentionConfig()
    assert (config.face_preference, config.face_decay, config.face_growth) == (1500, 2.0e-2, 1.2e-2)
    assert (config.object_preference, config.object_decay, config.object_growth) == (800, 1.0e-2, 2.0e-3)
    assert (config.motion_gain, config.motion_delay, config.motion_width) == (4.5, 20, 1.4)
    assert config.motion_cues
    assert config.recovery == "min"


def test_motion_saliency_by_hand():
    """Eq. 6.4: 1 + a/2 where x = d, nearly 1 without motion, nearly 1 + a long after."""
    assert motion_saliency(20.0, 4.5, 20.0, 1.4) == pytest.approx(3.25, abs=1e-12)
    assert motion_saliency(20 + 1.4 * math.log(3), 4.5, 20.0, 1.4) == pytest.approx(1 + 4.5 * 0.75, abs=1e-12)
    assert motion_saliency(0.0, 4.5, 20.0, 1.4) == pytest.approx(1, abs=1e-5)
    assert motion_saliency(60.0, 4.5, 20.0, 1.4) == pytest.approx(5.5, abs=1e-9)
    assert motion_saliency(0.0, 4.5, 20.0, 1e-3) == 1  # overflows inside, quietly


def test_saliency_by_hand():
    """Fifty frames at the face: S = 1500 e^-1. Then forty of fifty elsewhere: 1500 e^(-1 + .6), and never above C."""
    attention = selector()
    for _ in range(50):
        attention.advance(FACE, STILL)
    assert attention.saliency[FACE] == pytest.approx(1500 * math.exp(-1))
    assert attention.saliency[:FACE] == pytest.approx(800)
    for _ in range(50):
        attention.advance(0, STILL)
    assert attention.saliency[FACE] == pytest.approx(1500 * math.exp(-1 + 0.6))
    assert attention.saliency[0] == pytest.approx(800 * math.exp(-0.5))
    for _ in range(200):
        attention.advance(None, STILL)
    assert attention.saliency[FACE] == 1500
    assert attention.saliency[0] == pytest.approx(800 * math.exp(-0.5 + 0.4))


def test_degree_of_motion_by_hand():
    attention = selector()
    first_moves = np.arange(5) == 0
    counts = []
    for moves in [first_moves] * 3 + [STILL] * 5 + [first_moves]:
        attention.advance(None, moves)
        counts.append(attention.motion[0])
    assert counts == [1, 2, 3, 2, 1, 0, 0, 0, 1]
    assert not attention.motion[1:].any()


@settings(max_examples=60, deadline=None)
@given(
    objects=st.integers(1, 6),
    recovery=st.sampled_from(["min", "max"]),
    cues=st.booleans(),
    data=st.data(),
)
def test_against_plain_python(objects, recovery, cues, data):
    frame = st.tuples(
        st.none() | st.integers(0, objects), st.lists(st.booleans(), min_size=objects + 1, max_size=objects + 1)
    )
    attention = AttentionSelector(
        AttentionConfig(motion_cues=cues, recovery=recovery), objects, np.random.default_rng(0)
    )
    oracle = Oracle(objects, recovery, cues)
    for attended, moves in data.draw(st.lists(frame, max_size=80)):
        expected = oracle.advance(attended, moves)
        attention.advance(attended, np.array(moves))
        np.testing.assert_allclose(attention.interest, expected, rtol=1e-12)
        np.testing.assert_allclose(attention.saliency, oracle.saliency, rtol=1e-12)
        np.testing.assert_array_equal(attention.motion, oracle.motion)


def test_recovery_as_printed_grows_beyond_the_preference():
    """Eq. 6.6 with the printed max: what is not attended grows without bound; with min it stays at C."""
    printed, recovering = selector(recovery="max"), selector()
    for _ in range(100):
        printed.advance(0, STILL)
        recovering.advance(0, STILL)
    assert printed.saliency[FACE] == pytest.approx(1500 * math.exp(1.2))
    assert recovering.saliency[FACE] == 1500


def test_without_cues_motion_does_not_count():
    attention = selector(motion_cues=False)
    for _ in range(60):
        attention.advance(0, ALL_VISIBLE)
    np.testing.assert_array_equal(attention.interest, attention.saliency)  # M = 1
    assert (attention.motion == 60).all()  # still counted, for the log


@settings(max_examples=200, deadline=None)
@given(
    visible=st.lists(st.booleans(), min_size=5, max_size=5),
    interest=st.lists(st.floats(1e-300, 1e300), min_size=5, max_size=5),
    seed=st.integers(0, 2**32),
)
def test_unseen_candidates_are_never_drawn(visible, interest, seed):
    attention = selector(seed)
    attention.interest[:] = interest
    drawn = attention.draw(np.array(visible))
    assert visible[drawn] if any(visible) else drawn is None


def test_nothing_of_interest_is_no_choice():
    """A candidate attended for so long that its saliency underflows, with nothing else in view."""
    attention = selector()
    attention.interest[:] = 0
    assert attention.draw(ALL_VISIBLE) is None


class Fixed:
    """A generator that draws what a test wants."""

    def __init__(self, value: float):
        self.value = value

    def random(self) -> float:
        return self.value


def test_extreme_draws_stay_among_the_seen():
    visible = np.array([False, True, False, True, False])
    for value, expected in ((0.0, 1), (np.nextafter(1, 0), 3), (0.5, 3), (np.nextafter(0.5, 0), 1)):
        attention = AttentionSelector(AttentionConfig(), FACE, Fixed(value))
        assert attention.draw(visible) == expected


def test_draws_follow_the_interest():
    """Eq. 6.7, chi-square over 20000 draws; and over the seen ones alone."""
    attention = selector(1)
    for frame in range(40):
        attention.advance(FACE, np.arange(5) == (1 if frame > 15 else 0))
    for visible in (ALL_VISIBLE, np.array([True, True, False, False, True])):
        drawn = np.bincount([attention.draw(visible) for _ in range(20000)], minlength=5)
        expected = np.where(visible, attention.interest, 0)
        expected = 20000 * expected / expected.sum()
        assert not drawn[~visible].any()
        assert stats.chisquare(drawn[visible], expected[visible]).pvalue > 0.01


def test_same_seed_same_draws():
    def draws(seed):
        attention = selector(seed)
        return [attention.draw(ALL_VISIBLE) for _ in range(50)]

    assert draws(3) == draws(3) != draws(4)


@pytest.mark.parametrize(
    "options",
    [
        {"selection_period": 0},
        {"face_preference": 0.0},
        {"object_preference": -1.0},
        {"motion_width": 0.0},
        {"motion_width": math.nan},
        {"face_decay": -0.1},
        {"object_growth": math.nan},
    ],
)
def test_impossible_options(options):
    with pytest.raises(ConfigError, match=next(iter(options))):
        AttentionConfig(**options)


@pytest.mark.parametrize("dwelt", [-1, 0.5, float("nan"), "3", 1 << 60])
def test_a_checkpoint_holds_a_number_of_frames(dwelt):
    with pytest.raises(ValueError, match="frames of this fixation"):
        AttentionSelector.__new__(AttentionSelector).__setstate__({**vars(selector()), "_dwelt": dwelt})
