"""The camera's faults: noise as strong as it says and the frame's own, brightness, and images that come late."""

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError
from jointattn_mj.scene.dressing import Conditions
from jointattn_mj.scene.looker import LookingWorld
from jointattn_mj.scene.sensor import Sensor
from jointattn_mj.scene.world import AlignedObservation, World, WorldConfig

SEED = np.random.SeedSequence(1)
GREY = np.full((240, 320, 3), 120, np.uint8)
TURNED = np.array([0.3, -0.2])


def exposed(sensor: Sensor, frame: int = 0, image: np.ndarray = GREY) -> np.ndarray:
    image = image.copy()
    sensor.expose(image, frame)
    return image


def build(kind=World, **sensor) -> World:
    return kind.build(WorldConfig(), SEED, Conditions(sensor=Sensor(**sensor)))


def test_a_faultless_sensor_changes_nothing():
    image = np.random.default_rng(0).integers(0, 256, GREY.shape, np.uint8)
    np.testing.assert_array_equal(exposed(Sensor(), image=image), image)


@pytest.mark.parametrize("deviation", [2.0, 5.0, 20.0])
def test_noise_is_as_strong_as_it_says(deviation):
    noisy = exposed(Sensor(noise=deviation)).astype(float) - 120
    assert noisy.mean() == pytest.approx(0, abs=0.02 * deviation)
    assert noisy.std() == pytest.approx(deviation, rel=0.04)
    left, right = noisy[:, :-1].ravel(), noisy[:, 1:].ravel()
    assert abs(np.corrcoef(left, right)[0, 1]) < 0.02


def test_noise_is_the_frames_own():
    images = [exposed(Sensor(noise=5.0, seed=seed), frame) for seed, frame in ((1, 7), (1, 7), (1, 8), (2, 7))]
    np.testing.assert_array_equal(images[0], images[1])
    for other in images[2:]:
        assert abs(np.corrcoef(images[0].ravel(), other.ravel())[0, 1]) < 0.02


def test_values_stay_in_their_bounds():
    bright = exposed(Sensor(brightness=1.5, noise=30.0), image=np.full_like(GREY, 200))
    assert np.median(bright) == 255  # saturated, not wrapped around
    dark = exposed(Sensor(noise=30.0), image=np.zeros_like(GREY))
    assert np.median(dark) <= 1


def test_brightness_is_a_factor():
    np.testing.assert_array_equal(exposed(Sensor(brightness=0.5)), 60)


@pytest.mark.parametrize("wrong", [{"brightness": 0}, {"noise": -1}, {"noise": 100}, {"delay": -1}, {"delay": 31}])
def test_impossible_sensors_are_errors(wrong):
    with pytest.raises(ConfigError, match=next(iter(wrong))):
        Sensor(**wrong)


def test_images_come_late_and_nothing_else_changes():
    """At the beginning, what there was at first."""
    prompt, late = build(), build(delay=3)
    visible = [prompt.image().copy()]
    np.testing.assert_array_equal(late.image(), visible[0])
    for step in range(1, 50):
        for world in (prompt, late):
            world.step(TURNED)
        visible.append(prompt.image().copy())
        if step % 2:  # looking or not makes no difference
            np.testing.assert_array_equal(late.image(), visible[max(0, step - 3)])
        np.testing.assert_array_equal(prompt.data.qpos, late.data.qpos)
        np.testing.assert_array_equal(prompt.data.xpos, late.data.xpos)
        np.testing.assert_array_equal(prompt.head_angles(), late.head_angles())
    assert not np.array_equal(visible[-1], visible[-4])
    prompt.close(), late.close()


def test_aligned_senses_tell_the_head_as_it_is_in_the_image():
    """The head counts as moving until an image shows it at rest."""
    world, angles, moves = build(delay=3), [], []
    aligned = AlignedObservation(world)
    for step in range(60):
        angles.append(world.head_angles())
        moves.append((world.head_moves(), aligned.head_moves))
        np.testing.assert_array_equal(aligned.head_angles, angles[max(0, step - 3)])
        world.step(TURNED)
    really, seen = np.array(moves).T
    assert really.any() and not seen[-1]
    assert 1 <= np.flatnonzero(seen)[-1] - np.flatnonzero(really)[-1] <= 3
    behind = [np.abs(angles[step] - angles[max(0, step - 3)]).max() for step in range(60)]
    assert np.degrees(np.max(np.array(behind)[~seen])) < 0.1 < np.degrees(np.max(np.array(behind)[~really]))
    world.close()
    prompt = build()
    prompt.step(TURNED)
    np.testing.assert_array_equal(AlignedObservation(prompt).head_angles, prompt.head_angles())
    assert AlignedObservation(prompt).head_moves == prompt.head_moves()
    prompt.close()


def test_a_new_episode_has_no_past():
    world = build(delay=5)
    first = world.image().copy()
    for _ in range(10):
        world.step(TURNED)
    world.reset(SEED)
    np.testing.assert_array_equal(world.image(), first)
    world.close()


def test_a_delay_within_a_step_shows_what_lies_between():
    """A step of this world is three frames; a joint that moves steadily is two thirds back after one frame's delay."""
    world = build(LookingWorld, delay=1)
    world.step(np.zeros(2))
    before = world.head_angles()
    world.step(TURNED)
    after = world.head_angles()
    with world._past.shown(world.model, world.data):
        np.testing.assert_allclose(world.head_angles(), after + (before - after) / 3, atol=1e-12)
    np.testing.assert_array_equal(world.head_angles(), after)
    world.close()


def test_noise_does_not_depend_on_who_looked_before():
    first, second = build(noise=4.0), build(noise=4.0)
    for _ in range(4):
        first.image()
        first.step(TURNED), second.step(TURNED)
    np.testing.assert_array_equal(first.image(), second.image())
    first.close(), second.close()
