"""The curve of a measure over lags: as rows, as words and as a figure."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jointattn_mj.contingency.scan import LagScan
from jointattn_mj.io.results import number

if TYPE_CHECKING:  # drawing takes half a second to import
    from matplotlib.figure import Figure

INK, CHANCE, BEST = "#2471a3", "#7f8c8d", "#c0392b"
WIDTH, HEIGHT = 7.0, 3.2
"""Inches of one curve."""


def lag_rows(name: str, scan: LagScan, step: float | None) -> list[dict[str, Any]]:
    """A row a lag.

    Args:
        name: Name of the measure.
        scan: What was found.
        step: Seconds of a step, if known.
    """
    times = [{} if step is None else {"lag_s": float(lag * step)} for lag in scan.lags]
    return [{"measure": name, **time, **row} for time, row in zip(times, scan.rows(), strict=True)]


def lag_words(name: str, scan: LagScan, step: float | None, alpha: float = 0.05) -> str:
    """The lag that stands out, in words.

    Args:
        name: Name of the measure.
        scan: What was found.
        step: Seconds of a step, if known.
        alpha: Level of significance.
    """
    i, lag = scan.best, int(scan.lags[scan.best])
    time = "" if step is None else f" ({lag * step:.4g} s)"
    tried = f"lags {scan.lags[0]} to {scan.lags[-1]}"
    steps = f"{lag} step{'s' * (lag != 1)}{time}"
    if scan.p_adjusted[i] > alpha:
        return f"{name}: no lag stands out among {tried} (the least p, {scan.p_adjusted[i]:.4f}, at {steps})"
    above = [int(lag) for lag, p in zip(scan.lags, scan.p_adjusted, strict=True) if p <= alpha]
    return (
        f"{name}: strongest at {steps}, effective {number(float(scan.effective[i]))}, p {scan.p_adjusted[i]:.4f} for "
        f"{tried} together; significant at {_ranges(above)}"
    )


def draw_lags(path: Path, scans: Sequence[tuple[str, LagScan]], step: float | None, title: str, unit: str) -> None:
    """Write the figure of ``lag_figure`` as PNG to ``path``.

    Args:
        path: Of the PNG file.
        scans: Name and values of each curve.
        step: Length of a step, seconds; None if it is not known.
        title: Of the figure.
        unit: Of the values.
    """
    from jointattn_mj.io.figures import save, without_formulas

    save(without_formulas(lag_figure(scans, step, title, unit)), path)


def lag_figure(
    scans: Sequence[tuple[str, LagScan]], step: float | None, title: str, unit: str, alpha: float = 0.05
) -> "Figure":
    """Draw each measure over lags, with what stays below chance at one lag and at all together.

    Args:
        scans: Names of measures and what was found.
        step: Seconds of a step, if known; then the axis is in seconds.
        title: What is measured.
        unit: Of the values, such as bits.
        alpha: Level of significance.
    """
    from matplotlib.figure import Figure

    figure = Figure((WIDTH, HEIGHT * len(scans)), layout="constrained")
    every = figure.subplots(len(scans), 1, squeeze=False)[:, 0]
    for axes, (name, scan) in zip(every, scans, strict=True):
        at = scan.lags * (step or 1)
        tries = f"chance, {scan.level:.0%} of surrogates"
        axes.fill_between(
            at, 0, scan.chance_of_all, color=CHANCE, alpha=0.18, lw=0, label=f"{tries}, all lags together"
        )
        axes.plot(at, scan.chance, color=CHANCE, lw=1, ls="--", label=f"{tries}, each lag alone")
        mean = f", mean over {scan.recordings} recordings" if scan.recordings else ""
        axes.plot(at, scan.effective, color=INK, marker="o", ms=3.5, lw=1.6, label=f"effective value{mean}")
        told = scan.p_adjusted <= alpha
        axes.plot(
            at[told], scan.effective[told], "o", color=BEST, ms=6, label=f"significant among all lags at {alpha:g}"
        )
        axes.axhline(0, color="black", lw=0.6)
        axes.set_title(f"{name}: {title}" if name not in title else title, fontsize=11, loc="left")
        axes.set_ylabel(unit)
        axes.spines[["top", "right"]].set_visible(False)
    every[-1].set_xlabel("lag from source to result (s)" if step else "lag from source to result (steps)")
    figure.legend(
        *every[0].get_legend_handles_labels(), loc="outside upper center", ncols=2, fontsize=8.5, frameon=False
    )
    return figure


def _ranges(lags: Sequence[int]) -> str:
    """``1 to 3, 7``."""
    parts: list[list[int]] = []
    for lag in sorted(lags):
        if parts and lag == parts[-1][-1] + 1:
            parts[-1].append(lag)
        else:
            parts.append([lag])
    return ", ".join(f"{part[0]} to {part[-1]}" if len(part) > 1 else str(part[0]) for part in parts)
