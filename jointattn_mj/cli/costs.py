"""What whole commands cost: seconds of the processor and memory, as the system counts them for a process."""

import os
import shlex
import tempfile
from collections.abc import Mapping
from typing import NamedTuple

from jointattn_mj.benchmarks.figures import Figures
from jointattn_mj.cli import apart
from jointattn_mj.errors import CommandError

STATE_MINUTES = 26.0
"""Simulated minutes of the session from the state."""
FILMED_MINUTES = 0.2
"""Simulated minutes of the session that is filmed, and of the same one without a film."""
FRAMES_PER_MINUTE = 1800
BRIEF = "--robot.familiarise.minutes 0.05"
PATIENCE_S = 2.0
"""How long a command may take to stop: one that compiles takes long, and leaves nothing but temporary files."""
MOST_BLOCKS = 5
"""A command takes seconds, and differs little from time to time."""


class Cost(NamedTuple):
    """Time and memory that a command took."""

    seconds: float
    """Of the processor, all threads together."""
    mebibytes: float
    """Most memory that it held at one time."""


def run_commands_benchmark(blocks: int) -> Figures:
    """Run commands, one after the other in each block.

    Args:
        blocks: Their number, of which ``MOST_BLOCKS`` are used; before them all is run once, which compiles.

    Raises:
        CommandError: One of them has failed.
    """
    with tempfile.TemporaryDirectory() as path:
        folder = shlex.quote(path)
        first = {
            "first_session_s": _fresh(f"session --perception state --minutes 0.05 {BRIEF} --out {folder}/fresh"),
            "first_develop_s": _fresh(f"develop table --steps 1000 --out {folder}/fresh_table"),
        }
        state = f"session --perception state --minutes {STATE_MINUTES}"
        filmed = f"session --minutes {FILMED_MINUTES} {BRIEF}"
        works = {
            "help": "--help",
            "session help": "session --help",
            "measure help": "measure --help",
            "state": state,
            "closed form": f"{state} --world.dynamics closed_form",
            "images": filmed,
            "film": f"{filmed} --video",
        }
        costs: dict[str, list[Cost]] = {name: [] for name in works}
        for block in range(min(blocks, MOST_BLOCKS) + 1):
            for name, words in works.items():
                out = "" if "help" in name else f" --out {folder}/{name.replace(' ', '_')}_{block}"
                cost = measured(words + out)
                if block:  # the first compiles
                    costs[name].append(cost)
    seconds = {name: [cost.seconds for cost in of] for name, of in costs.items()}
    figures = Figures()
    for name in ("help", "session help", "measure help"):
        figures.add(f"{name.replace(' ', '_')}_s", seconds[name])
    for name in ("state", "closed form"):
        figures.add(f"{name.replace(' ', '_')}_command_s", seconds[name])
        pace = [60 * STATE_MINUTES / taken for taken in seconds[name]]
        figures.add(f"{name.replace(' ', '_')}_command_times_real_time", pace)
    more = [film - plain for film, plain in zip(seconds["film"], seconds["images"], strict=True)]
    figures.add("video_frame_ms", [1000 * taken / (FILMED_MINUTES * FRAMES_PER_MINUTE) for taken in more])
    figures.add("session_mib", [cost.mebibytes for cost in costs["images"]])
    figures.add("state_session_mib", [cost.mebibytes for cost in costs["state"]])
    for name, cost in first.items():
        figures.add(name, cost.seconds)
    return figures


def measured(words: str, environment: Mapping[str, str] | None = None) -> Cost:
    """What the command ``jointattn`` takes with these words, in a process of its own.

    Args:
        words: Of the command line, as in a shell.
        environment: Variables that differ from those of this process.

    Raises:
        CommandError: It has failed; the message repeats what it said last.
    """
    with tempfile.TemporaryFile() as errors:
        with apart.started(shlex.split(words), environment, errors, PATIENCE_S) as process:
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = code = os.waitstatus_to_exitcode(status)
        if code:
            errors.seek(0)
            lines = errors.read().decode(errors="replace").splitlines() if code > 0 else []
            said = lines[-1].removeprefix("jointattn: ") if lines else apart.ending(code)
            raise CommandError(f"jointattn {words}: {said}")
    return Cost(used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)


def _fresh(words: str) -> Cost:
    """What a command takes where nothing was compiled before."""
    with tempfile.TemporaryDirectory() as cache:
        return measured(words, {"NUMBA_CACHE_DIR": cache})
