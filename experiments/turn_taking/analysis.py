"""Success of turn taking over learning time, by number of objects, and the three stages (reference [19])."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointattn_mj.io.progress import count
from jointattn_mj.sweeps.claim import Comparison, Trial, Trials, Verdict
from jointattn_mj.sweeps.statistics import mean_interval, median_interval, proportion

from .sweep import SETTINGS, AttemptsConfig

END = 6
"""Stretches of a run, of 60, that count as its end: 30,000 attempts."""
LEVEL = 0.75
"""Success at which a stage counts as reached."""
COLOURS = {1: "#7f8c8d", 3: "#2471a3", 5: "#c0392b", 10: "#b7950b"}
ATTEMPTS = AttemptsConfig().attempts
STAGES = {"any": "any object", "right_in_view": "the right one, in view", "right_outside": "the right one, out of view"}


def columns(part: Sequence[Trial]) -> dict[str, np.ndarray]:
    """Each count of all runs, (runs, stretches)."""
    return {key: np.array([trial.result[key] for trial in part]) for key in part[0].result}


def rates(runs: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Rates (runs, stretches): any object, the right one, the right one where it was in view at first or was not.

    NaN where that was one attempt in a hundred or fewer (an object in view that was missed).
    """
    outside = runs["attempts"] - runs["in_view"]
    outside = np.where(outside > runs["attempts"] / 100, outside, np.nan)
    with np.errstate(invalid="ignore", divide="ignore"):
        return {
            "any": runs["reached"] / runs["attempts"],
            "right": runs["right"] / runs["attempts"],
            "right_in_view": runs["right_in_view"] / runs["in_view"],
            "right_outside": runs["right_outside"] / outside,
        }


def reaches(rate: np.ndarray, level: float) -> np.ndarray:
    """(runs,) when a rate first gets to ``level``, in stretches (interpolated); infinite where it never does."""
    reached = np.full(len(rate), np.inf)
    for run, values in enumerate(rate):
        above = np.flatnonzero(values >= level)
        if len(above):
            k = above[0]
            before = values[k - 1] if k else values[k]
            reached[run] = k + 0.5 - ((values[k] - level) / (values[k] - before) if values[k] > before else 0.0)
    return reached


def analyse(trials: Trials) -> list[Comparison]:
    """From chance to a high rate with 1, 3, 5 and 10 objects, the three stages, then other readings."""
    findings: list[Comparison] = []
    for objects in COLOURS:
        name = f"objects_{objects}"
        if trials.get(name):
            findings += rise(columns(trials[name]), objects)
    for objects in (3, 5, 10):
        name = f"objects_{objects}"
        if trials.get(name):
            findings += stages(columns(trials[name]), objects)
    for name, part in trials.items():
        if name in SETTINGS and not name.startswith("objects_"):
            end = mean_interval(rates(columns(part))["right"][:, -END:].mean(axis=1))
            findings.append(
                Comparison(
                    f"the right object at the end, {name.replace('_', ' ').removeprefix('readings/')}",
                    "not given",
                    end,
                    Verdict.EXTENSION,
                )
            )
    return findings


def rise(runs: dict[str, np.ndarray], objects: int) -> list[Comparison]:
    """Where success begins and ends."""
    right = rates(runs)["right"]
    start, end = mean_interval(right[:, 0]), mean_interval(right[:, -END:].mean(axis=1))
    new = mean_interval(runs["test_new_right"][:, 0] / runs["test_new_attempts"][:, 0])
    of = count(objects, "object")
    risen = Verdict.REPRODUCED if end.low > LEVEL else Verdict.PARTLY if end.low > start.high else Verdict.NOT
    chance = Verdict.REPRODUCED if objects > 1 and abs(start.mean - 1 / objects) < 0.05 else Verdict.NOT
    missed = "objects outside the first view are missed at first, which 1/n leaves out"
    return [
        Comparison(
            f"the right object at the start, {of}", f"1/{objects}", start, chance, "" if objects > 1 else missed
        ),
        Comparison(
            f"the right object at the end, {of}", "a high rate", end, risen, f"above {LEVEL:.0%} counts as high"
        ),
        Comparison(f"with new faces, {of}", "not given", new, Verdict.EXTENSION),
    ]


