"""In how many settings of the caregiver which modules come."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.sweeps.claim import Comparison, Trials, Verdict
from jointattn_mj.sweeps.statistics import proportion

from ..tables import STAGES, in_order
from .sweep import CHANCES

KNOWN = {
    STAGES[0]: ("C0", "FG (S1, A1, R3)"), STAGES[1]: ("C1", "SCf (Π1, A1, R1)"), STAGES[2]: ("C2", "SC (Π1, A1, R2)"),
    "(S1, A1, R2)": ("C3", "CM(1,1,2)"), "(S2, A1, R2)": ("C4", "CM(2,1,2)"),
}  # fmt: skip


def _results(trials: Trials, answer: float, follow: float, lead: float) -> list[dict[str, Any]]:
    return [trial.result for trial in trials.get(f"answer {answer} follow {follow} lead {lead}", ())]


def common(results: list[dict[str, Any]]) -> list[tuple[str, float, float]]:
    """Modules that more than half of the runs made, as in Fig. 5.4: symbol, mean and deviation of their steps."""
    times: dict[str, list[float]] = {}
    for result in results:
        for symbol, step in zip(result["modules"], result["turns"], strict=True):
            times.setdefault(symbol, []).append(step)
    rows = [(s, float(np.mean(t)), float(np.std(t))) for s, t in times.items() if len(t) > len(results) / 2]
    return sorted(rows, key=lambda item: item[1])


def analyse(trials: Trials) -> list[Comparison]:
    """Settings in which FG is first, in which all three come, and what comes instead without an answer."""
    findings = []
    for answer in (1.0, 0.75, 0.5, 0.25, 0.0):
        blocks = [results for f in CHANCES for p in CHANCES if (results := _results(trials, answer, f, p))]
        if not blocks:
            continue
        made = [[symbol for symbol, _, _ in common(results)] for results in blocks]
        first = proportion(sum(symbols[:1] == [STAGES[0]] for symbols in made), len(made))
        all_three = proportion(sum(set(STAGES) <= set(symbols) for symbols in made), len(made))
        everything = [result for results in blocks for result in results]
        ordered = proportion(sum(map(in_order, everything)), len(everything))
        known = {1.0: "most settings", 0.0: "not in general: others come under some settings"}.get(
            answer, "a high p_e promotes them"
        )
        others = proportion(sum(not set(STAGES) <= set(symbols) for symbols in made), len(made))
        holds = {1.0: Verdict.of_most(all_three), 0.0: Verdict.of_most(others)}.get(answer, Verdict.REPRODUCED)
        findings += [
            Comparison(
                f"settings in which gaze following comes first, p_e = {answer}", "most settings", first,
                Verdict.of_most(first),
            ),
            Comparison(
                f"settings with FG, SCf and SC, p_e = {answer}", known, all_three, holds,
            ),
            Comparison(
                f"runs with all three first and in order, p_e = {answer}", "not given", ordered, Verdict.EXTENSION
            ),
            Comparison(
                f"runs with looking back after following, SCf, p_e = {answer}", "more with a higher p_e",
                proportion(sum(STAGES[1] in r["modules"] for r in everything), len(everything)), Verdict.EXTENSION,
            ),
            Comparison(
                f"runs with alternation, SC, p_e = {answer}", "more with a higher p_e",
                proportion(sum(STAGES[2] in r["modules"] for r in everything), len(everything)), Verdict.EXTENSION,
            ),
        ]  # fmt: skip
        if answer == 0.0:
            for symbol in ("(S1, A1, R2)", "(S2, A1, R2)"):
                share = proportion(sum(symbol in symbols for symbols in made), len(made))
                findings.append(Comparison(
                    f"settings with {KNOWN[symbol][1]}, p_e = 0", "some settings", share,
                    Verdict.REPRODUCED if share.mean > 0 else Verdict.NOT,
                ))  # fmt: skip
    return findings


def draw(trials: Trials) -> Mapping[str, Figure]:
    """Fig. 5.4: a block for each caregiver, a bar for each module, from the mean step minus to plus one deviation."""
    figures = {}
    for answer in (1.0, 0.75, 0.5, 0.25, 0.0):
        if not any(_results(trials, answer, f, p) for f in CHANCES for p in CHANCES):
            continue
        figure = Figure(figsize=(9, 6.5), layout="constrained")
        grid = figure.subplots(5, 5, sharex=True, sharey=True)
        others: dict[str, str] = {}
        for row, follow in enumerate(reversed(CHANCES)):
            for column, lead in enumerate(CHANCES):
                axes = grid[row, column]
                for location, (symbol, mean, deviation) in enumerate(common(_results(trials, answer, follow, lead))):
                    colour = (
                        KNOWN[symbol][0] if symbol in KNOWN else others.setdefault(symbol, f"C{5 + len(others) % 5}")
                    )
                    label = (
                        "_"
                        if symbol in others and list(others).index(symbol) > 4
                        else KNOWN.get(symbol, ("", symbol))[1]
                    )
                    axes.barh(
                        location, max(2 * deviation, 800), left=mean - deviation, height=0.8, color=colour, label=label
                    )
                    axes.plot([mean, mean], [location - 0.4, location + 0.4], color="k", lw=1)
                axes.set(xlim=(0, 100_000), ylim=(5.5, -0.5), yticks=[])
                axes.set_xticks([0, 50_000, 100_000], ["0", "50k", "100k"], fontsize=7)
                if row == 4:
                    axes.set_xlabel(f"$p_i$ = {lead}", fontsize=8)
                if column == 0:
                    axes.set_ylabel(f"$p_r$ = {follow}", fontsize=8)
        handles = {label: h for axes in grid.flat for h, label in zip(*axes.get_legend_handles_labels(), strict=True)}
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=5, fontsize=7)
        figure.suptitle(
            f"When modules are made, by probabilities of the caregiver; $p_e$ = {answer} (steps, mean and deviation)",
            fontsize=10,
        )
        figures[f"caregiver_settings_{answer}"] = figure
    return figures
