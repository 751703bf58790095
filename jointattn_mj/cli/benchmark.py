"""``jointattn benchmark``: how fast simulation, perception and analysis run."""

import shlex
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

from jointattn_mj.benchmarks.figures import Figures, committed
from jointattn_mj.benchmarks.options import BenchmarkOptions
from jointattn_mj.cli import apart
from jointattn_mj.cli.running import one_thread
from jointattn_mj.errors import CommandError
from jointattn_mj.io.files import make_room
from jointattn_mj.io.progress import Progress
from jointattn_mj.options import FLAT

LESS = "fewer seconds"


def benchmark(options: Annotated[BenchmarkOptions, FLAT]) -> None:
    """Measure how fast everything runs, as ratios taken in one run.

    Compares a session from images with rendering alone, with a session from the state, and with dm_control's cartpole;
    steps of development from images with rendering these; the search for contingency with recomputation in numpy, and
    transfer entropy with pyinform; many worlds in one process with Gymnasium's way; and counts what whole commands
    take. Medians stand beside their quartiles and beside the figures that came with this version.
    """
    if options.out is not None:
        make_room(options.out)  # sooner than after minutes of measuring
    before, figures = committed(), Figures()
    if options.what == "all":
        for name in PARTS:
            figures.merge(_measured_apart(name, options))
    else:
        one_thread()
        with Progress(f"measuring {options.what}"):
            figures = PARTS[options.what](options)
    print(figures.text(before))
    if options.out is not None:
        figures.write(options.out)


def _measured_apart(name: str, options: BenchmarkOptions) -> Figures:
    """Measure one part in a process of its own, as if it alone had been asked for.

    What ran before in a process changes figures: where much memory was freed, pyinform takes half the time.

    Raises:
        SystemExit: The process has failed, and said why.
        CommandError: A signal has ended it.
    """
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "figures.json"
        words = ["benchmark", "--what", name, "--blocks", str(options.blocks)]
        words += ["--seconds", str(options.seconds), "--out", str(out)]
        with apart.started(words) as process:
            code = process.wait()
        if code < 0:
            raise CommandError(f"jointattn {shlex.join(words)}: {apart.ending(code)}")
        if code:
            sys.exit(code)
        return Figures.read(out)


def _scene(options: BenchmarkOptions) -> Figures:
    from jointattn_mj.benchmarks.loop import run_benchmark

    return run_benchmark(options)


def _steps(options: BenchmarkOptions) -> Figures:
    from jointattn_mj.benchmarks.steps import run_steps_benchmark

    return run_steps_benchmark(options.blocks)


def _contingency(options: BenchmarkOptions) -> Figures:
    from jointattn_mj.benchmarks.contingency import run_contingency_benchmark

    return run_contingency_benchmark(options.blocks)


def _vector(options: BenchmarkOptions) -> Figures:
    from jointattn_mj.benchmarks.vector import run_vector_benchmark

    return run_vector_benchmark(options.blocks)


def _commands(options: BenchmarkOptions) -> Figures:
    from jointattn_mj.cli.costs import run_commands_benchmark

    return run_commands_benchmark(options.blocks)


PARTS: dict[str, Callable[[BenchmarkOptions], Figures]] = {
    "scene": _scene,
    "steps": _steps,
    "contingency": _contingency,
    "vector": _vector,
    "commands": _commands,
}
