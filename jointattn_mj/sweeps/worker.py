"""What a worker process does: one trial, whatever happens in it.

Trials travel to workers as pickles, which can run any code: workers and whoever can reach a dask scheduler are trusted.
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
"""Environment of a worker: trials run side by side, so none takes more than its core (llvmpipe counts from 0)."""


@dataclass(frozen=True)
class Outcome:
    """How a trial ended."""

    seconds: float
    result: str = ""
    """JSON text; empty where the trial failed."""
    made_with: dict[str, Any] | None = None
    """Versions and platform."""
    error: str = ""
    traceback: str = ""


def pack(trial: Any, config: Any) -> bytes:
    """A trial's function and config for :func:`compute`, which unpacks them where an error can be caught."""
    return pickle.dumps((trial, config))


def compute(packed: bytes, seed: int) -> Outcome:
    """Compute one trial. An error is an outcome like another."""
    for name, value in SINGLE_THREADED.items():
        os.environ.setdefault(name, value)
    started = time.perf_counter()
    try:
        trial, config = pickle.loads(packed)
        result = text_of(trial(config, seed))
    except BaseException as error:  # a trial that exits is one that failed
        said = f"{type(error).__name__}: {error}".strip().rstrip(":")
        return Outcome(time.perf_counter() - started, error=said, traceback=traceback.format_exc())
    return Outcome(time.perf_counter() - started, result, _made_with())


def start() -> None:
    """Begin a worker process of this machine: Ctrl-C and the end of the terminal are the main process's, and without
    that one it ends."""
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
