"""A session from Python: in memory and in a folder it is the same, and a result is what its folder holds."""

import json
import signal
import sys
import types
from contextlib import contextmanager
from dataclasses import replace
from inspect import signature
from pathlib import Path

import numpy as np
import pytest

from jointattn_mj import Development, Session, SessionResult, SessionSummary, Table, perceive
from jointattn_mj.api.perceive import PerceiveFields
from jointattn_mj.cli.old_names import typed_names
from jointattn_mj.cli.parsing import module_of
from jointattn_mj.errors import CheckpointError, ConfigError, OutputError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, RobotConfig
from jointattn_mj.gaze_following.presets import PRESETS
from jointattn_mj.gaze_following.run import run_in_memory
from jointattn_mj.gaze_following.session import SessionRun
from jointattn_mj.gaze_following.varied_session import VariedSessionConfig, VariedSessionRun
from jointattn_mj.options import RenamedWarning

pytestmark = pytest.mark.integration

SHORT = RobotConfig(familiarise=FamiliariseConfig(minutes=0.05))
SESSION = Session(minutes=1, perception="state", seed=3, robot=SHORT)


@pytest.fixture(scope="module")
def result() -> SessionResult:
    return SESSION.run()


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A session that ran in a folder."""
    out = tmp_path_factory.mktemp("session") / "out"
    SESSION.run(out)
    return out


def test_a_run_in_memory_equals_one_in_a_folder(result, folder):
    opened = SessionResult.open(folder)
    assert opened == result
    assert opened.summary == result.summary and opened.shifts == result.shifts and opened.frames == result.frames
    assert (result.folder, opened.folder) == (None, folder)


def test_what_is_saved_is_what_the_folder_holds(result, folder, tmp_path):
    result.save(tmp_path / "saved")
    assert SessionResult.open(tmp_path / "saved") == result
    names = {path.name for path in folder.iterdir() if path.is_file()} - {".lock"}
    assert {path.name for path in (tmp_path / "saved").iterdir()} - {".lock"} == names - {"checkpoint.bin"}
    for name in names - {"checkpoint.bin", "summary.json"}:
        assert (folder / name).read_bytes() == (tmp_path / "saved" / name).read_bytes(), name
    with pytest.raises(OutputError, match="already holds a run"):
        result.save(tmp_path / "saved")


def test_another_seed_is_another_result(result):
    assert replace(SESSION, seed=4).run() != result
    assert result != "result"


def test_types_of_attributes(result, folder):
    for each in (result, SessionResult.open(folder)):
        assert type(each.config) is VariedSessionConfig and each.config == SESSION.config
        assert isinstance(each.summary, SessionSummary)
        assert isinstance(each.shifts, Table) and isinstance(each.frames, Table)
        assert all(isinstance(array, np.ndarray) for array in each.weights.values())
        assert each.shifts["success"].dtype == object and each.shifts["landing_s"].dtype == float
        assert len(each.frames) == each.summary.frames == 1800
        assert len(each.shifts) == each.summary.gaze_shifts_of_all_kinds


def test_tables_become_data_frames(result):
    frames = result.frames.to_pandas()
    assert list(frames.columns) == list(result.frames.columns) and len(frames) == 1800
    assert result.shifts.describe("launch_s") == "time at which the shift was decided"


def test_reprs_fit_a_line(result, folder):
    for shown in (SESSION, result, result.summary, result.shifts, result.frames, SessionResult.open(folder)):
        assert "\n" not in repr(shown) and len(repr(shown)) <= 200, repr(shown)
    assert repr(Session(minutes=2)) == "Session(minutes=2)"
    assert repr(result).startswith("SessionResult(1 min, ") and repr(result).endswith("in memory)")


def test_a_stopped_session_is_resumed(result, tmp_path):
    def interrupt(session: SessionRun) -> None:
        if session.frame == 900:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        SESSION.run(tmp_path / "out", progress=interrupt)
    with pytest.raises(OutputError, match="there is no"):
        SessionResult.open(tmp_path / "out")
    assert SESSION.run(tmp_path / "out", resume=True) == result
    assert SESSION.run(tmp_path / "out", resume=True) == result
    with pytest.raises(CheckpointError):
        replace(SESSION, seed=4).run(tmp_path / "out", resume=True)


def test_a_folder_of_the_last_version_is_read(folder, result, tmp_path):
    """Keys of its summary, names in its config."""
    SESSION.run(tmp_path / "out")
    summary = tmp_path / "out" / "summary.json"
    summary.write_text(json.dumps(SessionSummary.read(summary).by_old_keys()))
    config = tmp_path / "out" / "config.yaml"
    text = config.read_text().replace("perception: state", "perception: truth").replace("  state:", "  truth:")
    config.write_text(text)
    with pytest.warns(RenamedWarning):
        assert SessionResult.open(tmp_path / "out") == result


class Watched(SessionRun):
    """A session with parts of one's own."""

    def new_robot(self, perceiver, seed):
        robot = super().new_robot(perceiver, seed)
        robot.iterations = 1000
        return robot


