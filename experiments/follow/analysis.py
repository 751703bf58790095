"""Curves of reward, beside agents that know everything, nothing, and where objects tend to lie."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trial, Trials, Verdict
from jointattn_mj.sweeps.statistics import Estimate, mean_interval, median_interval, paired_difference

from .sweep import SETTINGS

WORDS = {
    "state": "from the state",
    "patch": "from the face patch",
    "images": "from images",
    "blindfolded": "blindfolded",
}
BLINDFOLDED = "blindfolded"
COLOURS = {"state": "#1f618d", "patch": "#1e8449", "images": "#b03a2e", BLINDFOLDED: "#7f8c8d"}
BASELINES = {"oracle": "-.", "zero": "--", "random": ":"}
NEAR = 0.9
"""Share of the way from the blindfolded learner to the oracle that counts as learned."""
ENOUGH = 5
"""Runs from which an interval is worth reading."""


def analyse(trials: Trials) -> list[Comparison]:
    """What each learner earns at the end, what seeing the caregiver is worth, how soon; and what baselines earn."""
    findings = []
    for task in _tasks(trials):
        blindfolded = trials.get(f"{task}/{BLINDFOLDED}", ())
        for observed, words in WORDS.items():
            part = trials.get(f"{task}/{observed}", ())
            if part:
                what = f"reward a step in {task} after {part[0].result['steps'][-1]:,} steps, PPO {words}"
                findings.append(_finding(what, mean_interval(final(part))))
                findings += _above(task, observed, part, blindfolded) if observed != BLINDFOLDED else []
        for name in BASELINES:
            findings.append(_finding(f"reward a step in {task}, {name}", mean_interval(_baseline(trials, task, name))))
    return findings


def draw(trials: Trials) -> Mapping[str, Figure]:
    """A panel for every task and what is observed of it: mean and interval over runs, every run, and baselines."""
    visible = [name for name in SETTINGS if name in trials and not name.endswith(f"/{BLINDFOLDED}")]
    if not visible:
        return {}
    rows = [[name for name in visible if name.startswith(f"{task}/")] for task in _tasks(trials)]
    rows = [row for row in rows if row]
    columns = max(map(len, rows))
    figure = Figure(figsize=(4.4 * columns + 0.6, 3.7 * len(rows) + 0.6), layout="constrained")
    panels = []
    for row, places in zip(rows, figure.subplots(len(rows), columns, sharey=True, squeeze=False), strict=True):
        for place, axes in enumerate(places):
            if place < len(row):
                _panel(axes, trials, *row[place].split("/"))
                panels.append(axes)
            else:
                axes.axis("off")
        places[0].set_ylabel("reward per step in test episodes")
    legends = [zip(*axes.get_legend_handles_labels(), strict=True) for axes in panels]
    entries = {label: handle for legend in legends for handle, label in legend}
    figure.legend(
        entries.values(), entries, fontsize=8, loc="outside lower center", ncols=2 * len(visible), frameon=False
    )
    figure.suptitle("How much reward PPO learns to earn, by what it sees")
    return {"follow": figure}


def final(part: Sequence[Trial]) -> list[float]:
    """Reward a step at the last test of each run."""
    return [trial.result["reward"][-1] for trial in part]


def steps_until(trial: Trial, level: float) -> float:
    """Steps of experience at the first test that reaches ``level``; infinite where none does."""
    reached = np.array(trial.result["reward"]) >= level
    return float(trial.result["steps"][int(np.argmax(reached))]) if reached.any() else np.inf


def _above(task: str, observed: str, part: Sequence[Trial], blindfolded: Sequence[Trial]) -> list[Comparison]:
    """What seeing the caregiver is worth, and when most of it is earned. The same seed means the same tests."""
    other = {trial.seed: trial.result["reward"][-1] for trial in blindfolded}
    pairs = [(trial.result["reward"][-1], other[trial.seed]) for trial in part if trial.seed in other]
    if not pairs:
        return []
    what = f"the same less that of PPO blindfolded, {task}, {WORDS[observed]}"
    chance, best = float(np.mean(list(other.values()))), float(np.mean([trial.result["oracle"] for trial in part]))
    times = [steps_until(trial, chance + NEAR * (best - chance)) for trial in part]
    late = f"steps until {NEAR:.0%} of the way from blindfolded to oracle (median), {task}, {WORDS[observed]}"
    return [_finding(what, paired_difference(*zip(*pairs, strict=True))), _finding(late, median_interval(times))]


def _panel(axes: Axes, trials: Trials, task: str, observed: str) -> None:
    part = trials[f"{task}/{observed}"]
    last = part[0].result["steps"][-1]
    for name in (BLINDFOLDED, observed):
        for trial in trials.get(f"{task}/{name}", ()):
            axes.plot(trial.result["steps"], trial.result["reward"], color=COLOURS[name], lw=0.5, alpha=0.35)
        _mean(axes, trials.get(f"{task}/{name}", ()), name, last)
    for name, style in BASELINES.items():
        level = mean_interval(_baseline(trials, task, name)).mean
        axes.axhline(level, color="k", ls=style, lw=0.9, label=name)
    number = len(trials.get(f"{task}/{BLINDFOLDED}", ()))
    axes.set(xlabel="steps of experience", xlim=(0, last), ylim=(-0.02, 1.03))
    axes.set_title(f"{task}, {WORDS[observed]} (n = {len(part)}; blindfolded {number})", fontsize=10)
    axes.grid(alpha=0.3)


def _mean(axes: Axes, part: Sequence[Trial], name: str, last: int) -> None:
    """Mean over runs and its interval; thin and level from the last test on, where others went on for longer."""
    if not part:
        return
    steps = part[0].result["steps"]
    tests = [mean_interval(column) for column in np.array([trial.result["reward"] for trial in part]).T]
    axes.plot([steps[-1], last], [tests[-1].mean] * 2, color=COLOURS[name], lw=1, ls=(0, (6, 4)))
    axes.fill_between(steps, [e.low for e in tests], [e.high for e in tests], color=COLOURS[name], alpha=0.25, lw=0)
    axes.plot(steps, [e.mean for e in tests], color=COLOURS[name], lw=2, label=f"PPO {WORDS[name]}")


def _tasks(trials: Trials) -> list[str]:
    """Those of which something is stored, as in the settings."""
    return list(dict.fromkeys(name.split("/")[0] for name in SETTINGS if name in trials))


def _baseline(trials: Trials, task: str, name: str) -> list[float]:
    """What an agent earned in the tests of every seed; learners with the same seed shared them."""
    by_seed = {trial.seed: trial.result[name] for other in WORDS for trial in trials.get(f"{task}/{other}", ())}
    return list(by_seed.values())


def _finding(what: str, ours: Estimate) -> Comparison:
    note = "" if ours.n >= ENOUGH else f"so few runs ({ours.n}) bound nothing"
    return Comparison(what, "not asked", ours, Verdict.EXTENSION, note)
