"""Which kind of run a folder holds, as its tables say, so that it is opened as what it is."""

from pathlib import Path

from jointattn_mj.errors import OutputError

KINDS = {
    "SessionResult": ("session", ("gaze_shifts.parquet",)),
    "DevelopmentResult": ("develop", ("steps.parquet", "turns.parquet")),
    "PerceptionResult": ("perceive", ("percepts.parquet",)),
}
"""Class of a result: the command that leaves it, and tables that only this command leaves."""


def check_kind(folder: Path, wanted: str) -> None:
    """Refuse the folder of another kind of run; one that holds none of them passes.

    Args:
        folder: Of a run.
        wanted: Class of the result that is to be opened.

    Raises:
        OutputError: The folder holds another kind of run.
    """
    there = [kind for kind, (_, tables) in KINDS.items() if any((folder / table).is_file() for table in tables)]
    if there and wanted not in there:
        command = KINDS[there[0]][0]
        raise OutputError(f"{folder} is the folder of a run of {command}; open it with {there[0]}.open")
