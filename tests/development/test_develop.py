"""Runs in folders: same seed, same files; stopped and killed runs go on; bad usage is refused in a line."""

import contextlib
import dataclasses
import json
import signal
import subprocess
import sys
from pathlib import Path

import pyarrow.parquet as pq
import pytest
import yaml
from shell import refused, stopped

from jointattn_mj.cli.develop import with_world
from jointattn_mj.development import figures
from jointattn_mj.development.config import DevelopmentOptions
from jointattn_mj.development.run import run_development
from jointattn_mj.development.table.config import TableDevelopmentConfig
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.errors import CheckpointError, ConfigError, OutputError
from jointattn_mj.io import space
from jointattn_mj.options import RenamedWarning

pytestmark = pytest.mark.integration

STEPS = 12_000
SHORT = ("--preset", "fast", "--seed", 1, "--steps", STEPS)
ALWAYS = {
    "behaviour.png", "checkpoint.bin", "config.yaml", "contingency.parquet", "maps.png", "sac.png", "summary.json",
    "steps.parquet",
}  # fmt: skip


def config(**changes) -> TableDevelopmentConfig:
    return TableDevelopmentConfig.of(**{"preset": "fast", "seed": 1, "steps": STEPS, **changes})


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def results(folder: Path) -> dict[str, bytes]:
    """All but the checkpoint, whose bytes depend on how often it was written."""
    return {name: data for name, data in content(folder).items() if name != "checkpoint.bin"}


@pytest.fixture(scope="module")
def finished(tmp_path_factory) -> Path:
    """A folder with a run in it."""
    out = tmp_path_factory.mktemp("run") / "finished"
    run_development(config(), DevelopmentOptions(out))
    return out


@pytest.fixture
def without_images(monkeypatch):
    """They take most of the time."""
    for name in ("draw_contingency", "draw_behaviour", "draw_maps"):
        monkeypatch.setattr(figures, name, lambda *_: None)


class TestResults:
    def test_files(self, finished):
        names = {path.name for path in finished.iterdir()}
        modules = {f"module_{number}.csv" for number in range(1, len(names) - len(ALWAYS) + 1)}
        assert names == ALWAYS | modules
        assert len(modules) >= 3

    def test_summary(self, finished):
        summary = json.loads((finished / "summary.json").read_text("utf-8"))
        assert (summary["preset"], summary["seed"], summary["steps"]) == ("fast", 1, STEPS)
        modules = summary["modules"]
        assert [made["step"] for made in modules] == sorted(made["step"] for made in modules)
        first = modules[0]
        assert first["event"] == "caregiver's face, shift gaze -> object"
        assert first["symbol"] == "(S1, A1, R3)"
        assert (first["name"], first["means"]) == ("FG-m", "gaze following")
        assert [made["name"] for made in modules[1:3]] == ["SCf-m", "SC-m"]
        assert all((finished / made["map"]).exists() for made in modules)
        phases = summary["phases"]
        assert [part["phase"] for part in phases] == [f"P{number}" for number in range(1, len(modules) + 2)]
        assert [part["last_step"] for part in phases] == [*(made["step"] for made in modules), STEPS]
        assert all(sum(part["rates"].values()) == pytest.approx(1, abs=1e-3) for part in phases)
        ranking = [made["value"] for made in summary["highest_at_the_end"]]
        assert ranking == sorted(ranking, reverse=True)

    def test_config(self, finished):
        written = yaml.safe_load((finished / "config.yaml").read_text())
        assert written["config"]["agent"]["detector"]["stop_rule"] == "confidence"
        assert "numba" in written["versions"]

    def test_log(self, finished):
        assert pq.read_metadata(finished / "steps.parquet").num_rows == STEPS
        assert pq.read_metadata(finished / "contingency.parquet").num_rows == STEPS // 100

    def test_same_seed_same_files(self, finished, tmp_path):
        run_development(config(), DevelopmentOptions(tmp_path / "again"))
        assert content(tmp_path / "again") == content(finished)

    def test_another_seed(self, finished, tmp_path, without_images):
        run_development(config(seed=2), DevelopmentOptions(tmp_path / "other"))
        assert (tmp_path / "other" / "steps.parquet").read_bytes() != (finished / "steps.parquet").read_bytes()

    def test_other_tables(self, tmp_path):
        """More spots, no profile, no module; one step only."""
        other = TableDevelopmentConfig.of(preset="chapter4", steps=500, table={"spots": 4})
        result = run_development(other, DevelopmentOptions(tmp_path / "table"))
        assert result.modules == () and result.summary.measure == "tc"
        result = run_development(TableDevelopmentConfig(steps=1), DevelopmentOptions(tmp_path / "step"))
        assert result.summary.steps == len(result.log) == 1

    def test_what_it_tells(self, tmp_path, without_images):
        told, steps_done = [], []

        def progress(run, found):
            steps_done.append(run.steps_done)
            told.extend((detection.step, meaning.words) for detection, meaning in found)

        result = run_development(config(), DevelopmentOptions(tmp_path, checkpoint_every=5000), progress)
        assert steps_done == [5000, 10_000, STEPS]
        assert told == [(made.step, made.means) for made in result.modules]

    def test_faces_avoided(self, tmp_path, without_images):
        """Fewer looks at the caregiver from the first phase on."""
        rates = []
        for reactive in ("random", "face_avoiding"):
            chosen = config(reactive=reactive, steps=2000)
            result = run_development(chosen, DevelopmentOptions(tmp_path / reactive))
            rates.append(result.summary.phases[0].rates)
        assert rates[1]["SC"] < rates[0]["SC"] / 3


