r"""Success of turn taking over learning time: figure and numbers from stored lives.

    python -m experiments.turn_taking.analysis out \
        --figure experiments/figures/turn_taking.png --summary out/turn_taking/summary.json
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.turn_taking.sweep import SETTINGS, Setting
from jointattn_mj.laboratory.statistics import mean_interval
from jointattn_mj.recording.figures import save
from jointattn_mj.recording.files import write_whole

END = 6
"""Stretches of a life, of 60, that count as its end: 30,000 attempts."""
LEVEL = 0.75
"""Success at which a stage counts as reached."""
COLOURS = {1: "#7f8c8d", 3: "#2471a3", 5: "#c0392b", 10: "#b7950b"}
ATTEMPTS = Setting().attempts


@dataclass(frozen=True)
class Options:
    """Where the lives are."""

    folder: Annotated[Path, tyro.conf.Positional]
    """What the sweep's --out was."""
    figure: Path | None = None
    """PNG to draw."""
    summary: Path | None = None
    """JSON file for the numbers."""


def read_lives(folder: Path, name: str) -> dict[str, np.ndarray]:
    """All stored lives of a setting: each count as an array (lives, stretches); empty if there are none."""
    paths = sorted((folder / name).glob("seed_*.npz"), key=lambda path: int(path.stem.removeprefix("seed_")))
    lives = [dict(np.load(path)) for path in paths]
    return {key: np.stack([life[key] for life in lives]) for key in lives[0]} if lives else {}


