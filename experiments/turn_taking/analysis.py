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

from experiments.statistics import mean_interval
from experiments.turn_taking.sweep import SETTINGS
from jointattn_mj.recording.figures import save
from jointattn_mj.recording.files import write_whole

END = 6
"""Stretches of a life, of 60, that count as its end: 30,000 attempts."""
COLOURS = {1: "#7f8c8d", 3: "#2471a3", 5: "#c0392b", 10: "#b7950b"}
STAGED = "turn_taking/objects_5"


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
    """Rates (lives, stretches): any object, the right one, the right one where it was in view at first or was not."""
    with np.errstate(invalid="ignore"):
        return {
            "any": lives["reached"] / lives["attempts"],
            "right": lives["right"] / lives["attempts"],
            "right_in_view": lives["right_in_view"] / lives["in_view"],
            "right_outside": lives["right_outside"] / (lives["attempts"] - lives["in_view"]),
        }


def numbers_of(name: str, lives: dict[str, np.ndarray]) -> dict[str, dict]:
    """What is reported of a setting, each with its interval over lives."""
    attempts = SETTINGS[name].attempts
    rate = rates(lives)
    stretch = attempts / rate["right"].shape[1]
    tests = {
        f"test_{kind}": lives[f"test_{kind}_right"][:, 0] / lives[f"test_{kind}_attempts"][:, 0]
        for kind in ("known", "new")
    }
    start = {f"{key}_start": values[:, 0] for key, values in rate.items()}
    end = {f"{key}_end": values[:, -END:].mean(axis=1) for key, values in rate.items()}
    half = {f"{key}_half_at": half_way(values) * stretch for key, values in rate.items() if key != "any"}
    lowest = {"right_lowest": rate["right"].min(axis=1), "any_lowest": rate["any"].min(axis=1)}
    return {key: vars(mean_interval(values)) for key, values in (start | end | half | lowest | tests).items()}


def half_way(rate: np.ndarray) -> np.ndarray:
    """(lives,) stretch from which a rate stays above half of its rise from start to end; NaN where it does not rise."""
    start, end = rate[:, :1], rate[:, -END:].mean(axis=1, keepdims=True)
    below = rate < start + 0.5 * (end - start)
    last = rate.shape[1] - np.argmax(below[:, ::-1], axis=1)
    rises = (end - start)[:, 0] > 0.1
    return np.where(rises & below.any(axis=1), last, np.nan)


def band(axes: Axes, rate: np.ndarray, attempts: int, label: str, colour: str, style: str = "-") -> None:
    """A curve over learning time: mean of all lives with its 95% interval."""
    estimates = [mean_interval(column) for column in rate.T]
    at = (np.arange(rate.shape[1]) + 0.5) * attempts / rate.shape[1] / 1e4
    axes.fill_between(at, [e.low for e in estimates], [e.high for e in estimates], color=colour, alpha=0.2, lw=0)
    axes.plot(at, [e.mean for e in estimates], style, color=colour, lw=1.5, label=label)


def draw(folder: Path, path: Path) -> None:
    """Success by number of objects; the three stages; where objects lie."""
    figure = Figure(figsize=(12, 3.9), layout="constrained")
    by_number, stages, by_place = figure.subplots(1, 3, sharey=True)
    for objects, colour in COLOURS.items():
        name = f"turn_taking/objects_{objects}"
        lives = read_lives(folder, name)
        if lives:
            label = f"{objects} object{'s' * (objects > 1)} ({len(lives['right'])} lives)"
            band(by_number, rates(lives)["right"], SETTINGS[name].attempts, label, colour)
            by_number.axhline(1 / objects, color=colour, ls=":", lw=0.8)
    lives = read_lives(folder, STAGED)
    if lives:
        shown = {
            "any": ("some object", "#7f8c8d", "-"),
            "right_in_view": ("hers, in the first view", "#1e8449", "-"),
            "right_outside": ("hers, outside the first view", "#6c3483", "-"),
        }
        for key, (label, colour, style) in shown.items():
            band(stages, rates(lives)[key], SETTINGS[STAGED].attempts, label, colour, style)
        robot = SETTINGS[STAGED].robot
        time = np.linspace(0, SETTINGS[STAGED].attempts, 300)
        gate = 1 / (1 + np.exp((robot.gate_midpoint - time) / robot.gate_width))
        stages.plot(time / 1e4, gate, ":", color="#2c3e50", lw=1, label="gate: network commands")
    places = {
        "objects_5": ("five, anywhere on the table", "#c0392b"),
        "in_view_5": ("five, in the first view", "#1e8449"),
        "outside_3": ("three, outside the first view", "#6c3483"),
    }
    for key, (label, colour) in places.items():
        lives = read_lives(folder, f"turn_taking/{key}")
        if lives:
            right, attempts = rates(lives)["right"], SETTINGS[f"turn_taking/{key}"].attempts
            band(by_place, right, attempts, label, colour)
            at = (np.arange(right.shape[1]) + 0.5) * attempts / right.shape[1] / 1e4
            by_place.plot(at, right.T, color=colour, lw=0.3, alpha=0.5)
    titles = {
        by_number: "the object she looks at is reached; dotted: chance",
        stages: "five objects on the table: three stages",
        by_place: "the object she looks at, by where objects may lie",
    }
    for axes, title in titles.items():
        axes.set_title(title, fontsize=10)
        axes.set(xlabel="learning time (10⁴ attempts)", ylim=(0, 1.02), xlim=(0, 30))
        axes.legend(fontsize=7, loc="lower right")
        axes.grid(alpha=0.3)
    by_number.set_ylabel("share of attempts")
    path.parent.mkdir(parents=True, exist_ok=True)
    save(figure, path)


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
