"""Whether the three modules come first and in their order, how many there are, and when they are made."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import mean_interval, median_interval, proportion

from ..tables import STAGES, in_order, time_of

NAMES = ("gaze following, FG-m", "looking back, SCf-m", "gaze alternation, SC-m")
EXAMPLE = (5748, 42862, 47686)
"""The times of the dissertation's one example run (section 5.3.2)."""


def analyse(trials: Trials) -> list[Comparison]:
    """How often the three modules come in order, how many there are in a run, and when each is made."""
    findings = []
    for setting in ("caregiver first", "robot first"):
        results = [trial.result for trial in trials.get(setting, ())]
        if not results:
            continue
        order = proportion(sum(map(in_order, results)), len(results))
        findings.append(Comparison(
            f"the first three modules are FG, SCf, SC in this order; {setting}", "90% of ten runs", order,
            Verdict.of_share(order, 0.9),
            "ten runs cannot tell 90% from 100%: nine of ten have an interval from 60% to 98%",
        ))  # fmt: skip
        count = mean_interval([len(result["modules"]) for result in results])
        findings.append(Comparison(
            f"modules a run; {setting}", "3.5", count,
            Verdict.REPRODUCED if count.low <= 3.5 <= count.high else Verdict.PARTLY,
        ))  # fmt: skip
        for stage, name in enumerate(NAMES):
            times = median_interval([time_of(result, stage) if in_order(result) else np.inf for result in results])
            inside = times.low <= EXAMPLE[stage] <= times.high
            known = np.isfinite(times.low) and np.isfinite(times.high)
            findings.append(Comparison(
                f"step of {name} (median); {setting}", f"{EXAMPLE[stage]} in the one run shown", times,
                Verdict.UNDECIDED if not known else Verdict.REPRODUCED if inside else Verdict.PARTLY,
                "a single run; the interval is that of our median, not of single runs",
            ))  # fmt: skip
    return findings


def draw(trials: Trials) -> Mapping[str, Figure]:
    """When each of the three modules was made, a line a run."""
    settings = [setting for setting in ("caregiver first", "robot first") if trials.get(setting)]
    if not settings:
        return {}
    figure = Figure(figsize=(7, 2.2 * len(settings) + 0.8), layout="constrained")
    for axes, setting in zip(figure.subplots(len(settings), 1, squeeze=False)[:, 0], settings, strict=True):
        results = sorted((trial.result for trial in trials[setting]), key=lambda result: time_of(result, 2))
        for number, symbol in enumerate([*STAGES, None]):
            points = [
                (step, row)
                for row, result in enumerate(results)
                for step, made in zip(result["turns"], result["modules"], strict=True)
                if made == symbol or (symbol is None and made not in STAGES)
            ]
            if points:
                steps, rows = zip(*points, strict=True)
                axes.plot(
                    steps,
                    np.add(rows, 1),
                    "os^."[number],
                    ms=3,
                    color=f"C{number}",
                    label=NAMES[number] if symbol else "other modules",
                )
        for step in EXAMPLE:
            axes.axvline(
                step, color="k", lw=0.8, ls=":", label="the dissertation's example" if step == EXAMPLE[0] else None
            )
        axes.set(title=f"Modules of each run: {setting}", ylabel="run", xlim=(0, 100_000), ylim=(0, len(results) + 1))
        axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel("step at which a module is made")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8)
    return {"order": figure}
