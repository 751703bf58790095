"""Success of the perceptron as a curve over its learning rate."""

from collections.abc import Mapping

from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import Estimate, mean_interval

from .sweep import EPOCHS, RATES

PUBLISHED = 0.84


def _success(trials: Trials, epochs: int, rate: float) -> Estimate:
    return mean_interval([trial.result["success"][str(epochs)][str(rate)] for trial in trials.get("chapter4", ())])


def analyse(trials: Trials) -> list[Comparison]:
    """The rate at which one epoch comes closest to 84%, and the range of all rates."""
    if not trials.get("chapter4"):
        return []
    curve = {rate: _success(trials, 1, rate) for rate in RATES}
    closest = min(RATES, key=lambda rate: abs(curve[rate].mean - PUBLISHED))
    matches = [rate for rate in RATES if curve[rate].low <= PUBLISHED <= curve[rate].high]
    everything = [_success(trials, epochs, rate) for epochs in EPOCHS for rate in RATES]
    low, high = min(e.mean for e in everything), max(e.mean for e in everything)
    return [
        Comparison(
            f"success of the perceptron, one epoch at rate {closest}", "84% over ten trials", curve[closest],
            Verdict.PARTLY if matches else Verdict.NOT,
            f"rate and epochs are not published; over {min(RATES)} to {max(RATES)} and 1 to {max(EPOCHS)} epochs the "
            f"mean goes from {low:.0%} to {high:.0%}, so that a match at some rate is no test",
        )
    ]  # fmt: skip


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Success over the learning rate, a curve for each number of epochs."""
    if not trials.get("chapter4"):
        return {}
    figure = Figure(figsize=(6.4, 3.8), layout="constrained")
    axes = figure.subplots()
    for epochs in EPOCHS:
        curve = [_success(trials, epochs, rate) for rate in RATES]
        means = [e.mean for e in curve]
        errors = [[e.mean - e.low for e in curve], [e.high - e.mean for e in curve]]
        axes.errorbar(RATES, means, errors, marker="o", ms=4, capsize=3, label=f"{epochs} epoch{'s' * (epochs > 1)}")
    axes.axhline(PUBLISHED, color="k", ls=":", label="dissertation, rate unknown")
    axes.axhline(0.1, color="grey", ls="--", lw=0.8, label="chance: one of ten outputs")
    axes.set(
        xscale="log",
        ylim=(0, 1.03),
        xlabel="learning rate",
        ylabel="share of right answers",
        title="How often the perceptron looks right",
    )
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3)
    return {"perceptron": figure}
