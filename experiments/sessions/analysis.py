"""Success of gaze following with and without motion cues (Fig. 6.8), and pan and tilt apart."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointattn_mj.gaze_following.summary import LATE_MINUTES, rate_of_success
from jointattn_mj.sweeps.claim import Comparison, Trial, Trials, Verdict
from jointattn_mj.sweeps.statistics import Estimate, mean_interval, paired_difference, too_few

PUBLISHED = {
    "cues": {"gaze_shifts": 302.0, "successes": 199.6, "late_rate": 0.8},
    "no_cues": {"gaze_shifts": 279.6, "successes": 124.4},
}
PUBLISHED_GAIN = PUBLISHED["cues"]["successes"] - PUBLISHED["no_cues"]["successes"]
WORDS = {"cues": "with motion cues", "no_cues": "without motion cues", "state": "the state", "pixels": "images"}
QUANTITIES = {
    "gaze_shifts": "gaze shifts from the face to an object",
    "successes": "successes",
    "late_rate": "success rate over the last 6 minutes",
}
MORE = {
    "successes_at_launch": "successes by the caregiver's target at launch",
    "successes_at_landing": "successes by the caregiver's target at landing",
    "landings_on_nothing": "landings more than 3.5 deg off everything",
    "successes_on_something": "successes within 3.5 deg",
    "map_error_deg.median": "error of the learned map, deg",
}
REPRODUCED, PARTLY = 0.1, 0.2
"""Relative distance from the published mean, for which no deviation is given."""
WITHIN_DEG = 3.5
COLOURS = {"cues": "#c0392b", "no_cues": "#2471a3"}
MINUTES = np.arange(1, 26)


def value(trial: Trial, key: str) -> float:
    """A number of a session by its dotted name; NaN where there is none."""
    result: Any = trial.result
    for part in key.split("."):
        result = result[part]
    return np.nan if result is None else float(result)


def estimate(trials: Sequence[Trial], key: str) -> Estimate:
    """Mean over sessions."""
    return mean_interval([value(trial, key) for trial in trials])


def in_words(name: str) -> str:
    """A setting for a reader: ``state/cues_linear`` is "from the state, with motion cues, linear"."""
    perception, _, rest = name.partition("/")
    condition = next(known for known in ("no_cues", "cues") if rest.startswith(known))
    changed = rest.removeprefix(condition).strip("_").replace("_", " ")
    return ", ".join(filter(None, [f"from {WORDS[perception]}", WORDS[condition], changed]))


def near(ours: Estimate, published: float) -> Verdict:
    """How close the mean came."""
    off = abs(ours.mean - published) / published
    return Verdict.REPRODUCED if off <= REPRODUCED else Verdict.PARTLY if off <= PARTLY else Verdict.NOT


def analyse(trials: Trials) -> list[Comparison]:
    """The published numbers first, then what has no counterpart there."""
    findings = [
        published(trials[f"{perception}/{condition}"], perception, condition, key)
        for perception in ("pixels", "state")
        for condition in ("cues", "no_cues")
        if f"{perception}/{condition}" in trials
        for key in QUANTITIES
    ]
    for perception in ("pixels", "state"):
        findings += differences(trials, perception)
    for name, part in trials.items():
        perception, _, condition = name.partition("/")
        if condition not in PUBLISHED:
            findings += [extension(part, name, key, QUANTITIES[key]) for key in ("successes", "late_rate")]
        elif perception == "state":
            findings += [extension(part, name, key, words) for key, words in MORE.items()]
    return findings + [axes_apart(trials[name], name) for name in ("state/cues", "state/no_cues") if name in trials]


def published(part: Sequence[Trial], perception: str, condition: str, key: str) -> Comparison:
    """A number of the dissertation beside ours.

    Args:
        part: Sessions of one setting.
        perception: ``pixels`` or ``state``.
        condition: ``cues`` or ``no_cues``.
        key: Name of the number.
    """
    stated, ours = PUBLISHED[condition].get(key), estimate(part, key)
    what = f"{QUANTITIES[key]}, {WORDS[condition]}, from {WORDS[perception]}"
    if stated is None:
        return Comparison(what, "only drawn", ours, Verdict.EXTENSION)
    verdict = near(ours, stated)
    note = f"within {REPRODUCED:.0%} of the published mean of five" if verdict is Verdict.REPRODUCED else ""
    return Comparison(what, f"{stated:g}", ours, verdict, note)


def differences(trials: Trials, perception: str) -> list[Comparison]:
    """With cues less without, seed by seed."""
    both = [trials.get(f"{perception}/{condition}", ()) for condition in ("cues", "no_cues")]
    seeds = sorted(set.intersection(*({trial.seed for trial in part} for part in both)))
    if not seeds:
        return []
    findings = []
    for key, stated in (("successes", PUBLISHED_GAIN), ("late_rate", None)):
        with_cues, without = ({trial.seed: value(trial, key) for trial in part} for part in both)
        a, b = [with_cues[seed] for seed in seeds], [without[seed] for seed in seeds]
        ours, note = paired_difference(a, b), ""
        verdict = Verdict.REPRODUCED if ours.low > 0 else Verdict.NOT if ours.high < 0 else Verdict.UNDECIDED
        if len(seeds) < 2:
            verdict, note = Verdict.UNDECIDED, "one pair of sessions"
        elif verdict is Verdict.UNDECIDED:
            note = too_few(len(seeds), float(np.nanmean(a)), float(np.nanmean(b)), ours.sd)
        elif stated is not None and ours.high < stated:
            note = "higher with cues, by less than there"
        what = f"{QUANTITIES[key]}, with motion cues less without, from {WORDS[perception]}"
        findings.append(Comparison(what, "higher" if stated is None else f"{stated:g}", ours, verdict, note))
    return findings


def extension(part: Sequence[Trial], name: str, key: str, words: str) -> Comparison:
    """A number that the dissertation does not give.

    Args:
        part: Sessions of one setting.
        name: Of the setting.
        key: Name of the number.
        words: What it is.
    """
    return Comparison(f"{words}, {in_words(name)}", "not given", estimate(part, key), Verdict.EXTENSION)


def axes_apart(part: Sequence[Trial], name: str) -> Comparison:
    """Whether following of horizontal displacement comes before vertical, as in infants."""
    pan, tilt = ([half_way(trial, axis) for trial in part] for axis in ("pan", "tilt"))
    return Comparison(
        f"minutes by which half of the gain in tilt comes after half of that in pan, {in_words(name)}",
        "in infants horizontal comes first (Silverstein et al.)",
        paired_difference(tilt, pan),
        Verdict.EXTENSION,
        f"share of landings within {WITHIN_DEG} deg of the caregiver's object along one axis; objects differ by "
        "up to 45 deg in pan and by some 10 in tilt, so the axes are not equally hard",
    )


def within(trial: Trial, axis: str, minutes: float = 1.0) -> np.ndarray:
    """Share of landings within 3.5 deg of the caregiver's object in pan or tilt, around every minute of ``MINUTES``.

    Args:
        trial: A session.
        axis: ``pan`` or ``tilt``.
        minutes: Half of the time around each minute in which landings count.
    """
    shifts = trial.result["shifts"]
    error = np.array(shifts[f"{axis}_error_deg"], float)
    at = np.array(shifts["landing_s"], float) / 60
    return rate_of_success(MINUTES / minutes, at / minutes, np.abs(error) <= WITHIN_DEG)


def half_way(trial: Trial, axis: str) -> float:
    """Minute at which the share first gets half of the way from its first to its last six minutes; NaN if it falls."""
    share = within(trial, axis, minutes=2.0)
    first, last = np.nanmean(share[: int(LATE_MINUTES)]), np.nanmean(share[-int(LATE_MINUTES) :])
    if not last > first:
        return np.nan
    return float(MINUTES[np.argmax(share >= (first + last) / 2)])


def curve(trial: Trial) -> np.ndarray:
    """Eq. 6.9 at every minute of ``MINUTES``."""
    shifts = trial.result["shifts"]
    return rate_of_success(MINUTES, np.array(shifts["landing_s"]) / 60, np.array(shifts["success"], bool))


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Fig. 6.8 for either kind of perception, and the axes apart."""
    figures = {}
    if any(f"{perception}/{condition}" in trials for perception in ("pixels", "state") for condition in COLOURS):
        figures["sessions"] = draw_success(trials)
    if any(f"state/{condition}" in trials for condition in COLOURS):
        figures["pan_and_tilt"] = draw_axes(trials)
    return figures


