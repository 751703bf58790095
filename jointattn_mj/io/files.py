"""Folders that one run has for itself, and files in them that are there whole or not at all."""

import errno
import os
import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from jointattn_mj.errors import CheckpointError, OutputError
from jointattn_mj.io.lock import locked
from jointattn_mj.io.notices import notice
from jointattn_mj.options import is_utf8, shown

NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.ENOTSUP)
"""What ``flock`` answers on file systems without locks, such as some of NFS and Lustre."""


@contextmanager
def claimed(out: Path, resume: bool = False) -> Iterator[None]:
    """Hold the folder ``out`` for one run while the block runs; without ``resume`` there must be no other run in it.

    Raises:
        OutputError: As ``held``, or it holds another run.
        CheckpointError: ``resume``, and there is no such folder.
    """
    if resume and not out.is_dir():
        raise CheckpointError(f"there is no checkpoint in {out}; run without `resume` to begin")
    with held(out):
        if not resume:
            _refuse_another(out)
        yield


@contextmanager
def held(out: Path) -> Iterator[None]:
    """Make the folder ``out`` and hold it while the block runs: no other process can do so meanwhile.

    A killed process holds nothing any more, and what it left half written is deleted.

    Raises:
        OutputError: Another process holds it, or it cannot be made or written to.
    """
    make_folder(out)
    busy = f"another process is at work in {out}; wait until it has ended, or choose another folder"
    with alone(out / ".lock", out, busy):
        forget_partial(out)
        yield


def make_folder(out: Path) -> None:
    """Make a folder of results and those that it is in, where they are not there yet.

    Raises:
        OutputError: It cannot be made, or some library could not write into it.
    """
    if not is_utf8(out.absolute()):
        raise OutputError(f"{shown(out)} is not UTF-8, and tables cannot be written there; choose another folder")
    _make(out)


def make_room(path: Path) -> None:
    """Make the folder of a file that is to be written later.

    Raises:
        OutputError: The folder cannot be made or written to, or ``path`` is a folder itself.
    """
    _make(path.parent)
    if os.path.isdir(path):
        raise OutputError(f"{path} is a folder; choose a file in it")
    if not os.access(path.parent, os.W_OK):
        raise OutputError(f"cannot write to {path.parent}; choose another folder")


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:  # ValueError: there is a NUL in it
        trouble = getattr(error, "strerror", None) or error
        raise OutputError(f"cannot make the folder {folder}: {trouble}; choose another folder") from error


@contextmanager
def alone(lock: Path, out: Path, busy: str) -> Iterator[None]:
    """Hold a lock while the block runs. Where the file system knows no locks, say so and go on.

    Args:
        lock: Its file.
        out: What it stands for: a folder, or a file.
        busy: What the error says where another process holds it.

    Raises:
        OutputError: Another process holds it, or its file cannot be made.
    """
    with ExitStack() as stack:
        try:
            free = stack.enter_context(locked(lock))
        except OSError as error:
            if error.errno not in NO_LOCKS:
                raise OutputError(f"cannot write to {out}: {error.strerror}; choose another folder") from error
            notice(f"the file system of {out} knows no locks; see to it that no second run begins there")
            free = True
        if not free:
            raise OutputError(busy)
        yield


def _refuse_another(out: Path) -> None:
    """Refuse a folder with a run in it; a config alone was left by a run that was killed as it began."""
    if (out / "checkpoint.bin").exists():
        raise OutputError(f"{out} already holds a run; choose another folder, or go on with that one by `resume`")
    if (out / "summary.json").exists():
        raise OutputError(f"{out} already holds a run, and no checkpoint to go on from; choose another folder")
    config = out / "config.yaml"
    try:
        foreign = config.exists() and b"jointattn_mj" not in config.read_bytes()
        if not foreign:
            config.unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"cannot replace {config}: {error.strerror}; choose another folder") from error
    if foreign:
        raise OutputError(f"{config} was not written by this package and is left alone; choose another folder")


def free_name(path: Path) -> Path:
    """``path``, or with a number where there is such a file already."""
    names = [path, *(path.with_stem(f"{path.stem}_{part}") for part in range(2, 1000))]
    return next(name for name in names if not name.exists())


def forget_partial(folder: Path) -> None:
    """Delete what processes that were killed while they wrote have left in ``folder``."""
    for path in folder.glob(".*"):
        if re.fullmatch(r"\..+\.\d+\.\w+", path.name):
            with suppress(OSError):
                path.unlink()


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Let ``write`` fill a temporary file beside ``path`` and put it in place in one step.

    Its name is an absolute path: libraries take what stands before a colon in a relative one as a protocol.

    Raises:
        OutputError: The file cannot be written; what ``path`` held before is still there.
    """
    temporary = path.absolute().with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        write(temporary)
        os.replace(temporary, path)
    except OutputError:  # of another file that belongs to this one
        raise
    except OSError as error:
        trouble = error.strerror or error
        raise OutputError(f"cannot write {path}: {trouble}; free space or choose another folder") from error
    finally:
        with suppress(OSError):  # a read-only file system refuses even to delete what is not there
            temporary.unlink(missing_ok=True)
