"""Runs that take a second or two, of every kind that can be stopped and gone on with."""

import json
import os
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
ENVIRONMENT = os.environ | {"PYTHONPATH": str(ROOT), "LP_NUM_THREADS": "0"}
SCHEDULER, VIDEO = "{scheduler}", "{video}"
"""Stand in a command for the address of a dask scheduler, and for a file to watch."""
JOINTATTN = (sys.executable, "-m", "jointattn_mj.cli.main")
LIMIT_S = 1800.0
"""A run that takes longer hangs."""


@dataclass(frozen=True)
class Subject:
    """A command that leaves its results in ``--out``."""

    name: str
    command: str
    resume: tuple[str, ...] = ("--resume",)
    """What goes on with it; experiments go on by themselves."""
    report: tuple[str, ...] = ()
    """Makes results of what is in the folder at last; the folder follows."""
    workers: bool = False
    """Whether it has processes of its own, which can be killed too."""
    program: tuple[str, ...] = JOINTATTN

    def start(self, out: Path, places: dict[str, str], more: tuple[str, ...] = ()) -> "Run":
        """Start it.

        Args:
            out: Folder of the run.
            places: Folders and files that commands name.
            more: Other arguments.
        """
        return Run(
            [*(places.get(word, word) for word in shlex.split(self.command)), "--out", str(out), *more], self.program
        )

    def make_report(self, out: Path) -> tuple[int, str]:
        """Code and what was said."""
        return Run([*self.report, "."], folder=out).end() if self.report else (0, "")  # a report names its folder


ORDER = "experiment run 5.2 --setting 'caregiver first' --runs 12"
SUBJECTS = (
    Subject("session, state", "session --perception state --minutes 8 --checkpoint-minutes 0.25"),
    Subject(
        "session, cross-situational",
        "session --preset cross_situational --perception state --minutes 8 --checkpoint-minutes 0.25",
    ),
    Subject("session, images", "session --minutes 0.8 --robot.familiarise.minutes 0.3 --checkpoint-minutes 0.1"),
    Subject("develop, table", "develop table --preset fast --steps 300000 --checkpoint-every 20000"),
    Subject("develop, local", "develop table --preset local --steps 8000 --checkpoint-every 500"),
    Subject(
        "develop, rendered",
        "develop rendered --steps 800 --rendered.exploration 240 --checkpoint-every 100",
    ),
    Subject("develop, growing", "develop rendered --resolution growing --steps 400 --checkpoint-every 50"),
    Subject(
        "develop, realtime",
        "develop realtime --minutes 0.5 --realtime.familiarise-minutes 0.4 --checkpoint-every 10",
    ),
    Subject("experiment, loky", f"{ORDER} --jobs 2", resume=(), report=("experiment", "report"), workers=True),
    Subject(
        "experiment, dask",
        f"{ORDER} --backend dask --address {SCHEDULER}",
        resume=(),
        report=("experiment", "report"),
    ),
    Subject("perceive", f"perceive {VIDEO} --no-overlay --checkpoint-minutes 0.05"),
    Subject("perceive, looks and overlay", f"perceive {VIDEO} --looks --checkpoint-minutes 0.05"),
)


class Run:
    """A command in a process group of its own."""

    def __init__(self, arguments: list[str], program: tuple[str, ...] = JOINTATTN, folder: Path = ROOT):
        """``folder``: where it works."""
        self._said = tempfile.TemporaryFile("w+", errors="replace")  # noqa: SIM115
        self.process = subprocess.Popen(
            [*program, *arguments],
            cwd=folder,
            env=ENVIRONMENT,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._said,
            start_new_session=True,
        )

    def running(self) -> bool:
        return self.process.poll() is None

    def workers(self) -> list[int]:
        """Processes of loky that compute for it."""
        children = []
        with suppress(OSError):
            for task in Path(f"/proc/{self.process.pid}/task").iterdir():
                for child in (task / "children").read_text().split():
                    if b"popen_loky" in Path(f"/proc/{child}/cmdline").read_bytes():
                        children.append(int(child))
        return children

    def end(self, limit_s: float = LIMIT_S) -> tuple[int, str]:
        """Its code and what it said, when it has ended; 124 where it hangs."""
        try:
            code = self.process.wait(limit_s)
        except subprocess.TimeoutExpired:
            code = 124
            self.clear()
            self.process.wait()
        self._said.seek(0)
        return code, self._said.read()

    def clear(self) -> None:
        """Kill what is left of it and of what it has started."""
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)


@contextmanager
def places(folder: Path, subjects: tuple[Subject, ...]) -> Iterator[dict[str, str]]:
    """What commands need that is not theirs: a video, and a scheduler with two workers."""
    needed, values = " ".join(subject.command for subject in subjects), {}
    if VIDEO in needed:
        values[VIDEO] = str(film(folder / "table.mp4", 450))
    if SCHEDULER not in needed:
        yield values
        return
    program = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    at = folder / "scheduler.json"
    quiet = {"cwd": ROOT, "env": ENVIRONMENT, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    started = [
        subprocess.Popen([*program, "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(at)], **quiet),
        subprocess.Popen(
            [sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file", str(at), "--nworkers", "2",
             "--nthreads", "1"], **quiet,
        ),
    ]  # fmt: skip
    try:
        yield values | {SCHEDULER: wait_for(lambda: _address(at))}
    finally:
        for process in reversed(started):
            process.terminate()
            process.wait()


def _address(file: Path) -> str | None:
    try:
        return json.loads(file.read_text())["address"]
    except (OSError, ValueError):
        return None


def wait_for(condition: Callable[[], str | None], seconds: float = 120) -> str:
    """What the condition returns as soon as it is something.

    Raises:
        TimeoutError: Never.
    """
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        if (result := condition()) is not None:
            return result
        time.sleep(0.05)
    raise TimeoutError(f"waited {seconds} s for {condition}")


def film(path: Path, frames: int) -> Path:
    """The simulated caregiver at the table, 30 frames a second."""
    import jointattn_mj
    from jointattn_mj.video.reel import Reel

    env = jointattn_mj.load("joint_attention", "object_transfer", task_kwargs={"random": 0})
    env.reset()
    with Reel(path, 240, 320, 30) as reel:
        for _ in range(frames):
            reel.add(env.step([0, -0.14]).observation["camera"])
    env.close()
    return path
