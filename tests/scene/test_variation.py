"""Domain randomisation: each option changes what it names and nothing else; a seed decides all; off changes nothing."""

import pickle
from dataclasses import fields, replace

import mujoco
import numpy as np
import pytest

from jointattn_mj.errors import ConfigError
from jointattn_mj.scene.caregiver import DURATIONS
from jointattn_mj.scene.dressing import Conditions, Lamp, Surfaces
from jointattn_mj.scene.model import SceneConfig
from jointattn_mj.scene.objects import OBJECTS, SHAPES
from jointattn_mj.scene.variation import PRESETS, VariationConfig, drawn, variation_of
from jointattn_mj.scene.world import AS_USUAL, World, WorldConfig

SEED = np.random.SeedSequence(3, spawn_key=(5,))
WIDE = replace(PRESETS["all"], object_shapes=SHAPES, camera_delay=30)
OPTIONS = tuple(option.name for option in fields(VariationConfig))
CHANGES = {
    "light_angle_deg": {"lamp.azimuth_deg", "lamp.elevation_deg"},
    "light_strength": {"lamp.direct", "lamp.ambient"},
    "light_tint": {"lamp.direct", "lamp.ambient"},
    "surface_colours": {"surfaces.table", "surfaces.wall", "surfaces.floor", "surfaces.clothes"},
    "textures": {"surfaces.contrast", "surfaces.seed"},
    "people": {"scene.caregiver"},
    "camera_noise": {"sensor.noise", "sensor.seed"},
    "camera_brightness": {"sensor.brightness"},
    "camera_delay": {"sensor.delay"},
    "object_shapes": {"scene.shapes"},
    "object_size": {"scene.object_size"},
    "object_hue_deg": {"scene.rgb"},
    "object_shade": {"scene.rgb"},
    "layout": {"layout.x_range", "layout.y_range"},
    "pace": {f"behaviour.{name}" for name in DURATIONS},
}


def only(option: str) -> VariationConfig:
    return VariationConfig(**{option: getattr(WIDE, option)})


def flat(ranges: VariationConfig, seed: np.random.SeedSequence = SEED) -> dict:
    """Everything that was drawn, by name."""
    world, conditions = drawn(WorldConfig(), ranges, seed)
    parts = {"scene": world.scene, "behaviour": world.behaviour, "layout": world.layout}
    parts |= {"lamp": conditions.lamp, "surfaces": conditions.surfaces, "sensor": conditions.sensor}
    values = {f"{name}.{f.name}": getattr(part, f.name) for name, part in parts.items() for f in fields(part)}
    objects = values.pop("scene.objects")
    assert [item.name for item in objects] == [item.name for item in OBJECTS[:4]]
    return values | {"scene.rgb": [item.rgb for item in objects], "scene.shapes": [item.shape for item in objects]}


def different(before: dict, after: dict) -> set[str]:
    return {name for name in before if before[name] != after[name]}


def still_image(config: WorldConfig, conditions=AS_USUAL) -> np.ndarray:
    world = World.build(config, np.random.SeedSequence(0), conditions)
    image = world.image().copy()
    world.close()
    return image


def test_every_option_is_listed():
    assert set(CHANGES) == set(OPTIONS)
    assert all(getattr(PRESETS["all"], option) for option in OPTIONS)


@pytest.mark.parametrize("option", OPTIONS)
def test_an_option_changes_what_it_names_and_nothing_else(option):
    seeds = [np.random.SeedSequence(number) for number in range(12)]
    changed = set().union(*(different(flat(VariationConfig(), seed), flat(only(option), seed)) for seed in seeds))
    assert changed == CHANGES[option]


@pytest.mark.parametrize("option", OPTIONS)
def test_switching_an_option_off_leaves_the_draws_of_others(option):
    without = replace(WIDE, **{option: getattr(VariationConfig(), option)})
    assert different(flat(WIDE), flat(without)) <= CHANGES[option]


def test_a_wider_range_stretches_the_same_draws():
    narrow, wide = (flat(VariationConfig(light_angle_deg=angle)) for angle in (10, 20))
    assert wide["lamp.azimuth_deg"] == pytest.approx(2 * narrow["lamp.azimuth_deg"])


