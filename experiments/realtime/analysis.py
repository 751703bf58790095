"""When gaze following, looking back and gaze alternation are found in an hour of real time, and what keeps them."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trial, Trials, Verdict
from jointattn_mj.sweeps.statistics import median_interval, paired_difference, proportion

from ..tables import STAGES
from .sweep import SETTINGS, STEPS_AN_HOUR, Hour

HOUR = 60.0
FOLLOWING, BACK, ALTERNATING = STAGES
NAMES = {FOLLOWING: "gaze following", BACK: "looking back", ALTERNATING: "gaze alternation"}
WORDS = {
    "pixels/cues": "from images, with motion cues",
    "pixels/no_cues": "from images, without",
    "state/cues": "from the state, with motion cues",
    "state/no_cues": "from the state, without",
    "table": f"at the symbolic table, {STEPS_AN_HOUR:,} steps",
    "table, objects stay": f"at the symbolic table where objects stay four times as long, {STEPS_AN_HOUR:,} steps",
}
PERCEPTION = {"pixels": "images", "state": "the state"}
COLOURS = {"pixels/cues": "#c0392b", "pixels/no_cues": "#2471a3", "state/cues": "#e59866", "state/no_cues": "#7fb3d5"}
STYLES = {FOLLOWING: "-", BACK: "--", ALTERNATING: ":"}
ANSWERED = 20
"""Fewest looks at the face after following from which a share is computed."""


def minute_of(trial: Trial, event: str) -> float:
    """Simulated minutes until an event was found, infinite where it was not."""
    modules = trial.result["modules"]
    return trial.result["minutes"][modules.index(event)] if event in modules else np.inf


def alternates(result: dict[str, Any]) -> bool:
    """Whether gaze alternation came after gaze following."""
    modules = result["modules"]
    return ALTERNATING in modules and FOLLOWING in modules[: modules.index(ALTERNATING)]


def analyse(trials: Trials) -> list[Comparison]:
    """The target first, then minutes, what cues do, and link by link what is in the way."""
    findings = []
    for name in WORDS:
        part = trials.get(name, ())
        if part:
            findings += _shares(name, part)
    findings += _cues(trials)
    for name in ("pixels/cues", "pixels/no_cues", "state/cues", "state/no_cues"):
        if trials.get(name):
            findings += _links(name, trials[name])
    return findings


def _shares(name: str, part: Sequence[Trial]) -> list[Comparison]:
    """How many found gaze following, and gaze alternation after it, and when."""
    timed, n = isinstance(SETTINGS[name].config, Hour), len(part)
    orders = Counter(" ".join(trial.result["modules"]) or "nothing" for trial in part).most_common(3)
    visible = "; ".join(f"{count} of {n}: {order}" for order, count in orders)
    if not timed:
        return _at_the_table(name, part, visible)
    times = [minute_of(trial, FOLLOWING) for trial in part]
    rows = [
        Comparison(
            f"gaze following found within an hour, {WORDS[name]}", "asked for: 80%",
            proportion(sum(time <= HOUR for time in times), n), Verdict.EXTENSION,
        ),
        Comparison(
            f"gaze alternation after gaze following within an hour, {WORDS[name]}", "asked for: 80%",
            proportion(sum(alternates(c.result) and minute_of(c, ALTERNATING) <= HOUR for c in part), n),
            Verdict.EXTENSION, visible,
        ),
        Comparison(
            f"minutes until gaze following (median), {WORDS[name]}", "not tried", median_interval(times),
            Verdict.EXTENSION,
        ),
    ]  # fmt: skip
    longest = SETTINGS[name].config.minutes
    if longest > HOUR:
        late = proportion(sum(alternates(trial.result) for trial in part), n)
        what = f"gaze alternation after gaze following within {longest:.0f} minutes, {WORDS[name]}"
        rows.append(Comparison(what, "not tried", late, Verdict.EXTENSION))
    return rows


def _at_the_table(name: str, part: Sequence[Trial], visible: str) -> list[Comparison]:
    """The same at the symbolic table, in about as many steps as an hour has."""
    n = len(part)
    following = proportion(sum(FOLLOWING in trial.result["modules"] for trial in part), n)
    both = proportion(sum(alternates(trial.result) for trial in part), n)
    return [
        Comparison(f"gaze following found, {WORDS[name]}", "not tried", following, Verdict.EXTENSION),
        Comparison(
            f"gaze alternation after gaze following, {WORDS[name]}", "not tried", both, Verdict.EXTENSION, visible
        ),
    ]


def _cues(trials: Trials) -> list[Comparison]:
    """What motion cues do to the time until gaze following, seed by seed."""
    findings = []
    for perception in ("pixels", "state"):
        both = [{c.seed: c for c in trials.get(f"{perception}/{cues}", ())} for cues in ("cues", "no_cues")]
        seeds = [
            seed
            for seed in sorted(set.intersection(*map(set, both)))
            if all(np.isfinite(minute_of(part[seed], FOLLOWING)) for part in both)
        ]
        if len(seeds) > 1:
            minutes = [[minute_of(part[seed], FOLLOWING) for seed in seeds] for part in both]
            rates = [np.mean([part[seed].result["lived"] / part[seed].result["lived_minutes"] for seed in seeds])
                     for part in both]  # fmt: skip
            findings.append(Comparison(
                f"minutes until gaze following, with motion cues less without, from {PERCEPTION[perception]}",
                "not tried", paired_difference(*minutes), Verdict.EXTENSION,
                f"{rates[0]:.0f} and {rates[1]:.0f} steps a minute",
            ))  # fmt: skip
    return findings


def _links(name: str, part: Sequence[Trial]) -> list[Comparison]:
    """Whether faces are told apart, the first map is right, and following shows in the caregiver's face."""
    purity, whole, used, unused = [], [], [], []
    for trial in part:
        faces = np.array(trial.result["faces"])[:-1, :-1]
        purity.append(float(faces.max(axis=1).sum() / faces.sum()))
        offered = trial.result["directions"]
        if offered is not None:
            whole.append(right_map(offered))
        after = trial.result["after_following"]
        if after is not None and right_map(offered) and after["used"][0] >= ANSWERED:
            used.append(after["used"][1] / after["used"][0])
            unused.append(after["not used"][1] / after["not used"][0])
    findings = [
        Comparison(
            f"faces whose category tells where the caregiver looks, {WORDS[name]}", "not tried",
            median_interval(purity), Verdict.EXTENSION,
        )
    ]  # fmt: skip
    if whole:
        reached = sum(alternates(c.result) for c in part if right_map(c.result["directions"]))
        findings.append(Comparison(
            f"maps of gaze following that are right for three places and wrong once at most, {WORDS[name]}",
            "not tried",
            proportion(sum(whole), len(whole)), Verdict.EXTENSION,
            f"gaze alternation after {reached} of these {sum(whole)}, and after "
            f"{sum(alternates(c.result) for c in part) - reached} of the other {len(whole) - sum(whole)}",
        ))  # fmt: skip
    if used:
        findings.append(Comparison(
            f"caregiver's face frontal when looked at after following, with such a map, {WORDS[name]}", "not tried",
            median_interval(used), Verdict.EXTENSION, f"after anything else {np.median(unused):.2f}",
        ))  # fmt: skip
    return findings


