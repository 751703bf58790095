"""Many worlds of ``follow`` in one process are as many single ones."""

import copy
import pickle

import numpy as np
import pytest
from dm_env import specs

from jointattn_mj.errors import ActionError, ClosedError, ConfigError, EpisodeError
from jointattn_mj.tasks.follow import Follow

pytestmark = pytest.mark.integration

gymnasium = pytest.importorskip("gymnasium")


def pair(name, number, **settings):
    """The same worlds together, and one by one."""
    return [
        gymnasium.make_vec(f"jointattn_mj:{name}", num_envs=number, vectorization_mode=mode, **settings)
        for mode in ("vector_entry_point", "sync")
    ]


def compare(together, alone, steps, seed):
    """Over as many steps of random actions, now and then beyond the bounds."""
    seen = [vector.reset(seed=seed) for vector in (together, alone)]
    assert seen[0][1] == {}
    rng = np.random.default_rng(0)
    for _ in range(steps):
        actions = rng.uniform(-1.2, 1.2, (together.num_envs, 2)).astype(np.float32)
        stepped = [vector.step(actions) for vector in (together, alone)]
        for ours, theirs in zip(stepped[0][1:4], stepped[1][1:4], strict=True):
            np.testing.assert_allclose(ours, theirs, atol=1e-7)
            assert ours.dtype == theirs.dtype
        seen += [step[:1] for step in stepped]
    for (ours, *_), (theirs, *_) in zip(seen[::2], seen[1::2], strict=True):
        assert list(ours) == list(theirs)
        for name, part in ours.items():
            assert part.dtype == theirs[name].dtype
            if name == "camera":
                assert (np.abs(part.astype(int) - theirs[name]) > 2).mean() < 1e-4
            elif name == "face_patch":
                assert np.abs(part.astype(int) - theirs[name]).max() <= 2
            else:
                np.testing.assert_allclose(part, theirs[name], atol=1e-7)
        assert ours in together.observation_space
    together.close(), alone.close()


@pytest.mark.parametrize(("name", "steps"), [("Follow-v0", 70), ("FollowHard-v0", 130)])
def test_states_and_rewards_are_those_of_single_worlds(name, steps):
    """Over the end of two episodes."""
    compare(*pair(name, 3, truth=True, camera=False), steps, seed=7)


def test_images_and_faces_are_those_of_single_worlds():
    compare(*pair("Follow-v0", 2, face_patch=True, time_limit=1.0), 14, seed=[5, 3])


@pytest.mark.parametrize("camera", [True, False])
def test_a_task_that_observes_more_does_so_in_many_worlds(camera, monkeypatch):
    def spec(task, physics):
        more = {"pan_deg": specs.BoundedArray((1,), float, -180, 180, name="pan_deg")}
        return super(Follow, task).observation_spec(physics) | more

    def observation(task, physics):
        observation = super(Follow, task).get_observation(physics)
        observation["pan_deg"] = np.degrees(observation["head_angles"][:1])
        return observation

    monkeypatch.setattr(Follow, "observation_spec", spec, raising=False)
    monkeypatch.setattr(Follow, "get_observation", observation, raising=False)
    compare(*pair("Follow-v0", 2, camera=camera), 4, seed=1)


def test_worlds_without_a_seed_go_on_with_their_episodes():
    together, alone = pair("Follow-v0", 2, truth=True, camera=False)
    first = [vector.reset(seed=1)[0]["truth"] for vector in (together, alone)]
    second = [vector.reset()[0]["truth"] for vector in (together, alone)]
    np.testing.assert_allclose(second[0], second[1], atol=1e-7)
    assert not np.array_equal(first[0], second[0])
    together.close(), alone.close()


def test_it_is_what_gymnasium_makes_unless_asked_otherwise():
    made = gymnasium.make_vec("jointattn_mj:Follow-v0", num_envs=2, camera=False)
    assert type(made.unwrapped).__name__ == "FollowVector"
    made.close()


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda made: pickle.loads(pickle.dumps(made))])
def test_a_copy_has_the_future_of_the_original(copied):
    made = gymnasium.make_vec("jointattn_mj:Follow-v0", num_envs=2, time_limit=0.5)
    made.reset(seed=1), made.step(np.full((2, 2), 0.5))
    twin, rng = copied(made), np.random.default_rng(0)
    for _ in range(7):
        actions = rng.uniform(-1, 1, (2, 2))
        (ours, *rest), (theirs, *others) = made.step(actions), twin.step(actions)
        np.testing.assert_equal((ours, rest), (theirs, others))
    made.close(), twin.close()
    with pytest.raises(ClosedError, match="FollowVector"):
        twin.step(actions)
    with pytest.raises(ClosedError, match="FollowVector"):
        twin.reset()


@pytest.mark.parametrize("number", [0, -1, 1.5, np.nan, "2", None, True])
def test_no_number_of_worlds(number):
    with pytest.raises(ConfigError, match="num_envs"):
        gymnasium.make_vec("jointattn_mj:Follow-v0", num_envs=number, camera=False)


def test_bad_input():
    made = gymnasium.make_vec("jointattn_mj:Follow-v0", num_envs=2, camera=False)
    with pytest.raises(EpisodeError, match="reset"):
        made.step(np.zeros((2, 2)))
    made.reset(seed=0)
    for wrong in (np.full((2, 2), np.nan), np.zeros(2), np.zeros((3, 2)), [["left", "right"]] * 2):
        with pytest.raises(ActionError) as caught:
            made.step(wrong)
        assert "\n" not in str(caught.value)
    for wrong in (-1, 0.5, [1], [1, -1], np.array(1)):
        with pytest.raises(ConfigError):
            made.reset(seed=wrong)
    made.close()
    for argument, value in (("variation", "pace"), ("render_mode", "rgb_array")):
        with pytest.raises(ConfigError, match=f"`{argument}` needs .*sync"):
            gymnasium.make_vec("jointattn_mj:Follow-v0", num_envs=2, camera=False, **{argument: value})
