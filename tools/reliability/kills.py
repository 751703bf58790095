"""Signals at random moments, again and again, until a run is done: its results against those of one left in peace."""

import os
import random
import shutil
import signal
import time
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path

from tools.reliability.folders import contents, differences
from tools.reliability.subjects import Run, Subject

MOST = 5
"""Kills of one run; then it is let be."""
MOMENTS = ("first second", "anywhere", "while writing", "at a new file")
"""``anywhere``: evenly over the time that the run takes in peace. ``while writing``: when the folder next changes after
such a moment. ``at a new file``: when a file appears for the first time, any of those that are left in the end."""
POLL_S = 0.001
STARTING, BEGUN = "while Python started", "in execute"
"""A moment at which Ctrl-C ends Python itself, and what its traceback says later than that."""
STOPPED = 130
"""Code of a command that was stopped by Ctrl-C."""


@dataclass(frozen=True)
class Reference:
    """The run in peace."""

    seconds: float
    contents: dict[str, bytes]


@dataclass
class KillTrial:
    """A run that was killed until it was done."""

    subject: str
    seed: int
    kills: list[dict[str, object]] = field(default_factory=list)
    """Moment, seconds after the start, and which process it was."""
    anew: int = 0
    """How often it could not be gone on with, though its folder was not empty, and began from the start."""
    trouble: str = ""
    """Why it could not be gone on with."""
    differing: dict[str, int] = field(default_factory=dict)
    """Bytes by file."""

    @property
    def lost(self) -> bool:
        return bool(self.trouble or self.differing)


def reference(subject: Subject, out: Path, places: dict[str, str], more: tuple[str, ...] = ()) -> Reference:
    """Run it in peace; ``more``: other arguments.

    Args:
        subject: The command.
        out: Its folder.
        places: Folders and files that commands name.
        more: Other arguments.

    Raises:
        RuntimeError: It fails.
    """
    began = time.monotonic()
    code, said = subject.start(out, places, more).end()
    seconds = time.monotonic() - began
    if code == 0:
        code, said = subject.make_report(out)
    if code:
        raise RuntimeError(f"{subject.name} fails when it is left in peace: {said}")
    return Reference(seconds, contents(out))


def kill_until_done(
    subject: Subject,
    seed: int,
    peace: Reference,
    out: Path,
    places: dict[str, str],
    by: signal.Signals = signal.SIGKILL,
) -> KillTrial:
    """One trial, whose moments come from ``seed``; its folder is deleted if nothing was lost.

    Args:
        subject: What is run.
        seed: Of the moments.
        peace: The same run without a signal.
        out: Its folder.
        places: What stands for words of the command.
        by: The signal; with SIGINT the command has to end as after Ctrl-C.
    """
    chance, trial = random.Random(f"{subject.name} {seed}"), KillTrial(subject.name, seed)
    more: tuple[str, ...] = ()
    refused, runs = "", []
    while True:
        run = subject.start(out, places, more)
        runs.append(run)
        if len(trial.kills) < MOST and (kill := _kill(run, subject, chance, peace, out, by)):
            trial.kills.append(kill)
            code, said = run.end() if kill["process"] == "main" else (0, "")
            if by is signal.SIGINT and code == -by and BEGUN not in said:
                kill["moment"] = STARTING
            elif by is signal.SIGINT and (code not in (0, STOPPED) or "Traceback" in said):
                trial.trouble = f"ended with {code} when it was stopped: {said.strip()[-800:]}"
                return trial
            if kill["process"] == "main":
                more = subject.resume
                continue
        code, said = run.end()
        if code == 2 and more:  # perhaps there is nothing yet to go on with: the command as it was at first
            trial.anew += any(out.iterdir()) if out.exists() else 0
            refused, more = said, ()
            continue
        break
    for run in runs:
        run.clear()
    if code == 0:
        code, said = subject.make_report(out)
    if code or "Traceback" in said:
        trial.trouble = f"ended with {code}: {said.strip()[-800:]}" + (f"; before: {refused}" if refused else "")
    else:
        trial.differing = differences(peace.contents, contents(out))
    if not trial.lost:
        shutil.rmtree(out)
    return trial


def _kill(
    run: Run, subject: Subject, chance: random.Random, peace: Reference, out: Path, by: signal.Signals
) -> dict[str, object] | None:
    """Wait for a random moment and send the signal; None if the run was done before."""
    moment, part, jitter = chance.choice(MOMENTS), chance.random(), chance.uniform(0, 0.01)
    name = chance.choice(sorted(peace.contents))
    of_workers = by is signal.SIGKILL and subject.workers and chance.random() < 0.3
    if moment == "at a new file" and (out / name).exists():
        moment = "anywhere"
    pause = {"first second": part, "at a new file": 0.0}.get(moment, part * peace.seconds)
    before: list[tuple[str, int, int]] | None = None

    def reached() -> bool:
        nonlocal before
        if time.monotonic() < began + pause:
            return False
        if moment == "at a new file":
            return (out / name).exists()
        if moment == "while writing":
            before = before if before is not None else _entries(out)
            return _entries(out) != before
        return True

    began = time.monotonic()
    while not reached():
        if not run.running():
            return None
        time.sleep(POLL_S)
    time.sleep(jitter)
    victim = chance.choice((of_workers and run.workers()) or [run.process.pid])
    if not run.running():
        return None
    with suppress(ProcessLookupError):
        os.kill(victim, by)
    which = "main" if victim == run.process.pid else "worker"
    return {"moment": moment, "seconds": round(time.monotonic() - began, 3), "process": which}


def _entries(folder: str | Path) -> list[tuple[str, int, int]]:
    """Files in a folder and below, their sizes and when they were changed."""
    listed = []
    try:
        with os.scandir(folder) as entries:
            for entry in entries:
                if entry.is_dir(follow_symlinks=False):
                    listed += _entries(entry.path)
                else:
                    status = entry.stat(follow_symlinks=False)
                    listed.append((entry.path, status.st_size, status.st_mtime_ns))
    except OSError:  # what has just been renamed
        pass
    return sorted(listed)


def summary(trials: list[KillTrial], signals: str = "kills") -> dict[str, object]:
    """Counts by subject, and what was lost; ``signals``: what they are called in the table."""
    rows = []
    seen = {kill["moment"] for trial in trials for kill in trial.kills}
    for name in dict.fromkeys(trial.subject for trial in trials):
        of = [trial for trial in trials if trial.subject == name]
        moments = [kill["moment"] for trial in of for kill in trial.kills]
        rows.append(
            {
                "run": name,
                "trials": len(of),
                signals: len(moments),
                **{moment: moments.count(moment) for moment in (*MOMENTS, STARTING) if moment in seen},
                "begun anew": sum(trial.anew for trial in of),
                "of workers": sum(kill["process"] == "worker" for trial in of for kill in trial.kills),
                "bytes of difference": sum(sum(trial.differing.values()) for trial in of),
                "not gone on with": sum(bool(trial.trouble) for trial in of),
            }
        )
    return {"rows": rows, "wrong": [asdict(trial) for trial in trials if trial.lost]}
