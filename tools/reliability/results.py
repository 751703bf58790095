"""What a harness found, as JSON with date, versions and machine, in ``experiments/reliability``."""

import datetime
import json
import os
import platform
from pathlib import Path

from jointattn_mj.io.provenance import versions
from tools.reliability.subjects import ROOT

FOLDER = ROOT / "experiments" / "reliability"
MOST_KEPT = 40
"""Failures that are written down; their number is in any case."""


def save(name: str, result: dict[str, object], seconds: float, folder: Path = FOLDER) -> Path:
    """Write a result to ``name``.json.

    Args:
        name: Of the file.
        result: What goes into it.
        seconds: How long it took.
        folder: For the file.
    """
    beside = {
        "date": datetime.date.today().isoformat(),
        "versions": versions() | {"python": platform.python_version()},
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores",
        "seconds": round(seconds),
    }
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.json"
    path.write_text(json.dumps(beside | result, indent=1) + "\n")
    return path


def load(name: str, folder: Path = FOLDER) -> dict | None:
    """What ``save`` wrote; None if there is nothing."""
    path = folder / f"{name}.json"
    return json.loads(path.read_text()) if path.exists() else None


def table(rows: list[dict]) -> str:
    """Rows of the same fields as a table in Markdown."""
    if not rows:
        return "Nothing."
    lines = [[str(field) for field in rows[0]], ["---"] * len(rows[0])]
    lines += [[f"{value:,}" if isinstance(value, int) else str(value) for value in row.values()] for row in rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