def test_draws_keep_to_their_ranges_and_fill_them():
    draws = [flat(WIDE, np.random.SeedSequence(number)) for number in range(300)]

    def reach(name):
        values = np.array([draw[name] for draw in draws], float)
        return values.min(), values.max()

    for name, low, high in (
        ("lamp.azimuth_deg", -WIDE.light_angle_deg, WIDE.light_angle_deg),
        ("surfaces.wall", 1 - WIDE.surface_colours, 1 + WIDE.surface_colours),
        ("surfaces.contrast", 0, WIDE.textures),
        ("sensor.noise", 0, WIDE.camera_noise),
        ("sensor.delay", 0, 30),
        ("scene.object_size", 0.06 * (1 - WIDE.object_size), 0.06 * (1 + WIDE.object_size)),
        ("behaviour.gaze_s", 2 * (1 - WIDE.pace), 2 * (1 + WIDE.pace)),
    ):
        least, most = reach(name)
        assert low <= least < low + 0.05 * (high - low), name
        assert high >= most > high - 0.05 * (high - low), name
    assert {draw["scene.caregiver"] for draw in draws} == set(WIDE.people)
    assert {shape for draw in draws for shape in draw["scene.shapes"]} == set(SHAPES)
    for draw in draws:
        assert draw["layout.x_range"][0] >= 0.90 and draw["layout.x_range"][1] <= 1.12


def test_a_draw_leaves_its_seed_as_it_was():
    seed = np.random.SeedSequence(1)
    first, second, third = flat(WIDE, seed), flat(WIDE, seed), flat(WIDE, np.random.SeedSequence(2))
    assert first == second != third
    assert seed.n_children_spawned == 0


def test_objects_that_look_alike_go_on_looking_alike():
    twins = tuple(replace(OBJECTS[0], name=name) for name in ("one", "two"))
    world, _ = drawn(WorldConfig(scene=SceneConfig(objects=(*twins, OBJECTS[2]))), WIDE, SEED)
    red, two, other = world.scene.objects
    assert (red.rgb, red.shape) == (two.rgb, two.shape)
    assert red.rgb != OBJECTS[0].rgb
    assert other.rgb not in (red.rgb, OBJECTS[2].rgb)


def test_nothing_to_vary_is_the_world_itself():
    config = WorldConfig()
    world, conditions = drawn(config, VariationConfig(), SEED)
    assert world is config
    assert conditions == AS_USUAL


def test_a_varied_world_is_drawn_and_moved_as_asked():
    asked = WorldConfig(draws="changes", renderer="warp", dynamics="closed_form")
    world, _ = drawn(asked, WIDE, SEED)
    assert world.scene != asked.scene
    assert (world.draws, world.renderer, world.dynamics) == ("changes", "warp", "closed_form")


def test_presets_by_name():
    assert variation_of("none") == VariationConfig()
    assert variation_of("lights+pace") == replace(PRESETS["lights"], pace=PRESETS["pace"].pace)
    assert variation_of(WIDE) is WIDE
    with pytest.raises(ConfigError, match="lights"):
        variation_of("lights+darkness")


@pytest.mark.parametrize(
    "wrong",
    [
        {"light_strength": -0.1}, {"pace": 1.0}, {"textures": 1.5}, {"camera_delay": 99}, {"camera_delay": 1.5},
        {"people": ("nobody",)}, {"object_shapes": ("cone",)}, {"people": "robin"}, {"layout": float("nan")},
    ],
)  # fmt: skip
def test_what_cannot_work_is_an_error(wrong):
    with pytest.raises(ConfigError, match=next(iter(wrong))):
        VariationConfig(**wrong)


@pytest.mark.parametrize("name", ["lights", "objects", "textures", "camera"])
def test_a_world_that_was_dressed_shows_what_one_compiled_so_shows(name):
    """And, dressed as usual again, what it showed at first."""
    ranges = PRESETS[name]
    config, conditions = drawn(WorldConfig(), ranges, SEED)
    seed = np.random.SeedSequence(0)
    first = drawn(WorldConfig(), ranges, np.random.SeedSequence(9)) if ranges.textures else (WorldConfig(), AS_USUAL)
    world = World.build(first[0], seed, first[1])
    before = world.image().copy()
    world.vary(config, conditions)
    world.reset(seed)
    np.testing.assert_array_equal(world.image(), still_image(config, conditions))
    assert np.abs(world.image().astype(int) - before).mean() > 0.1
    world.vary(*first)
    world.reset(seed)
    np.testing.assert_array_equal(world.image(), before)
    world.close()


