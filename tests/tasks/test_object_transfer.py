"""The table at which a caregiver handles objects: its world, its geometry, its reward."""

import numpy as np
import pytest
from dm_control.mujoco.engine import MovableCamera

from jointattn_mj.scene.camera import directions_to
from jointattn_mj.scene.caregiver import Phase
from jointattn_mj.scene.model import SceneConfig
from jointattn_mj.scene.world import World, WorldConfig
from jointattn_mj.tasks import load
from jointattn_mj.tasks.environment import LENS_LIT, LENS_RGBA

pytestmark = pytest.mark.integration

DOMAIN = ("joint_attention", "object_transfer")
BLIND = {"camera": False}


def blind(seed: int = 0, **environment_kwargs):
    """The task without images."""
    return load(*DOMAIN, task_kwargs=BLIND | {"random": seed}, environment_kwargs=environment_kwargs)


def random_actions(environment, count: int, seed: int = 0) -> np.ndarray:
    spec = environment.action_spec()
    return np.random.default_rng(seed).uniform(spec.minimum, spec.maximum, (count, *spec.shape))


def look_at(environment, target: int) -> None:
    """Turn the robot's head towards a target at once, the caregiver standing still."""
    physics = environment.physics
    points = np.vstack([physics.object_positions(), physics.face_position()])
    physics.named.data.qpos[["robot/pan", "robot/tilt"]] = np.radians(directions_to(points)[target])
    physics.forward()


def test_the_usual_episode_lasts_a_minute():
    environment = blind()
    environment.reset()
    steps = 1
    while not environment.step(np.zeros(2)).last():
        steps += 1
    assert steps == 1800


def test_one_task_is_one_world():
    """The environment's physics does the very steps that ``World.step`` does."""
    environment = load(*DOMAIN, task_kwargs={"random": 7})
    environment.reset()
    (seed,) = np.random.SeedSequence(7).spawn(1)
    world = World.build(WorldConfig(), seed)
    for i, action in enumerate(random_actions(environment, 600)):
        step = environment.step(action)
        world.step(action)
        for name in ("qpos", "qvel", "mocap_pos", "xpos", "site_xpos"):
            np.testing.assert_array_equal(getattr(environment.physics.data, name), getattr(world.data, name), name)
        np.testing.assert_array_equal(step.observation["head_angles"], world.head_angles())
        assert step.observation["head_moves"] == world.head_moves()
        if i % 100 == 0:
            np.testing.assert_array_equal(step.observation["camera"], world.image())
    environment.close()
    world.close()


def test_without_camera_nothing_is_rendered():
    environment = blind()
    step = environment.reset()
    environment.step(np.zeros(2))
    assert list(step.observation) == list(environment.observation_spec()) == ["head_angles", "head_moves"]
    assert environment.task.world.rendered_frames == 0


def test_one_image_a_step():
    environment = load(*DOMAIN)
    environment.reset()
    for _ in range(5):
        environment.step(np.zeros(2))
    assert environment.task.world.rendered_frames == 6
    environment.close()


def test_physics_renders_for_others_too():
    environment = load(*DOMAIN)
    camera = environment.reset().observation["camera"]
    third = environment.physics.render(camera_id="third_person")
    assert third.shape == (240, 320, 3)
    assert third.std() > 10
    np.testing.assert_array_equal(environment.physics.render(camera_id="robot/eye"), camera)
    assert MovableCamera(environment.physics, 120, 160).render().shape == (120, 160, 3)
    np.testing.assert_array_equal(environment.task.get_observation(environment.physics)["camera"], camera)
    environment.close()


def episode_return(environment, policy) -> float:
    step, total = environment.reset(), 0.0
    while not step.last():
        step = environment.step(policy(environment))
        total += step.reward or 0.0
    return total / 1800


def test_an_oracle_earns_more_than_chance():
    def oracle(environment):
        target = environment.task.world.caregiver.target
        points = environment.physics.object_positions()
        return np.zeros(2) if target is None else np.radians(directions_to(points)[target])

    rng = np.random.default_rng(0)

    def at_random(environment):
        spec = environment.action_spec()
        return rng.uniform(spec.minimum, spec.maximum)

    environment = blind()
    best = episode_return(environment, oracle)
    assert best > 0.7  # the rest is greeting and turning
    assert episode_return(environment, lambda _: np.zeros(2)) < 0.1
    assert episode_return(environment, at_random) < 0.1
    assert best <= 1


