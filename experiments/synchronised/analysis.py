r"""How the learner grows with l in step with the caregiver, and the published gate beside it (Fig. 6.7).

    python -m experiments.synchronised.analysis out \
        --figure experiments/figures/synchronised.png --summary out/synchronised/summary.json
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro
from matplotlib.figure import Figure

from experiments.synchronised.sweep import SETTINGS
from jointattn_mj.gaze import GazeConfig, gate_probability
from jointattn_mj.laboratory.statistics import mean_interval
from jointattn_mj.recording.figures import save
from jointattn_mj.recording.files import write_whole

SHOWN = {
    "synchronised/cues": ("with motion cues", "#c0392b"),
    "synchronised/no_cues": ("without motion cues", "#2471a3"),
    "synchronised/no_cues_face_to_object_only": ("without, pairs in one direction only", "#b7950b"),
}
SHARES = (0.8, 0.9)
LATE_FROM = 350
"""l from which on accuracy counts as final."""


@dataclass(frozen=True)
class Options:
    """Where the runs are."""

    folder: Annotated[Path, tyro.conf.Positional]
    """What the sweep's --out was."""
    figure: Path | None = None
    """PNG to draw."""
    summary: Path | None = None
    """JSON file for the numbers."""


def read_runs(folder: Path, name: str) -> dict[str, np.ndarray]:
    """All stored runs of a setting, each quantity (runs, tests); empty if there are none."""
    paths = sorted((folder / name).glob("seed_*.npz"), key=lambda path: int(path.stem.removeprefix("seed_")))
    runs = [dict(np.load(path)) for path in paths]
    return {key: np.stack([run[key] for run in runs]) for key in runs[0]} if runs else {}


def reaches(iterations: np.ndarray, accuracy: np.ndarray, share: float) -> np.ndarray:
    """(runs,) the first l at which a run's accuracy, averaged over three tests, is ``share`` of its final one."""
    smooth = np.stack([np.convolve(np.pad(run, 1, "edge"), np.ones(3) / 3, "valid") for run in accuracy])
    final = np.nanmean(np.where(iterations >= LATE_FROM, accuracy, np.nan), axis=1, keepdims=True)
    enough = smooth >= share * final
    return np.where(enough.any(axis=1), iterations[np.argmax(enough, axis=1)], np.nan)


def numbers_of(runs: dict[str, np.ndarray]) -> dict[str, dict]:
    """What is reported of a setting, each with its interval over runs."""
    iterations, accuracy = runs["iterations"][0], runs["accuracy"]
    values = {f"reaches_{share}_of_final_at_l": reaches(iterations, accuracy, share) for share in SHARES}
    for at in (50, 100, 150, 200, 300, 400):
        column = int(np.argmin(np.abs(iterations - at)))
        values |= {f"accuracy_at_{at}": accuracy[:, column], f"error_deg_at_{at}": runs["error_deg"][:, column]}
    values["right_pairs"] = runs["right_pairs"][:, -1]
    values["final_accuracy"] = accuracy[:, iterations >= LATE_FROM].mean(axis=1)
    return {key: vars(mean_interval(column)) for key, column in values.items()}


def draw(folder: Path, path: Path) -> None:
    """Accuracy and error against l, with the gate of Fig. 6.7."""
    figure = Figure(figsize=(10, 3.9), layout="constrained")
    rate, error = figure.subplots(1, 2)
    steps = np.arange(401)
    gate = [gate_probability(GazeConfig(), step) for step in steps]
    rate.plot(steps, gate, "--", color="#2c3e50", lw=1.2, label="gate of Fig. 6.7, (p, q) = (150, 22.5)")
    for name, (label, colour) in SHOWN.items():
        runs = read_runs(folder, name)
        if not runs:
            continue
        for axes, key in ((rate, "accuracy"), (error, "error_deg")):
            estimates = [mean_interval(column) for column in runs[key].T]
            at = runs["iterations"][0]
            low, high = [e.low for e in estimates], [e.high for e in estimates]
            axes.fill_between(at, low, high, color=colour, alpha=0.2, lw=0)
            axes.plot(at, [e.mean for e in estimates], color=colour, lw=1.5, label=f"{label} ({len(runs[key])} runs)")
        where = np.nanmean(reaches(runs["iterations"][0], runs["accuracy"], SHARES[1]))
        rate.axvline(where, color=colour, ls=":", lw=1)
    rate.axhline(0.25, color="#7f8c8d", ls=":", lw=0.8)
    rate.set_title("her object is nearest to the suggestion\n(dotted: l of 90 % of the final share; chance)")
    rate.set(ylabel="share", ylim=(0, 1.02))
    error.set(ylabel="degrees", ylim=(0, 15), title="median error of the suggested direction")
    for axes in (rate, error):
        axes.title.set_fontsize(10)
        axes.set(xlabel="learning iterations l (face-to-object pairs)", xlim=(0, 400))
        axes.grid(alpha=0.3)
        axes.legend(fontsize=7)
    path.parent.mkdir(parents=True, exist_ok=True)
    save(figure, path)


def main() -> None:
    """Print the numbers as Markdown; write figure and numbers where asked."""
    options = tyro.cli(Options, description=__doc__)
    numbers = {name: numbers_of(runs) for name in SETTINGS if (runs := read_runs(options.folder, name))}
    for name, values in numbers.items():
        print(f"\n{name}\n\n| quantity | mean [95% interval] | n |\n|---|---|---|")
        for key, value in values.items():
            print(f"| {key} | {value['mean']:.2f} [{value['low']:.2f}, {value['high']:.2f}] | {value['n']} |")
    if options.summary is not None:
        text = json.dumps(numbers, indent=1) + "\n"
        write_whole(options.summary, lambda temporary: temporary.write_text(text))
    if options.figure is not None:
        draw(options.folder, options.figure)


if __name__ == "__main__":
    main()
