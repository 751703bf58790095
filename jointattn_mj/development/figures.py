"""Figures of a run: contingency over time (Fig. 5.3), behaviour over time (Fig. 5.5), and the learned maps."""

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
"""Colours of modules, in the order in which they were made."""
PALE = ("#7f8c8d", "#e6a5a0", "#9cc3e0", "#9ad3ae", "#e8cf8e", "#c9b1d9")
"""Colours of events without a module."""
OTHER_INK = "#d0d3d4"
"""Colour of events without a module that are not named."""
BEHAVIOUR_INKS = ("#c0392b", "#e59866", "#d63384", "#2471a3", "#7f8c8d", "#a9cce3")
WIDTH = 7.0
"""Inches; with the sizes of text below it can still be read on a phone."""
TITLE, TEXT, SMALL = 12, 10.5, 9.5
"""Sizes of text, points."""
MOST_NAMED = len(PALE)
"""Largest number of events without a module that the legend names."""
LEAST_SHARE = 1e-3
"""The logarithmic axis ends at this share of the highest value: a measure near 0 is noise, and can be negative."""
MOST_POINTS = 2000
"""Points of a curve; more cannot be told apart at this width."""
ROW, MAP_WIDTH = 0.29, 3.4
"""Inches: height of a map's row, width of a map."""
AFTER = 2
"""A figure ends after this many times the steps until the last module."""


@dataclass(frozen=True)
class Made:
    """A module, and when it was made."""

    step: int
    """Steps done when it was made."""
    event: int
    """Number of its event."""
    label: str
    """What it means."""


