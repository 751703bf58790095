"""Files that are there whole or not at all."""

import os
import re
from collections.abc import Callable
from pathlib import Path

from jointattn_mj.errors import OutputError


def claim(out: Path, resumable: bool = True) -> None:
    """Make the folder of a run; ``resumable``: whether a run that is there could be gone on with.

    Raises:
        OutputError: It holds a run already, or cannot be made.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot make the folder {out}: {error.strerror}; choose another --out") from error
    if any((out / name).exists() for name in ("config.yaml", "checkpoint.bin")):
        resume = ", or --resume to go on with that one" if resumable else ""
        raise OutputError(f"{out} already holds a run; choose another --out{resume}")


def forget_partial(folder: Path) -> None:
    """Delete what processes that were killed while they wrote have left in ``folder``."""
    for path in folder.glob(".*"):
        if re.fullmatch(r"\..+\.\d+\.\w+", path.name):
            path.unlink(missing_ok=True)


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Let ``write`` fill a temporary file beside ``path`` and put it in place in one step.

    Raises:
        OutputError: The file cannot be written; what ``path`` held before is still there.
    """
    temporary = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        write(temporary)
        os.replace(temporary, path)
    except OSError as error:
        trouble = error.strerror or error
        raise OutputError(f"cannot write {path}: {trouble}; free space or choose another --out") from error
    finally:
        temporary.unlink(missing_ok=True)
