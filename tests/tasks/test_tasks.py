"""Every task of the suite: dm_env's own conformance tests, determinism, memory, rewards, and dm_control's wrappers."""

import doctest
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from absl.testing import absltest
from dm_control.suite.wrappers import action_noise, action_scale, pixels
from dm_env import StepType, test_utils

import jointattn_mj
from jointattn_mj import tasks
from jointattn_mj.errors import ConfigError
from jointattn_mj.tasks import ALL_TASKS, BENCHMARKING, EASY, HARD, TASKS_BY_DOMAIN, joint_attention, load, tagged

pytestmark = pytest.mark.integration

every_task = pytest.mark.parametrize(("domain", "task"), ALL_TASKS, ids=lambda name: name)
STEPS = 40


@pytest.fixture(scope="module")
def blind():
    """Gives each task without images, made once and begun anew with a seed."""
    made = {}

    def give(domain, task, seed=0):
        if task not in made:
            made[task] = load(domain, task, task_kwargs={"camera": False, "truth": True})
        made[task].task.seed(seed)
        return made[task]

    yield give
    for environment in made.values():
        environment.close()


def random_actions(environment, count: int, seed: int = 0) -> np.ndarray:
    spec = environment.action_spec()
    chosen = np.random.default_rng(seed).uniform(spec.minimum, spec.maximum + (spec.dtype == int), (count, *spec.shape))
    return chosen.astype(spec.dtype)


def conformance(task: str):
    """dm_env's own tests of a task, over the end of an episode."""

    class Conformance(test_utils.EnvironmentTestMixin, absltest.TestCase):
        def make_object_under_test(self):
            time_limit = 4.0 if "turn" in task else 0.4
            return load("joint_attention", task, environment_kwargs={"time_limit": time_limit, **self.more})

        more = {}  # noqa: RUF012

    return Conformance


class ObjectTransferTest(conformance("object_transfer")):
    """Of the task that lasts longest."""


class FollowHardTest(conformance("follow_hard")):
    """Of the one in which physics changes from episode to episode."""


class TurnTakingTest(conformance("turn_taking")):
    """Of the one whose actions are whole numbers."""


class FlatObservationTest(conformance("turn_taking")):
    """With all observations in one array."""

    more = {"flat_observation": True}  # noqa: RUF012


@every_task
def test_specs_and_observations(domain, task):
    environment = load(domain, task, task_kwargs={"random": 1, "truth": True})
    spec = environment.observation_spec()
    step = environment.reset()
    assert list(step.observation) == list(spec)
    for action in random_actions(environment, 3):
        environment.action_spec().validate(action)
        step = environment.step(action)
        for name, value in step.observation.items():
            spec[name].validate(value)
            assert np.isfinite(value).all()
    environment.close()


@every_task
def test_truth_only_where_asked_for(domain, task):
    environment = load(domain, task, task_kwargs={"random": 1})
    asked = load(domain, task, task_kwargs={"random": 1, "truth": True, "camera": False})
    known = set(environment.reset().observation)
    assert known <= {"camera", "head_angles", "head_moves"}
    assert set(asked.reset().observation) - known
    environment.close(), asked.close()


@every_task
def test_same_seed_same_episode(domain, task):
    first, second = (load(domain, task, task_kwargs={"random": 7, "truth": True}) for _ in range(2))
    for _ in range(2):
        own, other = first.reset(), second.reset()
        for action in random_actions(first, 10):
            for name in own.observation:
                np.testing.assert_array_equal(own.observation[name], other.observation[name])
            own, other = first.step(action), second.step(action)
            assert own.reward == other.reward
    np.testing.assert_array_equal(first.physics.get_state(), second.physics.get_state())
    first.close(), second.close()


