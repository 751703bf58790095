"""The command line: what it says, and how it refuses what cannot be done. Nothing that was there is lost."""

import json
import os
import shutil
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from shell import Outcome, refused, stopped

from jointattn_mj import Development, Session, perceive, run_claim
from jointattn_mj.cli import main as cli
from jointattn_mj.cli import parsing
from jointattn_mj.development.config import DevelopmentOptions
from jointattn_mj.errors import ConfigError
from jointattn_mj.scene import gl

pytestmark = pytest.mark.integration

SHORT = ("--minutes", 0.2, "--perception", "state", "--robot.familiarise.minutes", 0.05)


@pytest.fixture(scope="module")
def finished(jointattn, tmp_path_factory) -> Path:
    """A folder with a session in it."""
    out = tmp_path_factory.mktemp("run") / "finished"
    outcome = jointattn("session", "--out", out, *SHORT)
    assert outcome.code == 0, outcome.err
    assert outcome.err == ""
    assert str(out) in outcome.out
    return out


@pytest.fixture
def run(finished, tmp_path) -> Path:
    """A copy of it to be maltreated."""
    return shutil.copytree(finished, tmp_path / "run")


@pytest.mark.parametrize(("words", "together"), [
    ("a.mp4 --object x --seed 3 --object y --out o", "a.mp4 --objects x y --seed 3 --out o"),
    ("--object=x --objects blue red", "--objects x blue red"),
    ("--objects blue --objects red", "--objects blue --objects red"),  # the last holds, as of any option
])  # fmt: skip
def test_objects_one_by_one(words, together):
    assert parsing._gathered(words.split()) == together.split()


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


BAD_OPTIONS = [
    (("--caregiver", "nobody"), ("nobody", "robin")),
    (("--minutes", "-3"), ("minutes", "-3")),
    (("--minutes", "nan"), ("minutes", "nan")),
    (("--minutes", "inf"), ("minutes", "inf")),
    (("--minutes", "many"), ("minutes", "many")),
    (("--seed", "-1"), ("seed", "-1")),
    (("--seed", "1.5"), ("seed", "1.5")),
    (("--perception", "ears"), ("perception", "ears", "pixels")),
    (("--no-such-option",), ("--no-such-option",)),
    (("--quality", "poor"), ("quality", "poor")),
    (("--checkpoint-minutes", "0"), ("checkpoint_minutes", "0")),
    (("--video-every", "0"), ("video_every", "0")),
    (("--robot.attention.motion-width", "0"), ("motion_width", "0")),
    (("--robot.gaze.gate-width", "nan"), ("gate_width", "nan")),
    (("--robot.learner.rate", "0"), ("rate", "0")),
    (("--robot.familiarise.minutes", "0"), ("familiarise", "0")),
    (("--state.face-miss", "2"), ("state.face_miss: expected a number in [0, 1]; got 2.0",)),
    (("--robot.som.rate-start", "nan"), ("robot.som.rate_start: expected a number in [1e-9, 1]; got nan",)),
    (("--world.layout.cells", "-1", "1000000000"), ("world.layout.cells", "(-1, 1000000000)")),
    (("--world.behaviour.wobble-m", "1e308"), ("wobble_m", "[0, 1] (metres)", "1e+308")),
    (("--pixels.faces.side-px", "1_000"), ("side_px", "[8, 240] (pixels)", "1000")),
    (("--pixels.motion.face-inset-px", "99999999999999999999"), ("face_inset_px", "99999999999999999999")),
    (("--seed", "9" * 5000), ("--seed: expected a whole number in [0, 9e18]",)),
    (("--seed", str(2**63)), ("seed: expected a whole number", str(2**63))),
    (("--start-from", "x" * 300), ("start_from: expected a path",)),
    (("--robot.learner.code", "Population"), ("(perhaps you meant 'population')",)),
    (("--robot.gaze.gate-wdth", "3"), ("perhaps you meant --robot.gaze.gate-width",)),
]


@pytest.mark.parametrize(("options", "words"), BAD_OPTIONS, ids=lambda value: value[0].strip("-"))
def test_bad_options(jointattn, tmp_path, options, words):
    outcome = jointattn("session", "--out", tmp_path / "out", *SHORT, *options)
    refused(outcome, 2, *words)
    assert not (tmp_path / "out").exists()


