"""The table with bodies: they stand as the table says, within what bodies can do."""

from dataclasses import replace

import numpy as np
import pytest

from jointattn_mj.development.rendered.stage import Stage, StageConfig
from jointattn_mj.development.table.world import CAREGIVER, ROBOT, TableConfig, step
from jointattn_mj.errors import ConfigError
from jointattn_mj.scene.looker import spot_positions
from jointattn_mj.scene.movement import gaze_angles

EXACT = StageConfig(variation="none", object_jitter_m=0, head_jitter_deg=0, motor_noise_deg=0)


def n_steps(config: StageConfig, count: int):
    """Acts out ``count`` turns of a robot that moves at random; yields the stage after each."""
    stage = Stage(TableConfig(), config, np.random.SeedSequence(1))
    stage.begin(np.random.SeedSequence(7))
    heads, rng = np.vstack([stage.locations, [0.0, 0.05]]), np.random.default_rng(3)
    for _ in range(count):
        action = rng.integers((4, 4))
        step(stage.table, action, stage.sensors, stage.results)
        stage.show(int(action[1]), heads)
        stage.wanted = heads[stage.table.state[ROBOT]]
        yield stage
    stage.world.close()


def test_bodies_do_what_the_table_says():
    spots = spot_positions(3, EXACT.world.scene)
    for stage in n_steps(EXACT, 40):
        table, world = stage.table, stage.world
        lying = world.caregiver.objects[world.caregiver.objects[:, 2] > 0]
        assert {tuple(row) for row in lying} == {tuple(row) for row in spots[table.full]}
        np.testing.assert_array_equal(world.head_angles(), stage.wanted)
        looks_at = table.state[CAREGIVER]
        own = (spots[min(looks_at, 2)] - [1.5, 0, 0]) * [-1, -1, 1]
        gaze = np.zeros(2) if looks_at == 3 else gaze_angles(np.array([0.0, 0.0, 1.08]), own)
        np.testing.assert_allclose(world.face_angles(), 0.85 * gaze, atol=1e-9)


def test_imprecision_is_as_large_as_asked_for():
    config, spots = StageConfig(variation="none"), spot_positions(3, EXACT.world.scene)
    heads, own, objects, eyes = [], [], [], []
    for stage, exact in zip(n_steps(config, 400), n_steps(EXACT, 400), strict=True):
        heads.append(stage.world.face_angles() - exact.world.face_angles())
        own.append(stage.world.head_angles() - stage.wanted)
        for location in stage.world.caregiver.objects[stage.world.caregiver.objects[:, 2] > 0]:
            objects.append(np.abs(spots - location)[:, :2].max(axis=1).min())
        eyes.append(stage.world.data.body("caregiver/eye_left").xmat - exact.world.data.body("caregiver/eye_left").xmat)
    assert np.std(heads) == pytest.approx(np.radians(2.0), rel=0.1)
    assert np.std(own) == pytest.approx(np.radians(0.5), rel=0.1)
    assert 0.015 < np.max(objects) <= 0.02
    assert np.abs(eyes).max() < 0.05  # the eyes make up for the head: the gaze is right


def test_objects_have_colours_of_their_own_and_change_them_about():
    visible = {tuple(stage.world.caregiver.objects[:, 1].argsort()) for stage in n_steps(StageConfig(), 200)}
    assert len(visible) == 2


def test_a_seed_is_a_person_and_a_light():
    people = set()
    for seed in range(8):
        stage = Stage(TableConfig(), StageConfig(), np.random.SeedSequence(seed))
        people.add(stage.world.config.scene.caregiver)
        stage.world.close()
    assert len(people) > 2


def test_the_hand_gestures():
    pitches = {}
    for stage in n_steps(EXACT, 30):
        pitches[stage._gesture] = stage.world.data.body("robot/forearm").xquat[2]
    assert len(set(np.round(list(pitches.values()), 6))) == 4


@pytest.mark.parametrize("table", [TableConfig(kinds=3), TableConfig(order="robot_first")])
def test_tables_that_images_cannot_show(table):
    with pytest.raises(ConfigError, match="kinds 1 and"):
        Stage(table, StageConfig(), np.random.SeedSequence(0))


@pytest.mark.parametrize("wrong", [{"variation": "fog"}, {"head_jitter_deg": -1.0}, {"object_jitter_m": 1.0}])
def test_options_that_cannot_work(wrong):
    with pytest.raises(ConfigError):
        replace(StageConfig(), **wrong)
