"""The page about coded interaction, its figures and tables, as files."""

import shlex
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

from jointattn_mj.contingency.local import carriers
from jointattn_mj.io.figures import without_formulas
from jointattn_mj.io.files import write_whole
from jointattn_mj.io.page import drawn, page
from jointattn_mj.io.provenance import plain, versions
from jointattn_mj.io.results import bracket, number, share
from jointattn_mj.recordings.delays import delay_in_steps
from jointattn_mj.recordings.lags import lag_figure
from jointattn_mj.recordings.report import PAGE, RecordingReport, ReportOptions, write_tables, write_text
from jointattn_mj.recordings.report_figures import (
    MOST_ROWS,
    code_colours,
    dyad_figure,
    latency_figure,
    ranking_figure,
    timeline,
    transition_figure,
)
from jointattn_mj.recordings.report_groups import compared
from jointattn_mj.recordings.report_words import p_words, wilson

if TYPE_CHECKING:
    from jointattn_mj.recordings.measure import MeasureResult

UNIT = "bits"
MOST_TIMELINES = 40
"""Recordings whose timelines are drawn, the first ones, so that the page stays small."""
OPEN = 3
"""Timelines that are shown at once; the others unfold."""
MOST_TRANSITIONS = 12
"""Transitions in the page's table, those that stand out most; the file has all."""


def write_page(report: RecordingReport, folder: Path) -> None:
    """Write report.html, the tables and figures/*.png into a folder; the page comes last.

    Args:
        report: What was found.
        folder: Where it goes.

    Raises:
        OutputError: A file cannot be written.
    """
    names = write_tables(report, folder)
    images = {}
    for stem, figure in _figures(report).items():
        content, images[stem] = drawn(without_formulas(figure))
        (folder / "figures").mkdir(exist_ok=True)
        write_whole(folder / "figures" / f"{stem}.png", lambda path, content=content: path.write_bytes(content))  # type: ignore[misc]
    shown = [recording for recording in report.events.recordings][:MOST_TIMELINES]
    timelines = {recording: images[f"timeline_{number}"] for number, recording in enumerate(shown, 1)}
    values = {
        "report": report,
        "options": report.options,
        "images": images,
        "timelines": timelines,
        "opened": OPEN,
        "files": names,
        "ranking": report.ranking(),
        "sac": [{**row, "event": _event(row), "values": _carriers(report, row)} for row in report.events_ranked()],
        "groups": _groups(report),
        "lag_s": delay_in_steps("lag", report.options.lag, report.options.step) * report.options.step,
        "transitions": _transitions(report),
        "answers": _answers(report),
        "unanswered": _directions(report, False),
        "dyads": _of_dyads(report.pairs),
        "by_recording": _by_recording(report),
        "hidden": len(report.events.recordings) - len(shown),
        "agreement_notes": list(dict.fromkeys(note for agreed in report.agreements for note in agreed.notes())),
        "drawn_s": MOST_ROWS * report.options.row_s,
        "settings": _settings(report.options),
        "versions": versions(),
        "command": _command(report.options),
    }
    filters: dict[str, Any] = {
        "number": number,
        "with_interval": lambda row: f"{number(row['effective'])} {bracket((row['low'], row['high']))}".removesuffix(
            " -"
        ),
        "bracket": lambda row: bracket((row["low"], row["high"])),
        "two_digits": lambda ends: "-" if ends[0] != ends[0] else "[{:.2f}, {:.2f}]".format(*ends),
        "share": share,
        "short": _short,
        "decimals": lambda value: "-" if value != value else f"{value:.2f}",
        "sentence": lambda words: words[:1].upper() + words[1:],
    }
    text = page("jointattn_mj.recordings", PAGE, values, p=lambda p: p_words(p)[2:].removeprefix("= "), **filters)
    write_text(folder / PAGE, text)


def _figures(report: RecordingReport) -> dict[str, Figure]:
    options, colours = report.options, code_colours(report.events)
    figures = {
        f"timeline_{number}": timeline(
            report.attention,
            [tier for tier in report.events.tier_names if tier in report.events.tiers[recording]],
            recording,
            options.row_s,
            colours,
        )
        for number, recording in enumerate(report.events.recordings[:MOST_TIMELINES], 1)
    }
    lag_s = delay_in_steps("lag", options.lag, options.step) * options.step
    followers = options.infant, options.partner
    figures["latencies"] = latency_figure(report.attention.opportunities, followers, options.follow_within_s)
    figures["transitions"] = transition_figure(report.transitions, lag_s, options.alpha)
    pairs = [(f"{row['source']} → {row['target']}", row) for row in report.ranking()]
    figures["ranking"] = ranking_figure(pairs, "transfer entropy", UNIT)
    if report.sac:
        figures["sac"] = ranking_figure([(_event(row), row) for row in report.events_ranked()], "SAC", UNIT)
    scans = [(f"{a} → {b}", scan) for (a, b), result in report.pairs.items() for _, scan in result.scans]
    figures["lags"] = lag_figure(scans, options.step, "transfer entropy", UNIT, options.alpha)
    ways = (options.looks, options.looks[::-1])
    dyads = {pair: report.pairs[pair].dyads[0] for pair in ways if report.pairs[pair].dyads}
    if dyads:
        figures["dyads"] = dyad_figure(dyads, UNIT)
    return figures


