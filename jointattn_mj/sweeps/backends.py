"""Where trials are computed: processes of this machine (loky), or the workers of a dask scheduler somebody started.

Both take a function and its arguments and hand back a ``concurrent.futures.Future``; what differs is how the death of a
worker shows, and what is left after it.
"""

import logging
import os
import queue
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, Future
from contextlib import contextmanager, suppress
from typing import Any, Protocol

from joblib import cpu_count
from joblib.externals.loky import ProcessPoolExecutor
from joblib.externals.loky.backend.resource_tracker import ensure_running
from joblib.externals.loky.process_executor import BrokenProcessPool

from jointattn_mj.errors import ConfigError, SweepError
from jointattn_mj.sweeps.worker import SINGLE_THREADED, start


class Backend(Protocol):
    """Computes in other processes."""

    deaths: tuple[type[BaseException], ...]
    """What a future raises when its worker died."""
    all_die_together: bool
    """Whether one death takes everything under way with it."""
    most_deaths: int
    """So often a trial may end in one, the last times alone, before it counts as failed."""

    def slots(self) -> int:
        """How many trials can run at once; 0 while there is no worker."""

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Compute somewhere, soon."""

    def restart(self) -> None:
        """Begin anew after a death."""

    def close(self) -> None:
        """Stop whatever still runs."""


class Loky:
    """``jobs`` processes of this machine, as many as it has cores where it is 0."""

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
        return self._executor.submit(function, *arguments)

    def restart(self) -> None:
        self.close()

    def close(self) -> None:
        if self._executor is not None:
            _take_back_waiting(self._executor)
            self._executor.shutdown(wait=True, kill_workers=True)
            self._executor = None


@contextmanager
def _hangup_ignored() -> Iterator[None]:
    """loky's process that counts semaphores is started so that the end of the terminal does not end it before us: it
    would be missed, with a stack trace."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    kept = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGHUP, kept)


def _take_back_waiting(executor: ProcessPoolExecutor) -> None:
    """Empty the queue of trials that wait, so that loky's thread does not look them up when they have been thrown away:
    it would end in a KeyError without consequence, and its stack trace would stand before the user."""
    with suppress(AttributeError, queue.Empty):
        while True:
            executor._work_ids.get_nowait()


class Dask:
    """The workers of the scheduler at ``address``; they may come and go."""

    all_die_together = False
    most_deaths = 1  # the scheduler has tried it with several workers by then

    def __init__(self, address: str, patience_s: float = 10.0):
        try:
            from distributed import Client
            from distributed.scheduler import KilledWorker
        except ImportError as error:
            raise SweepError("--backend dask needs dask: pip install 'jointattn-mj[cluster]'") from error
        _silence("distributed", "tornado")
        self.deaths: tuple[type[BaseException], ...] = (KilledWorker,)
        try:
            self._client = Client(address, timeout=patience_s, set_as_default=False)
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
    """Log nothing of these libraries: they would print stack traces before this one says in a line what is wrong."""
    for logger in map(logging.getLogger, [*logging.Logger.manager.loggerDict]):
        if logger.name.split(".")[0] in names:
            logger.setLevel(logging.CRITICAL + 1)


def gone(error: BaseException) -> SweepError:
    """What to say where nobody is there any more to compute."""
    return SweepError(
        f"nobody computes any more ({type(error).__name__}); start scheduler and workers again, then the same command "
        "goes on"
    )


def lost_touch(error: BaseException) -> bool:
    """Whether a future ended so because nobody is there any more to compute it."""
    return isinstance(error, CancelledError) or type(error).__name__ in ("CommClosedError", "FutureCancelledError")


def new_backend(name: str, jobs: int, address: str | None) -> Backend:
    """The backend that the options ask for.

    Raises:
        ConfigError: Options that do not go together.
        LaboratoryError: The scheduler cannot be reached.
    """
    if name == "loky":
        if address is not None:
            raise ConfigError(f"--address {address} is for --backend dask; loky's processes are on this machine")
        return Loky(jobs)
    if address is None:
        raise ConfigError("--backend dask needs --address, such as tcp://127.0.0.1:8786")
    return Dask(address)
