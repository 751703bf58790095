"""Inputs that make no sense, and what became of each: a line and an exit code, or something worse."""

import os
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from queue import SimpleQueue

from tools.shell import HUNG, ROOT, Outcome, Shell

CODES = {0, 1, 2, 130}
"""All that a command may end with."""
MEMORY = 12 << 30
"""Bytes that an input may ask the machine for; what needs more is told that there are no more."""
PROGRESS = re.compile(r"so far$")
"""Ends a line of a long run that says how far it is; it is none of an error."""
NOT_A_NUMBER = re.compile(r"(?<![\w.])[-+]?(?:nan|inf|infinity)(?![\w.])", re.I)


def anything(outcome: Outcome) -> str:
    """Any result will do."""
    return ""


def numbers(outcome: Outcome) -> str:
    """A result will do if its numbers are some."""
    match = NOT_A_NUMBER.search(outcome.out)
    return f"printed {match[0]}" if match else ""


def refused(outcome: Outcome) -> str:
    """No result will do."""
    return "accepted"


@dataclass(frozen=True)
class Input:
    """Something that makes no sense."""

    kind: str
    what: str
    arguments: tuple[str, ...] = ()
    """Of ``jointattn``."""
    source: str = ""
    """Lines of Python in place of them."""
    result: Callable[[Outcome], str] = anything
    """Where the command ends well: what is wrong with that, or nothing."""
    alone: bool = False
    """Try it in an interpreter of its own, down to how that ends."""
    needed: bool = False
    """Whether there must be a result: no refusal will do."""

    def put(self, shell: Shell, seconds: float) -> Outcome:
        """Try it."""
        if self.source:
            return shell.python(self.source, seconds=seconds, memory=MEMORY)
        if self.alone:
            return _alone(self.arguments, seconds)
        return shell(*self.arguments, seconds=seconds, memory=MEMORY)


def _alone(arguments: tuple[str, ...], seconds: float) -> Outcome:
    command = [sys.executable, "-m", "jointattn_mj.cli.main", *arguments]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, errors="replace", timeout=seconds
        )
    except subprocess.TimeoutExpired:
        return Outcome(HUNG, "", "")
    return Outcome(done.returncode, done.stdout, done.stderr)


@dataclass(frozen=True)
class Failure:
    """An input that was not met with a line and an exit code."""

    kind: str
    what: str
    failure: str
    """One of ``FAILURES``."""
    said: str


FAILURES = ("traceback", "signal", "hang", "accepted", "exit code", "several lines", "nothing said")


def verdict(given: Input, outcome: Outcome) -> Failure | None:
    """What is wrong with how an input was met; None if nothing is."""
    said, text = outcome.err.strip(), outcome.out + outcome.err

    def failure(name: str, about: str) -> Failure:
        return Failure(given.kind, given.what, name, about[-600:])

    if outcome.code == HUNG:
        return failure("hang", said)
    if outcome.code < 0 or 128 < outcome.code != 130:
        return failure("signal", f"{outcome.code} {said}")
    if "Traceback (most recent call last)" in text or "Exception ignored" in text:
        return failure("traceback", text.strip())
    if outcome.code not in CODES:
        return failure("exit code", f"{outcome.code} {said}")
    if outcome.code == 0:
        wrong = given.result(outcome)
        return failure("accepted", f"{wrong}; {said}") if wrong else None
    if given.needed:
        return failure("exit code", f"{outcome.code}, and a result is possible; {said}")
    if not said:
        return failure("nothing said", str(outcome.code))
    lines = [line for line in said.splitlines() if not PROGRESS.search(line)]
    return failure("several lines", said) if len(lines) > 1 else None


def signature(failure: Failure) -> str:
    """By which failures of one cause are counted together."""
    if failure.failure in ("accepted", "hang"):
        return re.sub(r" = .*", "", failure.what)[:110]
    last = failure.said.splitlines()[-1] if failure.said else ""
    return re.sub(r"0x[0-9a-f]+|\d+|/[\w./-]+|'[^']*'", "_", last)[:110]


def try_all(inputs: list[Input], shells: list[Shell], seconds: float) -> list[Failure]:
    """Try each, as many at once as there are shells; what takes longer than ``seconds`` hangs.

    Args:
        inputs: What is tried.
        shells: As many run at once.
        seconds: After which a command counts as hanging.
    """
    free: SimpleQueue[Shell] = SimpleQueue()
    for shell in shells:
        free.put(shell)

    def tried(given: Input) -> Failure | None:
        shell = free.get()
        try:
            failure = verdict(given, given.put(shell, seconds))
        finally:
            free.put(shell)
        if failure is not None:
            print(f"{failure.failure}: {given.kind}, {given.what}", file=sys.stderr)
        return failure

    with ThreadPoolExecutor(len(shells)) as pool:
        return [failure for failure in pool.map(tried, inputs) if failure is not None]


def summary(inputs: list[Input], failures: list[Failure]) -> dict[str, object]:
    """Counts by kind, and failures by cause."""
    rows = []
    for kind in dict.fromkeys(given.kind for given in inputs):
        of = Counter(failure.failure for failure in failures if failure.kind == kind)
        rows.append(
            {"inputs": kind, "tried": sum(given.kind == kind for given in inputs), **{n: of[n] for n in FAILURES}}
        )
    causes = Counter((failure.kind, failure.failure, signature(failure)) for failure in failures)
    grouped = []
    for (kind, name, cause), count in causes.most_common():
        example = next(f for f in failures if (f.kind, f.failure, signature(f)) == (kind, name, cause))
        grouped.append({"kind": kind, "failure": name, "times": count, "example": example.what, "said": example.said})
    return {"rows": rows, "wrong": grouped}
