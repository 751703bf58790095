"""How well gaze is followed with the cross-situational learner, how soon, and with how many wrong maps."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointattn_mj.gaze_following.summary import LATE_MINUTES
from jointattn_mj.sweeps.claim import Comparison, Trial, Trials, Verdict
from jointattn_mj.sweeps.statistics import Estimate, mean_interval, paired_difference, proportion

from ..sessions.analysis import WITHIN_DEG, draw_landings, half_way, within
from ..wrong_map.analysis import WRONG_DEG
from .sweep import COMPLETE, SETTINGS, Strangers

LEVELS = (0.6, 0.75, 0.9)
"""Rates of success whose first minute is reported."""
KEEPS_MINUTES = 3.0
"""A level counts as reached when the rate stays at it for so long."""
STEP = 0.5
"""Minutes between the times at which the rate of eq. 6.9 is taken."""
RESAMPLES = 999
MAIN = ("state/no_cues", "state/cues", "state/no_cues_thesis", "state/cues_thesis", "pixels/no_cues", "pixels/cues")
TOGETHER = {"from the state": MAIN[:2], "from images": MAIN[4:]}
"""Settings whose sessions are counted together for wrong maps."""
PHASES = ("turn", "reach", "lift", "observe", "put", "gaze")
"""What the caregiver does, in its order."""
EARLY_MINUTES = 10
"""Beginning of a session, in which either axis is still being learned."""
AT_ONCE_S = 75.0
"""Beginning of the time with a stranger, before much can have been learned of the new face."""
COLOURS = {"no_cues": "#2471a3", "cues": "#c0392b", "no_cues_thesis": "#85c1e9", "cues_thesis": "#f1948a"}
LONGER = {
    "watching": "after watching only",
    "watching_thesis": "after watching only, the dissertation's rule",
    "hour": "an hour",
    "variation": "other worlds, from images",
    "variation_delay_not_known": "other worlds, from images, the camera's delay not known",
    "strangers/one_teacher_faces_as_they_are": "strangers, one teacher, faces as they are",
}
FACES = {
    "where_found": "faces cut out where they are found",
    "of_the_thesis": "faces coded as in the dissertation",
}
WORDS = {"no_cues": "without motion cues", "cues": "with motion cues", "thesis": "the dissertation's rule"}


def shares(
    trial: Trial, first_s: float, last_s: float = np.inf, column: str = "success", phase: str | None = None
) -> float:
    """Share of successes among the shifts that landed in a span of time; NaN if there were none.

    Args:
        trial: A session.
        first_s: Begin of the span, seconds.
        last_s: End of the span, seconds.
        column: Which moment's target counts.
        phase: Of the caregiver's task, in which the shifts began; None for any.
    """
    shifts = trial.result["shifts"]
    at, good = np.array(shifts["landing_s"]), np.array(shifts[column], float)
    counted = (at >= first_s) & (at < last_s)
    if phase is not None:
        counted &= np.array(shifts["phase_at_launch"]) == phase
    return float(good[counted].mean()) if counted.any() else np.nan


def late(trial: Trial, column: str = "success", phase: str | None = None) -> float:
    """Rate of success over the last six minutes; see ``shares``."""
    return shares(trial, 60 * (minutes_of(trial.setting) - LATE_MINUTES), column=column, phase=phase)


def minutes_of(setting: str) -> float:
    """Length of a setting's sessions."""
    minutes: float = SETTINGS[setting].config.config.minutes
    return minutes