def test_dressed_objects_are_as_compiled_ones():
    """All that concerns geoms; only the weight of what is nobody's to lift stays."""
    config, conditions = drawn(WorldConfig(), PRESETS["objects"], SEED)
    dressed = World.build(WorldConfig(), SEED)
    dressed.vary(config, conditions)
    compiled = World.build(config, SEED)
    for name in ("geom_type", "geom_size", "geom_rbound", "geom_aabb", "geom_rgba", "mat_rgba", "light_dir"):
        mine, other = getattr(dressed.model, name), getattr(compiled.model, name)
        np.testing.assert_allclose(mine, other, rtol=1e-12, err_msg=name)
    dressed.close(), compiled.close()


def test_objects_of_any_size_stand_on_the_table():
    for number in range(6):
        config, conditions = drawn(WorldConfig(), PRESETS["objects"], np.random.SeedSequence(number))
        world = World.build(config, SEED, conditions)
        heights = world.caregiver.objects[:, 2] - config.scene.object_size / 2
        np.testing.assert_allclose(heights, 0.711, atol=1e-9)
        world.close()


def test_a_pickled_varied_world_goes_on_as_it_would_have():
    config, conditions = drawn(WorldConfig(), replace(PRESETS["all"], camera_delay=6), SEED)
    world = World.build(config, SEED, conditions)
    for _ in range(20):
        world.step(np.array([0.2, -0.1]))
    other = pickle.loads(pickle.dumps(world))
    for _ in range(3):
        np.testing.assert_array_equal(other.image(), world.image())
        world.step(np.zeros(2)), other.step(np.zeros(2))
    world.close(), other.close()


def test_patterns_need_textures():
    config, conditions = drawn(WorldConfig(), PRESETS["textures"], SEED)
    world = World.build(WorldConfig(), SEED)
    with pytest.raises(ConfigError, match="blank"):
        world.vary(config, conditions)
    world.close()


def test_the_lamp_stays_above_the_table():
    for number in range(40):
        config, conditions = drawn(WorldConfig(), VariationConfig(light_angle_deg=90), np.random.SeedSequence(number))
        if number == 0:
            world = World.build(config, SEED, conditions)
        world.vary(config, conditions)
        direction = world.model.light_dir[0]
        assert np.linalg.norm(direction) == pytest.approx(1)
        assert direction[2] <= -np.sin(np.radians(9.9))
    assert world.model.light_type[0] == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    world.close()


def test_options_have_nothing_to_do_with_each_other():
    """Their streams are not one and the same."""
    draws = [flat(WIDE, np.random.SeedSequence(number)) for number in range(200)]
    names = ("lamp.azimuth_deg", "behaviour.gaze_s", "sensor.brightness", "scene.object_size", "surfaces.contrast")
    table = np.corrcoef([[draw[name] for draw in draws] for name in names])
    assert np.abs(table - np.eye(len(names))).max() < 0.25


def test_light_and_colours_are_factors():
    lamp = Lamp(direct=(0.5, 1.0, 1.5), ambient=(1.5, 1.0, 0.5))
    surfaces = Surfaces(table=(0.9, 1.0, 1.1), clothes=(0.5, 0.5, 0.5))
    usual, varied = (World.build(WorldConfig(), SEED, it) for it in (AS_USUAL, Conditions(lamp, surfaces)))
    np.testing.assert_allclose(varied.model.light_diffuse[0], usual.model.light_diffuse[0] * lamp.direct, rtol=1e-6)
    np.testing.assert_allclose(varied.model.light_ambient[0], usual.model.light_ambient[0] * lamp.ambient, rtol=1e-6)
    np.testing.assert_array_equal(varied.model.light_dir, usual.model.light_dir)
    for name, factors in (("room/table", surfaces.table), ("caregiver/cloth", surfaces.clothes), ("room/wall", 1)):
        expected = usual.model.material(name).rgba[:3] * factors
        np.testing.assert_allclose(varied.model.material(name).rgba[:3], expected, rtol=1e-6)
    usual.close(), varied.close()