KILLED = """
import os, signal, sys
from jointattn_mj.cli import main as cli, develop as develop_command
run, at = develop_command.run_development, int(sys.argv[1])
def killed(config, options, progress):
    def watch(run, found):
        if run.steps_done >= at:
            os.kill(os.getpid(), signal.SIGKILL)
    return run(config, options, watch)
develop_command.run_development = killed
cli.main(sys.argv[2:])
"""


class TestGoingOn:
    def test_after_a_kill(self, jointattn, finished, tmp_path):
        """kill -9 between checkpoints: the same files, byte for byte."""
        arguments = ["develop", "--out", tmp_path, *SHORT, "--checkpoint-every", 4000]
        program = [sys.executable, "-c", KILLED, "9000", *map(str, arguments)]
        assert subprocess.run(program, capture_output=True).returncode == -signal.SIGKILL
        assert {path.name for path in tmp_path.iterdir()} == {".lock", "checkpoint.bin", "config.yaml", "log"}
        (tmp_path / ".sac.123.png").write_text("half")
        outcome = jointattn(*arguments, "--resume")
        assert outcome.code == 0, outcome.err
        assert results(tmp_path) == results(finished)

    @pytest.mark.parametrize("changes", [{"memory": "window", "horizon": 3000}, {"refresh_every": 700}])
    def test_other_agents(self, tmp_path, changes, without_images):
        """What they remember besides counts is stored, too."""
        chosen = config(agent=changes, steps=6000)
        run_development(chosen, DevelopmentOptions(tmp_path / "whole"))

        class Stopped(Exception):
            pass

        def stop(run, found):
            if run.steps_done == 4500:
                raise Stopped

        with pytest.raises(Stopped):
            run_development(chosen, DevelopmentOptions(tmp_path / "parts", checkpoint_every=1500), stop)
        run_development(chosen, DevelopmentOptions(tmp_path / "parts", resume=True))
        assert results(tmp_path / "parts") == results(tmp_path / "whole")

    def test_of_a_finished_run(self, finished, tmp_path):
        before = content(finished)
        run_development(config(), DevelopmentOptions(finished, resume=True))
        assert content(finished) == before

    def test_of_nothing(self, tmp_path):
        with pytest.raises(CheckpointError, match="no checkpoint"):
            run_development(config(), DevelopmentOptions(tmp_path, resume=True))

    def test_of_another_run(self, finished):
        with pytest.raises(CheckpointError, match="another config"):
            run_development(config(seed=7), DevelopmentOptions(finished, resume=True))

    def test_folder_holds_another_run(self, finished):
        with pytest.raises(OutputError, match="already holds a run"):
            run_development(config(), DevelopmentOptions(finished))

    @pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
    def test_stopped_from_outside(self, tmp_path, number):
        refused(stopped(number, tmp_path, "develop", "--steps", 20_000_000), 130, "--resume", str(tmp_path))
        assert {path.name for path in tmp_path.iterdir()} - {"log"} == {"checkpoint.bin", "config.yaml"}


