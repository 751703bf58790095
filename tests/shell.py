"""Command lines for tests, each in a process of its own, without a second of imports for each.

A server imports the package once and forks for every command line; what is asked and answered are lines of JSON.
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
import traceback
from dataclasses import dataclass


@dataclass(frozen=True)
class Outcome:
    """How a command line ended."""

    code: int
    out: str
    err: str


class Shell:
    """Runs ``jointattn`` with the given arguments."""

    def __init__(self) -> None:
        self._server = subprocess.Popen(
            [sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def __call__(self, *arguments: object, env: dict[str, str] | None = None, file_limit: int | None = None) -> Outcome:
        """``env`` is added to the environment; no file can grow beyond ``file_limit`` bytes, as on a full disk."""
        request = {"arguments": [str(argument) for argument in arguments], "env": env or {}, "file_limit": file_limit}
        print(json.dumps(request), file=self._server.stdin, flush=True)
        return Outcome(**json.loads(self._server.stdout.readline()))

    def close(self) -> None:
        """End the server."""
        self._server.stdin.close()
        self._server.wait()


def _run(main, request: dict) -> int:
    """The command itself, in the forked process; its exit code."""
    os.environ.update(request["env"])
    if request["file_limit"] is not None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (request["file_limit"], resource.RLIM_INFINITY))
    try:
        main(request["arguments"])
    except SystemExit as stop:
        return stop.code or 0
    except BaseException:
        traceback.print_exc()
        return 1
    return 0


def _serve() -> None:
    from jointattn_mj.cli import COMMANDS, main

    for load in COMMANDS.values():
        load()
    for line in sys.stdin:
        with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
            child = os.fork()
            if child == 0:
                os.dup2(out.fileno(), 1)
                os.dup2(err.fileno(), 2)
                code = _run(main, json.loads(line))
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(code)
            code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
            out.seek(0)
            err.seek(0)
            print(json.dumps({"code": code, "out": out.read(), "err": err.read()}), flush=True)


if __name__ == "__main__":
    _serve()
