"""Up to how many objects the right event leads, and whether the caregiver's responses matter."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import mean_interval

from .sweep import CHANCES, OBJECTS


def _leads(trials: Trials, objects: int, follow: float | None = None, lead: float | None = None) -> np.ndarray:
    """Leads of all runs with so many objects, and where given with this p_r or p_i."""
    return np.array([
        trial.result["lead"]
        for f in CHANCES if follow in (None, f)
        for p in CHANCES if lead in (None, p)
        for trial in trials.get(f"follow {f} lead {p} objects {objects}", ())
    ])  # fmt: skip


def _difference(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    count = min(len(first), len(second))
    return first[:count] - second[:count]


def analyse(trials: Trials) -> list[Comparison]:
    """Signs of the lead, and its change with p_r and p_i."""
    findings = []
    for objects in OBJECTS:
        leads = _leads(trials, objects)
        if not len(leads):
            continue
        ours = mean_interval(leads * 1e3)
        expected = objects <= 7
        same = ours.low > 0 if expected else ours.high < 0
        verdict = Verdict.REPRODUCED if same else Verdict.UNDECIDED if ours.low <= 0 <= ours.high else Verdict.NOT
        findings.append(Comparison(
            f"lead of (S1, A1, R2) with {objects} of 9 spots full, millibits",
            "above 0" if expected else "not above 0", ours, verdict,
        ))  # fmt: skip
    for name, words in (("follow", "p_r"), ("lead", "p_i")):
        high, low = (_leads(trials, 3, **{name: chance}) for chance in (0.75, 0.25))
        if len(high) and len(low):
            ours = mean_interval(_difference(high, low) * 1e3)
            findings.append(Comparison(
                f"change of the lead with 3 objects from {words} = .25 to .75, millibits",
                "none beyond the error bars", ours,
                Verdict.REPRODUCED if ours.low <= 0 <= ours.high else Verdict.NOT,
            ))  # fmt: skip
    return findings


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Fig. 4.5: the lead over the number of objects, a line for each pair of p_r and p_i."""
    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.subplots()
    for row, follow in enumerate(CHANCES):
        for column, lead in enumerate(CHANCES):
            runs = [(objects, _leads(trials, objects, follow, lead)) for objects in OBJECTS]
            runs = [(objects, leads * 1e3) for objects, leads in runs if len(leads)]
            if runs:
                axes.errorbar(
                    [objects + 0.05 * (3 * row + column - 4) for objects, _ in runs],
                    [leads.mean() for _, leads in runs], [leads.std(ddof=min(1, len(leads) - 1)) for _, leads in runs],
                    color=f"C{row}", ls=("-", "--", ":")[column], marker="osd"[column], ms=3, lw=1, capsize=2,
                    label=f"$p_r$ {follow}, $p_i$ {lead}",
                )  # fmt: skip
    axes.axhline(0, color="k", lw=0.8)
    axes.set(xlabel="objects on 9 spots", ylabel="lead of $(S_1, A_1, R_2)$ in $T^C$ (millibits)")
    axes.set_title("How far the right event leads, by number of objects")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=8, ncols=3, title="mean and standard deviation")
    axes.grid(alpha=0.3)
    return {"many_objects": figure}
