"""How the learner grows with l in step with the caregiver, and the published gate beside it (Fig. 6.7)."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.gaze_following.gate import GazeConfig, gate_probability
from jointattn_mj.sweeps.claim import Comparison, Trial, Trials, Verdict
from jointattn_mj.sweeps.statistics import mean_interval, median_interval

SHOWN = {
    "cues": ("with motion cues", "#c0392b"),
    "no_cues": ("without motion cues", "#2471a3"),
    "no_cues_face_to_object_only": ("without, pairs in one direction only", "#b7950b"),
}
SHARE = 0.9
LATE_FROM = 350
"""l from which on accuracy counts as final."""
HALF_OPEN = 150
"""p of the published gate: l at which the learner commands every second time."""


def columns(part: Sequence[Trial]) -> dict[str, np.ndarray]:
    """Each quantity of all runs, (runs, tests)."""
    return {key: np.array([trial.result[key] for trial in part], float) for key in part[0].result}


def reaches(iterations: np.ndarray, accuracy: np.ndarray, share: float) -> np.ndarray:
    """(runs,) the first l at which a run's accuracy, averaged over three tests, is ``share`` of its final one.

    Infinite for a run that never gets there.

    Args:
        iterations: (m,) l at which accuracy was measured.
        accuracy: (runs, m) shares; NaN where a run did not get.
        share: Of the final accuracy, 0 to 1.
    """
    smooth = np.stack([np.convolve(np.pad(run, 1, "edge"), np.ones(3) / 3, "valid") for run in accuracy])
    late = (iterations >= LATE_FROM) & ~np.isnan(accuracy)
    counted = np.where(late.any(axis=1), late.sum(axis=1), np.nan)
    final = (np.where(late, accuracy, 0).sum(axis=1) / counted)[:, None]
    enough = smooth >= share * final
    return np.where(enough.any(axis=1), iterations[np.argmax(enough, axis=1)], np.inf)


def analyse(trials: Trials) -> list[Comparison]:
    """When the learner is nearly as good as it gets, and how good that is."""
    findings = []
    for name, (label, _) in SHOWN.items():
        if not trials.get(name):
            continue
        runs = columns(trials[name])
        iterations, accuracy = runs["iterations"][0], runs["accuracy"]
        ready = median_interval(reaches(iterations, accuracy, SHARE))
        verdict, note = Verdict.EXTENSION, "the text does not say whether its preliminary run had motion cues"
        if name == "cues":
            verdict = (
                Verdict.UNDECIDED
                if ready.low <= HALF_OPEN < ready.high
                else Verdict.REPRODUCED
                if ready.high <= HALF_OPEN
                else Verdict.NOT
            )
            note = "ready when the gate, set from such a run, is half open; so the published gate fits this learner"
        what = f"l at which the learner has {SHARE:.0%} of its final accuracy (median), {label}"
        findings.append(Comparison(what, f"gate half open at {HALF_OPEN}", ready, verdict, note))
        for at in (100, HALF_OPEN, 300):
            column = accuracy[:, int(np.argmin(np.abs(iterations - at)))]
            what = f"share of gazes for which the caregiver's object is suggested at l = {at}, {label}"
            findings.append(Comparison(what, "not given", mean_interval(column), Verdict.EXTENSION))
        what = f"share of right pairs, {label}"
        findings.append(Comparison(what, "not given", mean_interval(runs["right_pairs"][:, -1]), Verdict.EXTENSION))
    return findings


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Accuracy and error against l, with the gate of Fig. 6.7."""
    figure = Figure(figsize=(10, 3.9), layout="constrained")
    rate, error = figure.subplots(1, 2)
    steps = np.arange(401)
    gate = [gate_probability(GazeConfig(), step) for step in steps]
    rate.plot(steps, gate, "--", color="#2c3e50", lw=1.2, label="gate of Fig. 6.7, (p, q) = (150, 22.5)")
    for name, (label, colour) in SHOWN.items():
        if not trials.get(name):
            continue
        runs = columns(trials[name])
        for axes, key in ((rate, "accuracy"), (error, "error_deg")):
            estimates = [mean_interval(column) for column in runs[key].T]
            at = runs["iterations"][0]
            low, high = [e.low for e in estimates], [e.high for e in estimates]
            axes.fill_between(at, low, high, color=colour, alpha=0.2, lw=0)
            axes.plot(at, [e.mean for e in estimates], color=colour, lw=1.5, label=f"{label} ({len(runs[key])} runs)")
        ready = median_interval(reaches(runs["iterations"][0], runs["accuracy"], SHARE)).mean
        if np.isfinite(ready):
            rate.axvline(ready, color=colour, ls=":", lw=1)
    rate.axhline(0.25, color="#7f8c8d", ls=":", lw=0.8)
    rate.set_title(
        "How often the caregiver's object is nearest to the suggestion\n(dotted: l of 90% of the final share; chance)"
    )
    rate.set(ylabel="share", ylim=(0, 1.02))
    error.set(ylabel="degrees", ylim=(0, 15), title="How far the suggestion is off (median)")
    for axes in (rate, error):
        axes.title.set_fontsize(10)
        axes.set(xlabel="learning iterations l (face-to-object pairs)", xlim=(0, 400))
        axes.grid(alpha=0.3)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize=7)
    return {"synchronised": figure}
