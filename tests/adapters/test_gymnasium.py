"""Gymnasium's own tools on every task: its checker without a warning, vectors, videos, and a learner that trains."""

import subprocess
import sys
import warnings

import numpy as np
import pytest

from jointattn_mj.adapters.registration import IDS
from jointattn_mj.tasks import ALL_TASKS, load

pytestmark = pytest.mark.integration

gymnasium = pytest.importorskip("gymnasium")
from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.wrappers import RecordVideo  # noqa: E402

every_id = pytest.mark.parametrize("name", IDS)
FOLLOW = "jointattn_mj:Follow-v0"


def test_every_task_has_a_name():
    assert sorted(IDS.values()) == sorted(task for _, task in ALL_TASKS)


@every_id
def test_checker_has_nothing_to_say(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        environment = gymnasium.make(f"jointattn_mj:{name}", truth=True, time_limit=3.0, render_mode="rgb_array")
        check_env(environment.unwrapped)
        environment.close()


@pytest.mark.parametrize("first", ["gymnasium", "jointattn_mj"])
def test_whichever_is_imported_first(first):
    """And no more than needed: neither brings mujoco, and this package alone does not bring Gymnasium."""
    second = "jointattn_mj" if first == "gymnasium" else "gymnasium"
    program = f"import sys, {first}; assert {second!r} not in sys.modules; import {second}, gymnasium; "
    program += "assert 'Follow-v0' in gymnasium.registry and 'mujoco' not in sys.modules; "
    program += f"gymnasium.make({FOLLOW!r}, camera=False).close()"
    subprocess.run([sys.executable, "-c", program], check=True)


def test_without_gymnasium_it_asks_for_it_by_name():
    program = "import sys; sys.modules['gymnasium'] = None; import jointattn_mj.adapters.gymnasium"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert "ExtraError" in done.stderr
    assert "pip install 'jointattn-mj[gym]'" in done.stderr


def test_an_environment_says_what_it_is_in_a_line():
    environment = gymnasium.make(FOLLOW, camera=False).unwrapped
    assert repr(environment) == "JointAttentionEnv(Environment(Follow, step 0 of 30))"
    environment.close()
    assert repr(environment) == "JointAttentionEnv(Environment(closed))"


@every_id
def test_it_is_the_task(name):
    """The same observations and rewards as dm_control's, for the same seed and actions."""
    environment = gymnasium.make(f"jointattn_mj:{name}", truth=True)
    plain = load("joint_attention", IDS[name], task_kwargs={"truth": True, "random": 3})
    observation, _ = environment.reset(seed=3)
    step, spec = plain.reset(), plain.action_spec()
    rng = np.random.default_rng(0)
    for _ in range(4):
        assert observation.keys() == step.observation.keys()
        for key, value in observation.items():
            np.testing.assert_array_equal(np.squeeze(value), step.observation[key])
        if spec.dtype.kind == "i":
            action = scaled = rng.integers(spec.minimum, spec.maximum + 1)
        else:
            scaled = rng.uniform(-1, 1, 2).astype(np.float32)
            action = spec.minimum + (spec.maximum - spec.minimum) * (scaled + 1) / 2
        observation, reward, terminated, truncated, _ = environment.step(scaled)
        step = plain.step(action)
        assert (reward, terminated, truncated) == (step.reward, False, False)
    environment.close(), plain.close()


def test_time_is_up():
    environment = gymnasium.make(FOLLOW, camera=False)
    environment.reset(seed=0)
    ends = [environment.step(environment.action_space.sample())[2:4] for _ in range(30)]
    assert ends == [(False, False)] * 29 + [(False, True)]


@pytest.mark.parametrize("mode", ["sync", "async"])
def test_vectors_have_seeds_of_their_own(mode):
    """Each environment is the one of its seed; an asynchronous one runs in a process of its own."""
    context = {"vector_kwargs": {"context": "spawn"}} if mode == "async" else {}  # for this process has rendered
    vector = gymnasium.make_vec(FOLLOW, num_envs=3, vectorization_mode=mode, truth=True, time_limit=1.0, **context)
    alone = gymnasium.make(FOLLOW, truth=True, time_limit=1.0)
    observed, _ = vector.reset(seed=[5, 6, 5])
    np.testing.assert_array_equal(observed["camera"][0], observed["camera"][2])
    assert not np.array_equal(observed["truth"][0], observed["truth"][1])
    expected, _ = alone.reset(seed=6)
    np.testing.assert_array_equal(observed["camera"][1], expected["camera"])
    actions = np.zeros((3, 2), np.float32)
    for _ in range(12):  # over the end of an episode, and on
        observed, rewards, *_ = vector.step(actions)
        assert rewards.shape == (3,)
    assert observed["camera"].shape == (3, 240, 320, 3)
    np.testing.assert_array_equal(observed["truth"][0], observed["truth"][2])
    vector.close(), alone.close()


def test_processes_forked_before_anything_is_rendered():
    """Gymnasium's default; forked afterwards, they say why they cannot."""
    program = f"""
import gymnasium
def vector():
    made = gymnasium.make_vec({FOLLOW!r}, num_envs=2, vectorization_mode="async")
    print(made.reset(seed=0)[0]["camera"].shape)
    return made
vector().close()
alone = gymnasium.make({FOLLOW!r})
alone.reset()
vector()
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert "(2, 240, 320, 3)" in done.stdout
    assert "spawn or forkserver" in done.stderr


def test_seeds_drawn_by_the_vector_differ():
    vector = gymnasium.make_vec(FOLLOW, num_envs=3, vectorization_mode="sync", truth=True, camera=False)
    truth = vector.reset(seed=0)[0]["truth"]
    assert len(np.unique(truth, axis=0)) == 3
    vector.close()


def test_record_video(tmp_path):
    pytest.importorskip("moviepy")
    environment = gymnasium.make(
        "jointattn_mj:ObjectTransfer-v0", camera=False, time_limit=0.5, render_mode="rgb_array"
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        environment = RecordVideo(environment, str(tmp_path / "video"), episode_trigger=lambda episode: True)
    environment.reset(seed=0)
    for _ in range(15):
        environment.step(environment.action_space.sample())
    environment.close()
    (video,) = (tmp_path / "video").glob("*.mp4")
    assert video.stat().st_size > 1000


def test_the_robot_is_seen_from_the_side():
    """Its body belongs to a group that its own eye does not draw."""
    environment = gymnasium.make(FOLLOW, camera=False, render_mode="rgb_array")
    environment.reset(seed=0)
    shown = environment.render()
    assert shown.shape == (240, 320, 3) and shown.dtype == np.uint8
    without = environment.unwrapped.environment.physics.render(240, 320, camera_id="third_person")
    assert (shown != without).any(axis=-1).mean() > 0.005
    environment.close()
    assert gymnasium.make(FOLLOW, camera=False).unwrapped.render() is None


@pytest.mark.parametrize("settings", [{"camera": False, "truth": True}, {"camera": True}], ids=["state", "pixels"])
def test_ppo_trains(settings):
    """A few updates change the policy, and warn of nothing; whether it learns is experiments/follow's business."""
    stable = pytest.importorskip("stable_baselines3")
    environment = gymnasium.make(FOLLOW, time_limit=0.8, **settings)
    small = {"n_steps": 16, "batch_size": 16, "n_epochs": 1, "seed": 0, "device": "cpu"}
    features = {"features_extractor_kwargs": {"cnn_output_dim": 8}} if settings["camera"] else {}
    model = stable.PPO("MultiInputPolicy", environment, policy_kwargs=features, **small)
    before = [weights.clone() for weights in model.policy.parameters()]
    model.learn(32)
    assert model.num_timesteps == 32
    assert any((a != b).any() for a, b in zip(before, model.policy.parameters(), strict=True))
    action, _ = model.predict(environment.reset(seed=1)[0], deterministic=True)
    assert environment.action_space.contains(action)
    environment.close()
