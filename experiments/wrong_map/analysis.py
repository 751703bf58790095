"""Which component, made as good as it can be, mends the learned map."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trial, Trials, Verdict
from jointattn_mj.sweeps.statistics import mean_interval, proportion

from .sweep import SETTINGS

WRONG_DEG = 6.0
"""Median error of a map that counts as wrong."""


def error(trial: Trial) -> float:
    """Median error of the learned map over the last six minutes, deg."""
    median = trial.result["map_error_deg"]["median"]
    return np.nan if median is None else median


def analyse(trials: Trials) -> list[Comparison]:
    """Error, wrong maps and successes of every condition; the dissertation has no counterpart."""
    findings = []
    for name in SETTINGS:
        if not trials.get(name):
            continue
        errors = np.array([error(trial) for trial in trials[name]])
        label = name.replace("_", " ")
        rows = {
            "error of the learned map, deg": mean_interval(errors),
            f"sessions with an error above {WRONG_DEG:g} deg": proportion(int(np.sum(errors > WRONG_DEG)), len(errors)),
            "successes": mean_interval([trial.result["successes"] for trial in trials[name]]),
            "share of right pairs": mean_interval([trial.result["right_pairs"] for trial in trials[name]]),
        }
        findings += [
            Comparison(f"{words}, {label}", "not asked", ours, Verdict.EXTENSION) for words, ours in rows.items()
        ]
    return findings


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Error of every session's map."""
    figure = Figure(figsize=(8, 4), layout="constrained")
    axes = figure.subplots()
    names = [name for name in SETTINGS if trials.get(name)]
    for location, name in enumerate(names):
        errors = np.array([error(trial) for trial in trials[name]])
        axes.plot(np.full(len(errors), location) + np.linspace(-0.2, 0.2, len(errors)), np.sort(errors), "o", ms=3)
        axes.hlines(np.nanmedian(errors), location - 0.3, location + 0.3, color="black")
    axes.set_xticks(range(len(names)), [name.replace("_", "\n") for name in names], fontsize=8)
    axes.set(ylabel="error of the learned map, last 6 min (deg)")
    axes.set_title("How wrong the learned map is (a dot a session of 26 minutes; bars: medians)")
    axes.grid(alpha=0.3, axis="y")
    return {"wrong_map": figure}
