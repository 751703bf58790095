"""Where compiled code is stored: in a folder of its own for each state of the sources.

numba takes a stored function for current as long as the file that it stands in has not changed. What was inlined into
it from other files may have changed all the same, and an old mixture would run on, silently. A folder named after the
contents of all files with compiled functions rules that out.
"""

import hashlib
import os
import shutil
import sys
import time
from pathlib import Path

VARIABLE = "NUMBA_CACHE_DIR"
PREFIX = "jointattn-"
FORGOTTEN_AFTER_S = 7 * 24 * 3600
"""Folders of other states of the sources are removed when they have been left alone for so long."""


def state(package: Path) -> str:
    """Twelve digits that change with any file of the package in which something is compiled."""
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        text = path.read_bytes()
        if b"njit" in text:
            digest.update(str(path.relative_to(package)).encode() + b"\0" + text)
    return digest.hexdigest()[:12]


def choose_folder(package: Path = Path(__file__).parent) -> None:
    """Tell numba, and the processes that are started from this one, where to store what it compiles.

    That is beside the package's byte code, or in the folder that NUMBA_CACHE_DIR names. Where the package cannot be
    written to and none is named, numba's own choice stays.
    """
    named = os.environ.get(VARIABLE)
    base = Path(named) if named else package / "__pycache__"
    if base.name.startswith(PREFIX):  # from the process that started this one
        base = base.parent
    folder = base / f"{PREFIX}{state(package)}"
    if not folder.is_dir():
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            return
        _forget(base, folder)
    os.environ[VARIABLE] = str(folder)
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = str(folder)


def _forget(base: Path, kept: Path) -> None:
    for folder in base.glob(f"{PREFIX}*"):
        if folder != kept and time.time() - folder.stat().st_mtime > FORGOTTEN_AFTER_S:
            shutil.rmtree(folder, ignore_errors=True)
