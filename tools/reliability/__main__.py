"""``python -m tools.reliability``: see the package."""

import random
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from pathlib import Path

import tyro

from tools.reliability import hours, kills, together
from tools.reliability.inputs import all_kinds, odd_videos
from tools.reliability.malformed import summary, try_all
from tools.reliability.report import PAGE, page
from tools.reliability.results import FOLDER, save, table
from tools.reliability.subjects import SUBJECTS, Subject, film, places
from tools.shell import Shell


def run_kills(*, number: int = 100, only: str = "", seed: int = 0, jobs: int = 2, out: Path = FOLDER) -> bool:
    """Kill runs with -9 at random moments, and go on with them, until they are done.

    Args:
        number: Of kills in all, evenly over the kinds of runs.
        only: Only runs whose names begin so.
        seed: Of the moments.
        jobs: Runs at once.
        out: Folder for kills.json.
    """
    return _with_signals("kills", signal.SIGKILL, number, only, seed, jobs, out)


def run_stops(*, number: int = 100, only: str = "", seed: int = 0, jobs: int = 2, out: Path = FOLDER) -> bool:
    """Stop runs by Ctrl-C at random moments, and go on with them, until they are done.

    Args:
        number: Of stops in all, evenly over the kinds of runs.
        only: Only runs whose names begin so.
        seed: Of the moments.
        jobs: Runs at once.
        out: Folder for stops.json.
    """
    return _with_signals("stops", signal.SIGINT, number, only, seed, jobs, out)


def _with_signals(name: str, by: signal.Signals, number: int, only: str, seed: int, jobs: int, out: Path) -> bool:
    """Runs and signals; whether anything was lost."""

    def harness(folder: Path, subjects: tuple[Subject, ...], at: dict[str, str], pool: ThreadPoolExecutor) -> dict:
        def killed(subject: Subject) -> list[kills.KillTrial]:
            peace = kills.reference(subject, folder / f"{subject.name} in peace", at)
            trials: list[kills.KillTrial] = []
            while sum(len(trial.kills) for trial in trials) < number / len(subjects):
                trial_seed = 1000 * seed + len(trials)
                out_of_it = folder / f"{subject.name} {trial_seed}"
                trials.append(kills.kill_until_done(subject, trial_seed, peace, out_of_it, at, by))
                told = f"{subject.name} {trial_seed}: {len(trials[-1].kills)} {name}, "
                print(told + (f"LOST {trials[-1]}" if trials[-1].lost else "nothing lost"), file=sys.stderr)
            return trials

        return kills.summary([trial for trials in pool.map(killed, subjects) for trial in trials], name)

    return _with_runs(name, harness, [subject for subject in SUBJECTS if subject.name.startswith(only)], jobs, out)