BAD_OPTIONS = [
    (("--preset", "quick"), ("thesis_robot_first", "fast", "chapter4", "quick")),
    (("--preset=quick",), ("quick",)),
    (("--world", "moon"), ("world", "moon", "table")),
    (("--maps", "continuous"), ("--maps",)),
    (("--table.spot", "4"), ("--table.spot", "--table.spots")),
    (("--steps", "0"), ("steps", "0")),
    (("--steps", "1e5"), ("steps", "1e5")),
    (("--seed", "-1"), ("seed", "-1")),
    (("--sample-every", "0"), ("sample_every", "0")),
    (("--checkpoint-every", "0"), ("checkpoint_every", "0")),
    (("--reactive", "shy"), ("reactive", "shy", "face_avoiding")),
    (("--agent.detector.threshold", "0"), ("threshold", "0")),
    (("--agent.memory", "none"), ("memory", "none")),
    (("--table.spots", "1"), ("spots", "1")),
    (("--table.spots", "200"), ("125", "200")),
    (("--table.caregiver.follow", "2"), ("follow", "2")),
    (("--table.order", "both"), ("order", "both")),
    (("--steps", "1000000000000000"), ("steps", "1e10")),
    (("--steps", "10000000000", "--sample-every", "1"), ("steps", "GB", "--sample-every")),
    (("--no-such-option",), ("--no-such-option",)),
]


@pytest.mark.parametrize(("options", "words"), BAD_OPTIONS, ids=lambda value: value[0].strip("-"))
def test_bad_options(jointattn, tmp_path, options, words):
    refused(jointattn("develop", "--out", tmp_path / "out", *options), 2, *words)
    assert not (tmp_path / "out").exists()


def test_without_a_folder(jointattn):
    refused(jointattn("develop"), 2, "--out")


def test_flags_override_single_fields_of_the_preset(jointattn, tmp_path):
    options = ("--agent.detector.deviations", 2.5, "--table.caregiver.follow=0.75", "--table.no-profile")
    outcome = jointattn("develop", "--steps", 300, *options, "--preset=fast", "--out", tmp_path)
    assert outcome.code == 0, outcome.err
    written = yaml.safe_load((tmp_path / "config.yaml").read_text())["config"]
    fast = PRESETS["fast"]
    assert written["agent"]["detector"] == dataclasses.asdict(fast.agent.detector) | {"deviations": 2.5}
    assert written["agent"]["memory"] == "reset"
    caregiver = dataclasses.asdict(fast.world.caregiver) | {"follow": 0.75}
    assert written["table"] == dataclasses.asdict(fast.world) | {"caregiver": caregiver, "profile": False}


def test_a_preset_may_need_what_another_forbids(jointattn, tmp_path):
    """Nine objects need the nine spots of chapter 4; options are held against each other when the preset is known."""
    outcome = jointattn(
        "develop", "table", "--table.objects", 9, "--preset", "chapter4", "--steps", 1, "--out", tmp_path
    )
    assert outcome.code == 0, outcome.err


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("table --preset fast", "table --preset fast"),
        ("--preset fast", "table --preset fast"),
        ("--seed 1 --world rendered", "rendered --seed 1"),
        ("--world=rendered --mode realtime --minutes 2", "realtime --minutes 2"),
        ("--world rendered --mode turns", "rendered"),
        ("--world table --seed 3", "table --seed 3"),
        ("", "table"),
    ],
)
def test_what_the_last_version_typed_is_understood(typed, meant):
    old = "--world" in typed
    with pytest.warns(RenamedWarning, match=meant.split()[0]) if old else contextlib.nullcontext():
        assert with_world(typed.split()) == meant.split()


