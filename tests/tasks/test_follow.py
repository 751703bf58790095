"""Gaze following in short episodes: who looks where, and what it earns."""

from itertools import pairwise

import numpy as np
import pytest

from jointattn_mj.scene.camera import directions_to
from jointattn_mj.tasks import load
from jointattn_mj.tasks.physics import ROBOT_RADIUS


@pytest.fixture
def follow():
    environment = load("joint_attention", "follow", task_kwargs={"camera": False, "truth": True, "random": 3})
    yield environment
    environment.close()


@pytest.fixture
def hard():
    environment = load("joint_attention", "follow_hard", task_kwargs={"camera": False, "truth": True, "random": 3})
    yield environment
    environment.close()


def direction(environment, target: int, off: float = 0.0) -> np.ndarray:
    """Pan and tilt (rad) at which the robot looks at an object, or past it by so many degrees."""
    return np.radians(directions_to(environment.physics.object_positions())[target] + [0, off])


def test_the_caregiver_looks_at_one_object_all_the_time(follow):
    targets = set()
    for _ in range(20):
        step = follow.reset()
        target, truth = follow.task.world.caregiver.target, step.observation["truth"]
        targets.add(target)
        while not step.last():
            assert follow.physics.caregiver_fixates() == target
            step = follow.step(np.zeros(2))
            np.testing.assert_allclose(step.observation["truth"], truth, atol=1e-9)
    assert targets == {0, 1, 2, 3}


def test_the_head_tells_objects_apart(follow):
    """Yaw of head and pan of the object lie on opposite sides: the robot's right is the caregiver's left."""
    for _ in range(20):
        yaw = follow.reset().observation["truth"][0]
        position = follow.physics.object_positions()[follow.task.world.caregiver.target]
        assert np.sign(yaw) == -np.sign(position[1]) or abs(position[1]) < 0.02


def test_the_hand_stays(follow):
    hands = []
    for _ in range(2):
        step = follow.reset()
        while not step.last():
            hands.append(follow.physics.named.data.site_xpos["caregiver/grasp"].copy())
            step = follow.step(np.zeros(2))
    np.testing.assert_allclose(hands, np.broadcast_to(hands[0], (len(hands), 3)), atol=1e-4)


@pytest.mark.parametrize(("off", "expected"), [(0, 1.0), (3.0, 1.0), (13.5, 0.5), (-13.5, 0.5), (24, 0.0)])
def test_reward_grows_with_nearness(follow, off, expected):
    follow.reset()
    target = follow.task.world.caregiver.target
    for _ in range(5):
        step = follow.step(direction(follow, target, off))
    assert step.reward == pytest.approx(expected, abs=0.02)


def test_another_object_earns_little(follow):
    follow.reset()
    target = follow.task.world.caregiver.target
    angles = np.linalg.norm(direction(follow, target) - directions_to(follow.physics.object_positions()) * np.pi / 180)
    assert angles > ROBOT_RADIUS
    furthest = int(
        np.argmax(np.linalg.norm(follow.physics.object_positions() - follow.physics.object_positions()[target], axis=1))
    )
    for _ in range(5):
        step = follow.step(direction(follow, furthest))
    assert step.reward < 0.5


def test_the_hard_caregiver_looks_up_and_around(hard):
    step = hard.reset()
    assert hard.task.world.caregiver.target is None
    assert hard.task.best_action(hard.physics)[1] > 0  # up, at the face
    np.testing.assert_allclose(step.observation["truth"], 0)
    targets = []
    while not step.last():
        step = hard.step(np.zeros(2))
        targets.append(hard.task.world.caregiver.target)
        assert step.reward == 0.0  # straight ahead lies no object
    shifts = sum(a != b for a, b in pairwise(targets))
    assert 2 <= shifts <= 5
    assert len(targets) == 60


def test_nothing_but_fixating_is_rewarded_in_the_hard_form(hard):
    hard.reset()
    for _ in range(8):
        hard.step(np.zeros(2))
    target = hard.task.world.caregiver.target
    for _ in range(2):
        step = hard.step(direction(hard, target, 6.0))
    assert step.reward == 0.0
    for _ in range(2):
        step = hard.step(direction(hard, target))
    assert step.reward == 1.0


def test_a_step_is_a_tenth_of_a_second(follow, hard):
    for environment in (follow, hard):
        assert environment.control_timestep() == pytest.approx(0.1)
        environment.reset()
        environment.step(np.zeros(2))
        assert environment.physics.time() == pytest.approx(0.1)
