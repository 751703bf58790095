"""Whether the order holds from images, what is mistaken for what, the delay, and which part's errors cost it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import mean_interval, median_interval, paired_difference, proportion

from ..tables import STAGES, in_order, time_of
from .sweep import SETTINGS

NAMES = ("FG", "SCf", "SC")
ASKED = 0.85
"""Share of runs in order that was asked for."""


def _results(trials: Trials, setting: str) -> list[dict[str, Any]]:
    return [trial.result for trial in trials.get(setting, ())]


def mixed(result: dict[str, Any]) -> float:
    """Share of the detected faces that fell into a category which mostly means another direction."""
    faces = np.array(result["faces"])[:-1, :-1]
    return float(1 - faces.max(axis=1).sum() / faces.sum())


def missed(result: dict[str, Any]) -> float:
    """Share of looks at the caregiver's face in which none was detected."""
    faces = np.array(result["faces"])
    return float(faces[-1, :-1].sum() / faces[:, :-1].sum())


def objects_wrong(result: dict[str, Any]) -> float:
    """Share of steps in which an object was detected and none was there, or the other way round."""
    objects = np.array(result["objects"])
    return float((objects[0, 1] + objects[1, 0]) / objects.sum())


ERRORS = {
    "faces in a wrong category": mixed,
    "looks at the caregiver without a face detected": missed,
    "steps with a wrong object": objects_wrong,
}
WHOLE = {"fast, centre drawn": "fast", "unsteady, centre drawn": "unsteady"}
"""The setting in which all of each image is drawn."""


def analyse(trials: Trials) -> list[Comparison]:
    """Order, times beside those at the symbolic table, errors of perception, and what drawing the centre changes."""
    findings = []
    for setting in SETTINGS:
        results = _results(trials, setting)
        if not results:
            continue
        order = proportion(sum(map(in_order, results)), len(results))
        symbolic = proportion(sum(in_order(result["symbolic"]) for result in results), len(results))
        findings.append(Comparison(
            f"FG, SCf, SC first and in this order, from images: {setting}", "asked for, never done", order,
            Verdict.EXTENSION, f"by the same seeds at the symbolic table {symbolic}",
        ))  # fmt: skip
        for stage, name in ((0, "gaze following"), (2, "gaze alternation")):
            findings.append(_time(setting, results, stage, name))
        shares = ", ".join(f"{name} {mean_interval(list(map(error, results)))}" for name, error in ERRORS.items())
        count = mean_interval([len(result["faces"]) - 1 for result in results])
        findings.append(Comparison(
            f"categories of faces where 4 would do: {setting}", "given", count, Verdict.EXTENSION, shares,
        ))  # fmt: skip
    for setting, whole in WHOLE.items():
        drawn_whole = {trial.seed: trial.result for trial in trials.get(whole, ())}
        pairs = [(t.result, drawn_whole[t.seed]) for t in trials.get(setting, ()) if t.seed in drawn_whole]
        if len(pairs) > 1:
            findings += _centre(setting, whole, pairs)
    return findings


def _centre(setting: str, whole: str, pairs: list[tuple[dict[str, Any], dict[str, Any]]]) -> list[Comparison]:
    """What comes out otherwise when only the centre of images is drawn, seed by seed.

    Args:
        setting: In which only the centre is drawn.
        whole: In which all of the image is.
        pairs: Results of both with one seed.
    """
    same = proportion(sum(first == second for first, second in pairs), len(pairs))
    findings = [Comparison(f"runs that are the same: {setting}, and {whole}", "not given", same, Verdict.EXTENSION)]
    for name, value in {"FG, SCf, SC first and in this order": in_order, **ERRORS}.items():
        off = paired_difference(*([float(value(result)) for result in side] for side in zip(*pairs, strict=True)))
        findings.append(Comparison(f"{name}: {setting}, less {whole}", "not given", off, Verdict.EXTENSION))
    return findings


