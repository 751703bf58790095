"""Figures of the page about coded interaction."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from jointattn_mj.recordings.dyads import DyadResult
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.intervals import intervals_of
from jointattn_mj.recordings.joint_attention import (
    COORDINATED,
    ENGAGEMENT,
    MUTUAL,
    SHARED,
    SUPPORTED,
    GazeFollowing,
    JointAttention,
)
from jointattn_mj.recordings.sequential import LagTable

INKS = ("#4c78a8", "#f58518", "#54a24b", "#b279a2", "#e45756", "#72b7b2", "#9d755d", "#eeca3b", "#ff9da6", "#79706e")
"""Colours of codes, the most frequent first; further codes are grey."""
OTHER, POINT = "#c4c8cd", "#1c2430"
TOGETHER_INK, MUTUAL_INK = "#f6d55c", "#d81b60"
"""Shared attention, as a band behind all tiers, and mutual gaze, as a line above them."""
ENGAGED = {SUPPORTED: "#a9c9a4", COORDINATED: "#2e7d32"}
WIDTH, TIER, HEAD = 9.0, 0.26, 0.55
"""Inches: a figure's width, a tier's height, and what a row of time needs besides."""
SPARE = 0.1
"""A rest of so much of a row gets no row of its own; rows are a little longer then."""
MOST_ROWS = 60
"""Rows of time in one figure; what comes later is not drawn."""


def code_colours(events: Events) -> dict[str, str]:
    """A colour for each code, the same on all tiers and in all recordings."""
    codes, times = np.unique([str(code) for code in events.table["code"] if code is not None], return_counts=True)
    order = sorted(range(len(codes)), key=lambda i: (-times[i], codes[i]))
    return {str(codes[i]): INKS[at] if at < len(INKS) else OTHER for at, i in enumerate(order)}


def timeline(
    attention: JointAttention, tiers: Sequence[str], recording: str, row_s: float, colours: Mapping[str, str]
) -> Figure:
    """All tiers of a recording over time, with joint attention marked.

    Args:
        attention: Events with derived tiers.
        tiers: Names of the coded tiers.
        recording: Name of the recording.
        row_s: Seconds in a row; the figure has as many rows as are needed.
        colours: Of codes.
    """
    table = attention.events.select(recordings=[recording]).table
    onsets, offsets, codes, of_tier = (table[name] for name in ("onset", "offset", "code", "tier"))
    start = float(onsets.min()) if len(table) else 0.0
    stop = min(float(offsets.max()) if len(table) else row_s, start + MOST_ROWS * row_s)
    rows = max(1, int(np.ceil((stop - start) / row_s - SPARE)))
    row_s = max(row_s, (stop - start) / rows)
    shown = min(row_s, max(stop - start, 1e-3))
    figure = Figure((WIDTH, 0.75 + rows * (HEAD + TIER * (len(tiers) + 1))), layout="constrained")
    every = figure.subplots(rows, 1, squeeze=False)[:, 0]
    drawn = onsets <= stop  # of a long recording a small part
    onsets, offsets, codes, of_tier = onsets[drawn], offsets[drawn], codes[drawn], of_tier[drawn]
    shared, mutual, engaged = (
        intervals.kept(intervals.onset <= stop)
        for intervals in (intervals_of(attention.events, recording, tier) for tier in (SHARED, MUTUAL, ENGAGEMENT))
    )
    names = [*tiers, ENGAGEMENT]
    used: dict[str, str] = {}
    for row, axes in enumerate(every):
        begin = start + row * row_s
        within = (onsets < begin + row_s) & (offsets >= begin)
        together, faced, states = (
            intervals.kept((intervals.onset < begin + row_s) & (intervals.offset > begin))
            for intervals in (shared, mutual, engaged)
        )
        for onset, offset in zip(together.onset, together.offset, strict=True):
            axes.axvspan(onset, offset, color=TOGETHER_INK, alpha=0.45, lw=0, zorder=0)
        axes.hlines(np.full(len(faced), -0.62), faced.onset, faced.offset, color=MUTUAL_INK, lw=3.5, zorder=3)
        for line, tier in enumerate(tiers):
            inside = np.flatnonzero(within)
            inside = inside[of_tier[inside] == tier]
            for code in dict.fromkeys(codes[inside]):
                of_code = inside[codes[inside] == code]
                onset, length = onsets[of_code], offsets[of_code] - onsets[of_code]
                ink = colours.get(str(code), OTHER)
                used[str(code)] = ink
                lasting = length > 0
                spans = list(zip(onset[lasting], length[lasting], strict=True))
                axes.broken_barh(spans, (line - 0.36, 0.72), facecolors=ink, edgecolor="white", lw=0.3)
                axes.plot(onset[~lasting], np.full((~lasting).sum(), line), "|", color=POINT, ms=9, mew=1.2)
        for state, ink in ENGAGED.items():
            kept = states.coded(state)
            spans = list(zip(kept.onset, kept.offset - kept.onset, strict=True))
            axes.broken_barh(spans, (len(tiers) - 0.22, 0.44), facecolors=ink)
        axes.set_xlim(begin, begin + shown)
        axes.set_ylim(len(tiers) + 0.5, -0.85)
        axes.set_yticks(range(len(names)), names, fontsize=8)
        axes.tick_params(axis="y", length=0)
        axes.tick_params(axis="x", labelsize=8)
        axes.spines[["top", "right", "left"]].set_visible(False)
    every[-1].set_xlabel("time (s)", fontsize=9)
    handles = [Patch(color=used[code], label=code) for code in colours if code in used and used[code] != OTHER]
    handles += [Patch(color=OTHER, label="other codes")] if OTHER in used.values() else []
    handles += [
        Patch(color=TOGETHER_INK, alpha=0.45, label="same target (band)"),
        Patch(color=MUTUAL_INK, label="mutual gaze (line)"),
        *(Patch(color=ink, label=state) for state, ink in ENGAGED.items()),
    ]
    columns = int(np.ceil(len(handles) / np.ceil(len(handles) / 7)))
    _legend(figure, handles, loc="outside upper left", ncols=columns, fontsize=8)
    return figure


def transition_figure(tables: Mapping[tuple[str, str], LagTable], lag_s: float, alpha: float = 0.05) -> Figure:
    """What each value leads to: shares and adjusted residuals, marked where shifts say that it is more than chance.

    Args:
        tables: By source and target.
        lag_s: Seconds between the two.
        alpha: Level of significance.
    """
    size = max(max(len(table.given), len(table.target)) for table in tables.values())
    side = min(max(0.72 * size, 2.2), 7.0)
    figure = Figure((2 * side + 2.6, side + 1.3), layout="constrained")
    limit = max(float(np.nanmax(np.abs(table.adjusted_residuals), initial=1.0)) for table in tables.values())
    image = None
    for axes, ((source, target), table) in zip(
        figure.subplots(1, len(tables), squeeze=False)[0], tables.items(), strict=True
    ):
        image = axes.imshow(table.adjusted_residuals, cmap="RdBu_r", vmin=-limit, vmax=limit, aspect="auto")
        axes.set_xticks(range(len(table.target)), table.target, rotation=40, ha="right", fontsize=8)
        axes.set_yticks(range(len(table.given)), table.given, fontsize=8)
        axes.set_xlabel(f"{target}, {lag_s:.4g} s later", fontsize=9)
        axes.set_ylabel(source, fontsize=9)
        for i, j in np.ndindex(table.counts.shape):
            p = 1.0 if table.p_shift is None else float(table.p_shift[i, j])
            if table.possible[i, j] and table.conditional[i, j] == table.conditional[i, j] and size <= 12:
                strong = abs(table.adjusted_residuals[i, j]) > 0.6 * limit
                axes.text(
                    j, i, f"{table.conditional[i, j]:.2f}{'*' if p <= alpha else ''}", ha="center", va="center",
                    fontsize=8, color="white" if strong else "black",
                )  # fmt: skip
    if image is not None:
        bar = figure.colorbar(image, ax=figure.axes, shrink=0.8, pad=0.02)
        bar.set_label("adjusted residual", fontsize=8)
        bar.ax.tick_params(labelsize=8)
    return figure


def ranking_figure(rows: Sequence[tuple[str, Mapping[str, Any]]], measure: str, unit: str) -> Figure:
    """Effective values with their intervals, the most contingent on top.

    Args:
        rows: What each is of, and a row of ``RecordingReport.ranking`` or ``events_ranked``.
        measure: What is measured.
        unit: Of the values.
    """
    figure = Figure((7.5, 0.9 + 0.32 * len(rows)), layout="constrained")
    axes = figure.subplots()
    for at, (_, row) in enumerate(rows):
        ink = "#c0392b" if row["significant"] else "#7f8c8d"
        axes.plot([row["low"], row["high"]], [at, at], color=ink, lw=1.6)
        axes.plot(row["effective"], at, "o", color=ink, ms=5)
    axes.axvline(0, color="black", lw=0.6)
    axes.set_yticks(range(len(rows)), [name for name, _ in rows], fontsize=9)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.locator_params(axis="x", nbins=6)
    axes.set_xlabel(f"effective {measure} ({unit})", fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def dyad_figure(results: Mapping[tuple[str, str], DyadResult], unit: str) -> Figure:
    """Each recording's effective value, and means with their intervals over recordings: of all, or of each group.

    Args:
        results: By source and target.
        unit: Of the values.
    """
    lines = [
        (f"{a} → {b}" + (f", {group.name}" if group.name != "all" else ""), result, group)
        for (a, b), result in results.items()
        for group in result.groups[len(result.groups) > 1 :]
    ]
    figure = Figure((7.5, 1.0 + 0.45 * len(lines)), layout="constrained")
    axes = figure.subplots()
    for at, (_, result, group) in enumerate(lines):
        values = [value.corrected for value in result.of_group(group)]
        spread = np.linspace(-0.16, 0.16, len(values)) if len(values) > 1 else np.zeros(1)
        axes.plot(values, at + spread, "o", color="#4c78a8", ms=4, alpha=0.6)
        axes.plot(group.interval, [at, at], color=POINT, lw=2)
        axes.plot(group.mean, at, "D", color=POINT, ms=6)
    axes.axvline(0, color="black", lw=0.6)
    axes.set_yticks(range(len(lines)), [name for name, _, _ in lines], fontsize=9)
    axes.set_ylim(len(lines) - 0.5, -0.5)
    axes.locator_params(axis="x", nbins=6)
    axes.set_xlabel(f"effective transfer entropy ({unit}); diamond: mean and interval over recordings", fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def latency_figure(chances: Sequence[GazeFollowing], followers: Sequence[str], within_s: float) -> Figure:
    """Share of looks that were followed until so many seconds after they began.

    Args:
        chances: Looks that could be followed.
        followers: Tiers of who could follow.
        within_s: Longest latency that counts.
    """
    figure = Figure((7.5, 2.8), layout="constrained")
    axes = figure.subplots()
    handles: list[Artist] = []
    for ink, follower in zip(INKS, followers, strict=False):
        own = np.array([opportunity.latency for opportunity in chances if opportunity.follower == follower])
        if len(own):
            followed = np.sort(own[np.isfinite(own)])
            times = np.concatenate([[0.0], followed, [within_s]])
            shares = np.concatenate([[0.0], np.arange(1, len(followed) + 1), [len(followed)]]) / len(own)
            name = f"{follower} follows (n = {len(own)})"
            handles += axes.step(times, shares, where="post", color=ink, lw=1.8, label=name)
    axes.set_xlim(0, within_s)
    axes.set_ylim(0, 1)
    axes.set_xlabel("seconds after the partner began to look there", fontsize=9)
    axes.set_ylabel("share of looks followed", fontsize=9)
    if handles:
        _legend(axes, handles, fontsize=9, loc="upper left")
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def _legend(owner: Figure | Axes, handles: Sequence[Artist], **how: Any) -> None:
    """A legend with all labels: matplotlib leaves out those that begin with _ unless they are set afterwards."""
    legend = owner.legend(handles, list(map(str, range(len(handles)))), frameon=False, **how)
    for text, handle in zip(legend.get_texts(), handles, strict=True):
        text.set_text(str(handle.get_label()))