def test_a_misspelt_command(jointattn):
    refused(jointattn("sesion", "--minutes", 1), 2, "no command 'sesion' (perhaps you meant 'session')", "develop")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("session --ot x", "no option --ot (perhaps you meant --out)"),
        ("session --no-resme", "no option --no-resme (perhaps you meant --resume)"),
        ("session --robot.gaze.gate_wdth=3", "no option --robot.gaze.gate-wdth (perhaps you meant --robot.gaze.gate-w"),
        ("session --hlep", "no option --hlep (perhaps you meant --help)"),
        ("develop rendered --help-al --out x", "no option --help-al (perhaps you meant --help-all"),
        ("experiment rn", "no command 'rn' (perhaps you meant 'run'); there are list, run, report"),
        ("experiment run --ot x", "no option --ot (perhaps you meant --out)"),
        ("measure --sorce x", "no option --sorce (perhaps you meant --source)"),
        ("--hlep", "no option '--hlep' (perhaps you meant '--help')"),
        ("help", "for help: jointattn --help, or jointattn COMMAND --help"),
        ("session help", "for help: jointattn session --help"),
        ("develop help", "for help: jointattn develop --help"),
        ("session --minutes 1 --no-motion-cues", "--out"),
    ],
)
def test_what_is_misspelt_is_said_before_what_is_missing(jointattn, line, words):
    outcome = jointattn(*line.split())
    refused(outcome, 2, words)
    assert ("missing: " in outcome.err) == (words == "--out")


@pytest.mark.parametrize("command", ["session", "develop", "develop rendered", "perceive a.mp4"])
def test_an_empty_folder_name(jointattn, command):
    for out in (("--out", ""), ("--out=",)):
        refused(jointattn(*command.split(), *out), 2, "--out: the path is empty")


def test_an_empty_folder_name_from_python():
    for run in (
        Development(steps=1).run,
        Session(minutes=0.1).run,
        partial(perceive, "a.mp4"),
        partial(run_claim, "4.4"),
    ):
        with pytest.raises(ConfigError, match="out is empty"):
            run(out="")
    with pytest.raises(ConfigError, match="out: expected a path"):
        DevelopmentOptions("")


def test_a_complaint_is_made_once(jointattn):
    outcome = jointattn("play", "moon", "--agent", "zero")
    refused(outcome, 2, "'moon'", " follow, ")
    assert outcome.err.lower().count("expected one of") == 1
    assert "options." not in outcome.err


@pytest.mark.parametrize(
    ("command", "needed"),
    [("session", "--out"), ("develop", "--out"), ("measure", "PATH, --source, --target"), ("play follow", "--agent")],
)
def test_what_is_missing_is_named_without_its_help(jointattn, command, needed):
    outcome = jointattn(*command.split())
    refused(outcome, 2, f"missing: {needed} (run jointattn {command.split()[0]}")


def test_choices_come_in_one_order(jointattn):
    refused(
        jointattn("view", "follow", "--agent", "z"), 2, "--agent: expected one of gaze_follower, oracle, random, zero;"
    )
    refused(jointattn("session", "--perception", "State", "--out", "x"), 2, "(perhaps you meant 'state')")


def test_without_a_folder(jointattn):
    refused(jointattn("session", "--minutes", 1), 2, "--out")
    refused(jointattn("session"), 2, "--out")


def test_more_than_the_disk_holds(jointattn, tmp_path):
    refused(jointattn("session", "--out", tmp_path / "out", *SHORT, "--minutes", 1e9), 2, "GB", "fewer minutes")
    assert not (tmp_path / "out").exists()


def test_folder_holds_another_run(jointattn, run):
    before = content(run)
    refused(jointattn("session", "--out", run, *SHORT, "--seed", 5), 2, "already holds a run", "--resume")
    (run / "config.yaml").unlink()
    refused(jointattn("session", "--out", run, *SHORT, "--seed", 5), 2, "already holds a run")
    del before["config.yaml"]
    assert content(run) == before