def _transitions(report: RecordingReport) -> list[dict[str, Any]]:
    """The transitions that stand out most by their residuals, more frequent or less than by chance."""
    rows = [
        {"source": pair[0], "result": pair[1], "p_shift": None, **row}
        for pair in report.transitions
        for row in report.transition_rows(pair)
        if row["adjusted_residual"] == row["adjusted_residual"]
    ]
    return sorted(rows, key=lambda row: -abs(row["adjusted_residual"]))[:MOST_TRANSITIONS]


def _answers(report: RecordingReport) -> list[dict[str, Any]]:
    """Which look answers which: changes of looks that come more often than usual, in significant directions."""
    answers: list[dict[str, Any]] = []
    for source, target in _directions(report, True):
        result = report.pairs[source, target]
        labels = result.labels
        for value in result.measured[0].values:
            if value.before != value.result and value.contribution > 0 and value.p_adjusted <= report.options.alpha:
                low, high = wilson(value.count, value.occasions)
                answers.append(
                    {"source": source, "look": labels[source][value.sensor], "target": target,
                     "before": labels[target][value.before], "after": labels[target][value.result],
                     "count": value.count, "occasions": value.occasions,
                     "rate": value.rate, "low": low, "high": high, "usual": value.usual,
                     "contribution": value.contribution, "p_adjusted": value.p_adjusted}
                )  # fmt: skip
    return sorted(answers, key=lambda row: -row["contribution"])[:MOST_TRANSITIONS]


def _directions(report: RecordingReport, significant: bool) -> list[tuple[str, str]]:
    """Directions of looks that are significant in the ranking, or those that are not."""
    told = {(row["source"], row["target"]): row["significant"] for row in report.ranking()}
    return [pair for pair in (report.options.looks, report.options.looks[::-1]) if told[pair] == significant]


def _short(value: float) -> str:
    """Three digits; a dash for NaN."""
    return "-" if value != value else f"{value:.3g}"


def _event(row: Mapping[str, Any]) -> str:
    """``(mother, infant) → shared attention``."""
    return f"({row['sensor']}, {row['action']}) → {row['result']}"


def _carriers(report: RecordingReport, row: Mapping[str, Any]) -> list[str]:
    """The values that carry an event that is significant, in words."""
    event = row["sensor"], row["action"], row["result"]
    result = report.sac[event]
    kept = carriers(result.measured[0].values, report.options.alpha) if row["significant"] else ()
    return [value.words(event, result.labels) for value in kept]


def _groups(report: RecordingReport) -> list[dict[str, Any]]:
    """A row a value: means of the groups, and p of the comparison of all groups."""
    groups, comparisons = compared(report)
    values: dict[str, dict[str, Any]] = {}
    for row in groups:
        values.setdefault(row["value"], {"value": row["value"], "p": None, "of": {}})["of"][row["group"]] = row
    for row in comparisons[::-1]:  # the first one is of all groups, or of the only two
        values[row["value"]]["p"] = row["p"]
    return list(values.values())


def _by_recording(report: RecordingReport) -> list[dict[str, Any]]:
    """A row a recording: the transfer entropy of both directions of looks."""
    ways = [report.pairs[pair] for pair in (report.options.looks, report.options.looks[::-1])]
    if not all(way.dyads for way in ways):
        return []
    rows = [way.dyads[0].rows() for way in ways]
    return [{"name": a["recording"], "ways": [a, b]} for a, b in zip(*rows, strict=True)]


def _of_dyads(pairs: "Mapping[tuple[str, str], MeasureResult]") -> list[str]:
    """Mean values over recordings, in words."""
    named = [
        replace(dyads, measure=f"{a} → {b}")
        for (a, b), result in pairs.items()
        for dyads in (result.dyads[:1] if result.scans else ())
    ]
    return [line for dyads in named for line in dyads.lines()]


def _settings(options: ReportOptions) -> list[tuple[str, str]]:
    """Every option and its value."""
    given = plain(options)
    return [
        (field.name, "" if given[field.name] in (None, []) else str(given[field.name])) for field in fields(options)
    ]


NOT = "no-"
"""Before the name of an option that is turned off."""


def _command(options: ReportOptions) -> str:
    """The command line that makes this page again: options that are not the defaults."""
    words = ["jointattn", "recordings", str(options.file)]
    for field in fields(options):
        value = getattr(options, field.name)
        if field.name == "file" or value == field.default:
            continue
        name = field.name.replace("_", "-")
        if isinstance(value, bool):
            words.append(f"--{name}" if value else f"--{NOT}{name}")
        else:
            words += [f"--{name}", *(map(str, value) if isinstance(value, tuple) else [str(value)])]
    return shlex.join(words)
