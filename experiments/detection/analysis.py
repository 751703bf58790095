"""What the time courses of T^C say."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import mean_interval, median_interval, proportion

from .sweep import TARGET


def analyse(trials: Trials) -> list[Comparison]:
    """The stop, the event that is found, and what remains of the others in the long run."""
    findings = []
    for setting, words in (("chapter4", "in bits"), ("chapter4_nats", "in nats")):
        results = [trial.result for trial in trials.get(setting, ())]
        if not results:
            continue
        stopped = [result for result in results if result["stop"] is not None]
        stop = mean_interval([result["stop"] for result in stopped])
        right = proportion(sum(result["first_at_stop"] == TARGET for result in stopped), len(results))
        if setting == "chapter4":
            findings.append(Comparison(
                "(S1, A1, R2) has the highest T^C when the robot stops", "so in the run shown", right,
                Verdict.of_share(right, 1.0),
            ))  # fmt: skip
            since = median_interval([np.inf if r["right_since"] is None else r["right_since"] for r in results])
            findings.append(
                Comparison("step from which on it stays the highest (median)", "not given", since, Verdict.EXTENSION)
            )
        close = 25_000 <= stop.mean <= 35_000
        findings.append(Comparison(
            f"step from which on no T^C changes by theta, {words}", "about 30,000", stop,
            Verdict.REPRODUCED if close else Verdict.PARTLY,
            "the text does not say in which unit theta is",
        ))  # fmt: skip
    long = [trial.result["values"] for trial in trials.get("long", ())]
    if long:
        target = mean_interval([1e3 * values[TARGET][-1] for values in long])
        others = mean_interval([1e3 * max(v[-1] for name, v in values.items() if name != TARGET) for values in long])
        findings.append(
            Comparison("T^C of (S1, A1, R2) after 3 million steps, millibits", "not given", target, Verdict.EXTENSION)
        )
        findings.append(Comparison("the highest of all others then, millibits", "not given", others, Verdict.EXTENSION))
    return findings


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Fig. 4.4 with the range of all runs around the median."""
    results = [trial.result for trial in trials.get("chapter4", ())]
    if not results:
        return {}
    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.subplots()
    for number, symbol in enumerate(sorted(results[0]["values"], key=lambda name: name != TARGET)):
        courses = np.array([result["values"][symbol] for result in results])
        middle, low, high = np.median(courses, axis=0), courses.min(axis=0), courses.max(axis=0)
        colour = f"C{number}"
        axes.plot(results[0]["turns"], middle, color=colour, lw=2.5 if symbol == TARGET else 1.2, label=symbol)
        axes.fill_between(results[0]["turns"], low, high, color=colour, alpha=0.15, lw=0)
    stops = [result["stop"] for result in results if result["stop"] is not None]
    axes.plot(stops, np.full(len(stops), axes.get_ylim()[1]), "kv", ms=4, clip_on=False, label="the robot stops")
    axes.set(
        xscale="log", yscale="log", xlabel="steps", ylabel="$T^C$ (bits)", title="Contingency of each event over time"
    )
    axes.legend(fontsize=8, ncols=2, loc="lower left")
    axes.grid(alpha=0.3)
    return {"detection": figure}