def rates(lives: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Rates (lives, stretches): any object, the right one, the right one where it was in view at first or was not.

    NaN where that was one attempt in a hundred or fewer (an object in view that was missed).
    """
    outside = lives["attempts"] - lives["in_view"]
    outside = np.where(outside > lives["attempts"] / 100, outside, np.nan)
    with np.errstate(invalid="ignore"):
        return {
            "any": lives["reached"] / lives["attempts"],
            "right": lives["right"] / lives["attempts"],
            "right_in_view": lives["right_in_view"] / lives["in_view"],
            "right_outside": lives["right_outside"] / outside,
        }


def numbers_of(name: str, lives: dict[str, np.ndarray]) -> dict[str, dict]:
    """What is reported of a setting, each with its interval over lives."""
    rate = rates(lives)
    stretch = SETTINGS[name].attempts / rate["right"].shape[1]
    tests = {
        f"test_{kind}": lives[f"test_{kind}_right"][:, 0] / lives[f"test_{kind}_attempts"][:, 0]
        for kind in ("known", "new")
    }
    start = {f"{key}_start": values[:, 0] for key, values in rate.items()}
    end = {f"{key}_end": values[:, -END:].mean(axis=1) for key, values in rate.items()}
    in_view, outside = (reaches(rate[f"right_{place}"], LEVEL) * stretch for place in ("in_view", "outside"))
    stages = {"in_view_reaches_at": in_view, "outside_reaches_at": outside, "outside_later_by": outside - in_view}
    lowest = {"right_lowest": rate["right"].min(axis=1), "any_lowest": rate["any"].min(axis=1)}
    return {key: vars(mean_interval(values)) for key, values in (start | end | stages | lowest | tests).items()}


def reaches(rate: np.ndarray, level: float) -> np.ndarray:
    """(lives,) when a rate first gets to ``level``, in stretches (interpolated); NaN for lives in which it does not."""
    reached = np.full(len(rate), np.nan)
    for life, values in enumerate(rate):
        above = np.flatnonzero(values >= level)
        if len(above):
            k = above[0]
            before = values[k - 1] if k else values[k]
            reached[life] = k + 0.5 - ((values[k] - level) / (values[k] - before) if values[k] > before else 0.0)
    return reached


def band(axes: Axes, rate: np.ndarray, label: str, colour: str) -> None:
    """A curve over learning time: mean of all lives with its 95% interval."""
    estimates = [mean_interval(column) for column in rate.T]
    at = _times(rate)
    axes.fill_between(at, [e.low for e in estimates], [e.high for e in estimates], color=colour, alpha=0.2, lw=0)
    axes.plot(at, [e.mean for e in estimates], color=colour, lw=1.5, label=label)


def _times(rate: np.ndarray) -> np.ndarray:
    """Middle of each stretch, 10^4 attempts."""
    return (np.arange(rate.shape[1]) + 0.5) * ATTEMPTS / rate.shape[1] / 1e4


def draw(folder: Path, path: Path) -> None:
    """Success by number of objects; the three stages with five and with ten; where objects lie."""
    figure = Figure(figsize=(8.2, 6.0), layout="constrained")
    by_number, by_place, five, ten = figure.subplots(2, 2, sharey=True).ravel()
    for objects, colour in COLOURS.items():
        lives = read_lives(folder, f"turn_taking/objects_{objects}")
        if lives:
            label = f"{objects} object{'s' * (objects > 1)} ({len(lives['right'])} lives)"
            band(by_number, rates(lives)["right"], label, colour)
            by_number.axhline(1 / objects, color=colour, ls=":", lw=0.8)
    places = {
        "objects_5": ("five, anywhere on the table", "#c0392b"),
        "in_view_5": ("five, in the first view", "#1e8449"),
        "outside_3": ("three, outside the first view", "#6c3483"),
    }
    for key, (label, colour) in places.items():
        lives = read_lives(folder, f"turn_taking/{key}")
        if lives:
            band(by_place, rates(lives)["right"], label, colour)
            if key == "outside_3":
                by_place.plot(_times(rates(lives)["right"]), rates(lives)["right"].T, color=colour, lw=0.4)
    draw_stages(five, folder, "turn_taking/objects_5")
    draw_stages(ten, folder, "turn_taking/objects_10")
    titles = {
        by_number: "the object she looks at is reached (dotted: chance)",
        by_place: "the same, by where objects may lie (thin: single lives)",
        five: "three stages, five objects on the table",
        ten: "three stages, ten objects",
    }
    for axes, title in titles.items():
        axes.set_title(title, fontsize=10)
        axes.set(ylim=(0, 1.02), xlim=(0, 30))
        axes.grid(alpha=0.3)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize=7, loc="lower right")
    for axes in (five, ten):
        axes.set_xlabel("learning time (10⁴ attempts)")
    for axes in (by_number, five):
        axes.set_ylabel("share of attempts")
    path.parent.mkdir(parents=True, exist_ok=True)
    save(figure, path)


def draw_stages(axes: Axes, folder: Path, name: str) -> None:
    """Any object; hers where it was in the first view; hers where it was not; the gate."""
    lives = read_lives(folder, name)
    if not lives:
        return
    rate = rates(lives)
    band(axes, rate["any"], "some object", "#7f8c8d")
    band(axes, rate["right_in_view"], "hers, in the first view", "#1e8449")
    band(axes, rate["right_outside"], "hers, outside the first view", "#6c3483")
    robot, time = SETTINGS[name].robot, np.linspace(0, ATTEMPTS, 300)
    gate = 1 / (1 + np.exp((robot.gate_midpoint - time) / robot.gate_width))
    axes.plot(time / 1e4, gate, ":", color="#2c3e50", lw=1, label="gate: the network commands")


def main() -> None:
    """Print the table as Markdown; write figure and numbers where asked."""
    options = tyro.cli(Options, description=__doc__)
    numbers = {name: numbers_of(name, lives) for name in SETTINGS if (lives := read_lives(options.folder, name))}
    columns = (
        "right_start", "right_lowest", "right_end", "right_in_view_end", "right_outside_end", "any_end", "test_new",
    )  # fmt: skip
    print(f"| setting | n | {' | '.join(columns)} |\n|---|---|{'---|' * len(columns)}")
    for name, values in numbers.items():
        cells = [f"{values[c]['mean']:.2f} [{values[c]['low']:.2f}, {values[c]['high']:.2f}]" for c in columns]
        print(f"| {name} | {values['right_end']['n']} | {' | '.join(cells)} |")
    if options.summary is not None:
        text = json.dumps(numbers, indent=1) + "\n"
        write_whole(options.summary, lambda temporary: temporary.write_text(text))
    if options.figure is not None:
        draw(options.folder, options.figure)


if __name__ == "__main__":
    main()
