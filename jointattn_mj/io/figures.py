"""Figures as files that are the same whenever they are drawn."""

from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from jointattn_mj.io.files import write_whole

matplotlib.rcParams["svg.hashsalt"] = "jointattn"


def save(figure: Figure, path: Path, whole: bool = False) -> None:
    """Write a figure as PNG, without anything in it that changes from run to run.

    Args:
        figure: The figure.
        path: Of the file.
        whole: Make the image as large as all words need, whatever the figure's size.
    """
    box = "tight" if whole else None
    write_whole(
        path, lambda temporary: figure.savefig(temporary, dpi=110, metadata={"Software": None}, bbox_inches=box)
    )
