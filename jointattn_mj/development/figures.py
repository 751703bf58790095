"""Three images of a life: contingency over time (Fig. 5.3), behaviour over time (Fig. 5.5), and the learned maps."""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from jointattn_mj.contingency.online.events import Variables
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING, Module
from jointattn_mj.development.behaviour import BEHAVIOURS, SC, SHORT, WINDOW, BehaviourPhase, Series, moving_rates
from jointattn_mj.development.contingency_log import ContingencyLog
from jointattn_mj.io.figures import save
from jointattn_mj.io.rows import PART_BYTES, spans

INKS = ("#c0392b", "#2471a3", "#1e8449", "#b9770e", "#7d3c98", "#148f77", "#5d6d7e", "#d35400", "#2e4053", "#af7ac5")
"""Of modules, in the order in which they were made."""
PALE = ("#7f8c8d", "#e6a5a0", "#9cc3e0", "#9ad3ae", "#e8cf8e", "#c9b1d9")
"""Of events that never became one."""
BEHAVIOUR_INKS = ("#c0392b", "#e59866", "#d63384", "#2471a3", "#7f8c8d", "#a9cce3")
LEAST_SHARE = 1e-3
"""The logarithmic axis ends at this share of the highest value: a measure near 0 is noise, and can be negative."""
MOST_POINTS = 2000
"""Points of a curve: more than that many cannot be told apart in an image of this width."""


ROW, MAP_WIDTH = 0.27, 3.4
"""Inches: height of a map's row, width of a map."""

AFTER = 2
"""An image goes on for so many times the turns that the last module took."""


@dataclass(frozen=True)
class Made:
    """A module and its place in time."""

    step: int
    """Turns lived when it was made."""
    event: int
    """Number of its event."""
    label: str
    """What it means."""


