"""The learner with a torch network: it learns what no linear read-out can, and goes through checkpoints."""

import signal
from pathlib import Path

import numpy as np
import pytest
import torch

from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, RobotConfig
from jointattn_mj.gaze_following.learners import LearnerConfig, Locations, make_learner
from jointattn_mj.gaze_following.network_learner import NetworkLearner
from jointattn_mj.gaze_following.run import SessionOptions, run_session
from jointattn_mj.gaze_following.session import SessionConfig
from jointattn_mj.io.checkpoint import load, save

pytestmark = pytest.mark.integration

CONFIG = LearnerConfig(code="network")
LEFT, RIGHT = np.array([15.0, -12.0]), np.array([-15.0, -20.0])


def learn_exclusive_or(learner, steps: int) -> list[np.ndarray]:
    """Left where one of two inputs is on, right where both or none are; predictions in that order."""
    faces = np.array([[1.0, 0, 1], [0, 1, 1], [1, 1, 1], [0, 0, 1]])
    for step in range(steps):
        learner.learn(faces[step % 4], Locations.only(LEFT if step % 4 < 2 else RIGHT))
    return [learner.predict(face) for face in faces]


def test_it_learns_exclusive_or():
    predicted = learn_exclusive_or(make_learner(CONFIG, 3, np.random.default_rng(0)), 1000)
    np.testing.assert_allclose(predicted, [LEFT, LEFT, RIGHT, RIGHT], atol=2)


def test_first_weights_come_from_the_seed():
    first, again, other = (make_learner(CONFIG, 3, np.random.default_rng(seed)).weights() for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)


def test_divergence_is_a_named_error():
    with pytest.raises(ConfigError, match="network_rate below 5"):
        learn_exclusive_or(
            make_learner(LearnerConfig(code="network", network_rate=5.0), 3, np.random.default_rng(0)), 200
        )


def test_through_a_checkpoint(tmp_path):
    learner = make_learner(CONFIG, 3, np.random.default_rng(0))
    face = np.array([0.2, 0.5, 0.3])
    learner.learn(face, Locations.only(LEFT))
    save(tmp_path / "c", learner, {})
    again = load(tmp_path / "c", {})
    for each in (learner, again):
        each.learn(face, Locations.only(RIGHT))
    np.testing.assert_array_equal(again.weights(), learner.weights())
    np.testing.assert_array_equal(again.predict(face), learner.predict(face))


def test_a_network_of_ones_own(tmp_path):
    """It learns as it is; a checkpoint would not know how to build it, and says so when it is written."""
    outputs = CONFIG.units[0] * CONFIG.units[1]
    network = torch.nn.Sequential(torch.nn.Linear(3, 60), torch.nn.ReLU(), torch.nn.Linear(60, outputs))
    learner = NetworkLearner(CONFIG, network)
    for _ in range(300):
        learner.learn(np.ones(3), Locations.only(LEFT))
    np.testing.assert_allclose(learner.predict(np.ones(3)), LEFT, atol=0.8)
    with pytest.raises(ConfigError, match="of your own"):
        save(tmp_path / "c", learner, {})


def test_a_session_goes_on_after_a_stop(tmp_path: Path):
    robot = RobotConfig(familiarise=FamiliariseConfig(minutes=0.05), learner=CONFIG)
    config = SessionConfig(minutes=0.6, perception="state", robot=robot)

    def interrupt(session):
        if session.frame == 600:
            signal.raise_signal(signal.SIGINT)

    run_session(config, SessionOptions(tmp_path / "straight"))
    with pytest.raises(KeyboardInterrupt):
        run_session(config, SessionOptions(tmp_path / "on"), interrupt)
    run_session(config, SessionOptions(tmp_path / "on", resume=True))
    for name in ("frames.parquet", "gaze_shifts.parquet", "weights.npz"):
        assert (tmp_path / "on" / name).read_bytes() == (tmp_path / "straight" / name).read_bytes(), name
