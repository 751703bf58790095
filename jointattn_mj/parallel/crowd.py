"""Trials whose images one graphics card draws: processes of this machine, each with many trials at once.

A single image keeps a card waiting; it draws those of hundreds of worlds in hardly more time. Trials ask for images in
the middle of their computation, so that each process goes on with another trial meanwhile (``crowd_worker``).
"""

import os
import pickle
import subprocess
import threading
from collections import Counter
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from importlib.util import find_spec
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from typing import Any

from joblib import cpu_count

from jointattn_mj.errors import ConfigError, SweepError
from jointattn_mj.io.child import start_child
from jointattn_mj.io.extras import extra
from jointattn_mj.sweeps.worker import SINGLE_THREADED

AT_ONCE = 64
"""Trials at once in a process. Half of them are drawn while the other half compute."""

ALL = 0
"""Number in a worker's answer whose error ends all trials."""


class CrowdWorkerDied(RuntimeError):
    """A process with trials has ended."""


class Crowd:
    """Processes that share an eye server.

    Args:
        jobs: Number of processes; 0 for one a core.
        at_once: Trials at once in each.

    Raises:
        ConfigError: A number is out of range.
        ExtraError: The extra ``gpu`` is not installed.
    """

    deaths: tuple[type[BaseException], ...] = (CrowdWorkerDied,)
    all_die_together = True
    most_deaths = 3

    def __init__(self, jobs: int = 0, at_once: int = AT_ONCE):
        if jobs < 0 or at_once < 1:
            raise ConfigError(
                f"jobs must be 1 or more, or 0 for every core, and 1 or more trials at once; got {jobs}, {at_once}"
            )
        for module in ("greenlet", "mujoco_warp"):
            if find_spec(module) is None:
                extra("gpu", module)
        self.jobs, self.at_once = jobs or cpu_count(), at_once
        self._children: list[subprocess.Popen[bytes]] = []
        self._workers: list[Connection] = []
        self._load: Counter[Connection] = Counter()
        self._futures: dict[int, Future[Any]] = {}
        self._number = ALL
        self._end: Exception | None = None
        self._lock = threading.Lock()
        self._listener: threading.Thread | None = None

    def slots(self) -> int:
        return self.jobs * self.at_once

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """See :class:`Backend`.

        Raises:
            CrowdWorkerDied: A process with trials has ended.
            SweepError: The eye server has ended.
        """
        packed = pickle.dumps((function, arguments))
        if not self._workers:
            self._start()
        future: Future[Any] = Future()
        future.set_running_or_notify_cancel()
        with self._lock:
            if self._end is not None:
                raise self._end
            worker = min(self._workers, key=self._load.__getitem__)
            number = self._number = self._number + 1
            self._futures[number] = future
            self._load[worker] += 1
        with suppress(OSError):  # the listener sees the same end, and tells all futures
            worker.send((number, packed))
        return future

    def _start(self) -> None:
        """Start the eye server and all workers."""
        environment = {**SINGLE_THREADED, **os.environ}
        eyes, tasks = ([Pipe() for _ in range(self.jobs)] for _ in range(2))
        self._children = [start_child("jointattn_mj.scene.eye_server", "serve_eyes", [theirs for theirs, _ in eyes])]
        for (_, eye), (task, theirs) in zip(eyes, tasks, strict=True):
            self._children.append(start_child("jointattn_mj.parallel.crowd_worker", "work", [theirs, eye], environment))
            with suppress(OSError):
                task.send(self.at_once)
        self._workers = [task for task, _ in tasks]
        self._listener = threading.Thread(target=self._listen, args=(list(self._workers),), daemon=True)
        self._listener.start()

    def _listen(self, workers: list[Connection]) -> None:
        """Take results until a worker or the eye server has ended; then all trials under way are lost."""
        while True:
            for ready in wait(workers):
                worker: Any = ready
                try:
                    number, result, error = worker.recv()
                except (EOFError, OSError):
                    return self._give_up(CrowdWorkerDied())
                if number == ALL:
                    return self._give_up(SweepError(f"no trial can go on: {error}; the same command goes on"))
                with self._lock:
                    future = self._futures.pop(number)
                    self._load[worker] -= 1
                if error is None:
                    future.set_result(result)
                else:
                    future.set_exception(error)

    def _give_up(self, end: Exception) -> None:
        with self._lock:
            self._end, lost, self._futures = end, self._futures, {}
        for future in lost.values():
            future.set_exception(end)

    def restart(self) -> None:
        self.close()

    def close(self) -> None:
        for child in self._children:
            child.kill()
        for child in self._children:
            child.wait()
        if self._listener is not None:
            self._listener.join()  # it ends with the workers, and reads from their connections until then
        for worker in self._workers:
            worker.close()
        self._children, self._workers, self._load, self._end = [], [], Counter(), None
