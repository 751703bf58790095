"""Names that tables and their columns had in the last version; they are accepted for one version more."""

from pathlib import Path

from jointattn_mj.options import warn_renamed

FORMER_FILES = {"steps.parquet": "turns.parquet"}
"""Name of a table now, and its former name."""
FORMER = {"turn": "step", "looked": "perceived", "seen": "visible", "picture": "image"}
"""Former name of a column, or what followed a candidate's name in it, and its name now."""


def present_name(column: str) -> str:
    """The name now of a column of the last version, such as ``red_visible`` for ``red_seen``; others stay."""
    candidate, joint, name = column.rpartition("_")
    return candidate + joint + FORMER.get(name, name)


def present_file(folder: Path, name: str) -> Path:
    """A table in the folder of a run; where only that of the last version is there, that one, with a warning.

    Args:
        folder: Of the run.
        name: Name of the file now.

    Returns:
        Its path, whether or not the file is there.
    """
    path, former = folder / name, folder / FORMER_FILES.get(name, name)
    if path.exists() or path == former or not former.exists():
        return path
    warn_renamed(str(former), name)
    return former
