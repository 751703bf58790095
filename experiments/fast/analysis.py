"""Steps until gaze alternation, whether the order holds, and whether the same preset serves other worlds."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import median_interval, proportion

from ..tables import in_order, time_of
from .sweep import CHANCES, SETTINGS, SPOTS


def _results(trials: Trials, setting: str) -> list[dict[str, Any]]:
    return [trial.result for trial in trials.get(setting, ())]


def _grid(trials: Trials, preset: str, spots: int) -> list[dict[str, Any]]:
    return [
        r for f in CHANCES for p in CHANCES for r in _results(trials, f"{preset} spots {spots} follow {f} lead {p}")
    ]


def _third(results: list[dict[str, Any]]) -> list[float]:
    return [time_of(result, 2) if in_order(result) else np.inf for result in results]


def analyse(trials: Trials) -> list[Comparison]:
    """The two presets in chapter 5's world, then in 45 others, then what each option of the rule does."""
    findings = []
    for preset in ("fast", "thesis"):
        results = _results(trials, preset)
        if results:
            third, order = median_interval(_third(results)), proportion(sum(map(in_order, results)), len(results))
            findings.append(Comparison(
                f"step of gaze alternation (median), preset {preset}",
                "more than 45,000 in the example", third, Verdict.EXTENSION,
            ))  # fmt: skip
            findings.append(Comparison(f"order kept, preset {preset}", "90% of ten runs", order, Verdict.EXTENSION))
    for spots in SPOTS:
        for preset in ("fast", "thesis"):
            results = _grid(trials, preset, spots)
            if not results:
                continue
            order = proportion(sum(map(in_order, results)), len(results))
            right = sum(r["directions_right"] == spots for r in results)
            third = np.median(_third(results))
            note = f"gaze following first and right for all spots in {right / len(results):.0%}"
            note += f"; gaze alternation after {third:.0f} steps (median)" if np.isfinite(third) else ""
            findings.append(Comparison(
                f"order kept with {spots} spots, nine pairs of p_r, p_i, preset {preset}",
                "not tried", order, Verdict.EXTENSION, note,
            ))  # fmt: skip
    for setting in SETTINGS:
        results = _results(trials, setting)
        if results and setting.startswith("fast ") and "spots" not in setting:
            order = proportion(sum(map(in_order, results)), len(results))
            note = f"gaze alternation after {np.median(_third(results)):.0f} steps (median)"
            findings.append(Comparison(f"order kept, {setting}", "not tried", order, Verdict.EXTENSION, note))
    return findings


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Times of the third module in chapter 5's world; order kept in the others."""
    if not _results(trials, "fast"):
        return {}
    figure = Figure(figsize=(9, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    for number, preset in enumerate(("fast", "thesis")):
        times = np.sort(_third(_results(trials, preset)))
        if len(times):
            left.step(times, (np.arange(len(times)) + 1) / len(times), where="post", color=f"C{number}", label=preset)
    left.axvline(10_000, color="k", ls=":", label="asked of the fast preset")
    left.set(
        xscale="log",
        xlabel="step at which gaze alternation is found",
        ylabel="share of runs",
        title="How soon gaze alternation is found",
        ylim=(0, 1.02),
    )
    ticks = (4_000, 7_000, 10_000, 20_000, 40_000)
    left.set_xticks(ticks, [f"{tick // 1000}k" for tick in ticks], minor=False)
    left.set_xticks([], minor=True)
    left.legend(fontsize=8, loc="upper left")
    left.grid(alpha=0.3)
    for number, preset in enumerate(("fast", "thesis")):
        shares = [
            (spots, proportion(sum(map(in_order, r)), len(r))) for spots in SPOTS if (r := _grid(trials, preset, spots))
        ]
        if shares:
            right.errorbar(
                [spots + 0.08 * number for spots, _ in shares], [e.mean for _, e in shares],
                [[e.mean - e.low for _, e in shares], [e.high - e.mean for _, e in shares]],
                marker="o", ms=4, capsize=3, color=f"C{number}", label=preset,
            )  # fmt: skip
    right.set(
        xlabel="spots on the table, 1 or 2 objects",
        ylabel="share of runs with FG, SCf, SC in order",
        title="How often the order is kept in other worlds",
        ylim=(0, 1.02),
        xticks=SPOTS,
    )
    right.legend(fontsize=8, title="nine pairs of $p_r$, $p_i$ each", loc="lower center")
    right.grid(alpha=0.3)
    return {"fast": figure}
