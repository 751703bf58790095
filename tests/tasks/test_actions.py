"""Actions of all kinds, in every task and from either interface: clipped as documented, or one named error."""

import warnings

import numpy as np
import pytest

from jointattn_mj.adapters.registration import IDS
from jointattn_mj.errors import ActionError, ClosedError, ConfigError, EpisodeError
from jointattn_mj.scene.world import WorldConfig
from jointattn_mj.tasks import ALL_TASKS, load
from jointattn_mj.viewing.play import play_episodes

pytestmark = pytest.mark.integration

every_task = pytest.mark.parametrize("task", [task for _, task in ALL_TASKS])


class Mute:
    """Has neither words nor numbers."""

    def __repr__(self):
        raise RuntimeError("no")

    def __array__(self, *arguments, **settings):
        raise ValueError("no\nnumbers")


WRONG = {
    "NaN": [0.1, np.nan],
    "all NaN": np.full(2, np.nan),
    "infinite": [np.inf, 0],
    "minus infinite": np.array([0, -np.inf]),
    "one number": 1,
    "too few": [1],
    "too many": [0, 1, 2],
    "nothing": [],
    "another shape": np.zeros((1, 2)),
    "ragged": [[0], [1, 2]],
    "text": "ab",
    "texts": ["0", "1"],
    "None": None,
    "Nones": [None, None],
    "objects": [object(), object()],
    "a dictionary": {"pan": 0.0, "tilt": 0.0},
    "complex": [1j, 0],
    "yes and no": [True, False],
    "beyond 64 bits": [10**30, 0],
    "dates": np.array(["2020-01-01T00:00:00", "2020-01-02T00:00:00"], "datetime64[s]"),
    "masked NaN": np.ma.masked_invalid([0.1, np.nan]),
    "masked": np.ma.masked_equal([0, 1], 1),
    "without words": Mute(),
    "a record": np.zeros(2, [("pan", float)]),
}
FINE = {
    "a list": [1, 0],
    "float32": np.array([1, 0], np.float32),
    "whole": np.array([1, 0]),
    "unsigned": np.array([1, 0], np.uint8),
    "read-only": np.broadcast_to(np.array([1.0, 0.0]), (2,)),
    "not contiguous": np.array([1.0, 5.0, 0.0])[::2],
}


def make(task: str, interface: str = "dm_control", **settings):
    kwargs = {"camera": False, "truth": True, "random": 2, **settings}
    if interface == "dm_control":
        return load("joint_attention", task, task_kwargs=kwargs)
    gymnasium = pytest.importorskip("gymnasium")
    (name,) = (name for name, known in IDS.items() if known == task)
    return gymnasium.make(f"jointattn_mj:{name}", **kwargs)


def stepped(environment, action) -> list:
    """Everything that a step brings, as one list."""
    if hasattr(environment, "action_space"):
        observation, reward, *_ = environment.step(action)
    else:
        step = environment.step(action)
        observation, reward = step.observation, step.reward
    return [reward, *(np.asarray(observation[name]).tolist() for name in sorted(observation))]


both = pytest.mark.parametrize("interface", ["dm_control", "gymnasium"])


@every_task
@both
def test_what_is_no_action_is_one_error_and_changes_nothing(task, interface):
    """The next steps are as if it had never come."""
    environment, untouched = make(task, interface), make(task, interface)
    environment.reset(), untouched.reset()
    for name, action in WRONG.items():
        with pytest.raises(ActionError, match="an action is") as caught, warnings.catch_warnings():
            warnings.simplefilter("error")
            environment.step(action)
        assert "\n" not in str(caught.value), name
        assert "(2,)" in str(caught.value), name
        assert stepped(environment, [1, 0]) == stepped(untouched, [1, 0]), name
    environment.close(), untouched.close()


@every_task
@both
def test_numbers_of_any_dtype_are_one_action(task, interface):
    outcomes = []
    for action in FINE.values():
        environment = make(task, interface)
        environment.reset()
        outcomes.append([stepped(environment, action) for _ in range(3)])
        environment.close()
    assert all(outcome == outcomes[0] for outcome in outcomes)


@every_task
@both
@pytest.mark.parametrize("beyond", [9.0, 1e308, -1e308, 2**62])
def test_beyond_the_bounds_is_at_the_bounds(task, interface, beyond):
    """Head angles stay within those of the observation."""
    environment, bounded = make(task, interface), make(task, interface)
    environment.reset(), bounded.reset()
    space = environment.action_space if interface == "gymnasium" else None
    if space is None:
        spec = environment.action_spec()
        low, high = spec.minimum, spec.maximum
    elif hasattr(space, "low"):
        low, high = space.low, space.high
    else:
        low, high = space.start, space.start + space.nvec - 1
    for _ in range(20):
        outcome = stepped(environment, [beyond, beyond])
        assert outcome == stepped(bounded, np.where(beyond > 0, high, low))
    task_spec = environment.unwrapped.environment if interface == "gymnasium" else environment
    task_spec.observation_spec()["head_angles"].validate(task_spec.task.world.head_angles())
    environment.close(), bounded.close()


def test_choices_are_rounded():
    environment, rounded = make("turn_taking"), make("turn_taking")
    environment.reset(), rounded.reset()
    for action in ([0.4, 1.6], [2.51, -0.3], [3.4, 0.0]):
        assert stepped(environment, action) == stepped(rounded, np.rint(action))