def run_pairs(*, number: int = 24, only: str = "", seed: int = 0, jobs: int = 2, out: Path = FOLDER) -> bool:
    """Start two commands in one folder, at once or nearly so.

    Args:
        number: Of pairs in all, evenly over the kinds of runs.
        only: Only runs whose names begin so.
        seed: Of the pauses between the two.
        jobs: Pairs at once.
        out: Folder for pairs.json.
    """

    def harness(folder: Path, subjects: tuple[Subject, ...], at: dict[str, str], pool: ThreadPoolExecutor) -> dict:
        def started(subject: Subject) -> list[together.RunPair]:
            alone = (
                kills.reference(subject, folder / f"{subject.name} first alone", at),
                kills.reference(subject, folder / f"{subject.name} second alone", at, together.other_seed(subject)),
            )
            seeds = range(1000 * seed, 1000 * seed + max(1, number // len(subjects)))
            attempts = []
            for pair_seed in seeds:
                attempts.append(
                    together.start_two(subject, pair_seed, alone, folder / f"{subject.name} {pair_seed}", at)
                )
                print(attempts[-1], file=sys.stderr)
            return attempts

        return together.summary([pair for of in pool.map(started, subjects) for pair in of])

    chosen = [subject for subject in SUBJECTS if subject.name in together.SUBJECTS and subject.name.startswith(only)]
    return _with_runs("pairs", harness, chosen, jobs, out)


def run_malformed(
    *, number: int = 1000, only: str = "", seed: int = 0, jobs: int = 2, limit: float = 90.0, out: Path = FOLDER
) -> bool:
    """Try inputs that make no sense, over options, files and Python calls.

    Args:
        number: Of inputs in all.
        only: Only inputs whose descriptions have this in them.
        seed: Of all draws.
        jobs: Inputs at once.
        limit: Seconds after which an input hangs.
        out: Folder for malformed.json.
    """
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="malformed-") as name, ExitStack() as stack:
        folder, here = Path(name), Path(name) / "here" / "it" / "is"
        here.mkdir(parents=True)
        shells = [stack.enter_context(closing(Shell(here))) for _ in range(jobs)]
        given = [kind for kind in all_kinds(shells[0], seed, number, folder) if only in f"{kind.kind} {kind.what}"]
        tried = summary(given, try_all(given, shells, limit))
    return _leave("malformed", tried, time.monotonic() - began, out)


def run_videos(
    *, number: int = 300, only: str = "", seed: int = 0, jobs: int = 1, limit: float = 120.0, out: Path = FOLDER
) -> bool:
    """Watch odd and damaged videos.

    Args:
        number: Of videos in all.
        only: Only videos whose descriptions have this in them.
        seed: Of the damage.
        jobs: Videos at once.
        limit: Seconds after which a video hangs.
        out: Folder for videos.json.
    """
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="videos-") as name, ExitStack() as stack:
        folder = Path(name)
        clip = film(folder / "film.mp4", round(odd_videos.SECONDS * 30))
        shells = [stack.enter_context(closing(Shell(folder))) for _ in range(jobs)]
        given = [case for case in odd_videos.inputs(random.Random(seed), number, folder, clip) if only in case.what]
        tried = summary(given, try_all(given, shells, limit))
    return _leave("videos", tried, time.monotonic() - began, out)


def run_hours(*, share: float = 1.0, only: str = "", out: Path = FOLDER) -> bool:
    """Let runs go on for a simulated day, and watch their memory.

    Args:
        share: Of the day.
        only: Only runs whose names begin so.
        out: Folder for hours.json.
    """
    began, spent = time.monotonic(), []
    for day in hours.DAYS:
        if day.name.startswith(only):
            with tempfile.TemporaryDirectory(prefix="hours-") as folder:
                spent.append(hours.spend(day, share, Path(folder) / "out"))
            print(spent[-1]["row"], spent[-1]["trouble"], file=sys.stderr)
    return _leave("hours", hours.summary(spent), time.monotonic() - began, out)


def run_report(*, out: Path = FOLDER) -> bool:
    """Write what is stored into docs/reliability.md.

    Args:
        out: Folder of the results.
    """
    PAGE.write_text(page(PAGE.read_text("utf-8"), out), "utf-8")
    print(PAGE)
    return False


def _with_runs(name: str, harness: Callable[..., dict], subjects: list[Subject], jobs: int, out: Path) -> bool:
    """Give a harness what its runs need, and leave what it found; whether anything was lost."""
    began = time.monotonic()
    with (
        tempfile.TemporaryDirectory(prefix=f"{name}-") as folder,
        places(Path(folder), tuple(subjects)) as at,
        ThreadPoolExecutor(jobs) as pool,
    ):
        result = harness(Path(folder), tuple(subjects), at, pool)
    return _leave(name, result, time.monotonic() - began, out)


def _leave(name: str, result: dict, seconds: float, out: Path) -> bool:
    """Print and store it; whether anything is wrong."""
    path = save(name, result, seconds, out)
    print(table(result["rows"]))
    print(path)
    return bool(result["wrong"])


COMMANDS = {
    "kills": run_kills,
    "stops": run_stops,
    "pairs": run_pairs,
    "malformed": run_malformed,
    "videos": run_videos,
    "hours": run_hours,
    "report": run_report,
}

if __name__ == "__main__":
    sys.exit(int(tyro.extras.subcommand_cli_from_dict(COMMANDS, prog="python -m tools.reliability")))
