"""Steps after which each measure ranks the right event first, and keeps it there."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import median_interval, proportion

from .sweep import MEASURES, OF_EVENTS

WORDS = {"local: the strongest cell": "local: the strongest table entry"}
"""Names of measures in what is reported, where they differ from those under which trials are stored."""


def right_since(result: dict[str, Any], measure: str) -> float:
    """Length from which on the measure is right at every greater length too; infinite where it is wrong at the last."""
    right = np.array(result["right"][measure])
    wrong = np.flatnonzero(~right)
    since = wrong[-1] + 1 if len(wrong) else 0
    return float(result["lengths"][since]) if since < len(right) else np.inf


def analyse(trials: Trials) -> list[Comparison]:
    """The median over runs, and how many are right at the end."""
    results = [trial.result for trial in trials.get("chapter4", ())]
    findings = []
    for measure in MEASURES if results else ():
        since = median_interval([right_since(result, measure) for result in results])
        end = proportion(sum(result["right"][measure][-1] for result in results), len(results))
        called = WORDS.get(measure, measure)
        findings.append(Comparison(
            f"steps after which {called} keeps the right event first (median)", "T^C does; others not tried", since,
            Verdict.EXTENSION, f"right after {results[0]['lengths'][-1]} steps in {end}",
        ))  # fmt: skip
    return findings


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Share of runs in which each measure is right, over the length of the run."""
    results = [trial.result for trial in trials.get("chapter4", ())]
    if not results:
        return {}
    figure = Figure(figsize=(8, 4.2), layout="constrained")
    axes = figure.subplots()
    for number, measure in enumerate(MEASURES):
        share = np.mean([result["right"][measure] for result in results], axis=0)
        axes.plot(
            results[0]["lengths"], share + 0.004 * (number % 5), ls="-" if measure in OF_EVENTS else ":",
            color=f"C{number % 10}", marker="osd^v"[number % 5], ms=3, label=WORDS.get(measure, measure),
        )  # fmt: skip
    axes.set(
        xscale="log",
        ylim=(-0.03, 1.05),
        xlabel="steps",
        ylabel=f"share of {len(results)} runs, right event first",
        title="How often each measure finds the contingent event",
    )
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7, loc="center left", bbox_to_anchor=(1, 0.5))
    return {"measures": figure}
