"""A session in a folder: the same seed gives the same bytes, and so does going on after a kill; memory stays flat."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from jointattn_mj.errors import CheckpointError, ConfigError, OutputError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, RobotConfig
from jointattn_mj.gaze_following.run import SessionOptions, run_session
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.io import checkpoint, rows, space
from jointattn_mj.scene import gl

pytestmark = pytest.mark.integration

RESULTS = ("frames.parquet", "gaze_shifts.parquet", "weights.npz", "success.png", "som.png")
FOLDER = {*RESULTS, "summary.json", "config.yaml", "checkpoint.bin"}
MINUTES = {"state": 2.0, "pixels": 0.6}
needs_gl = pytest.mark.skipif(not any(map(gl.available, gl.LIBRARIES)), reason="no OpenGL library to render with")

PROGRAM = """
import os, signal, sys
from jointattn_mj.cli import main as cli, session as session_command
run, how, at = session_command.run_logged, sys.argv[1], int(sys.argv[2])
def interrupted(config, options, progress, kind):
    def watch(session):
        if session.frame == at:
            os.kill(os.getpid(), signal.SIGINT)
        progress(session)
    return run(config, options, watch, kind)
def killing_replace(source, target, replace=os.replace, written=[]):
    written.append(str(target).endswith("checkpoint.bin"))
    if sum(written) == at:
        os.kill(os.getpid(), signal.SIGKILL)
    replace(source, target)
if how == "interrupt":
    session_command.run_logged = interrupted
if how == "kill":
    os.replace = killing_replace
