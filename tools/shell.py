"""Command lines, each in a process of its own, without a second of imports for each.

A server imports once what commands need and forks for every command line; what is asked and answered are lines of JSON.
"""

import importlib
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
HUNG = 124
"""The code of a command that had to be stopped, as ``timeout`` has it."""


@dataclass(frozen=True)
class Outcome:
    """How a command line ended."""

    code: int
    """Exit code; the negative number of the signal that ended it; ``HUNG``."""
    out: str
    err: str


class Shell:
    """Runs ``jointattn`` with the given arguments, or lines of Python."""

    def __init__(self, cwd: Path | None = None) -> None:
        """``cwd``: where commands run, and its package is taken if it holds one; without it, where the caller is."""
        self._cwd = cwd
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, [os.getenv("PYTHONPATH"), str(ROOT)]))}
        self._server = subprocess.Popen(
            [sys.executable, __file__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=cwd,
            env=environment,
        )

    def __call__(
        self,
        *arguments: object,
        env: dict[str, str] | None = None,
        file_limit: int | None = None,
        seconds: float | None = None,
        memory: int | None = None,
    ) -> Outcome:
        """``env`` is added to the environment; no file can grow beyond ``file_limit`` bytes, as on a full disk; what
        takes longer than ``seconds`` is killed, with all that it has started; no process gets more than ``memory``
        bytes."""
        asked = [str(argument) for argument in arguments]
        return self._ask(arguments=asked, env=env, limit=file_limit, seconds=seconds, memory=memory)

    def python(self, source: str, seconds: float | None = None, memory: int | None = None) -> Outcome:
        """Run lines of Python, as if they were a program.

        Args:
            source: The lines.
            seconds: Most that it may take.
            memory: Most bytes that it may take.
        """
        return self._ask(source=source, seconds=seconds, memory=memory)

    def _ask(self, **request: object) -> Outcome:
        request["cwd"] = str(self._cwd or Path.cwd())
        print(json.dumps(request), file=self._server.stdin, flush=True)
        return Outcome(**json.loads(self._server.stdout.readline()))

    def close(self) -> None:
        """End the server."""
        self._server.stdin.close()
        self._server.wait()


def _run(main, request: dict) -> int:
    """The command itself, in the forked process; its exit code."""
    os.setpgid(0, 0)
    os.chdir(request["cwd"])
    os.environ.update(request.get("env") or {})
    if request.get("limit") is not None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (request["limit"], resource.RLIM_INFINITY))
    if request.get("memory") is not None:
        resource.setrlimit(resource.RLIMIT_AS, (request["memory"], request["memory"]))
    try:
        if "source" in request:
            exec(compile(request["source"], "<source>", "exec"), {"__name__": "__main__"})
        else:
            main(request["arguments"])
    except SystemExit as stop:
        if isinstance(stop.code, str):
            print(stop.code, file=sys.stderr)
            return 1
        return stop.code or 0
    except BaseException:
        traceback.print_exc()
        return 1
    return 0


def _wait(child: int, seconds: float | None) -> int:
    """Exit code of a child, which is given so many seconds."""
    if seconds is None:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.005)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return HUNG


def _warm_up() -> None:
    """Import what most commands import late, and let numba get ready: a second of every command's time."""
    import numba

    for name in ("matplotlib.backends.backend_agg", "pandas", "pyarrow.parquet", "scipy.stats"):
        importlib.import_module(name)
    numba.njit(lambda number: number + 1)(1)


def _serve() -> None:
    from jointattn_mj.cli.commands import COMMANDS
    from jointattn_mj.cli.main import main
    from jointattn_mj.cli.parsing import module_of

    for name in COMMANDS:
        module_of(name)
    _warm_up()
    for line in sys.stdin:
        with (
            tempfile.TemporaryFile("w+", errors="replace") as out,
            tempfile.TemporaryFile("w+", errors="replace") as err,
        ):
            request = json.loads(line)
            child = os.fork()
            if child == 0:
                os.dup2(out.fileno(), 1)
                os.dup2(err.fileno(), 2)
                code = _run(main, request)
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(code)
            code = _wait(child, request.get("seconds"))
            out.seek(0)
            err.seek(0)
            print(json.dumps({"code": code, "out": out.read(), "err": err.read()}), flush=True)


if __name__ == "__main__":
    _serve()
