"""Table and figure of the wrong maps from stored cells (see ``sweep``)."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro
from matplotlib.figure import Figure

from experiments.wrong_map.sweep import SETTINGS
from jointattn_mj.laboratory.statistics import mean_interval
from jointattn_mj.recording.figures import save


@dataclass(frozen=True)
class Options:
    """Where the cells are."""

    folder: Annotated[Path, tyro.conf.Positional]
    """What the sweep's --out was."""
    figure: Path | None = None
    """PNG to draw."""


def read_cells(folder: Path, name: str) -> list[dict]:
    """The stored results of a setting, by seed."""
    paths = sorted(folder.glob(f"{name}_[0-9]*.json"), key=lambda path: int(path.stem.rsplit("_", 1)[1]))
    return [json.loads(path.read_text()) for path in paths]


def main() -> None:
    """Print the table as Markdown and draw the figure where asked."""
    options = tyro.cli(Options, description=__doc__)
    figure = Figure(figsize=(8, 4), layout="constrained")
    axes = figure.subplots()
    names = [name for name in SETTINGS if read_cells(options.folder, name)]
    print("| setting | n | map error (deg) | sessions worse than 6 deg | successes | late rate | right pairs |")
    print("|---|---|---|---|---|---|---|")
    for place, name in enumerate(names):
        cells = read_cells(options.folder, name)
        error = np.array([cell["map_error_deg"]["median"] for cell in cells])
        columns = [mean_interval([cell[key] for cell in cells]) for key in ("successes", "late_rate", "right_pairs")]
        worse = f"{np.mean(error > 6):.0%}"
        print(f"| {name} | {len(cells)} | {mean_interval(error)} | {worse} | {' | '.join(map(str, columns))} |")
        axes.plot(np.full(len(error), place) + np.linspace(-0.2, 0.2, len(error)), np.sort(error), "o", ms=3)
        axes.hlines(np.median(error), place - 0.3, place + 0.3, color="black")
    axes.set_xticks(range(len(names)), [name.replace("_", "\n") for name in names], fontsize=8)
    axes.set(ylabel="error of the learned map, last 6 min (deg)")
    axes.set_title("A dot is a session of 26 minutes; bars are medians")
    axes.grid(alpha=0.3, axis="y")
    if options.figure is not None:
        options.figure.parent.mkdir(parents=True, exist_ok=True)
        save(figure, options.figure)


if __name__ == "__main__":
    main()