@every_task
def test_another_seed_another_episode(blind, domain, task):
    states = []
    for seed in (1, 2, 1):
        environment = blind(domain, task, seed)
        environment.reset()
        for action in random_actions(environment, 5):
            environment.step(action)
        states.append(np.append(environment.physics.data.mocap_pos.ravel(), environment.physics.data.qpos))
    assert not np.array_equal(states[0], states[1])
    np.testing.assert_array_equal(states[0], states[2])


@every_task
def test_observations_share_no_memory(domain, task):
    environment = load(domain, task, task_kwargs={"truth": True})
    steps = [environment.reset(), *(environment.step(action) for action in random_actions(environment, 2))]
    for name in steps[0].observation:
        arrays = [step.observation[name] for step in steps]
        assert not any(np.shares_memory(a, b) for i, a in enumerate(arrays) for b in arrays[:i])
        before = arrays[-1].copy()
        arrays[-1][...] = 1 - before
        np.testing.assert_array_equal(environment.task.get_observation(environment.physics)[name], before)
    environment.close()


@every_task
def test_every_episode_begins_differently(blind, domain, task):
    environment = blind(domain, task, seed=3)
    positions = []
    for _ in range(12):
        environment.reset()
        positions.append(environment.physics.object_positions().ravel().copy())
    assert len(np.unique(np.round(positions, 6), axis=0)) >= 3  # objects of turn_taking lie in one of three ways


@every_task
def test_people_take_turns_in_the_hard_form_alone(blind, domain, task):
    environment = blind(domain, task)
    people = set()
    for _ in range(12):
        environment.reset()
        people.add(environment.task.world.config.scene.caregiver)
        assert environment.physics is environment.task.world.physics
    assert len(people) > 2 if (domain, task) in HARD else people == {"robin"}


@every_task
def test_everything_has_a_name(blind, domain, task):
    model = blind(domain, task).physics.model
    counts = {"body": model.nbody, "joint": model.njnt, "geom": model.ngeom, "site": model.nsite, "camera": model.ncam}
    counts |= {"actuator": model.nu, "mesh": model.nmesh, "material": model.nmat}
    for kind, count in counts.items():
        names = [model.id2name(i, kind) for i in range(count)]
        assert all(names), (kind, names)


@every_task
def test_rewards_are_numbers_from_0_to_1(blind, domain, task):
    environment = blind(domain, task)
    environment.reset()
    for action in random_actions(environment, 200):
        step = environment.step(action)
        if not step.first():
            assert isinstance(step.reward, float)
            assert 0 <= step.reward <= 1


@every_task
def test_who_knows_everything_earns_more_than_chance(blind, domain, task):
    """And no more than there is; chance is the better one of random actions and none."""

    def earned(act):
        environment = blind(domain, task, seed=4)
        rewards = []
        for _ in range(3):
            step = environment.reset()
            while not step.last() and len(rewards) < 400:
                step = environment.step(act(environment))
                rewards.append(step.reward)
        return np.mean(rewards)

    actions = iter(random_actions(blind(domain, task), 3000))
    chance = max(earned(lambda _: next(actions)), earned(lambda _: np.zeros(2)))
    assert 1.5 * chance + 0.1 < earned(lambda environment: environment.task.best_action(environment.physics)) <= 1


@every_task
def test_an_episode_ends_at_its_time_limit(domain, task):
    environment = load(domain, task, task_kwargs={"camera": False, "time_limit": 3.0})
    steps = round(3.0 / environment.control_timestep())
    environment.reset()
    idle = np.zeros(2, environment.action_spec().dtype)
    taken = [environment.step(idle) for _ in range(steps + 1)]
    assert [step.step_type for step in taken[:-2]] == [StepType.MID] * (steps - 1)
    assert taken[-2].last()
    assert taken[-2].discount == 1.0  # time is up, nothing more: no terminal state
    assert taken[-1].first()
    environment.close()


@every_task
def test_pixels_wrapper(domain, task):
    environment = pixels.Wrapper(load(domain, task, task_kwargs={"camera": False, "people": ("noa", "kai")}))
    for _ in range(3):
        shown = environment.reset().observation["pixels"]
        environment.observation_spec()["pixels"].validate(shown)
        assert shown.std() > 10
    environment.close()


