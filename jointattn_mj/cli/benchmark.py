"""``jointattn benchmark``: how fast simulation, perception and analysis run."""

import json
from collections.abc import Callable
from typing import Annotated, Any

from jointattn_mj.benchmarks.loop import BenchmarkOptions, as_text, run_benchmark
from jointattn_mj.cli.running import one_thread
from jointattn_mj.io.files import write_whole
from jointattn_mj.io.progress import Progress
from jointattn_mj.options import FLAT

LESS = "fewer seconds"


def benchmark(options: Annotated[BenchmarkOptions, FLAT]) -> None:
    """Measure how fast everything runs, as ratios taken in one run.

    Compares a session from images with rendering alone, with a session from the state, and with dm_control's cartpole;
    steps of development from images with rendering these; the search for contingency with recomputation in numpy.
    """
    one_thread()
    parts: dict[str, Callable[[], dict[str, Any]]] = {
        "scene": lambda: run_benchmark(options).rows(),
        "steps": lambda: _steps(options.blocks),
        "contingency": lambda: _contingency(options.blocks),
    }
    rows: dict[str, Any] = {}
    with Progress("measuring") as shown:
        for name in parts if options.what == "all" else [options.what]:
            shown.doing(f"measuring {name}")
            rows |= parts[name]()
    print(as_text(rows))
    if options.out is not None:
        text = json.dumps(rows, indent=1) + "\n"
        write_whole(options.out, lambda path: path.write_text(text))


def _steps(blocks: int) -> dict[str, Any]:
    from jointattn_mj.benchmarks.steps import run_steps_benchmark

    return run_steps_benchmark(blocks).rows()


def _contingency(blocks: int) -> dict[str, Any]:
    from jointattn_mj.benchmarks.contingency import run_contingency_benchmark

    return run_contingency_benchmark(blocks).rows()
