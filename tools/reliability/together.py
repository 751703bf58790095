"""Two commands started in one folder at nearly the same moment: one has it, the other says so in a line."""

import random
import shutil
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from tools.reliability.folders import contents, differences
from tools.reliability.kills import Reference
from tools.reliability.subjects import Subject

SUBJECTS = ("session, state", "develop, table", "experiment, loky", "perceive")
APART_S = 0.6
"""The second starts up to so much later."""


@dataclass(frozen=True)
class RunPair:
    """How two commands in one folder ended."""

    subject: str
    seconds_apart: float
    codes: tuple[int, int]
    trouble: str
    """What is wrong with it; nothing if all is well."""


def start_two(
    subject: Subject, seed: int, alone: tuple[Reference, Reference], out: Path, places: dict[str, str]
) -> RunPair:
    """``alone``: either in a folder of its own; the second command differs in its seed, but for experiments.

    Args:
        subject: The command.
        seed: Of the first; the second has another one.
        alone: Either command in a folder of its own.
        out: The folder that both name.
        places: Folders and files that commands name.
    """
    chance = random.Random(f"{subject.name} {seed}")
    apart = 0.0 if chance.random() < 0.2 else chance.uniform(0, APART_S)
    first = subject.start(out, places)
    time.sleep(apart)
    second = subject.start(out, places, other_seed(subject))
    ends = [first.end(), second.end()]
    for run in (first, second):
        run.clear()
    codes = ends[0][0], ends[1][0]
    trouble = _trouble(subject, ends, alone, out)
    if not trouble:
        shutil.rmtree(out)
    return RunPair(subject.name, round(apart, 3), codes, trouble)


def other_seed(subject: Subject) -> tuple[str, ...]:
    """What the second command is told besides."""
    return ("--seed", "1") if subject.resume else ()


def summary(pairs: list[RunPair]) -> dict[str, object]:
    """Counts by subject, and what went wrong."""
    rows = []
    for name in dict.fromkeys(pair.subject for pair in pairs):
        of = [pair for pair in pairs if pair.subject == name]
        refused = sum(2 in pair.codes for pair in of)
        rows.append({"run": name, "pairs": len(of), "one refused": refused, "wrong": sum(bool(p.trouble) for p in of)})
    return {"rows": rows, "wrong": [asdict(pair) for pair in pairs if pair.trouble]}


def _trouble(
    subject: Subject,
    ends: list[tuple[int, str]],
    alone: tuple[Reference, Reference],
    out: Path,
) -> str:
    codes = [code for code, _ in ends]
    if any("Traceback" in said for _, said in ends):
        return "a traceback: " + "".join(said for _, said in ends)[-800:]
    if 0 not in codes or not set(codes) <= {0, 2}:
        return f"ended with {codes[0]} and {codes[1]}: " + "".join(said for _, said in ends)[-800:]
    if subject.resume:
        if codes == [0, 0]:
            return "both took the folder"
        loser = ends[codes.index(2)][1].strip()
        if len(loser.splitlines()) != 1:
            return f"more than a line from the one that was refused: {loser}"
    else:
        subject.make_report(out)
    differing = differences(alone[codes.index(0)].contents, contents(out))
    return f"bytes that differ from those of one alone: {differing}" if differing else ""
