"""How many faces and regions are told apart against what there is, by which splits, and what an agent makes of them."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import Estimate, mean_interval, median_interval, proportion

from .sweep import SETTINGS

Result = dict[str, Any]
COLOURS = {2: "#7d6608", 3: "#c0392b", 4: "#2471a3", 5: "#1e8449"}
GRID = np.geomspace(300, 40_000, 200)
NATS_PER_BIT = float(np.log(2))


def analyse(trials: Trials) -> list[Comparison]:
    """A handful of rows for each number of spots."""
    findings = []
    for setting in SETTINGS:
        results = [trial.result for trial in trials.get(setting, ())]
        if not results:
            continue
        spots = SETTINGS[setting].config.spots
        kinds = [step["kind"] for result in results for step in result["steps"]]
        exact = f"{spots + 1} exactly in {sum(faces(result) == spots + 1 for result in results)} of {len(results)}"
        findings += [
            _row(f"{setting}: face values; the caregiver looks at {spots} spots or the robot",
                 mean_interval([faces(result) for result in results]), exact),
            _row(f"{setting}: regions of gaze", mean_interval([regions(result) for result in results])),
            _row(f"{setting}: caregiver's targets with a face value of their own",
                 mean_interval([covered(result) / (spots + 1) for result in results])),
            _row(f"{setting}: faces that fall under a value that mostly means their target",
                 mean_interval([purity(result) for result in results])),
            _row(f"{setting}: steps until the last target had a value of its own (median)",
                 median_interval([settled(result, spots) for result in results])),
            _row(f"{setting}: splits for which S and A had to split together",
                 proportion(kinds.count("S and A"), len(kinds)), _first(results)),
            _row(f"{setting}: no split when the faces are shuffled",
                 proportion(sum(result["shuffled"] == 0 for result in results), len(results)),
                 f"{np.mean([result['shuffled'] for result in results]):.2f} splits a run"),
            _row(f"{setting}: preset fast then finds gaze following",
                 proportion(sum(result["found"] is not None for result in results), len(results)),
                 _agent(results, spots)),
        ]  # fmt: skip
    return findings


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Contingency against the number of values; faces against spots; steps; the regions of one robot for each table."""
    by_spots = {spots: [trial.result for trial in trials.get(f"{spots} spots", ())] for spots in COLOURS}
    by_spots = {spots: results for spots, results in by_spots.items() if results}
    if not by_spots:
        return {}
    figure = Figure(figsize=(12, 6.4), layout="constrained")
    path, count, time, plane = figure.subplots(2, 2).ravel()
    for spots, results in by_spots.items():
        colour, label = COLOURS[spots], f"{spots} spots"
        for number, result in enumerate(results):
            values = [2, *(step["faces"] + len(step["regions"]) for step in result["steps"])]
            height = [0.0, *(step["contingency"] / NATS_PER_BIT for step in result["steps"])]
            path.plot(values, height, "-", color=colour, lw=0.8, alpha=0.5, label=None if number else label)
        told = np.array([[faces_at(result, steps) for steps in GRID] for result in results])
        time.plot(GRID, told.mean(axis=0), color=colour, label=label)
        time.fill_between(GRID, *np.quantile(told, (0.1, 0.9), axis=0), color=colour, alpha=0.12, lw=0)
        time.axhline(spots + 1, color=colour, ls=":", lw=0.8)
        for which, offset, marker in ((faces, -0.06, "o"), (regions, 0.06, "s")):
            estimate = mean_interval([which(result) for result in results])
            off = [[estimate.mean - estimate.low], [estimate.high - estimate.mean]]
            name = {faces: "values of S (faces)", regions: "values of A (regions)"}[which]
            first = spots == min(by_spots)
            count.errorbar(spots + offset, estimate.mean, off, fmt=marker, ms=5, capsize=3, color=colour, mfc="none",
                           label=name if first else None)  # fmt: skip
        _draw_plane(plane, spots, results[0])
    ticks = np.arange(2, 6)
    count.plot(ticks, ticks + 1, "k:", lw=1, label="spots and the robot")
    path.set(
        xlabel="values of S and A together",
        ylabel="contingency SAC, corrected, bit",
        title="Contingency grows with resolution",
        ylim=(0, None),
    )
    count.set(
        xlabel="spots on the table (the robot is not told)",
        ylabel="values after 40,000 steps",
        title="How many values are told apart in the end",
        xticks=ticks,
    )
    time.set(
        xlabel="steps of babbling",
        ylabel="values of S (mean, 80% of runs)",
        title="How many faces are told apart over time",
        xscale="log",
    )
    plane.set(xlabel="pan, deg", ylabel="spots", yticks=list(by_spots), ylim=(1.4, 5.6))
    plane.set_title("Regions of gaze of the first robot\n(dots: spots)", fontsize=10)
    plane.invert_xaxis()
    for axes in (path, count, time):
        axes.legend(fontsize=7.5)
        axes.grid(alpha=0.3)
    return {"resolution": figure}


def faces(result: Result) -> int:
    """Number of faces that the robot tells apart; ``nothing sensed`` is not counted."""
    return len(result["confusion"])


def faces_at(result: Result, steps: float) -> int:
    """Number of faces that it told apart after so many steps of babbling."""
    return max((step["faces"] for step in result["steps"] if step["turns"] <= steps), default=1)


def regions(result: Result) -> int:
    """Number of regions to which the robot can shift its gaze; the look at the face is not counted."""
    return len(result["regions"])


def covered(result: Result) -> int:
    """Number of the caregiver's true targets that some face mostly means."""
    return len({int(np.argmax(row)) for row in result["confusion"] if np.sum(row)})


def purity(result: Result) -> float:
    """Share of faces whose value mostly means their target, of those that can have one."""
    counts = np.array(result["confusion"])
    return float(counts.max(axis=1).sum() / counts.sum())


def settled(result: Result, spots: int) -> float:
    """Steps until there were as many values of S as true targets; infinite where that never came."""
    return next((step["turns"] for step in result["steps"] if step["faces"] >= spots + 1), np.inf)


def _first(results: Sequence[Result]) -> str:
    begun = [result["steps"][0]["kind"] for result in results if result["steps"]]
    tilts = sum(step["axis"] == 1 and step["kind"] != "S" for result in results for step in result["steps"])
    return f"first split of both together in {begun.count('S and A')} of {len(begun)}; cuts through tilt: {tilts}"


def _agent(results: Sequence[Result], spots: int) -> str:
    following = [result for result in results if result["found"] is not None]
    if not following:
        return ""
    steps = np.median([result["found"] for result in following])
    right = sum(sum(result["right"]) == spots for result in following)
    first = sum(result["first"] == "(S1, A1, R3)" for result in results)
    return (
        f"after {steps:,.0f} steps more (median); its map leads right for all spots in {right} of {len(following)}; "
        f"the first event of all in {first} of {len(results)}"
    )


def _row(what: str, ours: Estimate, note: str = "") -> Comparison:
    return Comparison(what, "not tried", ours, Verdict.EXTENSION, note)


def _draw_plane(axes: Any, spots: int, result: Result) -> None:
    """The regions of one robot as a row of boxes."""
    for number, box in enumerate(result["regions"]):
        left, right = box[0]
        axes.fill_between((left, right), spots - 0.3, spots + 0.3, color=f"C{number % 10}", alpha=0.55, lw=0)
        axes.plot((left, left), (spots - 0.3, spots + 0.3), "k-", lw=0.6)
    for pan, _ in result["places"]:
        axes.plot(pan, spots, "ko", ms=4)
