"""Errors of the table and of continuous maps on faces held out, and how each followed when it moved the head."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import Estimate, mean_interval, median_interval, paired_difference, proportion

from .sweep import CHECKPOINTS, WITHIN_DEG

Result = dict[str, Any]
COLOURS = {"informative": "#c0392b", "all": "#2471a3", "chapter 6": "#7d6608"}
LABELS = {
    "informative": "informative pairs (section 7.1)",
    "all": "all face-to-object pairs",
    "chapter 6": "chapter 6: both directions",
}


def analyse(trials: Trials) -> list[Comparison]:
    """Whether it was found; errors of table, map and chapter 6's learner, on held-out faces and in the run."""
    everything = [trial.result for trial in trials.get("scattered", ())]
    results = _detected(everything)
    if not results:
        return []
    last = CHECKPOINTS[-1]
    findings = [
        _row("gaze following is found among objects that lie anywhere", proportion(len(results), len(everything)),
             f"after {np.median([r['found'] for r in results]):,.0f} steps (median), with "
             f"{np.median([r['categories'] for r in results]):.0f} categories of faces"),
        _row("error of the table on held-out faces, deg", _median(results, "table", 0, "median_deg")),
    ]  # fmt: skip
    for name, what in (
        ("informative", "the continuous map from informative pairs"),
        ("all", "a map from all face-to-object pairs"),
        ("chapter 6", "chapter 6's learner, pairs of both directions"),
        ("informative, two linear outputs", "two linear outputs from informative pairs"),
        ("all, two linear outputs", "two linear outputs from all face-to-object pairs"),
    ):
        findings.append(_row(f"error of {what} after {last:,} steps, deg", _median(results, name, last, "median_deg")))
    for key, what in (
        ("within", f"share within {WITHIN_DEG} deg of the caregiver's object"),
        ("nearest", "the caregiver's object is nearest"),
    ):
        findings.append(_row(
            f"held-out faces, {what}: continuous map after {last:,} steps less table",
            _difference(results, ("informative", last), ("table", 0), key),
        ))  # fmt: skip
    findings.append(_row(
        f"error of informative pairs less that of chapter 6's, after {last:,} steps, deg",
        _difference(results, ("informative", last), ("chapter 6", last), "median_deg"),
    ))  # fmt: skip
    for steps in CHECKPOINTS:
        gain = _difference(
            results, ("gaze at random, informative", steps), ("gaze at random, chapter 6", steps), "median_deg"
        )
        if gain.n > 1 and steps in (1000, 3500):
            findings.append(_row(
                f"the same while the gaze still moves at random, {steps:,} steps", gain,
                "the same steps, informative by the module made later",
            ))  # fmt: skip
    both = [r for r in results if r["landings"]["table"]["n"] and r["landings"]["map"]["n"]]
    for key, what in (("median_deg", "median distance, deg"), ("within", f"share within {WITHIN_DEG} deg")):
        by_map, by_table = ([r["landings"][name][key] for r in both] for name in ("map", "table"))
        findings.append(_row(f"gaze shifts of the module, {what}: moved by the table", mean_interval(by_table)))
        findings.append(_row(f"gaze shifts of the module, {what}: moved by the map", mean_interval(by_map)))
        findings.append(_row("the difference", paired_difference(by_map, by_table)))
    return findings


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Errors over steps, with the module and with gaze at random; shifts before and after the map took over."""
    results = _detected([trial.result for trial in trials.get("scattered", ())])
    if not results:
        return {}
    figure = Figure(figsize=(12, 3.8), layout="constrained")
    first, second, third = figure.subplots(1, 3)
    for axes, prefix in ((first, ""), (second, "gaze at random, ")):
        for name, colour in COLOURS.items():
            _curve(axes, results, prefix + name, colour, LABELS[name])
        table = _median(results, "table", 0, "median_deg")
        axes.axhspan(*_interval(table), color="#7f8c8d", alpha=0.25, lw=0)
        axes.axhline(table.mean, color="#7f8c8d", ls="--", label="the module's table")
        axes.set(xlabel="steps", ylim=(0, 7), xlim=(0, CHECKPOINTS[-1] * 1.03))
        axes.grid(alpha=0.3)
    first.set(ylabel="error on held-out faces, deg (median)")
    first.set_title("How far the learned gaze is off, module in use", fontsize=10)
    second.set_title("The same, learned while gaze is random", fontsize=10)
    first.legend(fontsize=7.5)
    shares = {name: [r["landings"][name] for r in results] for name in ("table", "map")}
    for result in results:
        pair = [result["landings"][name]["within"] for name in ("table", "map")]
        if None not in pair:
            third.plot((0, 1), pair, "o-", color="#95a5a6", ms=3, lw=0.7)
    for location, name in enumerate(("table", "map")):
        estimate = mean_interval([row["within"] for row in shares[name] if row["within"] is not None])
        off = [[estimate.mean - estimate.low], [estimate.high - estimate.mean]]
        third.errorbar(
            location + 0.06 * (2 * location - 1), estimate.mean, off,
            fmt="s", ms=6, capsize=4, color=COLOURS["informative"],
        )  # fmt: skip
    third.set(xticks=(0, 1), xlim=(-0.4, 1.4), ylim=(0, 1.02), ylabel=f"shifts of the module within {WITHIN_DEG} deg")
    third.set_xticklabels(("table moves\nthe head", "continuous map\nmoves it"))
    third.set_title("Gaze shifts that hit, by table and by map\n(a line a run)", fontsize=10)
    third.grid(alpha=0.3)
    return {"continuous": figure}


def _detected(results: Sequence[Result]) -> list[Result]:
    return [result for result in results if result["found"] is not None]


def _row(what: str, ours: Estimate, note: str = "") -> Comparison:
    return Comparison(what, "not tried", ours, Verdict.EXTENSION, note)


def _value(result: Result, name: str, steps: int, key: str) -> float:
    """A number of a map at a checkpoint; NaN where the event was found before so many steps."""
    return next((row[key] for row in result["maps"][name] if row["turns"] == steps and row[key] is not None), np.nan)


def _median(results: Sequence[Result], name: str, steps: int, key: str) -> Estimate:
    return median_interval(_known([_value(result, name, steps, key) for result in results]))


def _known(values: Sequence[float]) -> list[float]:
    return [value for value in values if not np.isnan(value)]


def _interval(estimate: Estimate) -> tuple[float, float]:
    """To be drawn: nothing where too few runs bound no median."""
    return (estimate.low, estimate.high) if np.isfinite(estimate.low) else (estimate.mean, estimate.mean)


def _difference(results: Sequence[Result], minuend: tuple[str, int], subtrahend: tuple[str, int], key: str) -> Estimate:
    first, second = ([_value(result, *which, key) for result in results] for which in (minuend, subtrahend))
    return paired_difference(first, second)


def _curve(axes, results: Sequence[Result], name: str, colour: str, label: str) -> None:
    estimates = [(steps, _median(results, name, steps, "median_deg")) for steps in CHECKPOINTS]
    known = [(steps, e) for steps, e in estimates if e.n >= len(results) / 2]
    steps, middle = [t for t, _ in known], [e.mean for _, e in known]
    low, high = zip(*(_interval(e) for _, e in known), strict=True) if known else ((), ())
    axes.fill_between(steps, low, high, color=colour, alpha=0.15, lw=0)
    axes.plot(steps, middle, "o-", ms=3, color=colour, label=label)
