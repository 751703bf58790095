"""``jointattn develop --world rendered --mode realtime``: an hour in minutes, to its end, however it is interrupted."""

from dataclasses import replace

import pytest

from jointattn_mj.cli import main as cli
from jointattn_mj.development.realtime.config import RealtimeDevelopConfig
from jointattn_mj.development.realtime.run import RealtimeConfig
from jointattn_mj.development.run import DevelopOptions, run_development
from jointattn_mj.errors import ConfigError
from jointattn_mj.io import rows

SHORT = RealtimeDevelopConfig(minutes=0.6, realtime=RealtimeConfig(perception="state", familiarise_minutes=1.0))


def test_it_lives_as_many_minutes_as_asked_for_and_resumes_to_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(rows, "BUFFER_BYTES", 36)  # three steps
    visible = []
    summary = run_development(SHORT, DevelopOptions(tmp_path / "whole"), lambda run, found: visible.append(run.spent))
    assert visible == sorted(visible) and 0.6 <= visible[-1] < 0.7
    assert summary["minutes"] == visible[-1] and summary["steps"] == len(visible) > 10

    def stop(run, found):
        if run.steps_done == 7:
            raise KeyboardInterrupt

    options = DevelopOptions(tmp_path / "stopped", checkpoint_every=5)
    with pytest.raises(KeyboardInterrupt):
        run_development(SHORT, options, stop)
    assert run_development(SHORT, replace(options, resume=True)) == summary


def test_the_command_line_chooses_the_world_and_how_time_goes_on(capsys):
    for arguments, option in (
        ([], "--table.spots"),
        (["--world", "rendered"], "--rendered.exploration"),
        (["--world=rendered", "--mode", "realtime"], "--minutes"),
    ):
        cli.main(["develop", *arguments, "--help"])
        assert option in capsys.readouterr().out


def test_minutes_that_are_none():
    with pytest.raises(ConfigError, match="minutes"):
        RealtimeDevelopConfig(minutes=0)
