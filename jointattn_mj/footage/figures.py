"""The figure of a video's fixations: where in the image, when, and the interest behind them."""

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from jointattn_mj.footage.fixations import Fixation
from jointattn_mj.footage.reader import RATE
from jointattn_mj.io.figures import save

POINTS = 600
"""Most points of a curve."""
WIDTH = 6.0
"""Inches. What is wider cannot be read on a telephone, which shows it at 390 pixels."""
FACE = "#8a5a3c"
Ink = str | tuple[float, ...]


def draw_fixations(
    path: Path, image: np.ndarray, fixations: list[Fixation], percepts: Path, names: tuple[str, ...], rgb: np.ndarray,
    start_s: float = 0.0,
) -> None:  # fmt: skip
    """Draw all fixations of a video.

    Args:
        path: Where to write the PNG.
        image: An image of the video as the robot gets it, (240, 320, 3) uint8 RGB.
        fixations: All of them.
        percepts: The file percepts.parquet, for the interest in each candidate.
        names: Of the candidates, the face last.
        rgb: (n, 3) colours of the objects, 0..1.
        start_s: Time of the first frame, s.
    """
    inks: list[Ink] = [*(tuple(0.85 * np.asarray(colour)) for colour in rgb), FACE]
    heights = (WIDTH * image.shape[0] / image.shape[1], 0.5 + 0.28 * len(names), 2.4)
    figure = Figure(figsize=(WIDTH, sum(heights)), layout="constrained")
    parts = figure.subplot_mosaic([["where"], ["when"], ["why"]], height_ratios=heights)
    _where(parts["where"], image, fixations, inks)
    _when(parts["when"], fixations, names, inks, start_s)
    _why(parts["why"], percepts, names, inks)
    parts["why"].sharex(parts["when"])
    parts["when"].set_xlim(start_s, start_s + max(_seconds(percepts), 1.0))
    save(figure, path)


def _seconds(percepts: Path) -> float:
    return int(pq.ParquetFile(percepts).metadata.num_rows) / RATE


def _where(axes: Axes, image: np.ndarray, fixations: list[Fixation], inks: list[Ink]) -> None:
    axes.imshow(image // 2 + 127)
    visible = [fixation for fixation in fixations if fixation.frames_visible]
    locations = np.array([fixation.px_sum / fixation.frames_visible for fixation in visible]).reshape(-1, 2)
    axes.plot(*locations.T, color="#34495e", lw=0.6, alpha=0.5)
    sizes, colours = (
        [160 * fixation.seconds for fixation in visible],
        [inks[fixation.candidate] for fixation in visible],
    )
    axes.scatter(locations[:, 0], locations[:, 1], sizes, colours, alpha=0.55, edgecolors="white", linewidths=0.8)
    axes.set(xticks=[], yticks=[])
    axes.set_title("Where the robot would look (area: how long)", loc="left", weight="bold")
    axes.set(xlim=(-0.5, image.shape[1] - 0.5), ylim=(image.shape[0] - 0.5, -0.5))


def _when(axes: Axes, fixations: list[Fixation], names: tuple[str, ...], inks: list[Ink], start_s: float) -> None:
    for number in range(len(names)):
        bars = [
            (start_s + fixation.start / RATE, fixation.seconds)
            for fixation in fixations
            if fixation.candidate == number
        ]
        axes.broken_barh(bars, (len(names) - 1 - number - 0.4, 0.8), facecolors=inks[number])
    axes.set(yticks=range(len(names)), yticklabels=names[::-1], ylim=(-0.6, len(names) - 0.4))
    axes.set_title("What it would look at, and when", loc="left", weight="bold")
    axes.tick_params(labelbottom=False)
    axes.grid(axis="x", alpha=0.3)


def _why(axes: Axes, percepts: Path, names: tuple[str, ...], inks: list[Ink]) -> None:
    columns = [f"{name}_interest" for name in names]
    file = pq.ParquetFile(percepts)
    every = max(1, file.metadata.num_rows // POINTS)
    kept: list[np.ndarray] = []
    first = 0
    for batch in file.iter_batches(columns=["time_s", *columns]):
        values = np.column_stack([np.asarray(column) for column in batch.columns])
        kept.append(values[-first % every :: every])
        first += len(values)
    table = np.concatenate(kept)
    for number, ink in enumerate(inks):
        axes.plot(table[:, 0], table[:, 1 + number], color=ink, lw=1.2, label=names[number])
    axes.set_title("How interesting each thing was", loc="left", weight="bold")
    axes.set(xlabel="time (s)", ylabel="interest I (eq. 6.1)", yscale="log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:,.0f}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.grid(alpha=0.3)
