"""Whether what was found sinks, and lets the next event rise, as Fig. 5.3 shows."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import proportion

from ..tables import STAGES


def _course(result: dict, symbol: str) -> np.ndarray:
    """Values over time, NaN where there are none."""
    return np.array([np.nan if value is None else value for value in result["values"].get(symbol, [])], float)


def analyse(trials: Trials) -> list[Comparison]:
    """FG sinks after FG-m is made; SC rises after SCf-m is made."""
    results = [
        trial.result for trial in trials.get("caregiver first", ()) if tuple(trial.result["modules"][:3]) == STAGES
    ]
    runs = len(trials.get("caregiver first", ()))
    if not results:
        return []
    sinks = rises = 0
    for result in results:
        at = [np.searchsorted(result["turns"], step) for step in result["made"][:3]]
        following, alternating = _course(result, STAGES[0]), _course(result, STAGES[2])
        sinks += bool(following[at[1] - 1] < following[at[0]])
        rises += bool(alternating[at[2] - 1] > alternating[at[1] - 1])
    return [
        Comparison(
            "SAC of gaze following is lower when SCf-m is made than when FG-m was", "it gradually decreased",
            (share := proportion(sinks, runs)), Verdict.of_share(share, 0.8),
        ),
        Comparison(
            "SAC of alternation is higher when SC-m is made than when SCf-m was", "promoted increase of it",
            (share := proportion(rises, runs)), Verdict.of_share(share, 0.8),
        ),
    ]  # fmt: skip


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Fig. 5.3 for the first seed."""
    if not trials.get("caregiver first"):
        return {}
    trial = trials["caregiver first"][0]
    result = trial.result
    figure = Figure(figsize=(8, 4.5), layout="constrained")
    axes = figure.subplots()
    for symbol in sorted(result["values"], key=lambda name: (name not in STAGES, name)):
        is_stage = symbol in STAGES
        axes.plot(
            result["turns"], np.maximum(_course(result, symbol), 1e-5), label=symbol, lw=2 if is_stage else 0.8,
            alpha=1 if is_stage else 0.6, color=f"C{STAGES.index(symbol)}" if is_stage else None,
        )  # fmt: skip
    top = axes.get_ylim()[1]
    for step, symbol in zip(result["made"], result["modules"], strict=True):
        axes.plot(step, top, "kv", clip_on=False)
        axes.annotate(
            symbol, (step, top), xytext=(0, 6), textcoords="offset points", ha="left", fontsize=7, rotation=20
        )
    axes.set(
        yscale="log",
        ylim=(1e-4, top),
        xlabel="steps",
        ylabel="state-action contingency (bits)",
        title="Contingency of each event over time",
    )
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7, ncols=2, loc="upper left", bbox_to_anchor=(1, 1), title=f"seed {trial.seed}")
    return {"time_course": figure}