def test_folder_holds_other_things(jointattn, tmp_path):
    """They do not matter, and stay."""
    (tmp_path / "notes.txt").write_text("mine")
    assert jointattn("session", "--out", tmp_path, *SHORT).code == 0
    assert (tmp_path / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize("below", [False, True])
def test_a_file_in_the_folders_place(jointattn, tmp_path, below):
    location = tmp_path / "file"
    location.write_text("mine")
    out = location / "out" if below else location
    refused(jointattn("session", "--out", out, *SHORT), 2, str(out))
    refused(jointattn("session", "--out", out, *SHORT, "--resume"), 2, str(out))
    assert location.read_text() == "mine"


class TestResume:
    def test_of_nothing(self, jointattn, tmp_path):
        refused(jointattn("session", "--out", tmp_path, *SHORT, "--resume"), 2, "no checkpoint", "without --resume")
        assert not list(tmp_path.iterdir())

    def test_of_a_finished_session(self, jointattn, run):
        """Its results once more."""
        before = content(run)
        assert jointattn("session", "--out", run, *SHORT, "--resume").code == 0
        after = content(run)
        for name in before.keys() - {"summary.json", "checkpoint.bin"}:
            assert after[name] == before[name], name
        assert after.keys() == before.keys()

    @pytest.mark.parametrize(
        ("options", "differing"),
        [
            (("--seed", 5), "seed is 0 there and 5 here"),
            (("--no-motion-cues",), "motion_cues is True there and False here"),
            (("--minutes", 0.4), "minutes is 0.2 there and 0.4 here"),
            (("--robot.learner.rate", 0.01), "robot.learner.rate is "),
        ],
    )
    def test_of_another_config(self, jointattn, run, options, differing):
        before = content(run)
        outcome = jointattn("session", "--out", run, *SHORT, *options, "--resume")
        refused(outcome, 2, "another config (", differing, "config.yaml")
        assert content(run) == before

    @pytest.mark.parametrize("damage", ["truncated", "empty", "flipped", "foreign", "folder"])
    def test_of_a_damaged_checkpoint(self, jointattn, run, damage):
        path = run / "checkpoint.bin"
        whole = path.read_bytes()
        middle = len(whole) // 2
        if damage == "folder":
            path.unlink()
            path.mkdir()
        else:
            path.write_bytes(
                {
                    "truncated": whole[:middle],
                    "empty": b"",
                    "flipped": whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :],
                    "foreign": b"GIF89a" + whole[6:],
                }[damage]
            )
        (run / "notes.txt").write_text("mine")
        kept = {child.name for child in run.iterdir()}
        refused(jointattn("session", "--out", run, *SHORT, "--resume"), 2, str(path))
        assert {child.name for child in run.iterdir()} == kept
        assert (run / "gaze_shifts.parquet").stat().st_size > 1000


