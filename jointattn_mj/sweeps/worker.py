"""Computes a trial in a worker process, and reports its error if it fails.

Trials are sent to workers as pickles, which can run any code. Workers, and whoever can reach the dask scheduler, are
trusted.
"""

import os
import pickle
import platform
import signal
import threading
import time
import traceback
from dataclasses import dataclass
from functools import cache
from typing import Any

from jointattn_mj.io.provenance import versions
from jointattn_mj.sweeps.store import text_of

SINGLE_THREADED = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "NUMBA_NUM_THREADS": "1",
    "OPENCV_FOR_THREADS_NUM": "1",
    "LP_NUM_THREADS": "0",
}
"""Environment of a worker, which keeps each trial to one core. llvmpipe counts extra threads, so 0 means one."""


@dataclass(frozen=True)
class TrialOutcome:
    """How a trial ended."""

    seconds: float
    """Wall time."""
    result: str = ""
    """JSON text; empty if the trial failed."""
    made_with: dict[str, Any] | None = None
    """Versions of packages, Python and platform."""
    error: str = ""
    """The error in one line; empty if there was none."""
    traceback: str = ""


def pack(trial: Any, config: Any) -> bytes:
    """Pickle a trial's function and config for :func:`compute`."""
    return pickle.dumps((trial, config))


def compute(packed: bytes, seed: int) -> TrialOutcome:
    """Compute one trial; an error becomes part of the outcome.

    Args:
        packed: The trial's function and config, as :func:`pack` makes them.
        seed: Seed of the trial.
    """
    for name, value in SINGLE_THREADED.items():
        os.environ.setdefault(name, value)
    started = time.perf_counter()
    try:
        trial, config = pickle.loads(packed)
        result = text_of(trial(config, seed))
    except BaseException as error:  # SystemExit is a failure too
        said = f"{type(error).__name__}: {error}".strip().rstrip(":")
        return TrialOutcome(time.perf_counter() - started, error=said, traceback=traceback.format_exc())
    return TrialOutcome(time.perf_counter() - started, result, _made_with())


def start() -> None:
    """Prepare a worker process: it ignores Ctrl-C and the end of the terminal, and exits when its parent is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(0.5)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@cache
def _made_with() -> dict[str, Any]:
    return {"versions": versions(), "python": platform.python_version(), "platform": platform.platform()}
