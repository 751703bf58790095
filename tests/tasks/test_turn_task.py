"""Turn-taking as a 3D scene: it is the table of chapters 4 and 5, and bodies stand as the table says."""

import numpy as np
import pytest

from jointattn_mj.development.table.world import CAREGIVER, ROBOT, TableConfig, new_table, step
from jointattn_mj.errors import ConfigError
from jointattn_mj.scene.looker import spot_positions
from jointattn_mj.scene.model import SceneConfig
from jointattn_mj.tasks import load

FORMS = ("turn_taking", "turn_taking_hard")


@pytest.fixture(params=FORMS)
def environment(request):
    made = load("joint_attention", request.param, task_kwargs={"camera": False, "truth": True, "random": 2})
    yield made
    made.close()


def actions(environment, count: int) -> np.ndarray:
    spec = environment.action_spec()
    return np.random.default_rng(1).integers(spec.minimum, spec.maximum + 1, (count, 2))


def test_it_is_the_table(environment):
    """The same sensors and results, step after step, as in a run at the table."""
    timestep = environment.reset()
    (seed,) = np.random.SeedSequence(2).spawn(1)
    table = new_table(environment.task.table_config, seed)
    s, r = (np.zeros_like(timestep.observation[name]) for name in ("sensors", "results"))
    step(table, np.zeros(2, np.int64), s, r)
    for action in actions(environment, 100):
        np.testing.assert_array_equal(timestep.observation["sensors"], s)
        np.testing.assert_array_equal(timestep.observation["results"], r)
        timestep = environment.step(action)
        step(table, action, s, r)


def test_bodies_stand_as_the_table_says(environment):
    """Objects on full spots, the robot's gaze on its spot within .1 degrees, the caregiver's nearest to its spot."""
    environment.reset()
    task, physics = environment.task, environment.physics
    spots = spot_positions(task.table_config.spots, task.world.config.scene)
    for action in (None, *actions(environment, 60)):
        if action is not None:
            environment.step(action)
        lying = [position for position in physics.object_positions() if position[2] > 0]
        full = {tuple(np.round(position, 6)) for position in spots[task.table.full]}
        assert {tuple(np.round(position, 6)) for position in lying} == full
        targets = np.vstack([spots, physics.face_position()])
        origin, ahead = physics.robot_sight()
        to_target = targets[task.table.state[ROBOT]] - origin
        assert ahead @ to_target / np.linalg.norm(to_target) > np.cos(np.radians(0.1))
        looks_at = task.table.state[CAREGIVER]
        origin, ahead = physics.caregiver_sight()
        if looks_at == len(spots):
            assert physics.caregiver_fixates() == len(physics.object_names)
        else:
            directions = (spots - origin) / np.linalg.norm(spots - origin, axis=1, keepdims=True)
            assert np.argmax(directions @ ahead) == looks_at


def test_kinds_are_seen(environment):
    environment.reset()
    task = environment.task
    names = environment.physics.object_names
    if task.table_config.kinds == 1:
        rgba = [environment.physics.named.model.geom_rgba[f"object/{name}"] for name in names]
        assert len(names) == 2
        np.testing.assert_array_equal(*rgba)
        return
    spots = spot_positions(task.table_config.spots, task.world.config.scene)
    for spot in np.flatnonzero(task.table.full):
        thing = names[task.table.kind[spot]]
        np.testing.assert_allclose(environment.physics.named.data.xpos[f"object/{thing}"], spots[spot])


def test_reward_is_joint_attention_by_either(environment):
    """For an object that one looked at when the other turned to it."""
    environment.reset()
    table, face = environment.task.table, environment.task.table_config.spots
    kinds = set()
    for action in actions(environment, 300):
        full, looked_at = table.full.copy(), table.state[CAREGIVER]
        reward = environment.step(action).reward
        follows = action[0] == looked_at != face and full[action[0]]
        led = action[0] == table.state[CAREGIVER] != face and table.full[action[0]]
        assert reward == float(follows or led)
        kinds.add((bool(follows), bool(led)))
    assert len(kinds) >= 3


def test_eye_contact_is_not_rewarded():
    environment = load("joint_attention", "turn_taking", task_kwargs={"camera": False, "random": 0})
    environment.reset()
    assert not any(environment.step([3, 0]).reward for _ in range(50))
    assert environment.physics.robot_fixates() == environment.physics.caregiver_fixates() == 2


def test_gestures_change_nothing():
    states = []
    for gesture in (0, 3):
        environment = load("joint_attention", "turn_taking", task_kwargs={"camera": False, "random": 0})
        environment.reset()
        for spot in (0, 1, 3, 2):
            environment.step([spot, gesture])
        states.append(environment.physics.get_state())
    np.testing.assert_array_equal(*states)


def test_a_step_lasts_a_second_and_shows_one_image():
    environment = load("joint_attention", "turn_taking", task_kwargs={"random": 0})
    environment.reset()
    for _ in range(5):
        environment.step([3, 0])
    assert environment.physics.time() == pytest.approx(5.0)
    assert environment.task.world.rendered_frames == 6
    environment.close()


def test_numbers_that_are_not_whole_or_too_large_are_taken_for_the_nearest():
    environment = load("joint_attention", "turn_taking", task_kwargs={"camera": False})
    environment.reset()
    for given, meant in ((1.4, 1), (1.6, 2), (-7, 0), (99, 3)):
        environment.step(np.array([given, 0.0]))
        assert environment.task.table.state[ROBOT] == meant


def test_more_kinds_than_can_be_shown():
    with pytest.raises(ConfigError, match="10 kinds"):
        load("joint_attention", "turn_taking", task_kwargs={"table": TableConfig(kinds=11)})


@pytest.mark.parametrize("count", [2, 3, 9])
def test_spots_are_apart(count):
    spots = spot_positions(count, SceneConfig())
    assert spots.shape == (count, 3)
    assert np.diff(spots[:, 1]).max() < -0.08
    assert np.abs(spots[:, 1]).max() <= 0.36