def test_parts_of_ones_own(tmp_path):
    brief = replace(SESSION, minutes=0.2)
    assert brief.run(kind=Watched).frames["iterations"].min() >= 1000
    assert brief.run(tmp_path / "out", kind=Watched) == brief.run(kind=Watched)
    with pytest.raises(ConfigError, match="VariedSessionRun; got Watched"):
        replace(brief, variation="pace").run(kind=Watched)
    assert replace(brief, variation="pace").run() != brief.run()


def test_watchers_see_every_frame():
    seen = []

    @contextmanager
    def watcher(session):
        seen.append("begin")
        yield lambda session: seen.append(session.frame)
        seen.append("end")

    run_in_memory(replace(SESSION, minutes=0.05).config, watchers=[watcher], kind=VariedSessionRun)
    assert seen == ["begin", *range(90), "end"]


def test_a_log_for_rerun(tmp_path, monkeypatch):
    """With a package in Rerun's place: which file is written, and which is refused."""
    opened = []

    @contextmanager
    def log(path, session):
        opened.append(path)
        yield lambda session: None

    monkeypatch.setitem(sys.modules, "rerun", types.ModuleType("rerun"))
    monkeypatch.setitem(sys.modules, "jointattn_mj.adapters.rerun", types.SimpleNamespace(SessionLog=log))
    brief = replace(SESSION, minutes=0.02)
    assert brief.run(rerun=tmp_path / "logs" / "a.rrd") == brief.run(tmp_path / "out", rerun=tmp_path / "b.rrd")
    assert opened == [tmp_path / "logs" / "a.rrd", tmp_path / "b.rrd"]
    (tmp_path / "a.rrd").touch()
    for out in (None, tmp_path / "other"):
        with pytest.raises(OutputError, match="already there"):
            brief.run(out, rerun=tmp_path / "a.rrd")
        with pytest.raises(ConfigError, match=r"ends in \.rrd"):
            brief.run(out, rerun=tmp_path / "a.mp4")


def test_what_needs_a_folder():
    for options in ({"resume": True}, {"video": True}):
        with pytest.raises(ConfigError, match="need the folder out"):
            SESSION.run(**options)


def test_a_folder_without_a_session(tmp_path):
    with pytest.raises(OutputError, match="give the folder of a finished run"):
        SessionResult.open(tmp_path)


@pytest.mark.parametrize(
    ("command", "arguments"),
    [
        ("session", {*signature(Session).parameters, *signature(Session.run).parameters}),
        ("perceive", {*signature(perceive).parameters, *PerceiveFields.__annotations__}),
    ],
)
def test_every_option_of_a_command_is_an_argument(command, arguments):
    options = typed_names(getattr(module_of(command), command))
    assert {option.removeprefix("--").replace("-", "_") for option in options if "." not in option} <= arguments


def test_parts_are_configs_or_what_differs():
    shut = Session(robot={"gaze": {"gate": "shut"}}, motion_cues=False, caregiver="noa")
    assert (shut.robot.gaze.gate, shut.robot.attention.motion_cues) == ("shut", False)
    assert shut.world.scene.caregiver == "noa"
    learner = PRESETS["cross_situational"]
    opened = Session(preset="cross_situational", robot={"gaze": {"gate": "open"}})
    assert opened.robot == replace(learner, gaze=replace(learner.gaze, gate="open"))
    assert replace(opened, seed=2).robot == opened.robot
    assert Session(robot=RobotConfig(), motion_cues=False) == Session(motion_cues=False)
    noa = Development("fast", world="rendered", caregiver="noa").config
    assert noa.rendered.stage.world.scene.caregiver == "noa"