def _time(setting: str, results: list[dict[str, Any]], stage: int, name: str) -> Comparison:
    """When a module was made, if all up to it came in order, and how much later than at the symbolic table."""
    first = [*STAGES[: stage + 1]]
    times = [time_of(result, stage) if result["modules"][: stage + 1] == first else np.inf for result in results]
    ratios = [at / time_of(result["symbolic"], stage) for at, result in zip(times, results, strict=True)]
    published = {0: "5,748 in the example", 2: "47,686 in the example"}[stage]
    return Comparison(
        f"step of {name} (median), from images: {setting}", published, median_interval(times),
        Verdict.EXTENSION, f"times that at the symbolic table by the same seed: {median_interval(ratios)}",
    )  # fmt: skip


def draw(trials: Trials) -> Mapping[str, Figure]:
    """When modules are made, from images and at the symbolic table; faces and their categories; order by exact part."""
    shown = [setting for setting in SETTINGS if _results(trials, setting)]
    if not shown:
        return {}
    figure = Figure(figsize=(11, 3.9), layout="constrained")
    times, confusion, order = figure.subplots(1, 3, width_ratios=(1.3, 1, 1))
    for number, setting in enumerate(name for name in ("fast", "thesis") if name in shown):
        results = _results(trials, setting)
        for stage, name in enumerate(NAMES):
            made = [
                (time_of(result["symbolic"], stage), time_of(result, stage)) for result in results if in_order(result)
            ]
            if made:
                times.plot(
                    *zip(*made, strict=True), "os^"[stage], ms=4, color=f"C{stage}",
                    mfc="none" if number else f"C{stage}", label=f"{name}, {setting}",
                )  # fmt: skip
    ends = (500, 100_000)
    times.plot(ends, ends, "k:", lw=1)
    times.set(xscale="log", yscale="log", xlim=ends, ylim=ends)
    times.set(xlabel="step at the symbolic table", ylabel="step from images", title="When each module is made")
    times.legend(fontsize=7)
    times.grid(alpha=0.3)
    _draw_confusion(confusion, _results(trials, "unsteady") or _results(trials, shown[0]))
    for location, setting in enumerate(shown):
        results = _results(trials, setting)
        share = proportion(sum(map(in_order, results)), len(results))
        order.errorbar(
            share.mean,
            -location,
            xerr=[[share.mean - share.low], [share.high - share.mean]],
            fmt="o",
            color="C0",
            capsize=3,
        )
    order.axvline(ASKED, color="k", ls=":", lw=1)
    order.set_yticks([-location for location in range(len(shown))], shown, fontsize=8)
    order.set(xlim=(0, 1.02), xlabel="share of runs in order, 95%", title="How often the order is kept")
    order.grid(alpha=0.3, axis="x")
    return {"rendered": figure}


def _draw_confusion(axes: Any, results: list[dict[str, Any]]) -> None:
    """Categories of all runs, each named after its most frequent true direction, against the true direction."""
    truths = ["spot 1", "spot 2", "spot 3", "robot", "not looked at"]
    total = np.zeros((5, 5))
    for result in results:
        faces = np.array(result["faces"])
        for row in faces[:-1]:
            total[row[:-1].argmax()] += row
        total[-1] += faces[-1]
    shares = total / total.sum(axis=0)
    axes.imshow(shares, cmap="Blues", vmin=0, vmax=1)
    for i, j in np.ndindex(shares.shape):
        axes.text(j, i, f"{shares[i, j]:.1%}" if total[i, j] else "0", ha="center", va="center", fontsize=7,
                  color="w" if shares[i, j] > 0.5 else "k")  # fmt: skip
    axes.set_xticks(range(5), truths, rotation=40, ha="right", fontsize=8)
    axes.set_yticks(range(5), [*truths[:-1], "no face"], fontsize=8)
    axes.set(
        xlabel="the caregiver looks at", ylabel="category (named by its majority)", title="What faces are taken for"
    )
