"""The benchmark measures what it says; how fast is not for tests to judge."""

import json
import math

import pytest

from jointattn_mj.benchmarks import loop as benchmark
from jointattn_mj.benchmarks import steps as steps_benchmark
from jointattn_mj.benchmarks import vector as vector_benchmark
from jointattn_mj.benchmarks.figures import Figures, committed
from jointattn_mj.benchmarks.options import BenchmarkOptions
from jointattn_mj.cli import benchmark as command
from jointattn_mj.cli.costs import measured
from jointattn_mj.cli.main import main
from jointattn_mj.errors import CommandError, ConfigError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, RobotConfig
from jointattn_mj.gaze_following.session import SessionConfig
from jointattn_mj.scene import gl

pytestmark = pytest.mark.integration

needs_gl = pytest.mark.skipif(not any(map(gl.available, gl.LIBRARIES)), reason="no OpenGL library to render with")


SCENE = (
    "renderer", "render_ms", "render_to_dm_control", "loop_ms_per_image", "loop_to_render", "contingent_to_render",
    "changes_to_render", "loop_times_real_time", "session_26_min_s", "familiarise_s", "state_times_real_time",
    "closed_form_times_real_time", "cartpole_ms", "loop_to_cartpole",
)  # fmt: skip


def shown(said):
    """Names and medians of a printed table."""
    return dict(line.split()[:2] for line in said.splitlines()[1:])


@needs_gl
def test_figures(tmp_path, capsys, monkeypatch):
    robot = RobotConfig(familiarise=FamiliariseConfig(minutes=0.05))
    monkeypatch.setattr(benchmark, "SessionConfig", lambda **options: SessionConfig(robot=robot, **options))
    monkeypatch.setattr(benchmark, "CARTPOLE_STEPS", 5)
    main(["benchmark", "--blocks", "1", "--seconds", "2", "--out", str(tmp_path / "figures.json")])
    figures = json.loads((tmp_path / "figures.json").read_text())
    assert figures.pop("quartiles") == {}
    assert tuple(figures) == tuple(shown(capsys.readouterr().out)) == SCENE
    assert figures.pop("renderer")
    for name, value in figures.items():
        assert math.isfinite(value), name
        assert value > 0, name
    assert figures["loop_to_render"] == pytest.approx(figures["loop_ms_per_image"] / figures["render_ms"])
    assert figures["session_26_min_s"] == pytest.approx(26 * 60 / figures["loop_times_real_time"])
    assert figures["loop_to_cartpole"] == pytest.approx(figures["loop_ms_per_image"] / figures["cartpole_ms"])
    assert figures["state_times_real_time"] > figures["loop_times_real_time"]


@needs_gl
def test_steps(capsys, monkeypatch):
    monkeypatch.setattr(steps_benchmark, "STEPS", 30)
    main(["benchmark", "--what", "steps", "--blocks", "1"])
    figures = {name: float(value) for name, value in shown(capsys.readouterr().out).items()}
    assert figures.keys() == {"step_image_ms", "step_ms", "step_to_image", "centre_step_to_image", "table_step_us"}
    assert all(math.isfinite(value) and value > 0 for value in figures.values())
    assert figures["step_to_image"] == pytest.approx(figures["step_ms"] / figures["step_image_ms"], rel=0.02)


@needs_gl
def test_many_worlds(capsys, monkeypatch):
    monkeypatch.setattr(vector_benchmark, "WORLDS", 2)
    monkeypatch.setattr(vector_benchmark, "STEPS", {"state": 10, "images": 2})
    main(["benchmark", "--what", "vector", "--blocks", "1"])
    figures = {name: float(value) for name, value in shown(capsys.readouterr().out).items()}
    assert figures.keys() == {f"vector_{kind}" for kind in (
        "state_steps_per_s", "state_to_sync", "images_steps_per_s", "images_to_sync",
    )}  # fmt: skip
    assert all(math.isfinite(value) and value > 0 for value in figures.values())
    assert figures["vector_state_steps_per_s"] > figures["vector_images_steps_per_s"]


@needs_gl
def test_parts_are_measured_in_processes_of_their_own(monkeypatch, tmp_path, capfd):
    monkeypatch.setattr(vector_benchmark, "STEPS", {})  # nothing would be measured here
    monkeypatch.setattr(command, "PARTS", {"vector": command.PARTS["vector"]})
    main(["benchmark", "--what", "all", "--blocks", "2", "--out", str(tmp_path / "figures.json")])
    figures = Figures.read(tmp_path / "figures.json")
    assert figures.values.keys() == figures.quartiles.keys() == shown(capfd.readouterr().out).keys()
    assert len(figures.values) == 4


def test_a_part_that_cannot_be_measured(monkeypatch, capfd):
    monkeypatch.setenv("MUJOCO_GL", "disable")
    with pytest.raises(SystemExit) as stop:
        main(["benchmark", "--what", "all"])
    assert stop.value.code == 1
    said = capfd.readouterr().err.splitlines()
    assert len(said) == 1
    assert "MUJOCO_GL turns rendering off" in said[0]


def test_figures_stand_beside_their_quartiles_and_those_before(tmp_path):
    figures = Figures()
    figures.add("taken_s", [1.0, 4.0, 2.0, 3.0])
    figures.add("renderer", "llvmpipe (LLVM 15)")
    figures.add("pyinform_ms", None)
    assert figures.text({"taken_s": 5.0, "gone_s": 1.0}).splitlines() == [
        "             now            quartiles     committed",
        "taken_s      2.5            1.75 to 3.25  5",
        "renderer     llvmpipe                     -",
        "pyinform_ms  not installed                -",
    ]
    figures.write(tmp_path / "figures.json")
    assert vars(Figures.read(tmp_path / "figures.json")) == vars(figures)
    assert json.loads((tmp_path / "figures.json").read_text()) == {
        "taken_s": 2.5, "renderer": "llvmpipe (LLVM 15)", "pyinform_ms": None, "quartiles": {"taken_s": [1.75, 3.25]},
    }  # fmt: skip


def test_the_committed_figures_have_todays_names():
    names = {*SCENE, "step_to_image", "thesis_100k_s", "transfer_entropy_to_pyinform"} - {
        "familiarise_s",
        "changes_to_render",
    }
    assert names <= committed().keys()


def test_what_a_command_takes_is_measured():
    cost = measured("--version")
    assert 0 < cost.seconds < 60
    assert cost.mebibytes > 5
    with pytest.raises(CommandError, match="jointattn no-such-command: no command 'no-such-command'"):
        measured("no-such-command")


@pytest.mark.parametrize("options", [{"blocks": 0}, {"seconds": 0.0}, {"seconds": math.nan}])
def test_impossible_options(options):
    with pytest.raises(ConfigError, match=next(iter(options))):
        BenchmarkOptions(**options)
