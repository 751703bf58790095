"""Copies of environments, and states that are put back: one state has one future, whatever came in between."""

import copy
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from jointattn_mj.development.table.world import TableConfig
from jointattn_mj.errors import ClosedError, StateError
from jointattn_mj.scene import snapshot
from jointattn_mj.scene.caregiver import CaregiverConfig
from jointattn_mj.scene.variation import VariationConfig
from jointattn_mj.scene.world import WorldConfig
from jointattn_mj.tasks import ALL_TASKS, load

pytestmark = pytest.mark.integration

every_task = pytest.mark.parametrize("task", [task for _, task in ALL_TASKS])
STEPS = 60
VARIED = VariationConfig(
    light_strength=0.2, camera_noise=4, camera_delay=7, object_size=0.2, layout=0.1, pace=0.3, object_shapes=("box",)
)


def episodes_of(task: str, seconds: int = 1, **settings):
    """A task with episodes of 15 steps or so: 60 steps live through several, with another person each where it can."""
    limit = 15.0 if "turn" in task else 1.5 if "follow" in task else 0.5
    return load("joint_attention", task, task_kwargs={"time_limit": seconds * limit, "random": 3, **settings})


def future(environment, steps: int = STEPS, seed: int = 0) -> list:
    """What comes of so many actions, which the seed draws."""
    spec, rng = environment.action_spec(), np.random.default_rng(seed)
    return [environment.step(rng.uniform(spec.minimum, spec.maximum)) for _ in range(steps)]


def assert_alike(first: list, second: list) -> None:
    for number, (step, other_step) in enumerate(zip(first, second, strict=True)):
        for name in ("step_type", "reward", "discount"):
            assert getattr(step, name) == getattr(other_step, name), (number, name)
        assert step.observation.keys() == other_step.observation.keys()
        for name, value in step.observation.items():
            np.testing.assert_array_equal(value, other_step.observation[name], err_msg=f"{name} of step {number}")


def assert_plain(value) -> None:
    """Arrays and plain values, and nothing that is somebody's."""
    if isinstance(value, dict):
        assert all(isinstance(name, str) for name in value)
        value = tuple(value.values())
    if isinstance(value, (tuple, list)):
        for item in value:
            assert_plain(item)
    else:
        frozen = getattr(type(value), "__dataclass_params__", None)
        assert value is None or isinstance(value, (np.ndarray, int, float, str)) or (frozen and frozen.frozen), value


def pickled(environment):
    return pickle.loads(pickle.dumps(environment))


@every_task
@pytest.mark.parametrize(
    ("camera", "lived"), [(False, 0), (False, 20), (True, 20)], ids=["after reset", "in the middle", "seeing"]
)
def test_a_copy_has_the_future_of_the_original(task, camera, lived):
    environment = episodes_of(task, camera=camera, truth=True)
    environment.reset()
    future(environment, lived, seed=1)
    twins = [copy.deepcopy(environment), pickled(environment)]
    twins.append(copy.deepcopy(twins[0]))
    steps = 12 if camera else STEPS
    expected = future(environment, steps)
    for twin in twins:
        assert twin.physics is twin.task.world.physics is not environment.physics
        assert_alike(future(twin, steps), expected)
        twin.close()
    environment.close()


def test_a_copy_made_before_the_first_episode():
    environment = episodes_of("turn_taking_hard", camera=False)
    twin = copy.deepcopy(environment)
    assert_alike(future(twin), future(environment))


def test_a_copy_of_a_varied_world_sees_the_same():
    """With images that come late and are noisy, other shapes, another pace."""
    environment = episodes_of("follow_hard", variation=VARIED)
    environment.reset()
    future(environment, 20, seed=1)
    assert environment.task.world.conditions.sensor.delay > 0
    twin, other = pickled(environment), episodes_of("follow_hard", variation=VARIED)
    state = environment.get_state()
    expected = future(environment, 40)
    assert_alike(future(twin, 40), expected)
    environment.set_state(state)
    other.set_state(state)
    assert_alike(future(environment, 40), expected)
    assert_alike(future(other, 40), expected)


def test_copies_answer_who_looks_where():
    environment = episodes_of("object_transfer", camera=False)
    environment.reset()
    twin = copy.deepcopy(environment)
    future(twin), future(environment)
    np.testing.assert_array_equal(twin.physics.robot_to_targets(), environment.physics.robot_to_targets())
    np.testing.assert_array_equal(
        twin.task.best_action(twin.physics), environment.task.best_action(environment.physics)
    )


