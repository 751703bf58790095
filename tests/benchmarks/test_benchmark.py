"""The benchmark measures what it says; how fast is not for tests to judge."""

import json
import math

import pytest

from jointattn_mj.benchmarks import loop as benchmark
from jointattn_mj.benchmarks import steps as steps_benchmark
from jointattn_mj.benchmarks.loop import BenchmarkOptions, run_benchmark
from jointattn_mj.benchmarks.steps import StepsBenchmark
from jointattn_mj.cli.main import main
from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, RobotConfig
from jointattn_mj.gaze_following.session import SessionConfig
from jointattn_mj.scene import gl

pytestmark = pytest.mark.integration

needs_gl = pytest.mark.skipif(not any(map(gl.available, gl.LIBRARIES)), reason="no OpenGL library to render with")


@needs_gl
def test_figures(tmp_path, capsys, monkeypatch):
    robot = RobotConfig(familiarise=FamiliariseConfig(minutes=0.05))
    monkeypatch.setattr(benchmark, "SessionConfig", lambda **options: SessionConfig(robot=robot, **options))
    monkeypatch.setattr(benchmark, "CARTPOLE_STEPS", 5)
    main(["benchmark", "--blocks", "1", "--seconds", "2", "--out", str(tmp_path / "figures.json")])
    figures = json.loads((tmp_path / "figures.json").read_text())
    shown = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert figures.keys() == shown.keys() == run_benchmark.__annotations__["return"].__annotations__.keys()
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
    figures = {name: float(value) for name, value in map(str.split, capsys.readouterr().out.splitlines())}
    assert figures.keys() == StepsBenchmark.__annotations__.keys()
    assert all(math.isfinite(value) and value > 0 for value in figures.values())
    assert figures["step_to_image"] == pytest.approx(figures["step_ms"] / figures["step_image_ms"], rel=0.02)


@pytest.mark.parametrize("options", [{"blocks": 0}, {"seconds": 0.0}, {"seconds": math.nan}])
def test_impossible_options(options):
    with pytest.raises(ConfigError, match=next(iter(options))):
        BenchmarkOptions(**options)
