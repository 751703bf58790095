"""A lock that one process holds at a time, and that is given up with the process, however it ends."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import IO


@contextmanager
def locked(path: Path) -> Iterator[bool]:
    """Hold the lock ``path`` while the block runs; yields False where another process, or block, holds it.

    ``path`` is an empty file that is made for the lock and deleted with it. A killed process leaves the file, and no
    lock.

    Raises:
        OSError: The file cannot be made, or its file system knows no locks.
    """
    with ExitStack() as stack:
        held = False
        while not held:
            file = stack.enter_context(path.open("a"))
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                break
            held = _is_at(path, file)
        if held:
            stack.callback(_delete, path)  # before the file is closed, so that no other holder's file is deleted
        yield held


def _is_at(path: Path, file: IO[str]) -> bool:
    """Whether ``file`` is still the one at ``path``: its last holder may have deleted it before it was locked here."""
    try:
        return os.path.samestat(path.stat(), os.fstat(file.fileno()))
    except FileNotFoundError:
        return False


def _delete(path: Path) -> None:
    with suppress(OSError):
        path.unlink()