def draw_contingency(
    path: Path, noted: ContingencyLog, names: Sequence[str], made: Sequence[Made], measure: str
) -> None:
    """Contingency of every event that was ever one of the two highest (Fig. 5.3), on a logarithmic axis.

    Args:
        path: PNG file.
        noted: The measure of all events over time.
        names: (events,) in words.
        made: Modules in their order; triangles mark where they were made.
        measure: Name and unit for the axis.
    """
    last = max(1, len(noted) * noted.every)
    end = _end(made, last)
    few = np.unique(np.linspace(0, min(len(noted), (end - 1) // noted.every), MOST_POINTS).astype(int))
    few = few[few < len(noted)]
    curves = _curves(noted, few)
    shown, n_steps = curves.shown, (few + 1) * noted.every
    figure = Figure(figsize=(9, 4 + 0.18 * -(-len(shown) // 2)), layout="constrained")
    axes = figure.subplots()
    claimed = {one.event: number for number, one in enumerate(made)}
    for event in [*(event for event in shown if event not in claimed), *claimed]:
        number = claimed.get(event)
        curve = np.where(curves.values[:, event] > 0, curves.values[:, event], np.nan)
        if number is None:
            others = len([other for other in axes.get_lines() if other.get_zorder() == 2])
            ink, dash = PALE[others % len(PALE)], ("-", "--", ":")[others // len(PALE) % 3]
            axes.plot(n_steps, curve, lw=1, ls=dash, color=ink, label=names[event], zorder=2)
        else:
            label = f"{number + 1}: {names[event]}"
            axes.plot(n_steps, curve, lw=2.2, color=INKS[number % len(INKS)], label=label, zorder=3)
    for number, one in enumerate(made):
        ink = INKS[number % len(INKS)]
        axes.axvline(one.step, color=ink, lw=0.8, ls=":", zorder=1)
        axes.plot(one.step, 1.02, "kv", ms=8, transform=axes.get_xaxis_transform(), clip_on=False, zorder=4)
        axes.text(
            one.step, 1.05, str(number + 1), transform=axes.get_xaxis_transform(), ha="center", va="bottom",
            color=ink, weight="bold",
        )  # fmt: skip
    if curves.highest > 0:
        axes.set_yscale("log")
        axes.set_ylim(curves.highest * LEAST_SHARE, curves.highest * 1.6)
    axes.set(xlabel=_step_label(end, last), ylabel=measure, xlim=(0, end))
    _thousands(axes)
    axes.grid(alpha=0.3)
    handles, labels = axes.get_legend_handles_labels()
    order = sorted(range(len(labels)), key=lambda at: handles[at].get_zorder(), reverse=True)  # modules first
    figure.legend(
        [handles[at] for at in order], [labels[at] for at in order], loc="outside lower center", ncols=2, fontsize=8,
        frameon=False, title="events that were ever one of the two highest; triangles and numbers: a module was made",
        title_fontsize=8,
    )  # fmt: skip
    save(figure, path)


def draw_behaviour(path: Path, found: Series, parts: Sequence[BehaviourPhase], made: Sequence[Made]) -> None:
    """Rates of the six behaviours over the last WINDOW turns (Fig. 5.5), with the phases between modules.

    Args:
        path: PNG file.
        found: (turns,) what each turn was.
        parts: The phases.
        made: Modules in their order.
    """
    figure = Figure(figsize=(9, 5.2), layout="constrained")
    axes = figure.subplots()
    steps_done = len(found)
    end = _end(made, steps_done)
    n_steps = np.unique(np.linspace(min(WINDOW, end), end, MOST_POINTS // 4).astype(int))
    rates = moving_rates(found, n_steps)
    for number, (short, words) in enumerate(zip(SHORT, BEHAVIOURS, strict=True)):
        axes.plot(n_steps, rates[:, number], color=BEHAVIOUR_INKS[number], lw=1.6, label=f"{short}  {words}")
    for one in made:
        axes.axvline(one.step, color="#2c3e50", lw=1, ls="--")
    for number, part in enumerate(parts):
        first, last = part.first, min(part.last, end)
        if last - first > 0.03 * end:
            axes.text(
                (first + last) / 2, 1.01, f"P{number + 1}", transform=axes.get_xaxis_transform(),
                ha="center", va="bottom", weight="bold", color="#2c3e50",
            )  # fmt: skip
    top = max(0.1, float(rates.max(initial=0)) * 1.08)
    axes.set(
        xlabel=_step_label(end, steps_done), ylabel=f"rate over the last {WINDOW:,} turns", xlim=(0, end), ylim=(0, top)
    )
    _thousands(axes)
    axes.grid(alpha=0.3)
    handles, labels = axes.get_legend_handles_labels()
    blank = Line2D([], [], linestyle="none")
    figure.legend(
        [blank, *handles[:SC], blank, *handles[SC:]],
        ["after looking at the caregiver:", *labels[:SC], "after looking at the table:", *labels[SC:]],
        loc="outside lower center", ncols=2, columnspacing=4, fontsize=9, frameon=False,
    )  # fmt: skip
    save(figure, path)


@dataclass(frozen=True)
class MapImage:
    """A module's map with the names that it needs."""

    title: str
    module: Module
    variables: Variables


def draw_maps(path: Path, maps: Sequence[MapImage]) -> None:
    """Each module's map: observables down, commands across, the commands that it offers with their reliability."""
    columns = min(2, max(1, len(maps)))
    heights = [
        max(one.module.command.size for one in maps[first : first + columns]) for first in range(0, len(maps), columns)
    ] or [2]
    inches = [ROW * height + 1.0 for height in heights]
    figure = Figure(figsize=(5.6 * columns, sum(inches) + 0.2), layout="constrained")
    grid = figure.subplots(len(heights), columns, squeeze=False, height_ratios=inches).ravel()
    for axes in grid:
        axes.set_axis_off()
    for axes, one in zip(grid, maps, strict=False):
        axes.set_axis_on()
        _draw_map(axes, one)
    if maps:
        figure.supxlabel(
            "rows: what is seen before; numbers: reliability of the offered command (Z, eq. 5.5)", fontsize=8
        )
    else:
        grid[0].text(0.5, 0.5, "no module was made", ha="center", va="center", transform=grid[0].transAxes)
    save(figure, path)


def _draw_map(axes: Axes, one: MapImage) -> None:
    results, sensors = one.module.command.shape
    event = one.module.event
    sensor, action = one.variables.sensors[event.sensor], one.variables.actions[event.action]
    result, sensed = one.variables.results[event.result], sensor.name.removesuffix(" before")
    height, width = results * sensors, len(action.values)
    command, reliability = one.module.command.ravel(), one.module.reliability.ravel()
    strength = np.full((height, width), np.nan)
    offered = command != OFFERS_NOTHING
    strength[np.arange(height)[offered], command[offered]] = reliability[offered]
    axes.imshow(strength, cmap="Reds", vmin=0, vmax=max(2 * reliability.max(), 1e-9), aspect="auto")
    for row in np.flatnonzero(offered):
        axes.text(
            float(command[row]),
            float(row),
            f"{reliability[row]:.2f}",
            ha="center",
            va="center",
            fontsize=9,
            weight="bold",
        )
    axes.set_xticks(range(width), action.values, fontsize=8, rotation=0 if width <= 5 else 60)
    axes.xaxis.tick_top()
    axes.set_yticks(
        range(height),
        [f"{result.name}: {r}, {sensed}: {s}" for r in result.values for s in sensor.values],
        fontsize=8,
    )
    axes.set_xticks(np.arange(width + 1) - 0.5, minor=True)
    axes.set_yticks(np.arange(height + 1) - 0.5, minor=True)
    axes.grid(which="minor", color="#bdc3c7", lw=0.6)
    axes.tick_params(which="both", length=0)
    axes.axhline(sensors - 0.5, color="#2c3e50", lw=1)
    axes.set_box_aspect(height * ROW / MAP_WIDTH)
    axes.set_anchor("N")
    axes.set_title(f"{textwrap.fill(one.title, 48)}\n{one.variables.describe(event)}", fontsize=9)


@dataclass(frozen=True)
class _Curves:
    """What there is to draw of the contingency of all events."""

    values: np.ndarray
    """(points, events)."""
    shown: list[int]
    """Events that were among the two highest at any time, the highest at the end first."""
    highest: float
    """The highest value of all, at least 0."""


def _curves(noted: ContingencyLog, points: np.ndarray) -> _Curves:
    """Go through all that was noted, a part at a time, and keep the rows ``points``."""
    kept, two, highest = list[np.ndarray](), set[int](), 0.0
    last = np.full((1, noted.events), np.nan)
    for first, end in spans(len(noted), max(1, PART_BYTES // (8 * noted.events))):
        values = noted.values(first, end)
        kept.append(values[points[(points >= first) & (points < end)] - first])
        highest = np.nanmax(values, initial=highest)
        values[np.isnan(values)] = -np.inf
        last = values[-1:].copy() if len(values) else last
        for _ in range(2):
            best = values.argmax(axis=1)
            two.update(best.tolist())
            values[np.arange(len(values)), best] = -np.inf
    shown = sorted(sorted(two), key=lambda event: -last[0, event])
    return _Curves(np.concatenate(kept), shown, highest)


def _end(made: Sequence[Made], steps_done: int) -> int:
    """Where an image ends: what comes long after the last module is more of the same."""
    return min(steps_done, AFTER * made[-1].step) if made else steps_done


def _step_label(end: int, steps_done: int) -> str:
    return "turns" if end == steps_done else f"turns (the first of {steps_done:,}; no module was made later)"


def _thousands(axes: Axes) -> None:
    axes.xaxis.set_major_formatter(lambda value, location: f"{value:,.0f}")
