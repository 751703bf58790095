"""Order, number of modules, behaviour: what remains of the result without each choice."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.development.behaviour import KEC
from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import mean_interval, proportion

from ..tables import in_order, time_of
from .sweep import SETTINGS


def _results(trials: Trials, setting: str) -> list[dict[str, Any]]:
    return [trial.result for trial in trials.get(setting, ())]


def analyse(trials: Trials) -> list[Comparison]:
    """Order kept, with modules a run, the median step of the third, and eye contact after it."""
    findings = []
    for setting in SETTINGS:
        results = _results(trials, setting)
        if not results:
            continue
        order = proportion(sum(map(in_order, results)), len(results))
        count = mean_interval([len(result["modules"]) for result in results])
        notes = [f"modules a run {count}"]
        developed = [result for result in results if in_order(result)]
        if developed:
            notes.append(f"third after {np.median([time_of(result, 2) for result in developed]):.0f} steps (median)")
            contact = [result["phases"][3][KEC] for result in developed if len(result["phases"]) > 3]
            notes.append(f"eye contact then {np.mean(contact):.2f}" if contact else "no time left after it")
        if "avoids" in setting:
            first = [time_of(result, 0) for result in results]
            notes.append(f"first module after {np.median(first):.0f} steps (median)")
        findings.append(Comparison(f"order kept: {setting}", "", order, Verdict.EXTENSION, "; ".join(notes)))
    return findings


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Share of runs with the order, and modules a run, for each change."""
    settings = [setting for setting in SETTINGS if _results(trials, setting)]
    if not settings:
        return {}
    figure = Figure(figsize=(8, 0.27 * len(settings) + 1.2), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    rows = np.arange(len(settings))
    groups = [_results(trials, setting) for setting in settings]
    shares = [proportion(sum(map(in_order, results)), len(results)) for results in groups]
    numbers = [mean_interval([len(result["modules"]) for result in results]) for results in groups]
    for axes, values, words in (
        (left, shares, "share of runs with FG, SCf, SC in order"),
        (right, numbers, "modules a run"),
    ):
        errors = [[e.mean - e.low for e in values], [e.high - e.mean for e in values]]
        axes.errorbar([e.mean for e in values], rows, xerr=errors, fmt="o", ms=4, capsize=2)
        axes.axvline(values[0].mean, color="k", ls=":", lw=0.8)
        axes.set_xlabel(words)
        axes.grid(alpha=0.3)
    left.set_yticks(rows, settings, fontsize=8)
    figure.suptitle("How often the modules come in order, and how many come, with one choice changed", fontsize=10)
    left.set(xlim=(-0.03, 1.03), ylim=(len(settings) - 0.4, -0.6))
    return {"ablations": figure}
