"""Whether FG-m and SCf-m change behaviour little, and SC-m drastically."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.development.behaviour import BEHAVIOURS, FG, KEC
from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import mean_interval

from ..tables import in_order

PHASES = 4


def _rates(trials: Trials, setting: str) -> np.ndarray:
    """(runs, phases, behaviours) of the runs with FG, SCf, SC in order."""
    results = [trial.result for trial in trials.get(setting, ()) if in_order(trial.result)]
    return np.array([result["phases"][:PHASES] for result in results]).reshape(-1, PHASES, len(BEHAVIOURS))


def analyse(trials: Trials) -> list[Comparison]:
    """Total change of behaviour with each module, and what rises with the third."""
    findings = []
    for setting in ("caregiver first", "robot first"):
        rates = _rates(trials, setting)
        if not len(rates):
            continue
        changes = np.abs(np.diff(rates, axis=1)).sum(axis=2) / 2
        per_module = [mean_interval(changes[:, module]) for module in range(PHASES - 1)]
        drastic = per_module[2].low > max(per_module[0].high, per_module[1].high)
        for module, (name, said) in enumerate((("FG-m", "little"), ("SCf-m", "little"), ("SC-m", "drastic"))):
            findings.append(Comparison(
                f"share of steps whose behaviour changes with {name}; {setting}", said, per_module[module],
                Verdict.REPRODUCED if drastic else Verdict.NOT,
            ))  # fmt: skip
        for behaviour, name in ((FG, "gaze following"), (KEC, "eye contact")):
            rise = mean_interval(rates[:, 3, behaviour] - rates[:, 2, behaviour])
            findings.append(Comparison(
                f"rise of the rate of {name} with SC-m; {setting}", "rises", rise,
                Verdict.REPRODUCED if rise.low > 0 else Verdict.NOT,
            ))  # fmt: skip
    return findings


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Rates of the six behaviours in each phase."""
    settings = [setting for setting in ("caregiver first", "robot first") if len(_rates(trials, setting))]
    if not settings:
        return {}
    figure = Figure(figsize=(8, 3.6), layout="constrained")
    panels = figure.subplots(1, len(settings), sharey=True, squeeze=False)[0]
    for axes, setting in zip(panels, settings, strict=True):
        rates = _rates(trials, setting)
        for number, name in enumerate(BEHAVIOURS):
            line = [mean_interval(rates[:, phase, number]) for phase in range(PHASES)]
            errors = [[e.mean - e.low for e in line], [e.high - e.mean for e in line]]
            axes.errorbar(range(PHASES), [e.mean for e in line], errors, marker="o", ms=4, capsize=3, label=name)
        axes.set_xticks(range(PHASES), ["P1\nno module", "P2\nFG-m", "P3\nSCf-m", "P4\nSC-m"])
        axes.set(
            title=f"What the robot does in each phase\n({setting}, {len(rates)} runs)",
            xlabel="phase, and the module it begins with",
        )
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("share of the phase's last 1000 steps")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8)
    return {"behaviour": figure}
