"""Figures as files that are the same whenever they are drawn."""

from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from jointattn_mj.io.files import write_whole

matplotlib.rcParams["svg.hashsalt"] = "jointattn"


def save(figure: Figure, path: Path) -> None:
    """Write a figure as PNG, without anything in it that changes from run to run."""
    write_whole(path, lambda temporary: figure.savefig(temporary, dpi=110, metadata={"Software": None}))
