"""Where trials are computed: in processes of this machine (loky), or by the workers of a running dask scheduler.

Both take a function with its arguments and return a ``concurrent.futures.Future``. They differ in how the death of a
worker shows, and in what else it ends.
"""

import logging
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, Future
from contextlib import contextmanager, suppress
from queue import Empty, Queue
from typing import Any, Protocol, cast

from joblib import cpu_count
from joblib.externals.loky import ProcessPoolExecutor
from joblib.externals.loky.backend.resource_tracker import ensure_running
from joblib.externals.loky.process_executor import BrokenProcessPool

from jointattn_mj.errors import ConfigError, SweepError
from jointattn_mj.sweeps.worker import SINGLE_THREADED, start


class Backend(Protocol):
    """Computes functions in other processes."""

    deaths: tuple[type[BaseException], ...]
    """Exceptions of a future whose worker died."""
    all_die_together: bool
    """Whether the death of one worker ends all trials under way."""
    most_deaths: int
    """Number of workers' deaths after which a trial counts as failed. All but the first are with the trial alone."""

    def slots(self) -> int:
        """Number of trials that can run at once; 0 while there is no worker."""

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Compute ``function(*arguments)`` in a worker."""

    def restart(self) -> None:
        """Get ready for new work after a worker's death."""

    def close(self) -> None:
        """Stop all work."""


class Loky:
    """Processes of this machine.

    Args:
        jobs: Number of processes; 0 for one a core.

    Raises:
        ConfigError: ``jobs`` is negative.
    """

    deaths: tuple[type[BaseException], ...] = (BrokenProcessPool,)
    all_die_together = True
    most_deaths = 3

    def __init__(self, jobs: int = 0):
        if jobs < 0:
            raise ConfigError(f"jobs must be 1 or more, or 0 for every core; got {jobs}")
        self.jobs = jobs or cpu_count()
        self._executor: ProcessPoolExecutor | None = None

    def slots(self) -> int:
        return self.jobs

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        if self._executor is None:
            with _hangup_ignored():
                ensure_running()
            environment = {name: os.environ.get(name, value) for name, value in SINGLE_THREADED.items()}
            self._executor = ProcessPoolExecutor(self.jobs, env=environment, initializer=start)
        future: Future[Any] = self._executor.submit(function, *arguments)
        return future

    def restart(self) -> None:
        self.close()

    def close(self) -> None:
        if self._executor is not None:
            _forget_waiting(self._executor)
            self._executor.shutdown(wait=True, kill_workers=True)
            self._executor = None


@contextmanager
def _hangup_ignored() -> Iterator[None]:
    """Ignore SIGHUP in processes started by the block.

    loky's resource tracker has to outlive this process when the terminal closes; without it loky prints a traceback.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    kept = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGHUP, kept)


def _forget_waiting(executor: ProcessPoolExecutor) -> None:
    """Empty loky's queue of trials that no worker has begun, before its workers are killed.

    Its own thread would look these up after throwing them away, and print the traceback of a KeyError.
    """
    waiting: Queue[int] = executor._work_ids
    with suppress(Empty):
        while True:
            waiting.get_nowait()


class Dask:
    """The workers of a dask scheduler, of which any may join or leave while it computes.

    Args:
        address: Where the scheduler listens, such as ``tcp://127.0.0.1:8786``.
        patience_s: Seconds to wait for its answer.

    Raises:
        SweepError: dask is not installed, or no scheduler answers.
    """

    all_die_together = False
    most_deaths = 1  # the scheduler has tried it with several workers by then

    def __init__(self, address: str, patience_s: float = 10.0):
        try:
            from distributed import Client
            from distributed.scheduler import KilledWorker
        except ImportError as error:
            raise SweepError("`backend='dask'` needs dask: pip install 'jointattn-mj[cluster]'") from error
        _silence("distributed", "tornado")
        self.deaths: tuple[type[BaseException], ...] = (KilledWorker,)
        try:
            self._client = cast(Any, Client)(address, timeout=patience_s, set_as_default=False)
        except (OSError, ValueError) as error:
            raise SweepError(
                f"no dask scheduler answers at {address} ({error}); start one with `dask scheduler`, workers with "
                f"`dask worker {address} --nthreads 1`"
            ) from error
        self._executor: Executor = self._client.get_executor(pure=False)

    def slots(self) -> int:
        try:
            return sum(self._client.nthreads().values())
        except Exception as error:
            raise gone(error) from error

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        try:
            return self._executor.submit(function, *arguments)
        except Exception as error:
            raise gone(error) from error

    def restart(self) -> None:
        pass

    def close(self) -> None:
        self._executor.shutdown(wait=False)
        self._client.close(timeout=2)


def _silence(*names: str) -> None:
    """Turn off the logging of these libraries, which print tracebacks before our one-line message."""
    for logger in map(logging.getLogger, [*logging.Logger.manager.loggerDict]):
        if logger.name.split(".")[0] in names:
            logger.setLevel(logging.CRITICAL + 1)


def gone(error: BaseException) -> SweepError:
    """The error to raise when scheduler or workers are gone."""
    return SweepError(
        f"the workers are gone ({type(error).__name__}); start scheduler and workers again, and the same command "
        "goes on"
    )


def lost_touch(error: BaseException) -> bool:
    """Whether a future ended with ``error`` because the workers are gone."""
    return isinstance(error, CancelledError) or type(error).__name__ in ("CommClosedError", "FutureCancelledError")
