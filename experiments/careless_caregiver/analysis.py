"""Above and below which care the right event leads."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import mean_interval

from .sweep import CARE


def _leads(trials: Trials, care: float) -> np.ndarray:
    return np.array([trial.result["lead"] * 1e3 for trial in trials.get(f"at objects {care}", ())])


def analyse(trials: Trials) -> list[Comparison]:
    """Signs: above 0 over p_c = .6 and below .2, in between not."""
    findings = []
    for care in CARE:
        leads = _leads(trials, care)
        if not len(leads):
            continue
        ours = mean_interval(leads)
        at_edge = care in (0.2, 0.6)
        positive = care > 0.6 or care < 0.2
        said = "about 0: the sign changes" if at_edge else "above 0" if positive else "not above 0"
        holds = ours.low > 0 if positive else ours.high <= 0
        verdict = (
            Verdict.REPRODUCED if at_edge or holds else Verdict.UNDECIDED if ours.low <= 0 <= ours.high else Verdict.NOT
        )
        findings.append(Comparison(f"lead of (S1, A1, R2) at p_c = {care}, millibits", said, ours, verdict))
    return findings


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Fig. 4.6."""
    runs = [(care, leads) for care in CARE if len(leads := _leads(trials, care))]
    figure = Figure(figsize=(6.4, 3.8), layout="constrained")
    axes = figure.subplots()
    axes.errorbar(
        [care for care, _ in runs], [leads.mean() for _, leads in runs],
        [leads.std(ddof=min(1, len(leads) - 1)) for _, leads in runs], marker="o", ms=4, capsize=3,
        label="mean and standard deviation",
    )  # fmt: skip
    axes.axhline(0, color="k", lw=0.8)
    for edge in (0.2, 0.6):
        axes.axvline(edge, color="C1", ls=":", label="sign changes in the dissertation" if edge == 0.2 else None)
    axes.set(
        xlabel="$p_c$: how often the caregiver behaves as described",
        ylabel="lead of $(S_1, A_1, R_2)$ (millibits)",
        title="How far the right event leads, by the caregiver's care",
    )
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3)
    return {"careless_caregiver": figure}
