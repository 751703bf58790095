"""How well looks are coded by minutes of video, under which conditions, and whether posteriors can be believed."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trial, Trials, Verdict
from jointattn_mj.sweeps.statistics import mean_interval

from .sweep import APART_DEG, LABELLED, MINUTES, SETTINGS

BY_MINUTES = ("usual", "webcam")
"""Settings of which shorter videos are reported too."""
CODERS = {"kappa": "without labels", "last_moved": "last object moved", "yaw": "yaw, fitted", "nearest": "nearest"}
COLOURS = {"kappa": "#c0392b", "last_moved": "#2471a3", "yaw": "#7d6608", "nearest": "#7f8c8d"}


def values(trials: Sequence[Trial], minutes: float, name: str) -> list[float]:
    """One number of every session, where it has it.

    Args:
        trials: Sessions of one setting.
        minutes: Of video that the coder had.
        name: Of the number.
    """
    results = [trial.result[f"{minutes:g}"][name] for trial in trials]
    return [float(result) for result in results if result is not None]


def analyse(trials: Trials) -> list[Comparison]:
    """Kappa, calibration and simpler coders of every condition; of two also after fewer minutes."""
    findings = []
    for setting in SETTINGS:
        part = trials.get(setting, ())
        if not part:
            continue
        words = setting.replace("_", " ")
        for minutes in MINUTES if setting in BY_MINUTES else MINUTES[-1:]:
            note = "; ".join(
                f"{label} {np.mean(values(part, minutes, name)):.2f}"
                for name, label in CODERS.items()
                if name != "kappa"
            )
            coded = sum(values(part, minutes, "coded"))
            placed = np.mean(values(part, minutes, "placements"))
            note += f"; coded {coded:.0f} of {len(part)}; {placed:.0f} placements"
            findings.append(_row(f"kappa, {words}, {minutes:g} minutes", values(part, minutes, "kappa"), note))
            right = values(part, minutes, "right_if_sure")
            if right:
                sure = f"of {np.mean(values(part, minutes, 'sure')):.0%} of the seconds"
                findings.append(_row(f"right where sure, {words}, {minutes:g} minutes", right, sure))
        helped = values(part, MINUTES[-1], "kappa_after_labels")
        if helped:
            without = np.mean(values(part, MINUTES[-1], "kappa_without_labels"))
            findings.append(
                _row(f"kappa after {LABELLED:g} minutes of labels, {words}", helped, f"without labels {without:.2f}")
            )
        hits = values(part, MINUTES[-1], "away_hits")
        if hits:
            false = np.mean(values(part, MINUTES[-1], "away_false"))
            findings.append(_row(f"looks away found, {words}", hits, f"false in {false:.2f} of looks at objects"))
            apart = values(part, MINUTES[-1], "away_hits_apart")
            share = np.mean(values(part, MINUTES[-1], "away_apart"))
            what = f"looks away more than {APART_DEG:g} deg from all objects found, {words}"
            findings.append(_row(what, apart, f"{share:.0%} of the looks away"))
    return findings


def _row(what: str, kappas: Sequence[float], note: str) -> Comparison:
    return Comparison(what, "not tried", mean_interval(kappas), Verdict.EXTENSION, note)


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Kappa by minutes of video, and under all conditions."""
    part = trials.get("usual", ())
    if not part:
        return {}
    figure = Figure(figsize=(10, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    for name, label in CODERS.items():
        means = [mean_interval(values(part, minutes, name)) for minutes in MINUTES]
        middle = [estimate.mean for estimate in means]
        errors = [
            [estimate.mean - estimate.low for estimate in means],
            [estimate.high - estimate.mean for estimate in means],
        ]
        left.errorbar(MINUTES, middle, errors, marker="o", ms=4, capsize=3, color=COLOURS[name], label=label)
    left.set(xscale="log", xlabel="minutes of video", ylabel="kappa by seconds, head still", ylim=(0, 1.02))
    left.set_xticks(MINUTES, [f"{minutes:g}" for minutes in MINUTES])
    left.minorticks_off()
    left.legend(fontsize=8)
    left.grid(alpha=0.3)
    names = [name for name in SETTINGS if trials.get(name)]
    for name in CODERS:
        middles = [float(np.mean(values(trials[setting], MINUTES[-1], name))) for setting in names]
        right.plot(middles, range(len(names)), "o", ms=5, color=COLOURS[name])
    right.set_yticks(range(len(names)), [name.replace("_", " ") for name in names], fontsize=8)
    right.set(xlabel=f"kappa, {MINUTES[-1]:g} minutes", ylim=(len(names) - 0.5, -0.5))
    right.grid(alpha=0.3)
    figure.suptitle(f"How well each way tells where a person looks, from the state (n = {len(part)}; bars: mean, 95%)")
    return {"looks": figure}
