"""Whether the diagonal, gaze following by chance, stands out."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import mean_interval


def analyse(trials: Trials) -> list[Comparison]:
    """Mean counts on and off the diagonal."""
    tables = [np.array(trial.result["counts"]) for trial in trials.get("chapter4", ())]
    if not tables:
        return []
    on = mean_interval([table.diagonal().mean() for table in tables])
    off = mean_interval([table[~np.eye(len(table), dtype=bool)].mean() for table in tables])
    largest = mean_interval([np.mean(table.argmax(axis=1) == np.arange(len(table))) for table in tables])
    stands_out = Verdict.REPRODUCED if on.low > off.high else Verdict.NOT
    return [
        Comparison(
            "objects found where the caregiver looked, for each spot in 30,000 steps",
            "the diagonal dominates",
            on,
            stands_out,
        ),
        Comparison("objects found elsewhere, for each pair of spots", "lower", off, stands_out),
        Comparison("share of rows whose highest count is on the diagonal", "not given", largest, Verdict.EXTENSION),
    ]


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Fig. 4.7 as the mean over runs."""
    tables = [np.array(trial.result["counts"]) for trial in trials.get("chapter4", ())]
    if not tables:
        return {}
    mean = np.mean(tables, axis=0)
    figure = Figure(figsize=(5, 4.2), layout="constrained")
    axes = figure.subplots()
    image = axes.imshow(mean, cmap="viridis", vmin=0)
    figure.colorbar(image, label="times an object was found in 30,000 steps")
    ticks = range(len(mean))
    axes.set_xticks(ticks, [f"$g_{k + 1}$" for k in ticks])
    axes.set_yticks(ticks, [f"$f_{k + 1}$" for k in ticks])
    axes.set(
        xlabel="where the robot looked",
        ylabel="where the caregiver looked",
        title=f"Where objects were found (mean of {len(tables)} runs)",
    )
    return {"experience": figure}
