"""A command of ``jointattn`` in a process of its own, which runs as one that is typed in a shell."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

CODE = "import sys; from jointattn_mj.cli.main import main; sys.exit(main())"
ENDS_ALONE_S = 1.0
"""How long a command has to end by itself when this process is interrupted: by Ctrl-C, both are."""
PATIENCE_S = 10.0
"""How long it has after SIGTERM, before it is killed."""


def command(words: Sequence[str]) -> list[str]:
    """The program ``jointattn`` with these words, to be started in ``environment``, which says where this package is.

    Modules in the working directory are not imported, as they are not by the program ``jointattn``.
    """
    return [sys.executable, "-P", "-c", CODE, *words]


def environment(others: Mapping[str, str] | None = None) -> dict[str, str]:
    """Variables of this process, and with them ``others`` or in their place; compiled code is stored."""
    package = str(Path(__file__).parents[2])
    paths = os.pathsep.join([package, *filter(None, [os.environ.get("PYTHONPATH")])])
    return {**os.environ, "PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "", **(others or {})}


@contextmanager
def started(
    words: Sequence[str],
    others: Mapping[str, str] | None = None,
    errors: IO[bytes] | None = None,
    patience_s: float = PATIENCE_S,
) -> Iterator["subprocess.Popen[bytes]"]:
    """Run a command while the block runs: where that is interrupted, the command is stopped and waited for.

    Args:
        words: Of its command line.
        others: As for ``environment``.
        errors: Where its stderr goes; None: to that of this process. What it prints on stdout is discarded.
        patience_s: As ``PATIENCE_S``; a command that a command starts needs less, or it stays behind.
    """
    process = subprocess.Popen(command(words), env=environment(others), stdout=subprocess.DEVNULL, stderr=errors)
    try:
        yield process
    finally:
        try:
            with suppress(subprocess.TimeoutExpired):
                process.wait(ENDS_ALONE_S)
            process.terminate()
            with suppress(subprocess.TimeoutExpired):
                process.wait(patience_s)
        finally:
            process.kill()  # none of these does anything to one that has ended


def ending(code: int) -> str:
    """How a process ended, in words, by its return code as in ``subprocess``: minus the number of a signal."""
    return f"exit code {code}" if code >= 0 else f"ended by signal {-code} ({signal.strsignal(-code)})"
