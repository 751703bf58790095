"""The truth path: exact without noise, and with it as wrong as it says."""

import json
from dataclasses import fields, replace
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError
from jointattn_mj.perception.state import StateConfig, StatePerception
from jointattn_mj.scene.camera import in_image, pixels_of_points
from jointattn_mj.scene.world import World, WorldConfig, WorldObservation

EXACT = StateConfig(
    face_noise_px=0, object_noise_px=0, object_miss=0, pattern_noise_deg=0, face_motion_hit=1,
    face_motion_false_alarm=0, object_motion_hit=1, object_motion_false_alarm=0,
)  # fmt: skip
MEASURED = Path(__file__).parents[2] / "experiments/perception/measured.json"


@pytest.fixture
def world():
    world = World.build(WorldConfig(), np.random.SeedSequence(3))
    yield world
    world.close()


def looks(world: World, config: StateConfig, frames: int, head=(0.0, 0.0), every: int = 1):
    """Percepts with what is true at that time: (percept, pixels, moving)."""
    perceiver, observation = StatePerception(config, world, np.random.default_rng(0)), WorldObservation(world)
    for frame in range(frames):
        world.step(np.radians(head))
        if frame % every == 0:
            pixels = pixels_of_points(world.candidate_points(), np.degrees(world.head_angles()))
            moving = world.moving(config.face_moves_above_deg_s, config.object_moves_above_m_s)
            yield perceiver.perceive(observation, landed=False), pixels, moving


def test_exact_without_noise(world):
    moved = np.zeros(5, int)
    for percept, pixels, moving in looks(world, EXACT, 900, head=(-20, 5)):
        inside = in_image(pixels)
        np.testing.assert_array_equal(percept.visible, inside)
        np.testing.assert_array_equal(percept.px[inside], pixels[inside])
        assert np.isnan(percept.px[~inside]).all()
        np.testing.assert_array_equal(percept.moves, moving & inside)
        moved += percept.moves
    assert (moved > 0).sum() >= 3


def test_nothing_is_rendered(world):
    for _ in looks(world, StateConfig(), 30):
        pass
    assert world.rendered_frames == 0


def test_no_motion_at_landing(world):
    config = replace(EXACT, object_motion_false_alarm=1.0, face_motion_false_alarm=1.0)
    perceiver, observation = StatePerception(config, world, np.random.default_rng(0)), WorldObservation(world)
    assert not perceiver.perceive(observation, landed=True).moves.any()
    assert perceiver.perceive(observation, landed=False).moves.all()


def test_noise_misses_and_flags_have_the_rates_they_are_given(world):
    config = StateConfig(
        face_noise_px=2.0, object_noise_px=0.5, face_miss=0.1, object_miss=0.2, face_motion_hit=0.7,
        face_motion_false_alarm=0.1, object_motion_hit=0.8, object_motion_false_alarm=0.05,
    )  # fmt: skip
    visible, off, moves, moving = [], [], [], []
    for percept, pixels, real in looks(world, config, 6000):
        visible.append(percept.visible), off.append(percept.px - pixels)
        moves.append(percept.moves), moving.append(real)
    visible, off, moves, moving = map(np.array, (visible, off, moves, moving))
    assert (~visible[:, -1]).mean() == pytest.approx(0.1, abs=0.015)
    assert (~visible[:, :-1]).mean() == pytest.approx(0.2, abs=0.01)
    assert np.nanstd(off[:, -1]) == pytest.approx(2.0, rel=0.04)
    assert np.nanstd(off[:, :-1]) == pytest.approx(0.5, rel=0.02)
    for part, hit, alarm in ((slice(4, 5), 0.7, 0.1), (slice(0, 4), 0.8, 0.05)):
        said, real = moves[:, part][visible[:, part]], moving[:, part][visible[:, part]]
        assert real.sum() > 500
        assert said[real].mean() == pytest.approx(hit, abs=0.04)
        assert said[~real].mean() == pytest.approx(alarm, abs=0.015)
    assert not moves[~visible].any()


def test_face_pattern_is_the_direction_of_the_head(world):
    for _ in range(45):
        world.step(np.zeros(2))
    exact = StatePerception(EXACT, world, np.random.default_rng(0))
    np.testing.assert_array_equal(exact.face_pattern(), world.face_angles_deg())
    assert np.abs(exact.face_pattern()).max() > 3
    noisy = StatePerception(replace(EXACT, pattern_noise_deg=1.5), world, np.random.default_rng(0))
    patterns = np.array([noisy.face_pattern() for _ in range(2000)])
    np.testing.assert_allclose(patterns.mean(0), world.face_angles_deg(), atol=0.15)
    np.testing.assert_allclose(patterns.std(0), 1.5, rtol=0.06)
    assert patterns.shape[1] == StatePerception.pattern_size


def test_defaults_are_what_was_measured():
    """Each default is the committed measurement, rounded to the default's own digits."""
    measured = json.loads(MEASURED.read_text())
    names = {field.name for field in fields(StateConfig)} & measured.keys()
    assert len(names) == 9
    for name in names:
        default = Decimal(str(getattr(StateConfig(), name)))
        digits = max(2, -default.as_tuple().exponent)
        assert abs(default - Decimal(str(measured[name]))) <= Decimal("0.5").scaleb(-digits), name


@pytest.mark.parametrize(
    "options", [{"face_miss": 1.5}, {"object_motion_hit": -0.1}, {"face_noise_px": -1.0}, {"pattern_noise_deg": np.nan}]
)
def test_impossible_options(options):
    with pytest.raises(ConfigError, match=next(iter(options))):
        StateConfig(**options)


def test_a_percept_of_another_size_is_not_restored(world):
    perceiver = StatePerception(EXACT, world, np.random.default_rng(0))
    state = vars(perceiver) | {"_errors": np.zeros((4, 2))}
    with pytest.raises(ValueError, match="errors must be"):
        StatePerception.__new__(StatePerception).__setstate__(state)