def right_map(offered: Sequence[int] | None) -> bool:
    """Whether a map of gaze following has a command for each of three places at least, and at most one that is wrong:
    one for a face that nearly never comes does no harm."""
    return offered is not None and offered[1] >= 3 and offered[0] - offered[1] <= 1


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Share of runs that found each event, over minutes; where the caregiver looks after being followed."""
    timed = [name for name in COLOURS if trials.get(name)]
    if not timed:
        return {}
    figure = Figure(figsize=(9.5, 3.9), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.6, 1))
    for name in timed:
        _draw_shares(left, name, trials[name])
    left.axvline(HOUR, color="k", lw=0.8)
    left.axhline(0.8, color="0.6", lw=0.8)
    longest = max(SETTINGS[name].config.minutes for name in timed)
    left.set(
        xlabel="simulated minutes",
        ylabel="share of runs",
        title="How many runs have found each event",
        ylim=(-0.02, 1.04),
        xlim=(0, longest),
    )
    for event, style in STYLES.items():
        left.plot([], [], "k", ls=style, label=NAMES[event])
    figure.legend(*left.get_legend_handles_labels(), fontsize=7, loc="outside lower center", ncols=3)
    _draw_answers(right, trials, timed)
    return {"realtime": figure}


def _draw_shares(axes: Axes, name: str, part: Sequence[Trial]) -> None:
    for event, style in STYLES.items():
        times = np.sort([minute_of(trial, event) for trial in part])
        steps = np.concatenate([[0.0], times[np.isfinite(times)], [SETTINGS[name].config.minutes]])
        share = np.arange(len(steps)) / len(part)
        share[-1] = share[-2]
        axes.step(steps, share, where="post", ls=style, color=COLOURS[name], lw=1.4)
    axes.plot([], [], color=COLOURS[name], label=f"{WORDS[name]} ({len(part)})")


def _draw_answers(axes: Axes, trials: Trials, timed: Sequence[str]) -> None:
    """The caregiver's face after following and after anything else, one line a run."""
    for number, name in enumerate(timed):
        for trial in trials[name]:
            after = trial.result["after_following"]
            if after is None or min(after["used"][0], after["not used"][0]) < ANSWERED:
                continue
            share = [after[key][1] / after[key][0] for key in ("not used", "used")]
            right = right_map(trial.result["directions"])
            axes.plot(
                [number * 3, number * 3 + 1], share, color=COLOURS[name], lw=0.9, ls="-" if right else ":",
                marker="o" if alternates(trial.result) else "", ms=3,
            )  # fmt: skip
    ticks = [3 * number + side for number in range(len(timed)) for side in (0, 1)]
    axes.set_xticks(ticks, ["else", "followed"] * len(timed), fontsize=7, rotation=40)
    axes.set(ylabel="share of looks with a frontal face", ylim=(-0.02, 1.02))
    axes.set_title("How often the caregiver looks back\n(dotted: map not whole; dots: gaze alternation)", fontsize=8)