def curves(trials: Sequence[Trial]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (m,), minutes, and of every session the shifts and successes within a minute of each, (n, m)."""
    times = np.arange(1.0, minutes_of(trials[0].setting) - 0.49, STEP)
    counts = np.zeros((2, len(trials), len(times)))
    for number, trial in enumerate(trials):
        at, good = (np.array(trial.result["shifts"][name], float) for name in ("landing_s", "success"))
        near = np.abs(at / 60 - times[:, None]) <= 1
        counts[:, number] = near.sum(axis=1), near @ good
    return times, *counts


def minute_of(level: float, times: np.ndarray, rate: np.ndarray) -> float:
    """First of ``times`` (m,) from which a rate (m,) stays at ``level`` for ``KEEPS_MINUTES``; infinite if never.

    Args:
        level: Rate that is to be kept, 0 to 1.
        times: (m,) minutes.
        rate: (m,) at these times.
    """
    length = round(KEEPS_MINUTES / STEP) + 1
    above = np.lib.stride_tricks.sliding_window_view(rate >= level, length).all(axis=1)
    return float(times[np.argmax(above)]) if above.any() else np.inf


def soon(trials: Sequence[Trial], level: float) -> Estimate:
    """``minute_of`` the rate of all sessions together, with a bootstrap interval over sessions."""
    times, shifts, good = curves(trials)
    rng = np.random.default_rng(0)
    draws = [rng.integers(len(trials), size=len(trials)) for _ in range(RESAMPLES)]
    minutes = [minute_of(level, times, good[draw].sum(0) / shifts[draw].sum(0)) for draw in draws]
    low, high = np.quantile(minutes, (0.025, 0.975), method="nearest")
    whole = minute_of(level, times, good.sum(0) / shifts.sum(0))
    return Estimate(whole, float(low), float(high), np.nan, len(trials))


def wrong(trials: Sequence[Trial]) -> Estimate:
    """Share of sessions whose map was off by more than ``WRONG_DEG`` in the last minutes."""
    errors = [trial.result["map_error_deg"] for trial in trials]
    return proportion(sum(error is not None and error > WRONG_DEG for error in errors), len(errors))


def in_words(name: str) -> str:
    """A setting for a reader."""
    group, _, rest = name.partition("/")
    if group in ("state", "pixels"):
        cues = rest.removesuffix("_thesis")
        parts = [WORDS["thesis"] if rest.endswith("thesis") else "cross-situational", WORDS[cues]]
        return ", ".join([*parts, f"from {'images' if group == 'pixels' else 'the state'}"])
    if group == "told":
        told = "whole percept" if rest == "all" else rest.replace("_", " ")
        return f"{in_words('faces/of_the_thesis')}, {told} told by the state"
    if group == "faces":
        return f"cross-situational, without motion cues, from images, {FACES[rest]}"
    if group == "upright":
        seen, _, cues = rest.removesuffix("_thesis").partition("_")
        return f"{in_words(f'{seen}/{cues}' + '_thesis' * rest.endswith('thesis'))}, objects in an upright square"
    if group == "ablation":
        return "with " + ", ".join(rest.replace("in_view", "all in view").replace("again", "reading again").split("+"))
    return LONGER.get(name) or f"{group}, {rest}".replace("_", " ").strip(", ")


def _row(what: str, ours: Estimate, note: str = "") -> Comparison:
    return Comparison(what, "not tried", ours, Verdict.EXTENSION, note)


def analyse(trials: Trials) -> list[Comparison]:
    """Late rates and wrong maps of all settings; how soon, and by which moment, of the main ones."""
    findings = []
    for name in SETTINGS:
        part = trials.get(name, ())
        if not part:
            continue
        words = in_words(name)
        if isinstance(SETTINGS[name].config, Strangers):
            findings += strangers(part, words)
            continue
        note = f"successes {mean_interval([trial.result['successes'] for trial in part])}; wrong maps {wrong(part)}"
        findings.append(_row(f"late rate, {words}", mean_interval([late(trial) for trial in part]), note))
        if name.startswith("upright"):
            findings += axes(part, words)
        if name in MAIN:
            findings += details(part, words)
    for origin, names in TOGETHER.items():
        if all(name in trials for name in names):
            both = [trial for name in names for trial in trials[name]]
            what = f"sessions with a map off by more than {WRONG_DEG:g} deg, cross-situational, with cues and without, "
            findings.append(_row(what + origin, wrong(both)))
    return findings + differences(trials)


def details(part: Sequence[Trial], words: str) -> list[Comparison]:
    """Wrong maps, rates by either moment's target, how soon, and rates by what the caregiver did at launch."""
    findings = [_row(f"sessions with a map off by more than {WRONG_DEG:g} deg, {words}", wrong(part))]
    for moment in ("launch", "landing"):
        rates = [late(trial, f"success_at_{moment}") for trial in part]
        findings.append(_row(f"late rate by the caregiver's target at {moment}, {words}", mean_interval(rates)))
    findings += [_minutes(level, part, words) for level in LEVELS]
    by_phase = {phase: mean_interval([late(trial, phase=phase) for trial in part]) for phase in PHASES}
    note = "; ".join(f"{phase} {rate}" for phase, rate in by_phase.items())
    what = f"late rate by the caregiver's task at launch, {words}"
    return [*findings, Comparison(what, "not tried", None, Verdict.EXTENSION, note)]


def axes(part: Sequence[Trial], words: str) -> list[Comparison]:
    """Whether pan is followed before tilt, where both have the same spread."""
    early, half = (
        [[measure(trial, axis) for trial in part] for axis in ("pan", "tilt")] for measure in (_early_share, half_way)
    )
    near = f"landings within {WITHIN_DEG} deg of the target in pan, less those in tilt, first {EARLY_MINUTES} minutes, "
    apart = "minutes by which half of the gain in tilt comes after half of that in pan, "
    return [
        _row(near + words, paired_difference(early[0], early[1])),
        _row(apart + words, paired_difference(half[1], half[0])),
    ]


def _early_share(trial: Trial, axis: str) -> float:
    """Share of landings near the caregiver's object in pan or tilt, over the first minutes."""
    return float(np.nanmean(within(trial, axis)[:EARLY_MINUTES]))


def _minutes(level: float, part: Sequence[Trial], words: str) -> Comparison:
    """How soon the rate stays at a level."""
    minutes, what = soon(part, level), f"minutes until a rate of {level:g}, {words}"
    if np.isfinite(minutes.mean):
        return _row(what, minutes)
    return Comparison(what, "not tried", None, Verdict.EXTENSION, f"never in {len(part)} sessions taken together")


def differences(trials: Trials) -> list[Comparison]:
    """Cues against none, and this learner against the dissertation's, on the same seeds."""
    findings = []
    for first, second in (
        ("state/cues", "state/no_cues"),
        ("state/cues_thesis", "state/no_cues_thesis"),
        ("state/no_cues", "state/no_cues_thesis"),
        ("state/cues", "state/cues_thesis"),
        *((name, "pixels/no_cues") for name in SETTINGS if name.startswith("faces")),
        *((name, "faces/of_the_thesis") for name in SETTINGS if name.startswith("told")),
    ):
        rates = [{trial.seed: late(trial) for trial in trials.get(name, ())} for name in (first, second)]
        seeds = sorted(rates[0].keys() & rates[1].keys())
        if seeds:
            gain = paired_difference(*([rate[seed] for seed in seeds] for rate in rates))
            findings.append(_row(f"late rate, {in_words(first)}, less {in_words(second)}", gain))
    return findings


def strangers(trials: Sequence[Trial], words: str) -> list[Comparison]:
    """Rates with people whom the robot had not learned with: at once, and in the last minute of each."""
    asked = SETTINGS[trials[0].setting].config
    last_s = 60 * (asked.minutes - 1)
    spans = {"at once": (0.0, AT_ONCE_S), "after five minutes": (last_s, np.inf)}
    findings = []
    for when, (first, last) in spans.items():
        each = {name: [shares(trial, first, last) for trial in _of(trials, name)] for name in asked.strangers}
        note = "; ".join(f"{name} {np.nanmean(rates):.2f}" for name, rates in each.items())
        means = [float(np.nanmean(rates)) for rates in zip(*each.values(), strict=True)]
        what = f"rate with {len(each)} strangers {when}, {words}"
        findings.append(_row(what, mean_interval(means), note))
    return findings


def _of(trials: Sequence[Trial], name: str) -> list[Trial]:
    """The part of the trials with one stranger, as sessions."""
    return [Trial(trial.setting, trial.seed, {"shifts": trial.result[name]}) for trial in trials]


APART = ("ablation", "faces", "strangers", "told", "upright")
"""Settings that have figures or rows of their own."""


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Success over time; late rates of all combinations of parts; late rates in harder conditions."""
    figures = {}
    if any(name in trials for name in MAIN):
        figures["cross_situational"] = draw_success(trials)
    if any(name.startswith("ablation") for name in trials):
        figures["cross_situational_ablation"] = draw_ablation(trials)
    if any(name not in MAIN and not name.startswith(APART) for name in trials):
        figures["cross_situational_conditions"] = draw_conditions(trials)
    if any(trials.get(name) for name in TOGETHER["from images"]):
        figures["cross_situational_images"] = draw_images(trials)
    if any(name.startswith("upright") for name in trials):
        figures["cross_situational_axes"] = draw_axes(trials)
    return figures


def draw_success(trials: Trials) -> Figure:
    """Rate of all sessions together over time (eq. 6.9), from the state and from images."""
    figure = Figure(figsize=(10, 4.4), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, perception in zip(panels, ("state", "pixels"), strict=True):
        numbers: list[int] = []
        for condition, colour in COLOURS.items():
            part = trials.get(f"{perception}/{condition}", ())
            if part:
                times, shifts, good = curves(part)
                label = in_words(f"{perception}/{condition}").rpartition(",")[0]
                axes.plot(times, good.sum(0) / shifts.sum(0), color=colour, label=label)
                numbers.append(len(part))
        axes.axhline(0.25, ls=":", color="#7f8c8d", lw=0.8)
        axes.text(25.7, 0.26, "one of four objects at random", ha="right", fontsize=8, color="#7f8c8d")
        axes.set(xlabel="time (simulated minutes)", xlim=(0, 26), ylim=(0, 1))
        origin = "from the simulator's state" if perception == "state" else "from rendered images"
        axes.set_title(f"{origin} ({' and '.join(map(str, sorted(set(numbers))))} sessions each)", fontsize=10)
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("share of right gaze shifts (eq. 6.9)")
    figure.suptitle("How often the robot looked where the caregiver looked")
    fullest = max(panels, key=lambda axes: len(axes.get_legend_handles_labels()[0]))
    figure.legend(*fullest.get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=2, frameon=False)
    return figure


def draw_ablation(trials: Trials) -> Figure:
    """Late rate of every combination of parts, a dot a session; below, which parts each has."""
    parts = ("in_view", "base", "competition", "wait", "again")
    labels = ("all in view, not the reached", "base rate", "competition", "waits for a still face", "reads it again")
    named = {name: set(name.removeprefix("ablation/").split("+")) for name in trials if name.startswith("ablation/")}
    if trials.get("state/no_cues"):
        named["state/no_cues"] = set(COMPLETE.split("+"))
    rates = {name: [late(trial) for trial in trials[name]] for name in named}
    order = sorted(named, key=lambda name: float(np.mean(rates[name])))
    figure = Figure(figsize=(10, 5.6), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    for at, name in enumerate(order):
        above.plot(np.full(len(rates[name]), at), rates[name], "o", ms=2.5, color="#aeb6bf")
        mean = mean_interval(rates[name])
        above.errorbar(at, mean.mean, [[mean.mean - mean.low], [mean.high - mean.mean]], fmt="_", color="#1b2631")
        has = [row for row, part in enumerate(parts) if part in named[name]]
        below.plot([at] * len(parts), range(len(parts)), "o", ms=5, color="#e5e7e9")
        below.plot([at] * len(has), has, "o", ms=5, color="#1b2631")
    above.set(ylabel="share of right gaze shifts, last 6 min", ylim=(0, 1))
    above.set_title("What each part is worth, without motion cues, from the state (dots: sessions; bars: mean, 95%)")
    above.grid(alpha=0.3, axis="y")
    below.set_yticks(range(len(parts)), labels, fontsize=8)
    below.set(xticks=[], ylim=(len(parts) - 0.5, -0.5))
    return figure


def draw_conditions(trials: Trials) -> Figure:
    """Late rate under other settings and in harder conditions, with the complete robot on top."""
    names = [name for name in SETTINGS if trials.get(name) and not name.startswith((*APART, "pixels"))]
    figure = Figure(figsize=(9, 0.32 * len(names) + 1.2), layout="constrained")
    axes = figure.subplots()
    for at, name in enumerate(names):
        rates = [late(trial) for trial in trials[name]]
        mean = mean_interval(rates)
        axes.plot(rates, np.full(len(rates), at), "o", ms=2.5, color="#aeb6bf")
        axes.errorbar(mean.mean, at, xerr=[[mean.mean - mean.low], [mean.high - mean.mean]], fmt="|", color="#1b2631")
    axes.set_yticks(range(len(names)), [f"{in_words(name)} ({len(trials[name])})" for name in names], fontsize=8)
    axes.set(xlim=(0, 1), ylim=(len(names) - 0.5, -0.5), xlabel="share of right gaze shifts, last 6 min")
    figure.suptitle(
        "How often the robot looked right in other conditions (sessions in brackets; bars: mean, 95%)",
        fontsize=10,
    )
    axes.grid(alpha=0.3, axis="x")
    return figure


def draw_images(trials: Trials) -> Figure:
    """Late rate by the caregiver's task, from the state and from images; and with parts of the percept told."""
    names = [name for name in SETTINGS if name.startswith("told") and trials.get(name)]
    figure = Figure(figsize=(10, 4), layout="constrained")
    panels = figure.subplots(1, 1 + bool(names), sharey=True, squeeze=False, width_ratios=(3, 2)[: 1 + bool(names)])[0]
    left = panels[0]
    for shift, (name, colour, filled) in zip(
        np.linspace(-0.24, 0.24, 4),
        [(f"{origin}/{cues}", COLOURS[cues], origin == "pixels") for cues in ("no_cues", "cues")
         for origin in ("state", "pixels")],
        strict=True,
    ):  # fmt: skip
        part = trials.get(name, ())
        if part:
            rates = [mean_interval([late(trial, phase=phase) for trial in part]) for phase in PHASES]
            label = f"{in_words(name).removeprefix('cross-situational, ')} ({len(part)})"
            _bars(left, np.arange(len(PHASES)) + shift, rates, colour, filled, label)
    left.set_xticks(range(len(PHASES)), PHASES)
    left.set(
        xlabel="what the caregiver did when the shift began",
        ylabel="share of right gaze shifts, last 6 min",
        ylim=(0.4, 1.02),
    )
    left.legend(fontsize=8, loc="lower right")
    if names:
        told = {name.removeprefix("told/"): name for name in names}
        shown = {"nothing": "faces/of_the_thesis"} | told | {"nothing;\nother faces": "pixels/no_cues"}
        _draw_told(panels[1], {label: name for label, name in shown.items() if trials.get(name)}, trials)
    for axes in panels:
        axes.grid(alpha=0.3, axis="y")
    figure.suptitle("What images cost in success (sessions in brackets; bars: mean, 95%)", fontsize=11)
    return figure


def _draw_told(axes: Axes, told: Mapping[str, str], trials: Trials) -> None:
    """Late rates by what the state tells; ``told`` has the settings by their labels."""
    rates = [mean_interval([late(trial) for trial in trials.get(name, ())]) for name in told.values()]
    _bars(axes, np.arange(len(told)), rates, COLOURS["no_cues"], True, "")
    labels = [f"{what}\n({len(trials.get(name, ()))})".replace("_", "\n") for what, name in told.items()]
    axes.set_xticks(range(len(told)), labels)
    axes.set(
        xlabel="told by the state, faces coded as in the dissertation;\nlast: faces coded as in the preset",
        xlim=(-0.6, len(told) - 0.4),
    )


def _bars(axes: Axes, at: np.ndarray, rates: Sequence[Estimate], colour: str, filled: bool, label: str) -> None:
    """Means with intervals at places (n,)."""
    means = np.array([rate.mean for rate in rates])
    around = np.abs(np.array([[rate.low, rate.high] for rate in rates]).T - means)
    face = colour if filled else "white"
    axes.errorbar(at, means, around, fmt="o", ms=5, color=colour, mfc=face, lw=1.2, label=label)


def draw_axes(trials: Trials) -> Figure:
    """Landings near the caregiver's object in pan and in tilt, where both have the same spread."""
    names = [name for name in SETTINGS if name.startswith("upright") and trials.get(name)]
    figure = Figure(figsize=(10, 3.4 * ((len(names) + 1) // 2)), layout="constrained")
    panels = figure.subplots((len(names) + 1) // 2, 2, sharex=True, sharey=True, squeeze=False).ravel()
    for panel, name in zip(panels, names, strict=False):
        draw_landings(panel, trials[name])
        words = in_words(name).removesuffix(", objects in an upright square")
        panel.set_title(f"{words} ({len(trials[name])})", fontsize=9)
    panels[0].legend(fontsize=8, loc="lower right")
    figure.supxlabel("time (simulated minutes)", fontsize=10)
    figure.supylabel(f"landings within {WITHIN_DEG} deg\nof the caregiver's object", fontsize=10)
    figure.suptitle(
        "How often gaze shifts end near the caregiver's object, objects in an upright square (bands: 95%)", fontsize=11
    )
    return figure
