"""``jointattn develop realtime``: an hour in minutes, to its end, however it is interrupted."""

from dataclasses import replace

import pytest

from jointattn_mj.cli import main as cli
from jointattn_mj.development.config import DevelopmentOptions
from jointattn_mj.development.realtime.config import RealtimeDevelopmentConfig
from jointattn_mj.development.realtime.run import RealtimeConfig
from jointattn_mj.development.run import run_development
from jointattn_mj.errors import CheckpointError, ConfigError
from jointattn_mj.io import rows
from jointattn_mj.scene.world import WorldObservation

pytestmark = pytest.mark.integration

SHORT = RealtimeDevelopmentConfig(minutes=0.6, realtime=RealtimeConfig(perception="state", familiarise_minutes=1.0))


def test_it_runs_as_many_minutes_as_asked_for_and_resumes_to_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(rows, "BUFFER_BYTES", 36)  # three steps
    spent = []
    whole = run_development(SHORT, DevelopmentOptions(tmp_path / "whole"), lambda run, found: spent.append(run.spent))
    assert spent == sorted(spent) and 0.6 <= spent[-1] < 0.7
    assert whole.summary.more["minutes"] == spent[-1] and whole.summary.steps == len(spent) > 10

    def stop(run, found):
        if run.steps_done == 7:
            raise KeyboardInterrupt

    options = DevelopmentOptions(tmp_path / "stopped", checkpoint_every=5)
    with pytest.raises(KeyboardInterrupt):
        run_development(SHORT, options, stop)
    assert run_development(SHORT, replace(options, resume=True)) == whole


def test_a_robot_that_did_not_know_its_delay_does_not_go_on_as_if_it_had(tmp_path):
    """Checkpoints of before there was ``AlignedObservation`` hold such a robot."""
    late = replace(SHORT, seed=2, realtime=replace(SHORT.realtime, variation="camera"))

    def stop(run, found):
        assert run.world.conditions.sensor.delay
        run._observation = WorldObservation(run.world)
        if run.steps_done == 7:
            raise KeyboardInterrupt

    options = DevelopmentOptions(tmp_path, checkpoint_every=5)
    with pytest.raises(KeyboardInterrupt):
        run_development(late, options, stop)
    with pytest.raises(CheckpointError, match="how late its camera is"):
        run_development(late, replace(options, resume=True))


def test_each_world_has_its_own_options(capsys):
    for world, options in (
        ("table", ["--table.spots"]),
        ("rendered", ["--rendered.stage.looks-at", "--maps", "--continuous.enough", "--babbling.steps"]),
        ("realtime", ["--minutes", "--realtime.longest-s"]),
    ):
        cli.main(["develop", world, "--help-all"])
        said = capsys.readouterr().out
        assert all(option in said for option in options)
        assert ("--minutes" in said) == (world == "realtime")


def test_minutes_that_are_none():
    with pytest.raises(ConfigError, match="minutes"):
        RealtimeDevelopmentConfig(minutes=0)
