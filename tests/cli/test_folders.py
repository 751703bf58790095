"""A folder belongs to one run at a time, whatever the command; and no kill and no disk leaves it unusable."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from clips import counted, encode
from shell import Outcome, refused

from jointattn_mj.io import files
from jointattn_mj.io.files import held

pytestmark = pytest.mark.integration

SESSION = ("session", "--perception", "state", "--minutes", 0.1, "--robot.familiarise.minutes", 0.05)
COMMANDS = {
    "session": SESSION,
    "develop": ("develop", "--steps", 2000),
    "rendered": ("develop", "rendered", "--steps", 20),
    "realtime": ("develop", "realtime", "--steps", 20),
    "perceive": ("perceive", "VIDEO", "--no-overlay", "--scale", 1, "--som.updates", 10),
    "play": ("play", "follow_hard", "--agent", "zero", "--episodes", 1),
    "recordings": ("recordings", "EVENTS", "--partner", "mother", "--time-unit", "s", "--resamples", 0),
    "measure": ("measure", "TABLE", "--source", "x", "--target", "y", "--surrogates", 10, "--resamples", 0),
}
OWNERS = ("session", "develop", "rendered", "realtime", "perceive")
"""Commands with checkpoints."""

KILLED = """
import os, signal, sys
from jointattn_mj.cli import main as cli
replace = os.replace
def killing(source, target):
    if str(target).endswith("checkpoint.bin"):
        os.kill(os.getpid(), signal.SIGKILL)
    replace(source, target)
os.replace = killing
cli.main(sys.argv[1:])
"""
"""``jointattn``, but it is killed before its first checkpoint is put in place."""


@pytest.fixture(scope="module")
def inputs(tmp_path_factory) -> dict[str, str]:
    """A video, a table, and coded events."""
    folder = tmp_path_factory.mktemp("inputs")
    (folder / "table.csv").write_text("x,y\n" + "0,1\n1,1\n1,0\n" * 20)
    looks = "".join(f"{who},{t},{t + 2},toy\n" for who in ("infant", "mother") for t in range(0, 60, 4))
    (folder / "events.csv").write_text(f"tier,onset,offset,code\n{looks}")
    video = encode(folder / "a.mkv", counted(20))
    return {"EVENTS": str(folder / "events.csv"), "VIDEO": str(video), "TABLE": str(folder / "table.csv")}


def command(name: str, inputs: dict[str, str], out: Path) -> list[str]:
    return [*(inputs.get(str(word), str(word)) for word in COMMANDS[name]), "--out", str(out)]


@pytest.mark.parametrize("name", [*OWNERS, "play", "recordings"])
def test_another_process_is_at_work(jointattn, inputs, tmp_path, name):
    out = tmp_path / "out"
    with held(out):
        for resume in ((), ("--resume",)) if name in OWNERS else ((),):
            refused(jointattn(*command(name, inputs, out), *resume), 2, str(out), "another process")
        assert [path.name for path in out.iterdir()] == [".lock"]


def test_two_sessions_at_once(tmp_path):
    """One does all, the other nothing."""
    program = [sys.executable, "-m", "jointattn_mj.cli.main", *map(str, SESSION), "--out", str(tmp_path), "--seed"]
    started = [
        subprocess.Popen([*program, str(seed)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for seed in (5, 6)
    ]
    ended = [(process.communicate(), process.returncode) for process in started]
    assert sorted(code for _, code in ended) == [0, 2]
    seed = next(seed for seed, (_, code) in zip((5, 6), ended, strict=True) if code == 0)
    for (_, err), code in ended:
        assert (err == "") if code == 0 else (err.count("\n") == 1 and str(tmp_path) in err)
    assert f"seed: {seed}" in (tmp_path / "config.yaml").read_text()
    assert not list(tmp_path.glob(".*"))


def test_two_that_resume_at_once(jointattn, tmp_path):
    """The first one is stopped, and loses nothing."""
    options = (*SESSION, "--minutes", 600, "--out", tmp_path)
    program = [sys.executable, "-m", "jointattn_mj.cli.main", *map(str, options)]
    for resume in ((), ("--resume",)):
        with subprocess.Popen([*program, *resume], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            while not ((tmp_path / "config.yaml").exists() and (tmp_path / ".lock").exists()):
                assert process.poll() is None
                time.sleep(0.02)
            refused(jointattn(*options, "--resume"), 2, "another process")
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=60)
        assert process.returncode == 130
        assert {path.name for path in tmp_path.iterdir()} == {"config.yaml", "checkpoint.bin", "log"}


@pytest.mark.parametrize("name", ["session", "develop", "perceive"])
def test_killed_before_the_first_checkpoint(jointattn, inputs, tmp_path, name):
    """The same command begins anew, and leaves nothing hidden."""
    arguments = command(name, inputs, tmp_path)
    killed = subprocess.run([sys.executable, "-c", KILLED, *arguments], capture_output=True)
    assert killed.returncode == -signal.SIGKILL
    assert len(list(tmp_path.glob(".checkpoint.*.bin"))) == 1
    refused(jointattn(*arguments, "--resume"), 2, "no checkpoint", "without --resume")
    assert not list(tmp_path.glob(".*"))
    outcome = jointattn(*arguments)
    assert (outcome.code, outcome.err) == (0, "")
    assert (tmp_path / "summary.json").exists()
    assert not list(tmp_path.glob(".*"))


@pytest.mark.parametrize("name", ["session", "develop", "perceive"])
def test_config_without_a_checkpoint(jointattn, inputs, tmp_path, name):
    """Of a run that was killed as it began: nothing is lost. With results beside it something would be."""
    arguments = command(name, inputs, tmp_path)
    assert jointattn(*arguments, "--seed", 1).code == 0
    (tmp_path / "checkpoint.bin").unlink()
    kept = {path: path.read_bytes() for path in tmp_path.iterdir()}
    refused(jointattn(*arguments, "--seed", 2), 2, "already holds a run", "no checkpoint", "another folder")
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == kept
    (tmp_path / "summary.json").unlink()
    assert jointattn(*arguments, "--seed", 2).code == 0
    assert "seed: 2" in (tmp_path / "config.yaml").read_text()


def test_somebody_elses_config(jointattn, tmp_path):
    (tmp_path / "config.yaml").write_text("mine: true\n")
    refused(jointattn(*SESSION, "--out", tmp_path), 2, "config.yaml", "another folder")
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("config.yaml", "mine: true\n")]


def test_no_locks(tmp_path, monkeypatch, capsys):
    """It goes on, and says what to see to."""

    def unknown(path):
        raise OSError(files.NO_LOCKS[0], os.strerror(files.NO_LOCKS[0]))

    monkeypatch.setattr(files, "locked", unknown)
    with held(tmp_path):
        pass
    assert capsys.readouterr().err == (
        f"jointattn: the file system of {tmp_path} knows no locks; see to it that no second run begins there\n"
    )


MOUNTED = """
import json, subprocess, sys
from shell import Shell
jointattn, outcomes = Shell(), []
for step in json.loads(sys.argv[1]):
    if step[0] == "jointattn":
        outcomes.append(vars(jointattn(*step[1:])))
    else:
        subprocess.run(step, check=True)
