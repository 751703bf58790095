"""The caregiver's face as an observation of the suite, found by the robot's own detector."""

import copy
import pickle

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError
from jointattn_mj.scene.camera import pixels_of_points
from jointattn_mj.tasks import load

pytestmark = pytest.mark.integration

STEPS = 12


@pytest.fixture(scope="module")
def environment():
    """``follow`` with face patch and image."""
    made = load("joint_attention", "follow", task_kwargs={"random": 0, "face_patch": True})
    made.reset()
    yield made
    made.close()


def watched(environment, seed=0, steps=STEPS):
    """Observations of random actions."""
    rng, spec = np.random.default_rng(seed), environment.action_spec()
    return [environment.step(rng.uniform(spec.minimum, spec.maximum)).observation for _ in range(steps)]


def same(left, right):
    pairs = zip(left, right, strict=True)
    return all(np.array_equal(step[name], other[name]) for step, other in pairs for name in step)


def test_the_face_is_found_where_it_is(environment):
    environment.task.seed(1)
    found, off = 0, []
    for _ in range(5):
        environment.reset()
        face = environment.physics.face_position()[None]
        for observation in watched(environment, steps=8):
            (x, y) = pixels_of_points(face, np.degrees(observation["head_angles"]))[0]
            if not (20 < x < 300 and 20 < y < 220):
                continue
            found += observation["face_visible"]
            grey = observation["camera"].mean(axis=2)
            patch = observation["face_patch"].astype(float)
            if observation["face_visible"]:
                fits = {
                    (i, j): np.corrcoef(grey[top : top + 32, left : left + 32].ravel(), patch.ravel())[0, 1]
                    for i in range(-6, 7)
                    for j in range(-6, 7)
                    if 0 <= (top := round(y) - 16 + i) <= 208 and 0 <= (left := round(x) - 16 + j) <= 288
                }
                best = max(fits, key=fits.get)
                assert fits[best] > 0.9
                off.append(np.hypot(*best))
    assert found == len(off) > 10
    assert np.median(off) < 4


def test_no_face_no_patch(environment):
    environment.reset()
    observation = environment.step([np.radians(45), np.radians(-35)]).observation
    for _ in range(8):
        observation = environment.step([np.radians(45), np.radians(-35)]).observation
    assert not observation["face_visible"]
    assert not observation["face_patch"].any()


def test_an_episode_depends_on_its_seed_alone(environment):
    environment.task.seed(3)
    environment.reset()
    first = watched(environment)
    environment.reset()
    watched(environment, seed=1)
    environment.task.seed(3)
    environment.reset()
    assert same(first, watched(environment))


def test_looking_twice_changes_nothing(environment):
    environment.task.seed(4)
    environment.reset()
    first = watched(environment)
    environment.task.seed(4)
    environment.reset()
    rng, spec = np.random.default_rng(0), environment.action_spec()
    again = []
    for _ in range(STEPS):
        environment.step(rng.uniform(spec.minimum, spec.maximum))
        again.append([environment.task.get_observation(environment.physics) for _ in range(3)][-1])
    assert same(first, again)


@pytest.mark.parametrize(
    "copied", [copy.deepcopy, lambda made: pickle.loads(pickle.dumps(made))], ids=["copy", "pickle"]
)
def test_a_copy_sees_the_same(environment, copied):
    environment.task.seed(5)
    environment.reset()
    watched(environment, seed=2, steps=4)
    other = copied(environment)
    assert same(watched(environment), watched(other))
    other.close()


def test_one_state_one_future(environment):
    environment.task.seed(6)
    environment.reset()
    watched(environment, seed=2, steps=4)
    state = environment.get_state()
    first = watched(environment)
    environment.set_state(pickle.loads(pickle.dumps(state)))
    assert same(first, watched(environment))


def test_every_task_offers_it():
    for task in ("object_transfer", "turn_taking"):
        made = load("joint_attention", task, task_kwargs={"random": 0, "camera": False, "face_patch": True})
        observation = made.reset().observation
        assert observation["face_visible"] and observation["face_patch"].std() > 10
        for name, spec in made.observation_spec().items():
            spec.validate(observation[name])
        made.close()


def test_gymnasium_offers_it_too():
    gymnasium = pytest.importorskip("gymnasium")
    made = gymnasium.make("jointattn_mj:Follow-v0", camera=False, face_patch=True)
    observation, _ = made.reset(seed=0)
    assert observation in made.observation_space
    assert observation["face_patch"].shape == (32, 32) and observation["face_visible"].tolist() == [1]
    made.close()


def test_it_is_on_or_off():
    with pytest.raises(ConfigError, match="face_patch"):
        load("joint_attention", "follow", task_kwargs={"face_patch": 32})