def test_copies_go_ways_of_their_own():
    environment = episodes_of("object_transfer", camera=False)
    environment.reset()
    twin = copy.deepcopy(environment)
    expected = future(copy.deepcopy(environment))
    future(twin, seed=5)
    assert_alike(future(environment), expected)


def test_the_eyes_of_a_copy_are_lit_as_the_original_s():
    environment = load("joint_attention", "follow", task_kwargs={"random": 0}, visualize_reward=True)
    environment.reset()
    for _ in range(10):
        environment.step(environment.task.best_action(environment.physics))
    side = environment.physics.render(240, 320, camera_id="third_person")
    twin = copy.deepcopy(environment)
    np.testing.assert_array_equal(twin.physics.render(240, 320, camera_id="third_person"), side)
    assert twin.physics.named.model.geom_rgba["robot/lens_left"][1] > 0.9


def test_a_closed_environment_is_not_copied():
    environment = episodes_of("follow", camera=False)
    environment.close()
    with pytest.raises(ClosedError, match="closed"):
        copy.deepcopy(environment)
    with pytest.raises(ClosedError, match="closed"):
        pickle.dumps(environment)


@every_task
def test_one_state_one_future(task):
    """60 of 60 steps, over the ends of episodes, after others have been lived through, and any number of times."""
    environment = episodes_of(task, camera=False, truth=True)
    environment.reset()
    future(environment, 20, seed=1)
    state = environment.get_state()
    kept = pickle.dumps(state)
    expected = future(environment)
    for seed in (2, 3):
        future(environment, 40, seed)
        environment.reset()
        environment.set_state(state)
        assert_alike(future(environment), expected)
    assert pickle.dumps(pickle.loads(kept)) == pickle.dumps(pickle.loads(pickle.dumps(state)))  # used, not used up


@every_task
def test_one_state_one_image(task):
    environment = episodes_of(task)
    environment.reset()
    future(environment, 5, seed=1)
    state = environment.get_state()
    now = environment.task.get_observation(environment.physics)["camera"]
    expected = future(environment, 8)
    future(environment, 20, seed=2)
    environment.set_state(state)
    np.testing.assert_array_equal(environment.task.get_observation(environment.physics)["camera"], now)
    assert_alike(future(environment, 8), expected)
    environment.close()


@every_task
def test_a_state_is_taken_up_by_an_environment_that_was_built_alike(task):
    """Whatever that has done; by one without images too, and one whose episodes are shorter."""
    environment = episodes_of(task, camera=False)
    environment.reset()
    future(environment, 20, seed=1)
    state = pickle.loads(pickle.dumps(copy.deepcopy(environment.get_state())))
    assert_plain(vars(state))
    rewards = [step.reward for step in future(environment, 8)]
    new, used = (episodes_of(task, camera=camera, random=8) for camera in (False, True))
    future(used, 7, seed=4)
    for other in (new, used):
        other.set_state(state)
        assert [step.reward for step in future(other, 8)] == rewards
        other.close()


def test_a_state_is_taken_up_in_another_process(tmp_path):
    environment = episodes_of("object_transfer_hard", camera=False)
    environment.reset()
    future(environment, 20, seed=1)
    (tmp_path / "state").write_bytes(pickle.dumps(environment.get_state()))
    program = f"""
import pickle, sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from pathlib import Path
from test_environment_state import episodes_of, future
environment = episodes_of("object_transfer_hard", camera=False, random=9)
environment.set_state(pickle.loads(Path({str(tmp_path / "state")!r}).read_bytes()))
print([step.observation["head_angles"].tolist() for step in future(environment)])
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == str([step.observation["head_angles"].tolist() for step in future(environment)])


def test_a_state_before_the_first_episode_and_at_the_end_of_one():
    environment = episodes_of("follow", camera=False)
    before = environment.get_state()
    expected = future(environment)
    environment.set_state(before)
    again = future(environment, 16)  # the first begins an episode, the last is its end
    assert again[0].first() and again[-1].last()
    end = environment.get_state()
    rest = future(environment, 20, seed=2)
    environment.set_state(end)
    assert_alike(future(environment, 20, seed=2), rest)
    environment.set_state(before)
    assert_alike(future(environment), expected)


def test_wrappers_draw_the_same_noise_again():
    from dm_control.suite.wrappers import action_noise

    environment = action_noise.Wrapper(episodes_of("follow", camera=False), scale=0.2)
    environment.reset()
    state = environment.get_state()
    expected = future(environment)
    environment.set_state(state)
    assert_alike(future(environment), expected)


def test_without_up_to_date_positions_too():
    """dm_control's ``legacy_step=False``, which is kept."""
    environment = load(
        "joint_attention", "follow", task_kwargs={"random": 0}, environment_kwargs={"legacy_step": False}
    )
    environment.reset()
    future(environment, 10, seed=1)
    twin, state = copy.deepcopy(environment), environment.get_state()
    assert twin.physics.legacy_step is False
    expected = future(environment, 15)
    assert_alike(future(twin, 15), expected)
    environment.set_state(state)
    assert_alike(future(environment, 15), expected)


