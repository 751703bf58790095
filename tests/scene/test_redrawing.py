"""Images of which only the part is drawn in which something has moved."""

import pickle

import numpy as np
import pytest

from jointattn_mj.errors import ClosedError
from jointattn_mj.scene.dressing import Conditions
from jointattn_mj.scene.model import SceneConfig
from jointattn_mj.scene.sensor import Sensor
from jointattn_mj.scene.world import World, WorldConfig

pytestmark = pytest.mark.integration

FRAMES = 160


@pytest.fixture(scope="module")
def worlds():
    """The same world twice: images drawn whole, and drawn where something has moved."""
    made = [World.build(WorldConfig(draws=draws), np.random.SeedSequence(3)) for draws in ("all", "changes")]
    yield made
    for world in made:
        world.close()


def commands(frames=FRAMES):
    """The head turns now and then."""
    rng, command = np.random.default_rng(0), np.zeros(2)
    for frame in range(frames):
        if frame % 60 == 20:
            command = np.radians([rng.uniform(-30, 30), rng.uniform(-25, 5)])
        yield command


def counted(world, monkeypatch):
    """Sizes of what is drawn from now on, in pixels."""
    sizes, draw = [], world.eye._draw_into
    monkeypatch.setattr(
        world.eye, "_draw_into", lambda pixels, where: (sizes.append(pixels[..., 0].size), draw(pixels, where))
    )
    return sizes


def test_images_are_those_drawn_whole_but_for_a_few_pixels(worlds, monkeypatch):
    sizes = counted(worlds[1], monkeypatch)
    off, least = 0, 1.0
    for world in worlds:
        world.reset(np.random.SeedSequence(4))
    for command in commands():
        for world in worlds:
            world.step(command)
        whole, parts = (world.image().astype(int) for world in worlds)
        different = np.abs(whole - parts).max(axis=2) > 2
        off += different.sum()
        least = min(least, np.corrcoef(whole.ravel(), parts.ravel())[0, 1])
    assert off < 1e-4 * FRAMES * whole[..., 0].size
    assert least > 0.999
    assert sum(sizes) < 0.7 * FRAMES * whole[..., 0].size
    assert len(sizes) < FRAMES  # nothing is drawn while nothing moves


def test_what_leaves_a_place_is_gone_from_there(worlds):
    """An object that is put elsewhere at once is seen there, and not where it was."""
    for world in worlds:
        world.reset(np.random.SeedSequence(4))
        world.image()
        world.data.mocap_pos[-1] += (0.0, 0.1, 0.0)
        world.step(np.zeros(2))
    whole, parts = (world.image().astype(int) for world in worlds)
    assert (np.abs(whole - parts).max(axis=2) > 2).sum() < 10


@pytest.mark.parametrize("way", ["state", "pickle"])
def test_goes_on_to_the_bit(worlds, way):
    world = worlds[1]
    world.reset(np.random.SeedSequence(5))
    steps = list(commands())
    for command in steps[:100]:
        world.step(command)
        world.image()
    state, copied = world.get_state(), pickle.loads(pickle.dumps(world))

    def rest(world):
        images = []
        for command in steps[100:160]:
            world.step(command)
            images.append(world.image().copy())
        return np.array(images)

    first = rest(world)
    if way == "state":
        world.set_state(state)
        copied.close()
        assert (rest(world) == first).all()
    else:
        assert (rest(copied) == first).all()
        copied.close()


def test_noise_of_one_image_is_not_in_the_next():
    noisy = Conditions(sensor=Sensor(noise=4.0))
    worlds = [World.build(WorldConfig(draws=draws), np.random.SeedSequence(3), noisy) for draws in ("all", "changes")]
    for _ in range(30):
        for world in worlds:
            world.step(np.zeros(2))
        whole, parts = (world.image().astype(int) for world in worlds)
    assert (np.abs(whole - parts).max(axis=2) > 2).sum() < 10
    for world in worlds:
        world.close()


def test_shadows_move_with_what_casts_them():
    """They fall on what has not moved itself."""
    fine = SceneConfig(quality="high")
    worlds = [World.build(WorldConfig(fine, draws=draws), np.random.SeedSequence(3)) for draws in ("all", "changes")]
    for frame in range(60):
        for world in worlds:
            world.step(np.zeros(2))
        if frame % 10 == 0:
            whole, parts = (world.image() for world in worlds)
            np.testing.assert_array_equal(whole, parts)
    for world in worlds:
        world.close()


def test_objects_that_have_grown_are_drawn_as_far_as_they_reach():
    small, large = (SceneConfig(object_size=size) for size in (0.02, 0.1))
    worlds = [World.build(WorldConfig(small, draws=draws), np.random.SeedSequence(3)) for draws in ("all", "changes")]
    for world in worlds:
        world.vary(WorldConfig(large, draws=world.config.draws), world.conditions)
        world.reset(np.random.SeedSequence(4))
    for _ in range(FRAMES):
        for world in worlds:
            world.step(np.zeros(2))
        whole, parts = (world.image().astype(int) for world in worlds)
        assert (np.abs(whole - parts).max(axis=2) > 8).sum() < 10
    for world in worlds:
        world.close()


def test_a_forged_state_is_refused(worlds):
    eye = worlds[1].eye
    with pytest.raises(ValueError, match="eye's image"):
        eye.set_state({**eye.get_state(), "image": np.zeros((2, 2, 3), np.uint8)})


def test_other_looks_are_drawn_whole(worlds, monkeypatch):
    world = worlds[1]
    world.reset(np.random.SeedSequence(6))
    world.image()
    world.step(np.zeros(2))
    world.vary(world.config, Conditions(sensor=Sensor(brightness=0.5)))
    sizes = counted(world, monkeypatch)
    world._image = None
    world.image()
    assert sizes == [240 * 320]


def test_a_head_that_has_come_to_rest_stands_still(worlds, monkeypatch):
    """Its servos creep on by less than a tenth of a milliradian."""
    world, command = worlds[1], np.array([0.3, -0.2])
    world.reset(np.random.SeedSequence(4))
    world.step(command)
    while world.head_moves():
        world.step(command)
    world.image()
    rest, sizes = world.head_angles(), counted(world, monkeypatch)
    for _ in range(5):
        world.step(command)
        world.image()
    assert not np.array_equal(world.head_angles(), rest)
    assert sizes == []  # nor does the caregiver move, who greets


def test_the_eye_of_a_closed_world():
    world = World.build(WorldConfig(draws="changes"), np.random.SeedSequence(3))
    world.image()
    eye = world.eye
    world.close()
    with pytest.raises(ClosedError):
        eye.render()
