"""How soon the three modules are found, how surely, what is found where there is nothing, and what each part does."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import median_interval, proportion

from ..tables import STAGES, in_order
from .sweep import CHANCES, FORGETTING, PARTS, REPLACED, SETTINGS, SPOTS, STEPS

KEEPS = 0.3
"""Least rate of keeping eye contact in which gaze alternation shows; before the first module it is .12 to .17."""
NULLS = {"null/profile shows nothing": "a profile that shows nothing", "null/silent": "neither follows nor answers"}
REALTIME = {
    "realtime/state": "in real time from the state",
    "realtime/pixels": "in real time from images",
    "realtime/pixels, no cues": "in real time from images, without motion cues",
    "realtime/state, late answers": "in real time from the state, answers after .5 to 1 s",
}
LATER = {
    "later/3 spots": "3 spots",
    "later/2 spots": "2 spots, p_r .5, p_i .75",
    "later/silent": "a caregiver who neither follows nor answers",
}
ORACLES = {"oracle/random": "random gaze", "oracle/face": "at the face half of the time"}
CAREGIVERS = {
    "another temper": "a caregiver who follows is replaced by one who leads",
    "silent first": "a silent caregiver is replaced by one who follows and answers",
    "silent then": "a caregiver is replaced by a silent one",
}
RIVAL = "(Π2, A1, R2)"
"""The event that most often comes before gaze alternation where the order is another: looking away from eye contact."""
BEYOND_DOUBT = 100.0
"""Bayes factor above which an event holds."""
RIGHT = ([0, 0], [1, 3], [0, 3])
"""A pair (value of the sensor, command) that the map of each module must hold, at 3 spots: the spot that is looked at,
the face after following, and the face else."""
Results = Sequence[Mapping[str, Any]]


def results(trials: Trials, setting: str) -> list[dict[str, Any]]:
    """Results of the setting of that name; without one, of those whose names begin with it and a slash.

    Settings with the same config share their trials; each takes as many as it has runs.
    """
    names = [setting] if setting in trials else [name for name in trials if name.startswith(f"{setting}/")]
    return [trial.result for name in names for trial in trials[name][: SETTINGS[name].runs]]


def grid(trials: Trials, spots: int) -> list[dict[str, Any]]:
    """Results at tables with so many spots, all pairs of p_r and p_i together."""
    names = [f"table/{spots} spots, follow {f}, lead {p}" for f in CHANCES for p in CHANCES]
    return [trial.result for name in names for trial in trials.get(name, ())[: SETTINGS[name].runs]]


def third(runs: Results, unit: str = "turns") -> list[float]:
    """Step, or minute, of gaze alternation in each run; infinite where the three modules are not there in order."""
    return [result[unit][2] if in_order(dict(result)) else np.inf for result in runs]


def analyse(trials: Trials) -> list[Comparison]:
    """At the table, with wrong observations, where there is nothing, on images, in real time, part by part."""
    rows = list[Comparison]()
    rows += _both("at the table", results(trials, "table") if "table" in trials else [])
    for spots in SPOTS:
        rows += _both(f"{spots} spots, nine pairs of p_r, p_i", grid(trials, spots))
    for spots in (3, 6):
        rows += _both(f"3% wrong observations, {spots} spots", results(trials, f"wrong/{spots} spots"))
    for name, words in NULLS.items():
        rows += _null(words, results(trials, name), silent=name == "null/silent")
    for name, words in LATER.items():
        rows += _later(name, words, results(trials, name))
    for name, words in ORACLES.items():
        runs = results(trials, name)
        rows += [_row(f"steps that a test needs that knows the ground truth, {words}", _median(runs))] if runs else []
    for name in REPLACED:
        for kept in FORGETTING:
            rows += _replaced(name, kept, results(trials, f"replaced/{name}/{kept}"))
    for answer in ("0.5", "0"):
        rows += _answering(answer, results(trials, f"answer/{answer}"))
    for name, words in (("rendered/steady", "from images, step by step"), ("rendered/unsteady", "unsteady bodies")):
        rows += _both(words, results(trials, name))
    for name, words in REALTIME.items():
        rows += _both(words, results(trials, name), "minutes")
        rows += _behaviour(words, results(trials, name)) if "late" not in name else []
    rows += _two_hours(results(trials, "realtime/state, two hours"))
    for name in PARTS:
        rows += _both(f"2, 3 and 6 spots, {name}", results(trials, f"part/{name}"))
    return rows


def _row(what: str, ours: Any, note: str = "", dissertation: str = "not tried") -> Comparison:
    return Comparison(what, dissertation, ours, Verdict.EXTENSION, note)


def _both(words: str, runs: Results, unit: str = "turns") -> list[Comparison]:
    """Order and time of gaze alternation."""
    if not runs:
        return []
    others = [" ".join(result["modules"][:3]) or "nothing" for result in runs if not in_order(dict(result))]
    times = third(runs, unit)
    late = float(np.quantile(times, 0.9, method="higher"))
    name = "minutes" if unit == "minutes" else "step"
    return [
        _row(
            f"the three modules in order, {words}",
            proportion(len(runs) - len(others), len(runs)),
            "else " + ", ".join(sorted(set(others))) if others else "",
            "90% of ten runs",
        ),
        _row(
            f"{name} of gaze alternation (median), {words}",
            median_interval(times),
            f"nine of ten by {late:,.0f}" if np.isfinite(late) else "",
            "more than 45,000 steps in the example",
        ),
    ]


def _null(words: str, runs: Results, silent: bool) -> list[Comparison]:
    """Modules where there is nothing to find, or nothing but gaze following."""
    if not runs:
        return []
    if not silent:
        return [_row(f"any module, {words}", proportion(sum(bool(result["modules"]) for result in runs), len(runs)))]
    more = proportion(sum(result["modules"] != [STAGES[0]] for result in runs), len(runs))
    note = "such a caregiver looks at the robot between two objects only, so that having followed does say something"
    return [_row(f"modules besides gaze following, a caregiver who {words}", more, note)]


def _answering(answer: str, runs: Results) -> list[Comparison]:
    """What is found with a caregiver who seldom or never looks up after joint attention."""
    if not runs:
        return []
    rows = []
    for number, name in enumerate(("gaze following", "looking back after it")):
        right = sum(result["modules"][: number + 1] == list(STAGES[: number + 1]) for result in runs)
        rows.append(_row(f"{name} found, p_e = {answer}", proportion(right, len(runs))))
    return rows


def _median(runs: Results) -> Any:
    """Steps to the last of three events."""
    return median_interval([result["turns"][2] for result in runs])


def _later(name: str, words: str, runs: Results) -> list[Comparison]:
    """Whether what comes after the three modules, or where there seems to be nothing, is true of other steps."""
    if not runs:
        return []
    known = set(STAGES[:1] if name == "later/silent" else STAGES)
    evidence = [
        (symbol, nats)
        for result in runs
        for symbol, nats in zip(result["modules"], result["evidence"], strict=True)
        if symbol not in known
    ]
    rows = []
    if evidence:
        names = ", ".join(sorted({symbol for symbol, _ in evidence}))
        rows.append(
            _row(
                f"events beside these that hold in other steps, {words}",
                proportion(sum(nats > np.log(BEYOND_DOUBT) for _, nats in evidence), len(evidence)),
                f"{names}; evidence {np.median([nats for _, nats in evidence]):,.0f} nats (median)",
            )
        )
    pairs = [dict(zip(result["modules"], result["evidence"], strict=True)) for result in runs]
    both = [evidence for evidence in pairs if {STAGES[2], RIVAL} <= evidence.keys()]
    if both:
        higher = proportion(sum(evidence[RIVAL] > evidence[STAGES[2]] for evidence in both), len(both))
        rows.append(_row(f"more evidence of {RIVAL} than of gaze alternation, {words}", higher))
    for part, what in enumerate(("after gaze was followed", "else")):
        n, k = np.sum([result["looks"][part] for result in runs if result["modules"]], axis=0).tolist()
        rows.append(_row(f"face frontal in looks from an object, {what}, {words}", proportion(k, n)))
    return rows


def _replaced(name: str, kept: str, runs: Results) -> list[Comparison]:
    """What is found of a second caregiver, and what stays of the first."""
    if not runs:
        return []
    words = f"{CAREGIVERS[name]}, {kept} kept"
    if name == "silent first":
        right = sum(set(STAGES) <= set(result["modules"]) for result in runs)
        times = [max(result["turns"][result["modules"].index(stage)] for stage in STAGES) - STEPS // 2
                 if set(STAGES) <= set(result["modules"]) else np.inf for result in runs]  # fmt: skip
        return [
            _row(f"all three events found, {words}", proportion(right, len(runs))),
            _row(f"steps from the change to the last of them (median), {words}", median_interval(times)),
        ]
    right = sum(in_order(dict(result)) and all(RIGHT[n] in result["offers"][n] for n in (1, 2)) for result in runs)
    return [_row(f"looking back and alternation still offered at the end, {words}", proportion(right, len(runs)))]


def _behaviour(words: str, runs: Results) -> list[Comparison]:
    """Whether gaze alternation shows in behaviour."""
    kept = [result["phases"][3][2] if len(result["phases"]) > 3 else 0.0 for result in runs]
    if not kept:
        return []
    note = f"rate {np.mean([rate for rate in kept if rate]):.2f} (mean); Fig. 5.5 as reproduced: .49"
    return [
        _row(
            f"keeps eye contact after gaze alternation, {words}",
            proportion(sum(k > KEEPS for k in kept), len(kept)),
            note,
        )
    ]


def _two_hours(runs: Results) -> list[Comparison]:
    """What comes after the third module."""
    if not runs:
        return []
    right = sum(in_order(dict(result)) and len(result["modules"]) == 3 for result in runs)
    return [_row("no module but the three in two hours, from the state", proportion(right, len(runs)))]


def draw(trials: Trials) -> Mapping[str, Figure]:
    """When gaze alternation is found: at tables, and in an hour of real time; and what each part does."""
    if "table" not in trials:
        return {}
    figure = Figure(figsize=(10, 7), layout="constrained")
    (left, right), (low_left, low_right) = figure.subplots(2, 2)
    _curve(left, third([trial.result for trial in trials["table"]]), "3 spots")
    for spots in SPOTS:
        _curve(left, third(grid(trials, spots)), f"{spots} spots")
    for name, words in ORACLES.items():
        _curve(left, [result["turns"][2] for result in results(trials, name)], f"ground truth known, {words}", "--")
    left.set(xlabel="step", ylabel="share of runs", title="Gaze alternation at the table", xlim=(0, 8_000))
    for name, words in REALTIME.items():
        if name in trials:
            _curve(right, third(results(trials, name), "minutes"), words.removeprefix("in real time "))
    right.set(xlabel="simulated minutes", ylabel="share of runs", title="Gaze alternation in real time", xlim=(0, 60))
    for axes in (left, right):
        axes.set_ylim(0, 1.02)
        axes.legend(fontsize=7, loc="lower right")
        axes.grid(alpha=0.3)
    _parts(low_left, trials)
    _rates(low_right, trials)
    return {"local": figure}


def _curve(axes: Any, times: Sequence[float], label: str, line: str = "-") -> None:
    """Share of runs by time."""
    ordered = np.sort(times)
    if len(ordered):
        axes.step(
            ordered,
            (np.arange(len(ordered)) + 1) / len(ordered),
            where="post",
            label=f"{label} ({len(ordered)})".replace(", ", ",\n"),
            linestyle=line,
        )


def _parts(axes: Any, trials: Trials) -> None:
    """Order and time with one part changed."""
    names = [name for name in PARTS if results(trials, f"part/{name}")]
    for at, name in enumerate(names):
        runs = results(trials, f"part/{name}")
        share = proportion(sum(map(in_order, runs)), len(runs))
        axes.errorbar(share.mean, at, xerr=[[share.mean - share.low], [share.high - share.mean]], fmt="o", color="C0")
        median = np.median(third(runs))
        axes.text(1.03, at, f"{median:,.0f}" if np.isfinite(median) else "-", va="center", fontsize=7)
    axes.set_yticks(range(len(names)), names, fontsize=7)
    axes.invert_yaxis()
    axes.set(xlim=(0, 1.2), xlabel="runs in order; number: median step", title="One part changed (2, 3 and 6 spots)")
    axes.grid(alpha=0.3, axis="x")


def _rates(axes: Any, trials: Trials) -> None:
    """Rates of behaviour before and after the modules, in real time from images."""
    runs = [result for result in results(trials, "realtime/pixels") if len(result["phases"]) > 3]
    if runs:
        rates = np.mean([[result["phases"][0], result["phases"][3]] for result in runs], axis=0)
        columns = np.arange(rates.shape[1])
        axes.bar(columns - 0.2, rates[0], 0.4, label="before the first module")
        axes.bar(columns + 0.2, rates[1], 0.4, label="after gaze alternation")
        words = ("follows", "does not\nfollow", "keeps eye\ncontact", "shifts to\ncaregiver", "stays", "other\nspot")
        axes.set_xticks(columns, words, fontsize=7)
        axes.legend(fontsize=7)
    axes.set(ylabel="share of steps", title="What the robot does with its gaze, from images")