def draw_success(trials: Trials) -> Figure:
    """Mean and standard deviation over sessions."""
    figure = Figure(figsize=(10, 4.4), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, perception in zip(panels, ("pixels", "state"), strict=True):
        for condition, fmt in (("cues", "x-"), ("no_cues", "+-")):
            part = trials.get(f"{perception}/{condition}", ())
            if part:
                curves = np.array([curve(trial) for trial in part])
                spread = np.nanstd(curves, axis=0, ddof=1) if len(curves) > 1 else None
                axes.errorbar(
                    MINUTES, np.nanmean(curves, axis=0), spread, fmt=fmt, color=COLOURS[condition], lw=1, capsize=2,
                    label=f"{WORDS[condition]} (mean, sd)",
                )  # fmt: skip
        axes.axhline(0.8, ls="--", color="#7f8c8d", lw=0.8, label="dissertation, with cues, after 20 min")
        axes.axhline(0.25, ls=":", color="#7f8c8d", lw=0.8, label="one of four objects at random")
        numbers = [len(trials.get(f"{perception}/{condition}", ())) for condition in COLOURS]
        title = "from rendered images" if perception == "pixels" else "from the simulator's state"
        axes.set(xlabel="time (simulated minutes)", xlim=(0, 26), ylim=(0, 1))
        axes.set_title(f"{title} ({numbers[0]} and {numbers[1]} sessions)", fontsize=10)
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("share of right gaze shifts (eq. 6.9)")
    figure.suptitle("How often the robot looked where the caregiver looked")
    fullest = max(panels, key=lambda axes: len(axes.get_legend_handles_labels()[0]))
    figure.legend(*fullest.get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=4, frameon=False)
    return figure


def draw_axes(trials: Trials) -> Figure:
    """Landings near the caregiver's object in pan and in tilt, over time."""
    figure = Figure(figsize=(10, 3.8), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for panel, condition in zip(panels, COLOURS, strict=True):
        part = trials.get(f"state/{condition}", ())
        panel.set(xlabel="time (simulated minutes)")
        panel.set_title(f"{WORDS[condition]} ({len(part)} sessions from the state)")
        if part:
            draw_landings(panel, part)
            panel.legend(fontsize=8, loc="lower right")
    panels[0].set_ylabel(f"landings within {WITHIN_DEG} deg\nof the caregiver's object")
    figure.suptitle("How often gaze shifts end near the caregiver's object, in pan and in tilt (bands: 95%)")
    return figure


def draw_landings(panel: Axes, part: Sequence[Trial]) -> None:
    """Share of landings near the caregiver's object over time, in pan and in tilt, with bands of 95%."""
    for axis, colour in (("pan", "#6c3483"), ("tilt", "#b7950b")):
        estimates = [mean_interval(column) for column in np.array([within(trial, axis) for trial in part]).T]
        panel.fill_between(
            MINUTES, [e.low for e in estimates], [e.high for e in estimates], color=colour, alpha=0.2, lw=0
        )
        panel.plot(MINUTES, [e.mean for e in estimates], color=colour, label=axis)
    panel.set(xlim=(0, 26), ylim=(0, 1))
    panel.grid(alpha=0.3)
