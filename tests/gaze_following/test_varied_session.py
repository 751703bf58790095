"""Sessions in worlds that the seed draws: one draw a session, off as ever, resumed as they would have gone on."""

from dataclasses import replace

import numpy as np
import pytest

from jointattn_mj.errors import CheckpointError, ConfigError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, RobotConfig
from jointattn_mj.gaze_following.run import SessionOptions, run_session
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.gaze_following.varied_session import VariedSessionConfig, VariedSessionRun
from jointattn_mj.io import checkpoint
from jointattn_mj.scene.world import AS_USUAL, WorldObservation

pytestmark = pytest.mark.integration

ROBOT = RobotConfig(familiarise=FamiliariseConfig(minutes=0.02))
VARIED = VariedSessionConfig(minutes=0.05, seed=4, robot=ROBOT, variation="all")


def angles(session: SessionRun, frames: int = 40) -> np.ndarray:
    path = []
    for _ in range(frames):
        session.step()
        path.append(session.world.data.qpos.copy())
    return np.array(path)


def test_off_is_the_same_session():
    plain = SessionRun(SessionConfig(minutes=0.05, seed=4, robot=ROBOT))
    off = VariedSessionRun(replace(VARIED, variation="none"))
    assert off.world.conditions == AS_USUAL
    np.testing.assert_array_equal(angles(plain), angles(off))
    np.testing.assert_array_equal(plain.world.image(), off.world.image())
    plain.close(), off.close()


def test_a_seed_decides_the_world_which_then_stays():
    first, same, second = (VariedSessionRun(replace(VARIED, seed=seed)) for seed in (4, 4, 5))
    assert first.world.config == same.world.config != second.world.config
    assert first.world.conditions == same.world.conditions != second.world.conditions
    before = first.world.conditions
    first.begin()
    first.step()
    assert first.world.conditions is before
    for session in (first, same, second):
        session.close()


def test_a_robot_that_knows_its_delay_lands_when_it_sees_that_it_has_turned():
    late = replace(VARIED, variation="camera", seed=955, minutes=1.0)
    off = []
    for knows in (False, True):
        session = VariedSessionRun(replace(late, knows_delay=knows))
        assert session.world.conditions.sensor.delay == 3
        session.begin()
        while session.frame < session.total:
            session.step()
        off.append([row.nearest_off_deg for row in session.shifts if row.face_to_object])
        session.close()
    unaware, aware = map(np.median, off)
    assert aware < 0.5 < unaware


def test_a_robot_that_did_not_know_its_delay_does_not_go_on_as_if_it_had(tmp_path):
    """Checkpoints of before there was the option hold such a robot, and their configs do not name it."""
    session = VariedSessionRun(VARIED)
    session.begin()
    session.step()
    session._observation = WorldObservation(session.world)
    checkpoint.save(tmp_path / "checkpoint.bin", (1.0, session), VARIED, VariedSessionRun.__module__)
    session.close()
    with pytest.raises(CheckpointError, match="how late the camera is"):
        run_session(VARIED, SessionOptions(tmp_path, resume=True), kind=VariedSessionRun)


def test_a_varied_session_goes_on_from_its_checkpoint(tmp_path):
    session = VariedSessionRun(VARIED)
    session.begin()
    angles(session, 20)
    checkpoint.save(tmp_path / "checkpoint.bin", session, VARIED)
    expected = angles(session)
    again = checkpoint.load(tmp_path / "checkpoint.bin", VARIED)
    np.testing.assert_array_equal(angles(again), expected)
    np.testing.assert_array_equal(again.world.image(), session.world.image())
    session.close(), again.close()


def test_the_command_takes_names_of_presets(tmp_path, jointattn):
    short = ("--minutes", "0.05", "--robot.familiarise.minutes", "0.02", "--perception", "state")
    run = jointattn("session", *short, "--variation", "pace+objects", "--out", tmp_path / "out")
    assert run.code == 0, run.err
    assert "variation: pace+objects" in (tmp_path / "out" / "config.yaml").read_text()
    wrong = jointattn("session", *short, "--variation", "weather", "--out", tmp_path / "other")
    assert wrong.code == 2
    assert "lights" in wrong.err
    assert not (tmp_path / "other").exists()


def test_unknown_presets_are_errors():
    with pytest.raises(ConfigError, match="lights"):
        VariedSessionConfig(variation="weather")