def test_an_agent_of_one_s_own_is_told():
    class Lost:
        def act(self, timestep):
            return np.full(2, np.nan)

    environment = make("follow")
    with pytest.raises(ActionError, match="not finite"):
        play_episodes(environment, Lost(), 1)


def test_a_step_after_the_end():
    """dm_control begins another episode, by its convention; Gymnasium asks for ``reset``."""
    plain = make("follow", time_limit=0.3)
    plain.reset()
    ends = [plain.step([0, 0]) for _ in range(4)]
    assert ends[2].last() and ends[3].first()
    environment = make("follow", "gymnasium", time_limit=0.3)
    environment.reset(seed=3)
    assert [environment.step(np.zeros(2))[3] for _ in range(3)] == [False, False, True]
    for _ in range(2):
        with pytest.raises(EpisodeError, match="reset"):
            environment.step(np.zeros(2))
    environment.reset()
    environment.step(np.zeros(2))
    bare = environment.unwrapped.__class__("follow", camera=False)
    with pytest.raises(EpisodeError, match="reset"):
        bare.step(np.zeros(2))


@both
def test_a_call_after_close_is_one_line(interface):
    environment = make("follow", interface)
    environment.reset()
    bare = environment.unwrapped if interface == "gymnasium" else environment
    world = (bare.environment if interface == "gymnasium" else bare).task.world
    physics, state = world.physics, bare.get_state()
    environment.close()
    environment.close()
    world.close()
    calls = [environment.reset, lambda: environment.step([0, 0]), bare.get_state, lambda: bare.set_state(state)]
    calls += [lambda: world.step(np.zeros(2)), world.image, world.head_angles, lambda: world.config]
    calls += [lambda: physics.render(24, 32), physics.robot_to_targets, physics.get_state, physics.step]
    if interface == "dm_control":
        calls += [environment.action_spec, environment.observation_spec, lambda: environment.physics]
    for call in calls:
        with pytest.raises(ClosedError, match="is closed; make another") as caught:
            call()
        assert "\n" not in str(caught.value)
    physics.free()


def test_render_after_close():
    gymnasium = pytest.importorskip("gymnasium")
    environment = gymnasium.make("jointattn_mj:Follow-v0", camera=False, render_mode="rgb_array")
    environment.reset()
    environment.render()
    environment.close()
    with pytest.raises(ClosedError, match="closed"):
        environment.render()


@pytest.mark.parametrize("task", ["object_transfer", "object_transfer_hard", "turn_taking", "turn_taking_hard"])
def test_a_misspelt_argument_is_named_with_what_there_is(task):
    with pytest.raises(ConfigError, match=r"'camra'; perhaps you meant camera; there are: .*variation"):
        load("joint_attention", task, task_kwargs={"camra": False})
    with pytest.raises(ConfigError, match=r"'flat_observations'; perhaps you meant flat_observation"):
        load("joint_attention", task, environment_kwargs={"flat_observations": True})


@pytest.mark.parametrize(
    "wrong",
    [
        {"camera": "yes"}, {"truth": 1}, {"people": "robin"}, {"people": None}, {"people": ("nobody",)}, {"world": {}},
        {"variation": 3}, {"time_limit": "3"}, {"time_limit": None}, {"random": -1}, {"random": 1.5}, {"random": "a"},
        {"environment_kwargs": 3}, {"world": WorldConfig(dynamics="closed_form")},
    ],
    ids=str,
)  # fmt: skip
def test_an_argument_of_another_kind_is_named(wrong):
    (name,) = wrong
    with pytest.raises(ConfigError, match="caregiver" if wrong[name] == ("nobody",) else name):
        load("joint_attention", "follow", task_kwargs={"camera": False, **wrong})


def test_misspelt_names_in_gymnasium():
    gymnasium = pytest.importorskip("gymnasium")
    with pytest.raises(ConfigError, match="perhaps you meant truth"):
        gymnasium.make("jointattn_mj:Follow-v0", thruth=True)
    with pytest.raises(ConfigError, match="perhaps you meant rgb_array"), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Gymnasium's own
        gymnasium.make("jointattn_mj:Follow-v0", render_mode="rgb_aray")


@pytest.mark.parametrize("seed", [-1, 1.5, "a", [1], True, np.float64(3)], ids=str)
def test_seeds_that_are_none(seed):
    environment = make("follow", "gymnasium")
    with pytest.raises(ConfigError, match="seed"):
        environment.reset(seed=seed)


def test_seeds_of_numpy_and_options():
    environment = make("follow", "gymnasium")
    first = environment.reset(seed=np.int64(5))[0]["truth"]
    np.testing.assert_array_equal(environment.reset(seed=5)[0]["truth"], first)
    environment.reset(options={})
    with pytest.raises(ConfigError, match="no options"):
        environment.reset(options={"people": ("noa",)})


def test_through_gymnasium_one_state_one_future():
    environment = make("object_transfer_hard", "gymnasium", time_limit=1.0)
    environment.reset(seed=1)
    actions = np.random.default_rng(0).uniform(-1, 1, (60, 2))
    state = environment.unwrapped.get_state()

    def future() -> list:
        outcomes = []
        for action in actions:
            outcomes.append(stepped(environment, action))
            if environment.unwrapped.environment.over:
                environment.reset()
        return outcomes

    expected = future()
    for _ in range(2):
        environment.unwrapped.set_state(state)
        assert future() == expected
