"""Whether similar faces have neighbouring units of the map, and Fig. 6.6."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.perception.som import SOMConfig
from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import mean_interval, paired_difference

from .sweep import unpacked

TOUCHING = 0.1
"""Share of faces beyond which the map does not keep neighbours together."""
QUANTITIES = {
    "cells_used": "units of 81 that are nearest to some face",
    "yaw_r2": "share of the variance of the head's yaw that the position on the map explains",
    "pitch_r2": "the same for its pitch",
}


def analyse(trials: Trials) -> list[Comparison]:
    """How well the map is ordered, and how well it tells the head's angles, over all caregivers."""
    every = [trial.result for part in trials.values() for trial in part]
    if not every:
        return []
    error = mean_interval([result["topographic_error"] for result in every])
    beside = paired_difference(
        [result["shuffled_error"] for result in every], [result["topographic_error"] for result in every]
    )
    verdict = Verdict.REPRODUCED if error.high < TOUCHING else Verdict.NOT if error.low > TOUCHING else Verdict.PARTLY
    return [
        Comparison(
            "share of new faces whose two nearest units do not touch", "similar faces have neighbouring units", error,
            verdict, f"maps with less than {TOUCHING:.0%} count as ordered",
        ),
        Comparison("how much larger it is on a shuffled map", "not given", beside, Verdict.EXTENSION),
        *(
            Comparison(words, "not given", mean_interval([result[key] for result in every]), Verdict.EXTENSION)
            for key, words in QUANTITIES.items()
        ),
    ]  # fmt: skip


def draw(trials: Trials) -> Mapping[str, Figure]:
    """The maps of the first seed of every caregiver."""
    shown = [(name, part[0]) for name, part in trials.items() if part]
    if not shown:
        return {}
    figure = Figure(figsize=(9, 3.3 * ((len(shown) + 2) // 3)), layout="constrained")
    panels = np.atleast_1d(figure.subplots((len(shown) + 2) // 3, min(3, len(shown)))).ravel()
    for axes in panels:
        axes.axis("off")
    for axes, (name, trial) in zip(panels, shown, strict=False):
        faces = unpacked(trial.result["pictures"], SOMConfig.rows, SOMConfig.columns)
        rows, columns, side, _ = faces.shape
        axes.imshow(faces.transpose(0, 2, 1, 3).reshape(rows * side, columns * side), cmap="gray")
        axes.set_title(f"{name}, seed {trial.seed}", fontsize=10)
    figure.suptitle("Faces that the robot knows after it has looked at each caregiver")
    return {"som": figure}
