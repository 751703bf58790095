"""Table and figure of chapter 6 from stored sessions (Fig. 6.8, section 6.4.3).

    python -m experiments.sessions.analysis out/sessions --figure experiments/figures/sessions.png
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import pyarrow.parquet as pq
import tyro
from matplotlib.figure import Figure

from experiments.sessions.sweep import SETTINGS
from jointattn_mj.laboratory.statistics import mean_interval
from jointattn_mj.recording.figures import save
from jointattn_mj.recording.summary import rate_of_success

QUANTITIES = {
    "gaze shifts": "gaze_shifts",
    "successes": "successes",
    "at launch": "successes_at_launch",
    "at landing": "successes_at_landing",
    "on nothing": "landings_on_nothing",
    "successes within 3.5 deg": "successes_on_something",
    "late rate": "late_rate",
    "map error (deg)": "map_error_deg.median",
    "pan error (deg)": "pan",
    "tilt error (deg)": "tilt",
}
PUBLISHED = {"cues": (302.0, 199.6, 0.80), "no_cues": (279.6, 124.4, None)}
COLOURS = {"cues": "#c0392b", "no_cues": "#2471a3"}
MINUTES = np.arange(1, 26)


@dataclass(frozen=True)
class Options:
    """Where the sessions are."""

    folder: Annotated[Path, tyro.conf.Positional]
    """What the sweep's --out was."""
    figure: Path | None = None
    """PNG to draw."""
    table: Path | None = None
    """JSON file for the numbers."""


def read_cells(folder: Path, name: str) -> list[dict]:
    """The summaries of a setting, by seed, each with its shifts under ``shifts``."""
    cells = []
    for path in sorted(folder.glob(f"{name}/*/summary.json"), key=lambda path: int(path.parent.name)):
        summary = json.loads(path.read_text())
        shifts = pq.read_table(path.parent / "gaze_shifts.parquet").to_pandas()
        summary["shifts"] = shifts[shifts.face_to_object]
        late = summary["shifts"][summary["shifts"].landing_s > (summary["minutes"] - 6) * 60]
        summary["pan"], summary["tilt"] = late.pan_error_deg.abs().median(), late.tilt_error_deg.abs().median()
        cells.append(summary)
    return cells


def value(summary: dict, key: str) -> float:
    """A number of a summary by its dotted name."""
    for part in key.split("."):
        summary = summary[part]
    return np.nan if summary is None else float(summary)


def moving_average(cell: dict) -> np.ndarray:
    """Eq. 6.9 at every minute of ``MINUTES``."""
    shifts = cell["shifts"]
    return rate_of_success(MINUTES, shifts.landing_s.to_numpy() / 60, shifts.success.to_numpy(bool))


def draw(folder: Path, path: Path) -> None:
    """Fig. 6.8 for either kind of perception: mean and standard deviation over sessions."""
    figure = Figure(figsize=(10, 4.4), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, perception in zip(panels, ("pixels", "truth"), strict=True):
        for condition, label in (("cues", "with motion cues"), ("no_cues", "without")):
            cells = read_cells(folder, f"{perception}/{condition}")
            if not cells:
                continue
            curves = np.array([moving_average(cell) for cell in cells])
            axes.errorbar(
                MINUTES, np.nanmean(curves, axis=0), np.nanstd(curves, axis=0, ddof=1) if len(curves) > 1 else None,
                fmt="x-" if condition == "cues" else "+-", color=COLOURS[condition], lw=1, capsize=2,
                label=f"{label} (mean, sd)",
            )  # fmt: skip
        axes.axhline(0.8, ls="--", color="#7f8c8d", lw=0.8, label="dissertation, with cues, after 20 min")
        axes.axhline(0.25, ls=":", color="#7f8c8d", lw=0.8, label="one of four objects at random")
        title = "from rendered pictures" if perception == "pixels" else "from the simulator's state"
        title += f" ({len(read_cells(folder, f'{perception}/cues'))} sessions each)"
        axes.set(xlabel="time (simulated minutes)", xlim=(0, 26), ylim=(0, 1), title=title)
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("success of gaze following, eq. 6.9")
    lines = panels[0].get_legend_handles_labels()
    figure.legend(*lines, fontsize=8, loc="outside lower center", ncols=4, frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    save(figure, path)


def main() -> None:
    """Print the table as Markdown; write it and the figure where asked."""
    options = tyro.cli(Options, description=__doc__)
    numbers: dict[str, dict] = {}
    print(f"| setting | n | {' | '.join(QUANTITIES)} |\n|---|---|{'---|' * len(QUANTITIES)}")
    for name in SETTINGS:
        cells = read_cells(options.folder, name)
        if cells:
            columns = {label: [value(cell, key) for cell in cells] for label, key in QUANTITIES.items()}
            estimates = {label: mean_interval(np.array(column)) for label, column in columns.items()}
            numbers[name] = {label: vars(estimate) for label, estimate in estimates.items()}
            print(f"| {name} | {len(cells)} | {' | '.join(map(str, estimates.values()))} |")
    for condition, (shifts, successes, late) in PUBLISHED.items():
        print(f"| dissertation, {condition} | 5 | {shifts} | {successes} | | | | {late or ''} | | | |")
    if options.table is not None:
        options.table.write_text(json.dumps(numbers, indent=1) + "\n")
    if options.figure is not None:
        draw(options.folder, options.figure)


if __name__ == "__main__":
    main()
