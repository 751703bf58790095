"""A run that has lost its numbers stops by name, and leaves the last checkpoint from before."""

import numpy as np
import pytest

from jointattn_mj.development.config import DevelopmentOptions
from jointattn_mj.development.run import run_development
from jointattn_mj.development.table.config import TableDevelopmentConfig
from jointattn_mj.errors import NotFiniteError, ObservationError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, RobotConfig
from jointattn_mj.gaze_following.run import SessionOptions, run_session
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.guards.finite import check_finite, not_finite
from jointattn_mj.io import checkpoint

ROBOT = RobotConfig(familiarise=FamiliariseConfig(minutes=0.02))
CONFIG = SessionConfig(minutes=0.4, perception="state", robot=ROBOT)


def test_only_floats_can_be_lost():
    arrays = {"a": np.ones(3), "b": np.array(["x"]), "c": 3, "d": np.array([1, np.nan]), "e": 1j * np.inf, "f": []}
    assert not_finite(arrays) == ["d", "e"]
    with pytest.raises(NotFiniteError, match="in d, e"):
        check_finite(arrays)


def spoil_learner(session):
    session.robot.learner._weights[0, 0, 0] = np.nan


def spoil_map(session):
    session.robot.som.weights[3] = np.inf


def spoil_physics(session):
    session.world._head_angles[:] = np.nan


@pytest.mark.integration
@pytest.mark.parametrize(
    ("spoil", "words"),
    [(spoil_learner, "learner"), (spoil_map, "som_weights|activations"), (spoil_physics, "unstable|joint")],
)
def test_a_session_stops_at_its_next_checkpoint(tmp_path, spoil, words):
    def progress(session):
        if session.frame == 360:
            spoil(session)

    with pytest.raises((NotFiniteError, ObservationError), match=words):
        run_session(CONFIG, SessionOptions(tmp_path, checkpoint_minutes=0.1), progress)
    assert not (tmp_path / "weights.npz").exists()
    session = checkpoint.load(tmp_path / "checkpoint.bin", CONFIG, kind=(float, SessionRun))[1]
    assert session.frame == 360
    session.check()
    session.close()


def test_a_session_that_never_had_any_leaves_no_checkpoint(tmp_path):
    class Broken(SessionRun):
        def begin(self):
            super().begin()
            spoil_map(self)

    with pytest.raises(NotFiniteError, match="som_weights"):
        run_session(CONFIG, SessionOptions(tmp_path), kind=Broken)
    assert not (tmp_path / "checkpoint.bin").exists()


def test_a_developing_robot_stops(tmp_path):
    config = TableDevelopmentConfig(steps=40_000)

    def progress(run, found):
        if run.steps_done == 20_000:
            run.agent.state.maps.odds[0] = np.nan

    with pytest.raises(NotFiniteError, match="odds"):
        run_development(config, DevelopmentOptions(tmp_path), progress)
    assert not (tmp_path / "summary.json").exists()
    assert (tmp_path / "checkpoint.bin").exists()
