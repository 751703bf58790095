"""``python -m tools.reliability``: see the package."""

import queue
import random
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from pathlib import Path

import tyro

from tools.reliability import calls, files, options, together
from tools.reliability import hours as long
from tools.reliability import kills as killing
from tools.reliability.malformed import Failure, Input, summary, verdict
from tools.reliability.report import PAGE, page
from tools.reliability.results import FOLDER, save, table
from tools.reliability.subjects import SUBJECTS, Subject, film, places
from tools.shell import Shell


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


SHARES = {
    "options": 0.55,
    "calls": 0.13,
    "tables": 0.1,
    "checkpoints": 0.08,
    "weights": 0.06,
    "videos": 0.05,
    "stores": 0.03,
}
"""Of the malformed inputs; tables, weights and videos begin with those that were thought of, then come random ones."""


def malformed(
    *, inputs: int = 1000, only: str = "", seed: int = 0, jobs: int = 2, limit: float = 90.0, out: Path = FOLDER
) -> bool:
    """Try inputs that make no sense, over options, files and Python calls.

    Args:
        inputs: In all.
        only: Only inputs whose descriptions have this in them.
        seed: Of all draws.
        jobs: Inputs at once.
        limit: Seconds after which an input hangs.
        out: Folder for malformed.json.
    """
    began, chance = time.monotonic(), random.Random(seed)
    many = {name: max(1, round(share * inputs)) for name, share in SHARES.items()}
    with tempfile.TemporaryDirectory(prefix="malformed-") as name, ExitStack() as stack:
        folder, here = Path(name), Path(name) / "here" / "it" / "is"
        here.mkdir(parents=True)
        shells = [stack.enter_context(closing(Shell(here))) for _ in range(jobs)]
        shell, clip = shells[0], film(folder / "clip.mp4", 90)
        table = folder / "codings.csv"
        table.write_text(files.as_csv(files.codings()))
        at = {"{video}": str(clip), "{table}": str(table), "{store}": str(folder / "no_store")}
        given = [
            *options.inputs(shell, chance, many["options"], folder / "options", at),
            *calls.calls(chance, many["calls"]),
            *files.tables(chance, many["tables"], folder / "tables"),
            *files.weights(shell, chance, many["weights"], folder / "weights"),
            *files.checkpoints(shell, chance, many["checkpoints"], folder / "checkpoints"),
            *files.videos(chance, many["videos"], folder / "videos", clip),
            *files.stores(shell, chance, many["stores"], folder / "stores"),
        ]
        given = [one for one in given if only in f"{one.kind} {one.what}"]
        free: queue.SimpleQueue[Shell] = queue.SimpleQueue()
        for shell in shells:
            free.put(shell)

        def tried(one: Input) -> Failure | None:
            shell = free.get()
            try:
                failure = verdict(one, one.put(shell, limit))
            finally:
                free.put(shell)
            if failure is not None:
                print(f"{failure.failure}: {one.kind}, {one.what}", file=sys.stderr)
            return failure

        with ThreadPoolExecutor(jobs) as pool:
            failures = [failure for failure in pool.map(tried, given) if failure is not None]
    return _leave("malformed", summary(given, failures), time.monotonic() - began, out)


def hours(*, share: float = 1.0, only: str = "", out: Path = FOLDER) -> bool:
    """Let runs go on for a simulated day, and watch their memory.

    Args:
        share: Of the day.
        only: Only runs whose names begin so.
        out: Folder for hours.json.
    """
    began, spent = time.monotonic(), []
    for day in long.DAYS:
        if day.name.startswith(only):
            with tempfile.TemporaryDirectory(prefix="hours-") as folder:
                spent.append(long.spend(day, share, Path(folder) / "out"))
            print(spent[-1]["row"], spent[-1]["trouble"], file=sys.stderr)
    return _leave("hours", long.summary(spent), time.monotonic() - began, out)


def report(*, out: Path = FOLDER) -> bool:
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
        found = harness(Path(folder), tuple(subjects), at, pool)
    return _leave(name, found, time.monotonic() - began, out)


def _leave(name: str, found: dict, seconds: float, out: Path) -> bool:
    """Print and store it; whether anything is wrong."""
    path = save(name, found, seconds, out)
    print(table(found["rows"]))
    print(path)
    return bool(found["wrong"])


COMMANDS = {"kills": kills, "pairs": pairs, "malformed": malformed, "hours": hours, "report": report}

if __name__ == "__main__":
    sys.exit(int(tyro.extras.subcommand_cli_from_dict(COMMANDS, prog="python -m tools.reliability")))
