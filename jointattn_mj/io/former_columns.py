"""Names that columns of this package's tables had in the last version; they are accepted for one version more."""

FORMER = {"turn": "step", "looked": "perceived", "seen": "visible", "picture": "image"}
"""Former name of a column, or what followed a candidate's name in it, and its name now."""


def present_name(column: str) -> str:
    """The name now of a column of the last version, such as ``red_visible`` for ``red_seen``; others stay."""
    candidate, joint, name = column.rpartition("_")
    return candidate + joint + FORMER.get(name, name)