@pytest.mark.parametrize(
    ("task", "settings"),
    [
        ("follow_hard", {}),
        ("object_transfer", {}),
        ("follow", {"people": ("noa", "kai")}),
        ("follow", {"variation": "pace"}),
        ("follow", {"world": WorldConfig(behaviour=CaregiverConfig(gaze_s=1.0))}),
    ],
    ids=["another task", "of another kind", "other people", "another variation", "another world"],
)
def test_a_state_of_another_environment_is_refused(task, settings):
    environment, other = episodes_of("follow", camera=False), episodes_of(task, camera=False, **settings)
    other.reset()
    environment.reset()
    expected = future(copy.deepcopy(environment), 20)
    with pytest.raises(StateError, match="built"):
        environment.set_state(other.get_state())
    assert_alike(future(environment, 20), expected)  # as if nothing had been tried


def test_a_state_of_another_table_is_refused():
    environment = episodes_of("turn_taking", camera=False)
    other = episodes_of("turn_taking", camera=False, table=TableConfig(gestures=2))
    with pytest.raises(StateError, match="table"):
        environment.set_state(other.get_state())


@pytest.mark.parametrize("wrong", [None, {}, np.zeros(5), "state"])
def test_what_is_no_state_is_refused(wrong):
    environment = episodes_of("follow", camera=False)
    with pytest.raises(StateError, match="get_state"):
        environment.set_state(wrong)


def test_bodies_alone_are_not_set():
    """dm_control's habit would leave the caregiver's script where it is."""
    environment = episodes_of("follow", camera=False)
    environment.reset()
    state = environment.physics.get_state()
    before = state.copy()
    with pytest.raises(StateError, match=r"environment.set_state\(state\)"):
        environment.physics.set_state(state + 1)
    np.testing.assert_array_equal(environment.physics.get_state(), before)
    bodies = environment.physics.copy()
    bodies.set_state(state + 0.1)
    np.testing.assert_array_equal(bodies.get_state(), state + 0.1)
    with pytest.raises(StateError, match="caregiver's script"):
        copy.deepcopy(environment).physics.set_state(state)


def test_planning_by_roll_outs_earns_more_than_looking_straight_ahead():
    """And leaves the environment that it plans for as it was: a planner of its own takes up the state."""
    environment = load("joint_attention", "follow", task_kwargs={"random": 0, "camera": False})
    planner = load("joint_attention", "follow", task_kwargs={"camera": False, "time_limit": 60.0})
    rng, spec = np.random.default_rng(0), environment.action_spec()

    def value(state, action) -> float:
        planner.set_state(state)
        return sum(planner.step(action).reward for _ in range(4))

    def earned(act) -> float:
        step, total = environment.reset(), 0.0
        while not step.last():
            step = environment.step(act())
            total += step.reward
        return total

    def best() -> np.ndarray:
        state = environment.get_state()
        return max(rng.uniform(spec.minimum, spec.maximum, (16, 2)), key=lambda action: value(state, action))

    environment.task.seed(0)
    idle = earned(lambda: np.zeros(2))
    environment.task.seed(0)
    assert earned(best) > idle + 3


class Somebody:
    """With everything that a caregiver of one's own may have."""

    def __init__(self):
        self.rng = np.random.default_rng(0)
        self.shared = [np.zeros(2), {"a": 1, "b": [2, 3]}]
        self.words, self.nothing = {"she", "he"}, None
        self.inner = CaregiverConfig()


def test_snapshots_of_any_object():
    somebody = Somebody()
    taken = snapshot.take(somebody)
    drawn = somebody.rng.random()
    somebody.shared[0][:] = 5
    somebody.shared[1]["b"].append(4)
    somebody.words.add("it")
    somebody.nothing, somebody.more = 3, "more"
    for _ in range(2):
        snapshot.put(somebody, taken)
        assert somebody.rng.random() == drawn
        np.testing.assert_array_equal(somebody.shared[0], 0)
        assert somebody.shared[1] == {"a": 1, "b": [2, 3]}
        assert (somebody.words, somebody.nothing, hasattr(somebody, "more")) == ({"she", "he"}, None, False)
        somebody.shared[0][:] = 7
    del somebody.rng
    with pytest.raises(StateError, match="bit_generator"):
        snapshot.put(somebody, taken)
