"""``python -m tools.reliability``: see the package."""

import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import tyro

from tools.reliability import kills as killing
from tools.reliability import together
from tools.reliability.results import FOLDER, save, table
from tools.reliability.subjects import SUBJECTS, Subject, places


def kills(*, kills: int = 100, only: str = "", seed: int = 0, jobs: int = 2, out: Path = FOLDER) -> bool:
    """Kill runs with -9 at random moments, and go on with them, until they are done.

    Args:
        kills: In all, evenly over the kinds of runs.
        only: Only runs whose names begin so.
        seed: Of the moments.
        jobs: Runs at once.
        out: Folder for kills.json.
    """

    def harness(folder: Path, subjects: tuple[Subject, ...], at: dict[str, str], pool: ThreadPoolExecutor) -> dict:
        def killed(subject: Subject) -> list[killing.Trial]:
            peace = killing.reference(subject, folder / f"{subject.name} in peace", at)
            trials: list[killing.Trial] = []
            while sum(len(trial.kills) for trial in trials) < kills / len(subjects):
                number = 1000 * seed + len(trials)
                trials.append(killing.kill_until_done(subject, number, peace, folder / f"{subject.name} {number}", at))
                told = f"{subject.name} {number}: {len(trials[-1].kills)} kills, "
                print(told + (f"LOST {trials[-1]}" if trials[-1].lost else "nothing lost"), file=sys.stderr)
            return trials

        return killing.summary([trial for trials in pool.map(killed, subjects) for trial in trials])

    return _with_runs("kills", harness, [one for one in SUBJECTS if one.name.startswith(only)], jobs, out)


def pairs(*, pairs: int = 24, only: str = "", seed: int = 0, jobs: int = 2, out: Path = FOLDER) -> bool:
    """Start two commands in one folder, at once or nearly so.

    Args:
        pairs: In all, evenly over the kinds of runs.
        only: Only runs whose names begin so.
        seed: Of the pauses between the two.
        jobs: Pairs at once.
        out: Folder for pairs.json.
    """

    def harness(folder: Path, subjects: tuple[Subject, ...], at: dict[str, str], pool: ThreadPoolExecutor) -> dict:
        def started(subject: Subject) -> list[together.Pair]:
            alone = (
                killing.reference(subject, folder / f"{subject.name} first alone", at),
                killing.reference(subject, folder / f"{subject.name} second alone", at, together.other_seed(subject)),
            )
            numbers = range(1000 * seed, 1000 * seed + max(1, pairs // len(subjects)))
            found = []
            for number in numbers:
                found.append(together.start_two(subject, number, alone, folder / f"{subject.name} {number}", at))
                print(found[-1], file=sys.stderr)
            return found

        return together.summary([pair for of in pool.map(started, subjects) for pair in of])

    chosen = [one for one in SUBJECTS if one.name in together.SUBJECTS and one.name.startswith(only)]
    return _with_runs("pairs", harness, chosen, jobs, out)


def _with_runs(name: str, harness: Callable[..., dict], subjects: list[Subject], jobs: int, out: Path) -> bool:
    """Give a harness what its runs need, and leave what it found; whether anything was lost."""
    began = time.monotonic()
    with (
        tempfile.TemporaryDirectory(prefix=f"{name}-") as folder,
        places(Path(folder), tuple(subjects)) as at,
        ThreadPoolExecutor(jobs) as pool,
    ):
        found = harness(Path(folder), tuple(subjects), at, pool)
    return _leave(name, found, time.monotonic() - began, out)


def _leave(name: str, found: dict, seconds: float, out: Path) -> bool:
    """Print and store it; whether anything is wrong."""
    path = save(name, found, seconds, out)
    print(table(found["rows"]))
    print(path)
    return bool(found["wrong"])


COMMANDS = {"kills": kills, "pairs": pairs}

if __name__ == "__main__":
    sys.exit(int(tyro.extras.subcommand_cli_from_dict(COMMANDS, prog="python -m tools.reliability")))