@pytest.mark.parametrize("target", range(5))
def test_the_robot_fixates_what_it_is_turned_to(target):
    environment = blind()
    environment.reset()
    look_at(environment, target)
    physics = environment.physics
    assert physics.robot_fixates() == target
    assert physics.robot_to_targets()[target] < 1e-6
    assert physics.in_view()[target]
    assert not physics.joint_attention()  # the caregiver still greets


def test_nothing_within_the_radius_is_nothing_fixated():
    environment = blind()
    environment.reset()
    physics = environment.physics
    physics.named.data.qpos[["robot/pan", "robot/tilt"]] = np.radians([100.0, 10.0])
    physics.forward()
    assert physics.robot_fixates() is None
    assert physics.robot_fixates(radius=np.pi) is not None
    assert not physics.in_view().any()
    assert not physics.joint_attention()


def test_the_caregiver_fixates_the_target():
    environment = blind(seed=5)
    environment.reset()
    physics, caregiver = environment.physics, environment.task.world.caregiver
    assert physics.caregiver_fixates() == len(physics.object_names)  # greeting: it is the robot
    right = wrong = 0
    for _ in range(900):
        environment.step(np.zeros(2))
        if caregiver.phase not in (Phase.GREET, Phase.TURN):
            right += physics.caregiver_fixates() == caregiver.target
            wrong += physics.caregiver_fixates() != caregiver.target
    assert right > 500
    assert wrong < 0.01 * right


def test_both_at_the_same_object_is_rewarded():
    environment = blind(seed=2)
    environment.reset()
    while environment.task.world.caregiver.phase != Phase.REACH:
        environment.step(np.zeros(2))
    look_at(environment, environment.task.world.caregiver.target)
    assert environment.task.get_reward(environment.physics) == 1.0
    other = (environment.task.world.caregiver.target + 1) % 4
    look_at(environment, other)
    assert environment.task.get_reward(environment.physics) == 0.0


def test_a_copy_of_the_physics_answers_too():
    environment = blind()
    environment.reset()
    copy = environment.physics.copy()
    assert copy.object_names == ("red", "yellow", "blue", "green")
    np.testing.assert_array_equal(copy.robot_to_targets(), environment.physics.robot_to_targets())
    np.testing.assert_array_equal(copy.caregiver_to_targets(), environment.physics.caregiver_to_targets())


def test_the_table_is_within_reach_of_the_action():
    environment = blind()
    low, high = np.degrees(environment.action_spec().minimum), np.degrees(environment.action_spec().maximum)
    corners = np.array([(x, y, 0.741) for x in (0.90, 1.12) for y in (-0.36, 0.36)] + [(1.5, 0, 1.08)])
    directions = directions_to(corners)
    assert np.all((directions > low + 5) & (directions < high - 5))


def test_reward_can_be_seen_from_outside_and_not_by_the_robot():
    lit, plain = (load(*DOMAIN, task_kwargs={"random": 2}, visualize_reward=shown) for shown in (True, False))
    lit.reset(), plain.reset()
    rewarded = colours = 0
    for _ in range(120):
        target = lit.task.world.caregiver.target
        action = np.zeros(2) if target is None else np.radians(directions_to(lit.physics.object_positions())[target])
        bright, dim = lit.step(action), plain.step(action)
        green = np.allclose(lit.physics.named.model.geom_rgba["robot/lens_left"], LENS_LIT)
        assert green == bool(bright.reward)
        rewarded, colours = rewarded + bool(bright.reward), colours + green
        np.testing.assert_array_equal(bright.observation["camera"], dim.observation["camera"])
    assert rewarded > 10
    assert np.allclose(plain.physics.named.model.geom_rgba["robot/lens_left"], LENS_RGBA)
    lit.close(), plain.close()


def test_another_world():
    world = WorldConfig(scene=SceneConfig(objects=SceneConfig().objects[:2]))
    environment = load(*DOMAIN, task_kwargs=BLIND | {"world": world})
    environment.reset()
    assert environment.physics.object_names == ("red", "yellow")
    assert environment.physics.robot_to_targets().shape == (3,)