cli.main(sys.argv[3:])
"""
"""``jointattn``, but it is interrupted at a frame, or killed while it writes a checkpoint."""


def command(perception: str, out: Path, *options: str, how: str = "plain", at: int = 0, hash_seed: int = 1):
    """A session in a process of its own."""
    arguments = [
        "session", "--out", str(out), "--perception", perception, "--minutes", str(MINUTES[perception]), "--seed", "3",
        "--robot.familiarise.minutes", "0.15", "--checkpoint-minutes", "0.2", *options,
    ]  # fmt: skip
    return subprocess.run(
        [sys.executable, "-c", PROGRAM, how, str(at), *arguments],
        env=os.environ | {"PYTHONHASHSEED": str(hash_seed)},
        capture_output=True,
        text=True,
    )


def said(done: subprocess.CompletedProcess) -> str:
    """What it said on stderr, but for how far it was, which a slow machine has the time to say."""
    return "".join(line for line in done.stderr.splitlines(keepends=True) if not line.endswith(" so far\n"))


def assert_same(first: Path, second: Path) -> None:
    """All that a session leaves, byte for byte; only the wall clock may differ."""
    assert {path.name for path in first.iterdir()} == {path.name for path in second.iterdir()} == FOLDER
    for name in (*RESULTS, "config.yaml"):
        assert (first / name).read_bytes() == (second / name).read_bytes(), name
    summaries = [json.loads((out / "summary.json").read_text()) | {"wall_seconds": 0} for out in (first, second)]
    assert summaries[0] == summaries[1]


@pytest.fixture(scope="module", params=["state", pytest.param("pixels", marks=needs_gl)])
def straight(request, tmp_path_factory) -> tuple[str, Path]:
    """A session that nothing disturbs."""
    out = tmp_path_factory.mktemp(request.param) / "straight"
    done = command(request.param, out)
    assert (done.returncode, said(done)) == (0, "")
    return request.param, out


def test_same_seed_same_bytes(straight, tmp_path):
    perception, out = straight
    done = command(perception, tmp_path / "again", hash_seed=2)
    assert (done.returncode, said(done)) == (0, "")
    assert_same(out, tmp_path / "again")
    summary = json.loads((out / "summary.json").read_text())
    assert summary["gaze_shifts"] > 3
    assert (summary["rendered_frames"] > 300) == (perception == "pixels")


def test_interrupted_and_resumed(straight, tmp_path):
    perception, out = straight
    stopped = command(perception, tmp_path / "on", how="interrupt", at=600)
    assert stopped.returncode == 130
    assert said(stopped).count("\n") == 1
    assert "--resume" in said(stopped)
    assert {path.name for path in (tmp_path / "on").iterdir()} == {"checkpoint.bin", "config.yaml", "log"}
    resumed = command(perception, tmp_path / "on", "--resume", hash_seed=3)
    assert (resumed.returncode, said(resumed)) == (0, "")
    assert_same(out, tmp_path / "on")


def test_killed_and_resumed(straight, tmp_path):
    """Killed in the middle of its third checkpoint, without a chance to tidy up."""
    perception, out = straight
    killed = command(perception, tmp_path / "on", how="kill", at=3)
    assert killed.returncode == -signal.SIGKILL
    assert len([*(tmp_path / "on").iterdir()]) == 5  # config, log, two checkpoints, one of them half, a void lock
    resumed = command(perception, tmp_path / "on", "--resume", hash_seed=3)
    assert (resumed.returncode, said(resumed)) == (0, "")
    assert_same(out, tmp_path / "on")


def config(seed: int = 0, minutes: float = 0.5, **options) -> SessionConfig:
    robot = RobotConfig(familiarise=FamiliariseConfig(minutes=0.1))
    return SessionConfig(seed=seed, minutes=minutes, perception="state", robot=robot, **options)


def test_another_seed_another_session(tmp_path):
    for seed in (0, 1):
        run_session(config(seed), SessionOptions(tmp_path / str(seed)))
    for name in RESULTS:
        assert (tmp_path / "0" / name).read_bytes() != (tmp_path / "1" / name).read_bytes(), name


def test_progress_comes_every_second(tmp_path):
    frames = []
    run_session(config(), SessionOptions(tmp_path), lambda session: frames.append(session.frame))
    assert frames == list(range(30, 901, 30))


def interrupt(session: SessionRun) -> None:
    if session.frame == 300:
        signal.raise_signal(signal.SIGINT)


def test_signal_handlers_are_given_back(tmp_path):
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    with pytest.raises(KeyboardInterrupt):
        run_session(config(), SessionOptions(tmp_path), interrupt)
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


def test_resume_of_a_session_that_started_from_weights(tmp_path):
    """The path of the weights is part of its config, and of its checkpoint."""
    run_session(config(), SessionOptions(tmp_path / "first"))
    later = config(seed=1, start_from=tmp_path / "first" / "weights.npz")
    run_session(later, SessionOptions(tmp_path / "straight"))
    with pytest.raises(KeyboardInterrupt):
        run_session(later, SessionOptions(tmp_path / "on"), interrupt)
    run_session(later, SessionOptions(tmp_path / "on", resume=True))
    assert_same(tmp_path / "straight", tmp_path / "on")


def test_wall_time_goes_on(tmp_path):
    """What was spent before a stop counts."""
    with pytest.raises(KeyboardInterrupt):
        run_session(config(), SessionOptions(tmp_path), interrupt)
    summary = run_session(config(), SessionOptions(tmp_path, resume=True))
    again = run_session(config(), SessionOptions(tmp_path, resume=True))
    assert 0 < summary["wall_seconds"] <= again["wall_seconds"]


def test_a_checkpoint_holds_no_frames_twice(tmp_path, monkeypatch):
    """What a session has written down is in its log; all checkpoints together add little to it."""
    monkeypatch.setattr(rows, "BUFFER_BYTES", 1 << 13)
    sizes, save = [], checkpoint.save

    def weighed(path, *arguments):
        save(path, *arguments)
        sizes.append(path.stat().st_size)

    monkeypatch.setattr(checkpoint, "save", weighed)
    run_session(config(minutes=2.0), SessionOptions(tmp_path, checkpoint_minutes=0.25))
    assert len(sizes) == 10
    assert max(sizes) - sizes[0] < 60_000  # frames alone are 864,000 bytes


@pytest.mark.parametrize("at", ["summary.json", "frames.parquet"])
def test_killed_while_results_are_left(tmp_path, monkeypatch, at):
    """Before the log is deleted, or before all results are there: nothing is lost."""
    run_session(config(), SessionOptions(tmp_path / "straight"))
    replace = os.replace

    def killing(source, target):
        replace(source, target)
        if Path(target).name == at:
            raise SystemExit(9)

    monkeypatch.setattr(os, "replace", killing)
    with pytest.raises(SystemExit):
        run_session(config(), SessionOptions(tmp_path / "on"))
    monkeypatch.undo()
    assert (tmp_path / "on" / "log").exists()
    run_session(config(), SessionOptions(tmp_path / "on", resume=True))
    assert_same(tmp_path / "straight", tmp_path / "on")


def test_log_that_is_gone(tmp_path, monkeypatch):
    """A named error, and what a finished session has left stays."""
    monkeypatch.setattr(rows, "BUFFER_BYTES", 1 << 13)
    summary = run_session(config(), SessionOptions(tmp_path))
    assert run_session(config(), SessionOptions(tmp_path, resume=True)) == summary
    (tmp_path / "summary.json").unlink()
    with pytest.raises(CheckpointError, match="frames"):
        run_session(config(), SessionOptions(tmp_path, resume=True))
    assert (tmp_path / "frames.parquet").exists()


def test_too_little_space(tmp_path, monkeypatch):
    monkeypatch.setattr(space, "free_bytes", lambda folder: 1_000_000)
    with pytest.raises(ConfigError, match="fewer minutes"):
        run_session(config(minutes=26), SessionOptions(tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_named_errors(tmp_path):
    with pytest.raises(CheckpointError, match="without `resume`"):
        run_session(config(), SessionOptions(tmp_path, resume=True))
    (tmp_path / "checkpoint.bin").write_bytes(b"")
    with pytest.raises(OutputError, match="already holds a run"):
        run_session(config(), SessionOptions(tmp_path))
    for options in ({"checkpoint_minutes": 0.0}, {"checkpoint_minutes": float("nan")}, {"video_every": 0}):
        with pytest.raises(ConfigError, match=next(iter(options))):
            SessionOptions(tmp_path, **options)


RESIDENT = """
import gc, os, sys
from pathlib import Path
from jointattn_mj.gaze_following.agent import FamiliariseConfig, RobotConfig
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun

perception, seconds, folder = sys.argv[1], float(sys.argv[2]), Path(sys.argv[3])
robot = RobotConfig(familiarise=FamiliariseConfig(minutes=0.1))
session = SessionRun(SessionConfig(minutes=seconds / 60, perception=perception, robot=robot))
session.begin()
session.attach(folder)
while session.frame < session.total:
    session.step()
    if session.frame % (session.total // 8) == 0:
        gc.collect()
        print(int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE"))
session.close()
"""
"""A session that says eight times how many bytes of memory its process holds."""


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="no /proc")
@pytest.mark.parametrize(("perception", "seconds"), [("state", 240), pytest.param("pixels", 60, marks=needs_gl)])
def test_memory_stays_flat(tmp_path, perception, seconds):
    """After a warm-up of a quarter of the time, in a process of its own. Over 26 minutes even 1 MB a minute would be
    little; here it is less."""
    program = [sys.executable, "-c", RESIDENT, perception, str(seconds), str(tmp_path / "log")]
    sizes = [int(line) / 1e6 for line in subprocess.check_output(program, text=True).split()]
    assert len(sizes) == 8
    assert sizes[-1] - sizes[1] < 3