def draw_contingency(path: Path, log: ContingencyLog, names: Sequence[str], made: Sequence[Made], measure: str) -> None:
    """Draw the contingency of every event that was ever one of the two highest (Fig. 5.3), on a logarithmic axis.

    Args:
        path: PNG file.
        log: The measure of all events over time.
        names: (events,) in words.
        made: Modules in their order; triangles mark where they were made.
        measure: Name and unit for the axis.
    """
    last = max(1, len(log) * log.every)
    end = _end(made, last)
    few = np.unique(np.linspace(0, min(len(log), (end - 1) // log.every), MOST_POINTS).astype(int))
    few = few[few < len(log)]
    curves, steps = _curves(log, few), (few + 1) * log.every
    modelled = {module.event: number for number, module in enumerate(made)}
    others = [event for event in curves.shown if event not in modelled]
    rows = len(made) + min(len(others), MOST_NAMED + 1)
    figure = Figure(figsize=(WIDTH, 4.2 + 0.19 * rows), layout="constrained")
    axes = figure.subplots()
    positive = np.where(curves.values > 0, curves.values, np.nan)
    for number, event in enumerate(others[MOST_NAMED:]):
        label = None if number else f"{len(others) - MOST_NAMED} other events"
        axes.plot(steps, positive[:, event], lw=0.8, color=OTHER_INK, label=label, zorder=1.5)
    for event, ink in zip(others, PALE, strict=False):
        axes.plot(steps, positive[:, event], lw=1, color=ink, label=names[event], zorder=2)
    for event, number in modelled.items():
        label = f"{number + 1}: {names[event]}"
        axes.plot(steps, positive[:, event], lw=2.2, color=INKS[number % len(INKS)], label=label, zorder=3)
    above = axes.get_xaxis_transform()
    for number, module in enumerate(made):
        ink = INKS[number % len(INKS)]
        axes.axvline(module.step, color=ink, lw=0.8, ls=":", zorder=1)
        axes.plot(module.step, 1.02, "kv", ms=8, transform=above, clip_on=False, zorder=4)
        axes.text(
            module.step, 1.05, str(number + 1), transform=above, ha="center", va="bottom", color=ink, weight="bold"
        )
    if curves.highest > 0:
        axes.set_yscale("log")
        axes.set_ylim(curves.highest * LEAST_SHARE, curves.highest * 1.6)
    axes.set(xlabel=_step_label(end, last), ylabel=f"contingency: {measure}", xlim=(0, end))
    _finish(axes)
    figure.suptitle("Which events are contingent, and when each became a module", fontsize=TITLE, weight="bold")
    handles, labels = axes.get_legend_handles_labels()
    order = sorted(range(len(labels)), key=lambda at: handles[at].get_zorder(), reverse=True)  # modules first
    figure.legend(
        [handles[at] for at in order], [labels[at] for at in order], loc="outside lower center", fontsize=SMALL,
        frameon=False, title_fontsize=SMALL,
        title="sensor, action -> result; triangles and numbers: a module was made of the event",
    )  # fmt: skip
    save(figure, path)


def draw_behaviour(path: Path, series: Series, parts: Sequence[BehaviourPhase], made: Sequence[Made]) -> None:
    """Draw the rates of the six behaviours over the last WINDOW steps (Fig. 5.5), with the phases between modules.

    Args:
        path: PNG file.
        series: (steps,) the behaviour in each step.
        parts: The phases.
        made: Modules in their order.
    """
    figure = Figure(figsize=(WIDTH, 5.4), layout="constrained")
    axes = figure.subplots()
    steps_done = len(series)
    end = _end(made, steps_done)
    steps = np.unique(np.linspace(min(WINDOW, end), end, MOST_POINTS // 4).astype(int))
    rates = moving_rates(series, steps)
    for number, (short, words) in enumerate(zip(SHORT, BEHAVIOURS, strict=True)):
        axes.plot(steps, rates[:, number], color=BEHAVIOUR_INKS[number], lw=1.6, label=f"{short}  {words}")
    for detection in made:
        axes.axvline(detection.step, color="#2c3e50", lw=1, ls="--")
    for number, part in enumerate(parts):
        first, last = part.first, min(part.last, end)
        if last - first > 0.03 * end:
            axes.text(
                (first + last) / 2, 1.01, f"P{number + 1}", transform=axes.get_xaxis_transform(),
                ha="center", va="bottom", weight="bold", color="#2c3e50",
            )  # fmt: skip
    top = max(0.1, float(rates.max(initial=0)) * 1.08)
    axes.set(xlabel=_step_label(end, steps_done), ylabel=f"share of the last {WINDOW:,} steps", xlim=(0, end))
    axes.set_ylim(0, top)
    _finish(axes)
    figure.suptitle("What the robot does with its gaze as modules are added", fontsize=TITLE, weight="bold")
    handles, labels = axes.get_legend_handles_labels()
    blank = Line2D([], [], linestyle="none")
    figure.legend(
        [blank, *handles[:SC], blank, *handles[SC:]],
        ["after looking at the caregiver:", *labels[:SC], "after looking at the table:", *labels[SC:]],
        loc="outside lower center", ncols=2, columnspacing=2, fontsize=SMALL, frameon=False, title_fontsize=SMALL,
        title="dashed lines: a module was made; P1, P2, ...: the phases between",
    )  # fmt: skip
    save(figure, path)


@dataclass(frozen=True)
class MapImage:
    """A module's map with the names that it needs."""

    title: str
    module: Module
    variables: Variables


def draw_maps(path: Path, maps: Sequence[MapImage]) -> None:
    """Draw each module's map: observables down, commands across, offered commands with their reliability.

    Args:
        path: PNG file.
        maps: In the order in which the modules were made.
    """
    inches = [ROW * image.module.command.size + 1.1 for image in maps] or [1.0]
    figure = Figure(figsize=(WIDTH, sum(inches) + 1.0), layout="constrained")
    grid = figure.subplots(len(inches), 1, squeeze=False, height_ratios=inches).ravel()
    for axes in grid:
        axes.set_axis_off()
    for axes, image in zip(grid, maps, strict=False):
        axes.set_axis_on()
        _draw_map(axes, image)
    figure.suptitle("What each module does next, given what is sensed", fontsize=TITLE, weight="bold")
    if maps:
        figure.supxlabel(
            "rows: result and sensor before; columns: the command\nnumbers: its reliability (Z, eq. 5.5); blank: none",
            fontsize=SMALL,
        )
    else:
        grid[0].text(0.5, 0.5, "no module was made", ha="center", va="center", transform=grid[0].transAxes)
    save(figure, path, whole=True)


def _draw_map(axes: Axes, image: MapImage) -> None:
    results, sensors = image.module.command.shape
    event = image.module.event
    sensor, action = image.variables.sensors[event.sensor], image.variables.actions[event.action]
    result, sensed = image.variables.results[event.result], sensor.name.removesuffix(" before")
    height, width = results * sensors, len(action.values)
    command, reliability = image.module.command.ravel(), image.module.reliability.ravel()
    strength = np.full((height, width), np.nan)
    offered = command != OFFERS_NOTHING
    strength[np.arange(height)[offered], command[offered]] = reliability[offered]
    axes.imshow(strength, cmap="Reds", vmin=0, vmax=max(2 * reliability.max(), 1e-9), aspect="auto")
    for row in np.flatnonzero(offered):
        text, x, y = f"{reliability[row]:.2f}", float(command[row]), float(row)
        axes.text(x, y, text, ha="center", va="center", fontsize=SMALL, weight="bold")
    axes.set_xticks(range(width), action.values, fontsize=SMALL, rotation=0 if width <= 5 else 60)
    axes.xaxis.tick_top()
    axes.set_yticks(
        range(height),
        [f"{result.name}: {r}, {sensed}: {s}" for r in result.values for s in sensor.values],
        fontsize=SMALL,
    )
    axes.set_xticks(np.arange(width + 1) - 0.5, minor=True)
    axes.set_yticks(np.arange(height + 1) - 0.5, minor=True)
    axes.grid(which="minor", color="#bdc3c7", lw=0.6)
    axes.tick_params(which="both", length=0)
    axes.axhline(sensors - 0.5, color="#2c3e50", lw=1)
    axes.set_box_aspect(height * ROW / MAP_WIDTH)
    axes.set_anchor("N")
    axes.set_title(f"{textwrap.fill(image.title, 48)}\n{image.variables.describe(event)}", fontsize=TEXT)


@dataclass(frozen=True)
class _Curves:
    """The contingency of all events, as far as it is drawn."""

    values: np.ndarray
    """(points, events)."""
    shown: list[int]
    """Events that were among the two highest at any time, the most frequent first."""
    highest: float
    """The highest value of all, at least 0."""


def _curves(log: ContingencyLog, points: np.ndarray) -> _Curves:
    """Go through the log, a part at a time, and keep the rows ``points``."""
    kept, often, highest = list[np.ndarray](), np.zeros(log.events, np.int64), 0.0
    for first, end in spans(len(log), max(1, PART_BYTES // (8 * log.events))):
        values = log.values(first, end)
        kept.append(values[points[(points >= first) & (points < end)] - first])
        highest = np.nanmax(values, initial=highest)
        values[np.isnan(values)] = -np.inf
        for _ in range(2):
            best = values.argmax(axis=1)
            often += np.bincount(best, minlength=log.events)
            values[np.arange(len(values)), best] = -np.inf
    shown = [event for event in np.argsort(-often, kind="stable").tolist() if often[event]]
    return _Curves(np.concatenate(kept), shown, highest)


def _end(made: Sequence[Made], steps_done: int) -> int:
    """Steps at which a figure ends; long after the last module nothing new comes."""
    return min(steps_done, AFTER * made[-1].step) if made else steps_done


def _step_label(end: int, steps_done: int) -> str:
    return "steps" if end == steps_done else f"steps (the first of {steps_done:,}; no module was made later)"


def _finish(axes: Axes) -> None:
    """Grid, sizes of text, and thousands along the steps."""
    axes.xaxis.set_major_formatter(lambda value, location: f"{value:,.0f}")
    axes.tick_params(labelsize=SMALL)
    axes.xaxis.label.set_fontsize(TEXT)
    axes.yaxis.label.set_fontsize(TEXT)
    axes.locator_params(axis="x", nbins=6)
    axes.grid(alpha=0.3)