jointattn.close()
print(json.dumps(outcomes))
"""
"""Runs ``jointattn`` and other programs, and says how the first ended."""


def in_a_mount(*steps: list[str]) -> list[Outcome]:
    """How the steps ended that call ``jointattn``; the others may mount what nobody else sees."""
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    program = ["unshare", "-rm", sys.executable, "-c", MOUNTED, json.dumps(steps)]
    done = subprocess.run(program, env=os.environ | {"PYTHONPATH": path}, stdout=subprocess.PIPE, check=True)
    return [Outcome(**outcome) for outcome in json.loads(done.stdout)]


def can_mount() -> bool:
    program = ["unshare", "-rm", "mount", "-t", "tmpfs", "tmpfs", "/mnt"]
    return shutil.which("unshare") is not None and subprocess.run(program, capture_output=True).returncode == 0


@pytest.mark.skipif(not can_mount(), reason="nothing can be mounted here")
class TestMounted:
    def test_read_only(self, inputs, tmp_path):
        """An existing folder that cannot be written to: one line, whatever the command."""
        steps = [
            ["mount", "-t", "tmpfs", "tmpfs", str(tmp_path)],
            ["mkdir", str(tmp_path / "out")],
            ["mount", "-o", "remount,ro", str(tmp_path)],
            *(["jointattn", *command(name, inputs, tmp_path / "out")] for name in COMMANDS),
        ]
        outcomes = in_a_mount(*steps)
        assert len(outcomes) == len(COMMANDS)
        for outcome in outcomes:
            refused(outcome, 2, str(tmp_path), "write")

    @pytest.mark.parametrize(("name", "size"), [("play", 4), ("measure", 0), ("recordings", 4), ("perceive", 100)])
    def test_full(self, inputs, tmp_path, name, size):
        """One line; with space again the same command begins anew. ``size`` is in kB."""
        disk = tmp_path / "disk"
        disk.mkdir()
        (tmp_path / "filler").write_bytes(b"x" * 4096)
        again = ["jointattn", *command(name, inputs, disk / "out")]
        full, enough = in_a_mount(
            ["mount", "-t", "tmpfs", "-o", f"size={size + 4}k", "tmpfs", str(disk)],
            ["cp", str(tmp_path / "filler"), str(disk)],
            again,
            ["mount", "-o", "remount,size=20m", str(disk)],
            again,
        )
        refused(full, 2, str(disk), "No space left on device")
        assert (enough.code, enough.err) == (0, "")