@every_task
def test_action_wrappers(blind, domain, task):
    """The noise comes from the task's seed; whole numbers stay whole."""
    noisy = []
    for scale in (0.0, 0.3, 0.3):
        plain = blind(domain, task, seed=5)
        environment = action_scale.Wrapper(action_noise.Wrapper(plain, scale=scale), minimum=-1.0, maximum=1.0)
        environment.reset()
        for _ in range(6):
            step = environment.step(np.full(2, 0.2))
        noisy.append(np.concatenate([np.ravel(part) for part in step.observation.values()]))
    assert not np.array_equal(noisy[0], noisy[1])
    np.testing.assert_array_equal(noisy[1], noisy[2])


@every_task
@pytest.mark.parametrize("wrong", [{"control_timestep": 0.02}, {"n_sub_steps": 1}])
def test_the_control_timestep_is_fixed(domain, task, wrong):
    with pytest.raises(ConfigError, match="/30 s"):
        load(domain, task, environment_kwargs=wrong)


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan")])
def test_an_episode_takes_time(seconds):
    with pytest.raises(ConfigError, match="time_limit"):
        load("joint_attention", "follow", task_kwargs={"time_limit": seconds})


def test_a_random_state_may_give_the_seed():
    states = []
    for seed in (4, 4, 5):
        random = np.random.RandomState(seed)
        environment = load("joint_attention", "follow", task_kwargs={"camera": False, "random": random})
        environment.reset()
        states.append(environment.physics.data.mocap_pos.copy())
    np.testing.assert_array_equal(states[0], states[1])
    assert not np.array_equal(states[0], states[2])


def test_unknown_names_are_errors_that_tell_the_known_ones():
    with pytest.raises(ConfigError, match="joint_attention"):
        load("joint_intention", "object_transfer")
    with pytest.raises(ValueError, match="object_transfer"):
        load("joint_attention", "peekaboo")
    with pytest.raises(ConfigError, match="robin"):
        load("joint_attention", "follow", task_kwargs={"people": ("nobody",)})


def test_tasks_bear_tags():
    names = [task for _, task in ALL_TASKS]
    assert {"joint_attention": tuple(names)} == TASKS_BY_DOMAIN
    assert set(BENCHMARKING) == set(EASY) | set(HARD) == set(ALL_TASKS)
    assert {(domain, f"{task}_hard") for domain, task in EASY} == set(HARD)
    assert tagged("no such tag") == ()


def test_the_package_offers_the_suite_and_imports_mujoco_only_then():
    assert jointattn_mj.load is load
    assert jointattn_mj.ALL_TASKS is ALL_TASKS
    assert {"load", "ALL_TASKS", "BENCHMARKING"} <= set(dir(jointattn_mj))
    with pytest.raises(AttributeError, match="peekaboo"):
        _ = jointattn_mj.peekaboo
    check = "import sys, jointattn_mj; assert not {'mujoco', 'dm_control', 'cv2', 'numba', 'numpy'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", check], check=True)


@pytest.mark.parametrize(("domain", "task"), EASY, ids=lambda name: name)
def test_docstrings_and_page_name_every_observation_with_its_shape(blind, domain, task):
    """Of the easy forms; hard ones refer to these."""
    described, page = getattr(joint_attention, task).__doc__, Path("docs/suite.md").read_text()
    for name, spec in blind(domain, task).observation_spec().items():
        shapes = [line.strip().split(" | ")[1] for line in described.splitlines() if f'observation["{name}"]' in line]
        assert len(shapes) == 1 and str(spec.shape) in shapes[0]
        assert f"`{name}`" in page
    assert "| action | (2,) |" in described and "| reward | () |" in described and "| step, episode |" in described


def test_the_example_of_load_works():
    assert doctest.testmod(tasks).failed == 0
