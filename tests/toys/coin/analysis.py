"""Share of heads over coins."""

from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Verdict
from jointattn_mj.sweeps.statistics import mean_interval


def analyse(trials):
    """A row a coin."""
    findings = [
        Comparison(f"heads of the {name} one", "0.5", mean_interval([trial.result["heads"] for trial in part]), verdict)
        for name, verdict in (("fair", Verdict.REPRODUCED), ("loaded", Verdict.NOT))
        if (part := trials.get(name))
    ]
    return [*findings, Comparison("a sentence", "so | so", None, Verdict.EXTENSION, "no <number> there")]


def draw(trials):
    """Every throw."""
    figure = Figure(figsize=(3, 2))
    axes = figure.subplots()
    for name, part in trials.items():
        axes.plot([trial.seed for trial in part], [trial.result["heads"] for trial in part], ".", label=name)
    return {"heads": figure}