def test_old_names_of_groups_are_understood(jointattn, tmp_path):
    options = ("--mind.memory", "reset", "--mind.detector.rule=certain", "--steps", 50)
    outcome = jointattn("develop", "--world", "table", *options, "--out", tmp_path)
    assert outcome.code == 0
    for name in ("develop table", "--agent.memory", "--agent.detector.stop-rule", "confidence"):
        assert name in outcome.err
    agent = yaml.safe_load((tmp_path / "config.yaml").read_text())["config"]["agent"]
    assert (agent["memory"], agent["detector"]["stop_rule"]) == ("reset", "confidence")


def test_a_config_file_gives_defaults(jointattn, finished, tmp_path):
    """The same run again from its config.yaml; options override it, but for those that choose other defaults."""
    file = finished / "config.yaml"
    outcome = jointattn("develop", "table", "--config", file, "--out", tmp_path / "again")
    assert outcome.code == 0, outcome.err
    assert results(tmp_path / "again") == results(finished)
    options = ("--steps", 30, "--agent.memory", "whole", "--preset", "fast")
    outcome = jointattn("develop", "table", "--config", file, *options, "--out", tmp_path / "other")
    assert outcome.code == 0, outcome.err
    written = yaml.safe_load((tmp_path / "other" / "config.yaml").read_text())["config"]
    before = yaml.safe_load(file.read_text())["config"]
    assert written == before | {"steps": 30, "agent": before["agent"] | {"memory": "whole"}}
    refused(
        jointattn("develop", "--config", file, "--preset", "thesis", "--out", tmp_path / "no"), 2, "--preset thesis"
    )


@pytest.mark.parametrize("typed", ["develop moon", "develop --world moon"])
def test_no_such_world(jointattn, typed):
    refused(jointattn(*typed.split()), 2, "moon", "table, rendered, realtime")


def test_what_it_says(jointattn, tmp_path):
    outcome = jointattn("develop", "--out", tmp_path / "out", *SHORT)
    assert (outcome.code, outcome.err) == (0, "")
    lines = outcome.out.splitlines()
    first = json.loads((tmp_path / "out" / "summary.json").read_text("utf-8"))["modules"][0]
    assert f"{first['step']:,}  caregiver's face, shift gaze -> object" in lines[1]
    assert lines[1].endswith("gaze following (FG-m)")
    assert lines[-1].endswith(str(tmp_path / "out"))


def test_help(jointattn):
    outcome = jointattn("develop", "--help")
    assert outcome.code == 0
    for word in ("table", "rendered", "realtime", "sac.png"):
        assert word in outcome.out
    outcome = jointattn("develop", "table", "--help-all")
    assert outcome.code == 0
    for word in ("--preset", "--table.caregiver.follow", "--agent.selector.habituation", "--reactive", "--out"):
        assert word in outcome.out
    assert "(default: 3; 9 with chapter4)" in outcome.out
    assert "--world" not in outcome.out and "--maps" not in outcome.out


def test_needs_no_3d_world():
    """Neither MuJoCo nor OpenCV is imported for a run at the table."""
    program = (
        "import sys; from jointattn_mj.cli import develop; "
        "from jointattn_mj.development import figures, logbook; "
        "print({'mujoco', 'cv2', 'torch', 'dm_control'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout == "set()\n", done.stderr


def test_too_little_space(tmp_path, monkeypatch):
    """Refused before anything is written."""
    monkeypatch.setattr(space, "free_bytes", lambda folder: 1_000_000)
    with pytest.raises(ConfigError, match="fewer steps"):
        run_development(config(steps=1_000_000), DevelopmentOptions(tmp_path / "out"))
    with pytest.raises(ConfigError, match="larger `sample_every`"):
        run_development(config(sample_every=1), DevelopmentOptions(tmp_path / "out"))
    assert not (tmp_path / "out").exists()
