"""The synchronised run: told when, visual feedback decides where; pairs in both directions; the test gazes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from jointattn_mj.baselines.synchronised import RESTS, Gazes, SynchronisedSession, ToldSelector, synchronised
from jointattn_mj.gaze_following.attention import AttentionConfig
from jointattn_mj.gaze_following.session import SessionConfig
from jointattn_mj.scene.camera import directions_to
from jointattn_mj.scene.caregiver import Phase
from jointattn_mj.scene.model import HEAD_POSITION


@pytest.fixture(scope="module")
def session() -> SynchronisedSession:
    config = synchronised(SessionConfig(minutes=2.0, perception="state", seed=3))
    config = replace(config, robot=replace(config.robot, familiarise=replace(config.robot.familiarise, minutes=0.5)))
    session = SynchronisedSession(config)
    session.begin()
    while session.frame < session.total:
        session.step()
    session.close()
    return session


def test_every_shift_starts_and_ends_while_the_caregivers_gaze_rests_on_one_thing(session):
    assert len(session.shifts) > 40
    for row in session.shifts:
        assert row.phase_at_launch == row.phase_at_landing and row.phase_at_launch in RESTS
        assert row.target_at_launch == row.target_at_landing is not None


def test_the_robot_goes_out_once_a_rest_and_comes_back(session):
    sources = [row.source for row in session.shifts]
    assert sources[::2] == ["face"] * len(sources[::2])
    assert all(row.reached == "face" for row in session.shifts[1::2])
    phase = session.frames.column("phase")
    rests = np.isin(phase, [list(Phase).index(phase) for phase in RESTS])
    begun = int(np.sum(rests[1:] & ~rests[:-1]))
    assert abs(len(sources[::2]) - begun) <= 1


def test_visual_feedback_decides_and_both_directions_teach(session):
    assert {row.commanded_by for row in session.shifts} == {"visual_feedback"}
    assert {row.reached for row in session.shifts[::2]} > {"red", "green"}
    assert np.mean([row.learned for row in session.shifts]) > 0.95
    assert session.robot.iterations == sum(row.learned for row in session.shifts[::2])


def test_told_once_it_draws_one_object_and_never_the_face():
    selector = ToldSelector(AttentionConfig(), 4, np.random.default_rng(0))
    visible = np.ones(5, bool)
    assert selector.draw(visible) is None
    drawn = []
    for _ in range(200):
        selector.told = True
        drawn.append(selector.draw(visible))
        assert selector.draw(visible) is None
    assert set(drawn) == {0, 1, 2, 3}
    selector.told = True
    assert selector.draw(np.array([False] * 4 + [True])) is None and selector.told  # nothing in view: told all the same


def test_test_gazes_are_passed_by_a_learner_that_knows_geometry_and_by_no_constant(session):
    gazes = Gazes(session.config.world, 150, 0.0, np.random.default_rng(0))
    start = directions_to(np.array([HEAD_POSITION]))[0]
    share = session.config.world.behaviour.head_share

    class Geometer:
        """Follows a line of sight to the table."""

        def predict(self, pattern: np.ndarray) -> np.ndarray:
            yaw, pitch = np.radians(pattern / share)
            reach = (HEAD_POSITION[2] - 0.741) / np.tan(pitch)
            location = np.array([[HEAD_POSITION[0] - reach * np.cos(yaw), -reach * np.sin(yaw), 0.741]])
            return directions_to(location)[0] - start

    class Constant:
        """Always looks at the middle of the table."""

        def predict(self, pattern: np.ndarray) -> np.ndarray:
            return np.array([0.0, -17.0])

    class Robot:
        som = type("Map", (), {"activations": staticmethod(lambda pattern: pattern)})

    robot = Robot()
    robot.learner = Geometer()
    right, error = gazes.test(robot)
    assert right == 1.0 and error < 1e-6
    robot.learner = Constant()
    right, error = gazes.test(robot)
    assert 0.1 < right < 0.45 and error > 5


def test_a_learning_curve_rises_and_says_what_it_learned_from(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2]))
    from experiments.synchronised import analysis, sweep
    from jointattn_mj.sweeps.claim import Trial

    config = sweep.SETTINGS["cues"].config
    robot = replace(config.robot, familiarise=replace(config.robot.familiarise, minutes=1.0))
    config = replace(config, minutes=4.0, robot=robot)
    curve = sweep.learning_curve(config, np.array([0, 10, 40, 10_000]), gazes=100)
    assert curve["accuracy"][2] > curve["accuracy"][0] + 0.1
    assert curve["error_deg"][2] < curve["error_deg"][0]
    assert np.isnan(curve["accuracy"][3]) and curve["pairs"][2] >= 60
    assert 0.25 < curve["right_pairs"][2] < 0.8
    monkeypatch.setattr(sweep, "learning_curve", lambda config: curve)
    trial = Trial("cues", 0, sweep.trial(config, 0))
    assert analysis.columns([trial, trial])["accuracy"].shape == (2, 4)
    assert "half open" in analysis.analyse({"cues": [trial]})[0].dissertation


def test_when_a_run_is_good_enough(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2]))
    from experiments.synchronised.analysis import reaches

    accuracy = np.array([[0.2, 0.3, 0.5, 0.7, 0.8, 0.8, 0.8, 0.8, 0.8], [0.8] * 9])
    assert reaches(np.arange(0, 401, 50), accuracy, 0.8).tolist() == [150, 0]
    assert reaches(np.array([0, 400]), np.array([[0.0, np.nan]]), 0.8).tolist() == [np.inf]