def stages(runs: dict[str, np.ndarray], objects: int) -> list[Comparison]:
    """Whether any object, the right one in view and the right one outside the view are reached in this order."""
    rate = rates(runs)
    times = {key: reaches(rate[key], LEVEL) * ATTEMPTS / rate[key].shape[1] for key in STAGES}
    first, second, third = times.values()
    ordered = proportion(int(np.sum((first < second) & (second < third))), len(first))
    verdict = Verdict.REPRODUCED if ordered.low > 0.5 else Verdict.NOT if ordered.high < 0.5 else Verdict.UNDECIDED
    what = f"runs with any object, the right one in view, the right one out of view in this order, {objects} objects"
    with np.errstate(invalid="ignore"):
        later = median_interval(third - second)
    return [
        Comparison(what, "three stages, as in infants", ordered, verdict, f"each when it first gets to {LEVEL:.0%}"),
        Comparison(
            f"attempts from the second stage to the third (median), {objects} objects", "not given", later,
            Verdict.EXTENSION,
        ),
    ]  # fmt: skip


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Success by number of objects; the three stages with five and with ten; where objects lie."""
    figure = Figure(figsize=(8.2, 6.0), layout="constrained")
    by_number, by_location, five, ten = figure.subplots(2, 2, sharey=True).ravel()
    for objects, colour in COLOURS.items():
        part = trials.get(f"objects_{objects}")
        if part:
            band(by_number, rates(columns(part))["right"], f"{count(objects, 'object')} ({len(part)} runs)", colour)
            by_number.axhline(1 / objects, color=colour, ls=":", lw=0.8)
    locations = {
        "objects_5": ("five, anywhere on the table", "#c0392b"),
        "in_view_5": ("five, in the first view", "#1e8449"),
        "outside_3": ("three, outside the first view", "#6c3483"),
    }
    for key, (label, colour) in locations.items():
        if trials.get(key):
            right = rates(columns(trials[key]))["right"]
            band(by_location, right, label, colour)
            if key == "outside_3":
                by_location.plot(_times(right), right.T, color=colour, lw=0.4)
    draw_stages(five, trials, "objects_5")
    draw_stages(ten, trials, "objects_10")
    titles = {
        by_number: "How often the right object is reached (dotted: chance)",
        by_location: "The same, by where objects lie (thin: single runs)",
        five: "What is reached in three stages, five objects",
        ten: "What is reached in three stages, ten objects",
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
    return {"turn_taking": figure}


def band(axes: Axes, rate: np.ndarray, label: str, colour: str) -> None:
    """A curve over learning time: mean of all runs with its 95% interval.

    Args:
        axes: Where it is drawn.
        rate: (runs, m) shares over learning time.
        label: For the legend.
        colour: Of line and band.
    """
    estimates = [mean_interval(column) for column in rate.T]
    at = _times(rate)
    axes.fill_between(at, [e.low for e in estimates], [e.high for e in estimates], color=colour, alpha=0.2, lw=0)
    axes.plot(at, [e.mean for e in estimates], color=colour, lw=1.5, label=label)


def _times(rate: np.ndarray) -> np.ndarray:
    """Middle of each stretch, 10^4 attempts."""
    return (np.arange(rate.shape[1]) + 0.5) * ATTEMPTS / rate.shape[1] / 1e4


def draw_stages(axes: Axes, trials: Trials, name: str) -> None:
    """Any object; the right one where it was in the first view and where it was not; the gate.

    Args:
        axes: Where they are drawn.
        trials: Runs by setting.
        name: Of the setting.
    """
    if not trials.get(name):
        return
    rate = rates(columns(trials[name]))
    for (key, label), colour in zip(STAGES.items(), ("#7f8c8d", "#1e8449", "#6c3483"), strict=True):
        band(axes, rate[key], label, colour)
    robot, time = SETTINGS[name].config.robot, np.linspace(0, ATTEMPTS, 300)
    gate = 1 / (1 + np.exp((robot.gate_midpoint - time) / robot.gate_width))
    axes.plot(time / 1e4, gate, ":", color="#2c3e50", lw=1, label="gate: the network commands")
