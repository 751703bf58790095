"""Whether sessions come out alike when only what has changed is drawn, when a graphics card draws many worlds, and when
bodies move in closed form."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trial, Trials, Verdict
from jointattn_mj.sweeps.statistics import mean_interval, paired_difference, proportion

from ..sessions.analysis import MINUTES, QUANTITIES, curve, value

WORDS = {
    "opengl/all": "OpenGL, all of each image",
    "opengl/changes": "OpenGL, what has changed",
    "warp/changes": "Warp, what has changed",
    "state/mujoco": "from the state, MuJoCo's physics",
    "state/closed_form": "from the state, closed form",
}
USUAL = {"opengl/changes": "opengl/all", "warp/changes": "opengl/all", "state/closed_form": "state/mujoco"}
"""What each other way is compared with."""
COLOURS = {
    "opengl/all": "#2471a3", "opengl/changes": "#c0392b", "warp/changes": "#1e8449", "state/mujoco": "#b7950b",
    "state/closed_form": "#6c3483",
}  # fmt: skip


def analyse(trials: Trials) -> list[Comparison]:
    """Each way's own values, and their differences from the usual way, seed by seed."""
    findings = []
    for name, words in WORDS.items():
        part = trials.get(name, ())
        for key, quantity in QUANTITIES.items():
            if part:
                ours = mean_interval([value(trial, key) for trial in part])
                findings.append(Comparison(f"{quantity}; {words}", "not given", ours, Verdict.EXTENSION))
    for name, usual in USUAL.items():
        both = {trial.seed: trial for trial in trials.get(usual, ())}
        pairs = [(trial, both[trial.seed]) for trial in trials.get(name, ()) if trial.seed in both]
        if len(pairs) < 2:
            continue
        for key, quantity in QUANTITIES.items():
            ours = paired_difference(*([value(side, key) for side in sides] for sides in zip(*pairs, strict=True)))
            agrees = ours.low <= 0 <= ours.high
            note = "the interval holds 0" if agrees else "the interval does not hold 0"
            what = f"{quantity}; {WORDS[name]}, less {WORDS[usual]}"
            findings.append(Comparison(what, "not given", ours, Verdict.EXTENSION, note))
        same = sum(_looked(first) == _looked(second) for first, second in pairs)
        what = f"sessions whose gaze shifts land in the same frames, with the same success; {WORDS[name]}"
        findings.append(Comparison(what, "not given", proportion(same, len(pairs)), Verdict.EXTENSION))
    return findings


def _looked(trial: Trial) -> tuple[list[float], list[bool]]:
    """Landings of all gaze shifts from the face, s, and whether each was a success."""
    shifts = trial.result["shifts"]
    return shifts["landing_s"], shifts["success"]


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Success over time, with a band of 95% for each way of drawing or moving."""
    if not any(name in trials for name in WORDS):
        return {}
    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.subplots()
    for name, words in WORDS.items():
        part = trials.get(name, ())
        if part:
            estimates = [mean_interval(column) for column in np.array([curve(trial) for trial in part]).T]
            low, high = [each.low for each in estimates], [each.high for each in estimates]
            axes.fill_between(MINUTES, low, high, color=COLOURS[name], alpha=0.15, lw=0)
            mean = [each.mean for each in estimates]
            dashed = "--" if name == "state/closed_form" else "-"  # what lies below it stays visible
            axes.plot(MINUTES, mean, dashed, color=COLOURS[name], label=f"{words} ({len(part)} sessions)")
    axes.set(
        xlabel="time (simulated minutes)", ylabel="share of right gaze shifts (eq. 6.9)", xlim=(0, 26), ylim=(0, 1)
    )
    axes.set_title("How often the robot looked where the caregiver looked", fontsize=11)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="lower right")
    return {"drawing": figure}
