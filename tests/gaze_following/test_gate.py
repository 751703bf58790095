"""The gate of eq. 6.8 and the head's movement."""

import math
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.gate import GazeConfig, HeadShift, gate_probability

directions = st.tuples(st.floats(-60, 60), st.floats(-45, 30)).map(np.array)


def test_gate_by_hand():
    """(p, q) = (150, 22.5): half at the 150th step (section 6.4.1); three quarters q ln 3 later."""
    config = GazeConfig()
    assert (config.gate_midpoint, config.gate_width) == (150, 22.5)
    assert gate_probability(config, 150) == pytest.approx(0.5, abs=1e-15)
    assert gate_probability(config, 0) == pytest.approx(1 / (1 + math.exp(150 / 22.5)), rel=1e-9)
    assert gate_probability(GazeConfig(gate_midpoint=100, gate_width=20 / math.log(3)), 120) == pytest.approx(0.75)


@given(st.integers(0, 10**6), st.floats(1e-3, 1e4))
def test_gate_is_a_probability_and_grows(iterations, width):
    config = GazeConfig(gate_width=width)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        now, later = gate_probability(config, iterations), gate_probability(config, iterations + 50)
    assert 0 <= now <= later <= 1
    x = (150 - iterations) / width
    if x < 600:
        assert now == pytest.approx(1 / (1 + math.exp(x)), rel=1e-6, abs=1e-12)


def test_gate_shut_and_open():
    for iterations in (0, 150, 10000):
        assert gate_probability(GazeConfig(gate="shut"), iterations) == 0
        assert gate_probability(GazeConfig(gate="open"), iterations) == 1


@given(directions, directions, st.integers(1, 60))
def test_a_shift_ends_at_its_aim(start, end, frames):
    shift = HeadShift(start, end, frames)
    path = []
    while not shift.commanded:
        path.append(shift.next_reference())
    assert len(path) == frames
    np.testing.assert_allclose(path[-1], end, atol=1e-9)
    np.testing.assert_array_equal(shift.next_reference(), path[-1])  # stays there
    low, high = np.minimum(start, end) - 1e-9, np.maximum(start, end) + 1e-9
    assert ((path >= low) & (path <= high)).all()


def test_a_shift_goes_on_from_every_frame():
    """Also while its end is held for a head that still moves."""
    shift = HeadShift(np.zeros(2), np.array([20.0, -10.0]), 5)
    for _ in range(8):
        copy = HeadShift.__new__(HeadShift)
        copy.__setstate__(vars(shift))
        assert np.array_equal(copy.next_reference(), shift.next_reference())
        assert copy.commanded == shift.commanded


def test_a_shift_is_minimum_jerk():
    """Halfway at half time, and 15/8 of the mean speed there."""
    shift = HeadShift(np.zeros(2), np.array([26.0, -13.0]), 26)
    path = np.array([shift.next_reference() for _ in range(26)])
    np.testing.assert_allclose(path[12], [13, -6.5])
    speed = np.diff(path[:, 0], prepend=0)
    assert speed.max() == pytest.approx(15 / 8, rel=0.01)
    assert speed[0] < 0.02 > speed[-1]


@given(directions, directions, st.lists(st.tuples(st.integers(0, 25), directions), max_size=4), st.integers(1, 26))
def test_aiming_anew_does_not_jump(start, end, aims, frames):
    """Each step stays within what a minimum-jerk movement over the rest of the way would do at its fastest."""
    shift, before, aim = HeadShift(start, end, frames), start, end
    for frame in range(frames):
        for when, anew in aims:
            if when == frame:
                shift.aim(anew)
                aim = anew
        now = shift.next_reference()
        assert np.isfinite(now).all()
        left = frames - frame  # a movement that is all ahead is never faster than 15/8 of its mean; later ones brake
        assert (np.abs(now - before) <= 3 * np.abs(aim - before) / left + 1e-9).all()
        before = now
    np.testing.assert_allclose(before, aim, atol=1e-9)


def test_aiming_at_the_same_place_changes_nothing():
    plain, aimed = (HeadShift(np.zeros(2), np.array([20.0, -10.0]), 26) for _ in range(2))
    for frame in range(26):
        if frame in (0, 7, 17, 25):
            aimed.aim(np.array([20.0, -10.0]))
        np.testing.assert_allclose(aimed.next_reference(), plain.next_reference(), atol=1e-12)


@pytest.mark.parametrize(
    "options",
    [{"shift_frames": 0}, {"gate_width": 0.0}, {"gate_width": math.nan}, {"centre_radius_deg": -1.0}],
)
def test_impossible_options(options):
    with pytest.raises(ConfigError, match=next(iter(options))):
        GazeConfig(**options)


def test_certainty_is_the_probability_of_the_best_object():
    config = GazeConfig(gate="certainty", gate_sharpness=2.0)
    scores = np.log([4.0, 2.0, 2.0])
    assert gate_probability(config, 0, scores) == pytest.approx(16 / 24)
    assert gate_probability(config, 10**9, scores[:0]) == gate_probability(config, 10**9) == 0
    assert gate_probability(config, 0, scores[:1]) == 1
    assert gate_probability(config, 0, np.array([-1e9, 1e9])) == 1