class TestStartFrom:
    def test_weights(self, jointattn, finished, tmp_path):
        assert jointattn("session", "--out", tmp_path, *SHORT, "--start-from", finished / "weights.npz").code == 0
        first, second = (json.loads((out / "summary.json").read_text()) for out in (finished, tmp_path))
        assert second["learning_iterations"] >= first["learning_iterations"] > 0

    @pytest.mark.parametrize("what", ["missing", "text", "npy", "truncated", "flipped", "folder", "table", "pickle"])
    def test_no_weights(self, jointattn, finished, tmp_path, what):
        path, whole = tmp_path / "weights.npz", bytearray((finished / "weights.npz").read_bytes())
        match what:
            case "text":
                path.write_text("no weights")
            case "npy":
                with path.open("wb") as file:
                    np.save(file, np.zeros(3))
            case "truncated":
                path.write_bytes(whole[: len(whole) // 2])
            case "flipped":
                whole[len(whole) // 2] ^= 255
                path.write_bytes(whole)
            case "folder":
                path.mkdir()
            case "table":
                shutil.copy(finished / "frames.parquet", path)
            case "pickle":
                np.savez(path, learner=np.array([{}], object))
        refused(jointattn("session", "--out", tmp_path / "out", *SHORT, "--start-from", path), 2, str(path))

    def test_weights_of_another_robot(self, jointattn, finished, tmp_path):
        options = ("--start-from", finished / "weights.npz")
        linear = jointattn("session", "--out", tmp_path, *SHORT, *options, "--robot.learner.code", "linear")
        refused(linear, 2, "must have shape")
        seeing = jointattn("session", "--out", tmp_path, *options, "--minutes", 0.1)
        refused(seeing, 2, "1024", "got 2")
        assert not list(tmp_path.iterdir())  # the folder is free for a run that can be done


class TestFullDisk:
    """A limit on the size of files stands for it: the same errors, at the same places."""

    def test_from_the_first(self, jointattn, tmp_path):
        out = tmp_path / "out"
        refused(jointattn("session", "--out", out, *SHORT, file_limit=10_000), 2, str(out), "free space")
        assert not list(out.iterdir())
        assert jointattn("session", "--out", out, *SHORT).code == 0

    def test_on_the_way(self, jointattn, finished, tmp_path):
        """The last good checkpoint stays, and with space again leads to the same results."""
        out = tmp_path / "out"
        size = (finished / "checkpoint.bin").stat().st_size
        options = ("--out", out, *SHORT, "--checkpoint-minutes", 0.02)
        refused(jointattn("session", *options, file_limit=size - 20_000), 2, "checkpoint.bin", "free space")
        assert {path.name for path in out.iterdir()} == {"checkpoint.bin", "config.yaml"}
        assert jointattn("session", *options, "--resume").code == 0
        expected, got = content(finished), content(out)
        assert got.keys() == expected.keys()
        for name in expected.keys() - {"summary.json", "checkpoint.bin"}:
            assert got[name] == expected[name], name


def test_no_ffmpeg(jointattn, tmp_path):
    """Said at once, before minutes are spent and a folder is claimed."""
    nowhere = {"PATH": str(tmp_path), "IMAGEIO_FFMPEG_EXE": str(tmp_path / "ffmpeg")}
    out = tmp_path / "out"
    refused(jointattn("session", "--out", out, *SHORT, "--video", env=nowhere), 1, "ffmpeg", "apt-get install")
    assert not out.exists()


LEAVE_OUT = "works here: leave MUJOCO_GL out"
NO_DRIVER = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/nowhere"}
NO_OPENGL = {
    "disabled": ({"MUJOCO_GL": "disable"}, "MUJOCO_GL turns rendering off", LEAVE_OUT),
    "unknown": ({"MUJOCO_GL": "crayons"}, "MUJOCO_GL=crayons", LEAVE_OUT),
    "no library": ({"MUJOCO_GL": "osmesa"}, "MUJOCO_GL=osmesa", LEAVE_OUT),
    "no driver": ({"MUJOCO_GL": "", **NO_DRIVER}, "none that works was found", "apt-get install"),
    "no driver, asked for": ({"MUJOCO_GL": "egl", **NO_DRIVER}, "MUJOCO_GL=egl", "apt-get install"),
}


@pytest.mark.parametrize("case", NO_OPENGL)
def test_no_opengl(tmp_path, case):
    """In a process of its own from the start: backends are chosen before anything is imported."""
    env, why, what_to_do = NO_OPENGL[case]
    if case == "no library" and gl.available("osmesa"):
        pytest.skip("OSMesa is there")
    if case.startswith("no driver") and gl.available("osmesa"):
        pytest.skip("OSMesa is taken instead, or recommended")
    arguments = ["session", "--out", str(tmp_path / "out"), "--minutes", "0.05"]
    program = [sys.executable, "-m", "jointattn_mj.cli.main", *arguments]
    done = subprocess.run(program, env=os.environ | env, capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.startswith("jointattn: ")
    for part in (why, what_to_do, "--perception state"):
        assert part in done.stderr
    assert "Traceback" not in done.stderr
    assert not list((tmp_path / "out").iterdir())
    if case == "no driver, asked for":  # the message's promise
        truth = [*program, "--perception", "state", "--robot.familiarise.minutes", "0.05"]
        done = subprocess.run(truth, env=os.environ | env, capture_output=True, text=True)
        assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_stopped_from_outside(tmp_path, number):
    """Ctrl-C, the kind signal of a scheduler, a closed terminal: a checkpoint, one line that says how to go on, 130."""
    refused(stopped(number, tmp_path, "session", *SHORT, "--minutes", 600), 130, "--resume", str(tmp_path))
    assert {path.name for path in tmp_path.iterdir()} - {"log"} == {"checkpoint.bin", "config.yaml"}


INTERRUPTED = """
import os, signal, sys

class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == MODULE:
            try:
                signal.raise_signal(signal.SIGINT)
            except KeyboardInterrupt as error:
                raise ImportError("initialization failed") from error  # as compiled libraries do

sys.meta_path.insert(0, Interrupting())
from jointattn_mj.cli.main import main
main()
"""


@pytest.mark.parametrize("module", ["jointattn_mj.cli.execution", "tyro", "mujoco"])
def test_stopped_while_libraries_are_imported(tmp_path, module):
    code = INTERRUPTED.replace("MODULE", repr(module))
    program = [sys.executable, "-c", code, "session", "--perception", "state", "--out", str(tmp_path / "out")]
    done = subprocess.run(program, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")
    assert not (tmp_path / "out").exists()


def test_stopped_when_all_is_done():
    """While Python clears up: what the command said counts."""
    code = "import atexit, signal; atexit.register(signal.raise_signal, signal.SIGINT)\n"
    code += "from jointattn_mj.cli.main import main\nmain()"
    done = subprocess.run([sys.executable, "-c", code, "--version"], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_bad_benchmark(jointattn):
    refused(jointattn("benchmark", "--blocks", 0), 2, "blocks")
    refused(jointattn("benchmark", "--seconds", "nan"), 2, "seconds")


@pytest.fixture(scope="module")
def measure(tmp_path_factory) -> str:
    path = tmp_path_factory.mktemp("codes") / "codes.csv"
    path.write_text("mother,infant\n" + "".join(f"{k % 3},{k % 5 // 2}\n" for k in range(60)))
    return f"measure {path} --source mother --target infant --surrogates 20 --resamples 0"


class TestStreams:
    """In processes of their own, for a shell's redirections."""

    JOINTATTN = f"{sys.executable} -m jointattn_mj.cli.main"

    def shell(self, line: str, **environment: str) -> Outcome:
        done = subprocess.run(
            ["bash", "-c", f"set -o pipefail; {line}"], env=os.environ | environment, capture_output=True, text=True
        )
        return Outcome(done.returncode, done.stdout, done.stderr)

    @pytest.mark.parametrize("what", ["measure", "--help", "session --help"])
    def test_a_reader_that_has_enough(self, measure, what):
        line = measure if what == "measure" else what
        outcome = self.shell(f"{self.JOINTATTN} {line} | head -1")
        assert (outcome.code, outcome.err) == (0, "")
        assert outcome.out.count("\n") == 1

    @pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no device that is full")
    @pytest.mark.parametrize("what", ["measure", "--help"])
    def test_a_full_disk(self, measure, what):
        outcome = self.shell(f"{self.JOINTATTN} {measure if what == 'measure' else what} > /dev/full")
        refused(outcome, 1, "standard output", "No space left")

    @pytest.mark.parametrize("closed", [">&-", "2>&-", "<&- >&- 2>&-"])
    @pytest.mark.parametrize("what", ["measure", "--help"])
    def test_closed(self, measure, what, closed):
        outcome = self.shell(f"{self.JOINTATTN} {measure if what == 'measure' else what} {closed}")
        assert (outcome.code, outcome.err) == (0, "")

    def test_a_log_that_nobody_reads_any_more(self, tmp_path):
        """Progress has nowhere to go; the session does its work all the same."""
        short = " ".join(map(str, SHORT))
        outcome = self.shell(f"{self.JOINTATTN} session --out {tmp_path / 'out'} {short} 2>&1 >/dev/null | true")
        assert (outcome.code, outcome.err) == (0, "")
        assert (tmp_path / "out" / "summary.json").exists()

    def test_letters_that_a_terminal_does_not_have(self, tmp_path):
        path = tmp_path / "codes.csv"
        path.write_text("mère,infant\n" + "".join(f"{k % 3},{k % 5 // 2}\n" for k in range(60)))
        line = f"measure {path} --source mère --target infant --surrogates 20 --resamples 0"
        outcome = self.shell(f"{self.JOINTATTN} {line}", PYTHONIOENCODING="ascii")
        assert (outcome.code, outcome.err) == (0, "")
        assert outcome.out.startswith("m\\xe8re -> infant")


class TestUnforeseen:
    @pytest.fixture
    def broken(self, monkeypatch):
        def fails(error):
            play = SimpleNamespace(play=self.command(error), LESS="a shorter episode")
            monkeypatch.setattr(parsing, "module_of", lambda name: play)

        return fails

    @staticmethod
    def command(error):
        def play(episodes: int = 1):
            raise error

        return play

    def end(self, capsys) -> Outcome:
        with pytest.raises(SystemExit) as stop:
            cli.main(["play"])
        return Outcome(stop.value.code, *capsys.readouterr())

    def test_a_fault_is_said_in_a_line(self, broken, capsys):
        broken(KeyError("gaze\nmap"))
        outcome = self.end(capsys)
        refused(outcome, 1, "KeyError: 'gaze\\nmap'", "fault of jointattn", "report")
        path = Path(outcome.err.split("its traceback is in ")[1].strip())
        assert "raise error\nKeyError" in path.read_text()
        path.unlink()

    def test_its_traceback_can_be_shown(self, broken, capsys, monkeypatch):
        monkeypatch.setenv("JOINTATTN_TRACEBACK", "1")
        broken(KeyError("map"))
        outcome = self.end(capsys)
        assert outcome.code == 1
        assert outcome.err.startswith("Traceback")
        assert outcome.err.splitlines()[-1].startswith("jointattn: KeyError: 'map'. This is a fault")

    def test_what_the_system_refuses(self, broken, capsys):
        broken(PermissionError(13, "Permission denied", "/there"))
        outcome = self.end(capsys)
        refused(outcome, 1, "/there: Permission denied")
        assert "fault" not in outcome.err

    def test_no_memory(self, broken, capsys):
        broken(MemoryError("Unable to allocate 8 TiB"))
        refused(self.end(capsys), 1, "8 TiB", "ask for a shorter episode")
