"""How much room there is on the disk."""

import shutil
from pathlib import Path

from jointattn_mj.errors import ConfigError


def free_bytes(folder: Path) -> int | None:
    """Bytes that may still be written to ``folder``, which need not be there yet; None where the system won't say."""
    try:
        there = next(path for path in (folder, *folder.absolute().parents) if path.exists())
        return shutil.disk_usage(there).free
    except OSError:
        return None


def check_free(folder: Path, needed: int, what: str, advice: str) -> None:
    """Refuse a run whose log would not fit; ``advice`` says what to ask for instead.

    Args:
        folder: Into which the run writes.
        needed: Bytes that it will write.
        what: The run in words, which begins the message.
        advice: What to ask for instead.

    Raises:
        ConfigError: ``what`` needs more bytes than are free.
    """
    free = free_bytes(folder)
    if free is not None and needed > free:
        raise ConfigError(
            f"{what} would write about {needed / 1e9:.1f} GB to {folder}, and {free / 1e9:.1f} GB are free there; ask "
            f"for {advice}, or choose another folder"
        )
