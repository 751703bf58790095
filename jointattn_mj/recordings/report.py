"""``jointattn recordings``: one page about coded interaction, from the files of a coding program."""

import csv
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, TypeVar

import numpy as np
import tyro

from jointattn_mj.contingency.significance import Method, adjust
from jointattn_mj.errors import ConfigError, OutputError
from jointattn_mj.io.files import held, write_whole
from jointattn_mj.io.progress import count
from jointattn_mj.io.provenance import plain, versions
from jointattn_mj.io.results import without_nan
from jointattn_mj.options import NotNegative, Real, Seed, Whole, warn_renamed
from jointattn_mj.recordings.agreement import Agreement, AgreementOptions, agreement
from jointattn_mj.recordings.delays import check_delay, delay_in_steps
from jointattn_mj.recordings.dyads import LEAST_P
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.groups import GroupOptions, groups_of
from jointattn_mj.recordings.joint_attention import (
    MUTUAL,
    SHARED,
    JointAttention,
    JointAttentionRules,
    joint_attention,
    without_gaps,
)
from jointattn_mj.recordings.measure import (
    ENOUGH_RECORDINGS,
    MeasureOptions,
    MeasureResult,
    notes_on_tests,
    run_measure,
)
from jointattn_mj.recordings.methods import holm_notes
from jointattn_mj.recordings.reader import ReadOptions, read
from jointattn_mj.recordings.sampling import SampleOptions
from jointattn_mj.recordings.sequential import LagTable, OverRecordings, SequentialOptions, lag_table, yules_q_over
from jointattn_mj.recordings.steps import Recordings

PAGE = "report.html"


@dataclass(frozen=True, kw_only=True)
class ReportOptions(ReadOptions, JointAttentionRules, GroupOptions):
    """What is read, what counts as joint attention, and how contingency is tested."""

    file: tyro.conf.Positional[Path] = field(kw_only=False)
    """A folder of event files, each a recording, or one such file."""
    out: Path
    """Folder for the page and its tables."""
    step: Annotated[float, Real("[1e-3, 1e3]")] = 0.1
    """Events are sampled to steps of so many seconds."""
    tiers: tuple[str, ...] = ()
    """Tiers to rank by how much each says about the others; by default all."""
    sensors: tuple[str, ...] = ()
    """Tiers of what is sensed, for events by their SAC (eq. 5.2); by default the partner's looks."""
    actions: tuple[str, ...] = ()
    """Tiers of what is done, likewise; by default the infant's looks."""
    results: tuple[str, ...] = ()
    """Tiers of what may come of it, likewise; by default the others, mutual gaze and shared attention."""
    lag: str = "0.5s"
    """From the earlier to the later look, in steps or as a time: about what an answer takes."""
    scan: str = "3s"
    """Longest lag of the curve, in steps or as a time."""
    second: Path | None = None
    """A second coder's file or folder of the same recordings, for kappa."""
    tolerance_s: Annotated[float, Real("[0, 60]")] = 0.0
    """Two coders agree if the other has the same code within so many seconds."""
    surrogates: Annotated[int, Whole("[1, 1e9]")] = 1000
    """Surrogates behind effective values and p."""
    resamples: Annotated[int, Whole("[0, 1e9]")] = 500
    """Bootstrap resamples behind intervals; 0 leaves these out."""
    method: Method = "auto"
    """How surrogates are made, as for measure."""
    alpha: Annotated[float, Real("[1e-9, 1)")] = 0.05
    """Level of significance."""
    seed: Seed = 0
    """Random seed of surrogates and resamples."""
    row_s: NotNegative = 120.0
    """Seconds in a row of a timeline."""
    title: str = "Coded interaction"
    """Title of the page."""
    yes: bool = False
    """Go on however long the surrogates take."""

    ADVANCED: ClassVar[Sequence[str]] = ("resamples", "alpha", "row_s", "yes", "sensors", "actions", "results")

    def __post_init__(self) -> None:
        super().__post_init__()
        check_delay("lag", self.lag)
        check_delay("scan", self.scan)
        if self.row_s < 1:
            raise ConfigError(f"row_s: expected at least 1 second in a row; got {self.row_s:g}")
        delay_in_steps("lag", self.lag, self.step)
        given = {*(self.sensors or (self.partner,)), *(self.actions or (self.infant,))} & set(self.results)
        if given:
            raise ConfigError(f"results: {min(given)!r} is a sensor or an action, too; its own past says what it says")

    @property
    def rules(self) -> JointAttentionRules:
        """What counts as joint attention."""
        return JointAttentionRules(**{field.name: getattr(self, field.name) for field in fields(JointAttentionRules)})

    @property
    def looks(self) -> tuple[str, str]:
        """The two tiers of looks, the partner's first."""
        return self.partner, self.infant

    @property
    def lags(self) -> int:
        """Longest lag in steps."""
        return delay_in_steps("scan", self.scan, self.step)


Of = TypeVar("Of")
Event = tuple[str, str, str]
"""Tiers of what is sensed, of what is done and of what comes of it."""


@dataclass(frozen=True, repr=False)
class RecordingReport:
    """What the page shows."""

    options: ReportOptions
    events: Events
    """As they were read."""
    attention: JointAttention
    steps: Recordings
    pairs: Mapping[tuple[str, str], MeasureResult]
    """Transfer entropy from the one tier to the other, at the lag. From three recordings on, each has a value too."""
    p_adjusted: Mapping[tuple[str, str], float]
    """By Holm, for all pairs."""
    sac: Mapping[Event, MeasureResult]
    """SAC of events: sensor, action and result, at the lag."""
    p_of_events: Mapping[Event, float]
    """By Holm, for all events."""
    transitions: Mapping[tuple[str, str], LagTable]
    """What the looks of the one lead to in the other, both ways."""
    agreements: tuple[Agreement, ...]
    notes: tuple[str, ...]
    """What was left out, and why; where p-values come from."""
    over_recordings: Mapping[tuple[str, str], OverRecordings] = field(default_factory=dict)
    """Yule's Q recording by recording, where there are several."""
    group_of: Mapping[str, str] | None = None
    """Group of each recording, if recordings are compared."""
    out: Path | None = None
    """Where it was written."""

    def __repr__(self) -> str:
        where = "" if self.out is None else f", in {self.out}"
        return f"RecordingReport({len(self.attention.seconds)} recordings, {len(self.pairs)} pairs of tiers{where})"

    @property
    def found(self) -> Mapping[Event, MeasureResult]:
        """Old name of ``sac``."""
        warn_renamed("RecordingReport.found", "sac")
        return self.sac

    def text(self) -> str:
        """The main values, to read on a terminal."""
        page = [] if self.out is None else [f"Page: {self.out / PAGE}"]
        reach = [*self.out_of_reach("pair of tiers"), *self.out_of_reach("event"), *self.groups_out_of_reach()]
        return "\n".join([*self.main(), *(f"Note: {note}." for note in reach), *page])

    def main(self) -> list[str]:
        """A sentence for each main value."""
        return [*self.following(), *self.over_lags(), *self._agreement()]

    def ranking(self) -> list[dict[str, Any]]:
        """A row a pair of tiers, the most contingent first."""
        rows = [
            {"source": source, "target": target, **self._tested(result, self.p_adjusted[source, target])}
            for (source, target), result in self.pairs.items()
        ]
        return sorted(rows, key=lambda row: (-row["effective"], row["source"], row["target"]))

    def events_ranked(self) -> list[dict[str, Any]]:
        """A row an event, the one of the highest SAC first."""
        rows = [
            {"sensor": event[0], "action": event[1], "result": event[2],
             **self._tested(result, self.p_of_events[event])}
            for event, result in self.sac.items()
        ]  # fmt: skip
        return sorted(rows, key=lambda row: (-row["effective"], row["sensor"], row["action"], row["result"]))

    def _tested(self, result: MeasureResult, p_adjusted: float) -> dict[str, Any]:
        return {
            **_value(result),
            "p_adjusted": p_adjusted,
            "significant": bool(p_adjusted <= self.options.alpha),
        }

    def tables(self) -> dict[str, list[dict[str, Any]]]:
        """All tables by the names of their files."""
        columns = self.event_columns()
        return {
            **self.results(),
            "events": [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)],
        }

    def event_columns(self) -> dict[str, np.ndarray]:
        """Columns of the table of events, with the derived ones."""
        events = self.attention.events.table
        return {name: events[name] for name in ("recording", "tier", "code", "onset", "offset")}

    def results(self) -> dict[str, list[dict[str, Any]]]:
        """All tables but that of the events, which may be millions."""
        from jointattn_mj.recordings.report_groups import compared

        pairs = self.pairs.items()
        groups, comparisons = compared(self)

        def named(pair: tuple[str, str], rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
            return [{"source": pair[0], "target": pair[1], **row} for row in rows]

        return {
            "joint_attention": self.attention.rows(),
            "following": [vars(opportunity) for opportunity in self.attention.opportunities],
            "ranking": self.ranking(),
            "lags": [row for pair, result in pairs for row in named(pair, result.lag_rows())],
            "values": [row for pair, result in pairs for row in named(pair, _first_measure(result.value_rows()))],
            "sac": self.events_ranked(),
            "sac_values": [
                {"event": f"({s}, {a}) -> {r}", **row}
                for (s, a, r), result in self.sac.items()
                for row in result.value_rows()
            ],
            "dyads": [row for pair, result in pairs for row in named(pair, result.dyad_rows())],
            "groups": groups,
            "comparisons": comparisons,
            "transitions": [row for pair in self.transitions for row in named(pair, self.transition_rows(pair))],
            "agreement": [agreed.row() for agreed in self.agreements],
        }

    def transition_rows(self, pair: tuple[str, str]) -> list[dict[str, Any]]:
        """A row a transition of a pair of tiers, with means over recordings where there are several."""
        table = self.transitions[pair]
        if pair not in self.over_recordings:
            return table.rows()
        more = self.over_recordings[pair].rows(table.possible)
        return [{**row, **means} for row, means in zip(table.rows(), more, strict=True)]

    def methods(self) -> str:
        """A paragraph to paste: what was done, with every number and setting."""
        from jointattn_mj.recordings.report_words import methods_paragraph

        return methods_paragraph(self)

    def out_of_reach(self, what: Literal["pair of tiers", "event"]) -> list[str]:
        """Why no pair of tiers, or no event, can be significant: there are too few surrogates for so many of them."""
        results = (self.pairs if what == "pair of tiers" else self.sac).values()
        drawn = [result.measured[0].significance.surrogates for result in results]
        least = [
            LEAST_P if result.dyads and result.dyads[0].groups[0].dyads > 1 else 1 / (1 + surrogates)
            for result, surrogates in zip(results, drawn, strict=True)
        ]
        return holm_notes(what, least, max(drawn, default=0), self.options.surrogates, self.options.alpha)

    def all_notes(self) -> list[str]:
        """What was left out and why, where p-values come from, and what is out of their reach."""
        reach = [*self.out_of_reach("pair of tiers"), *self.out_of_reach("event"), *self.groups_out_of_reach()]
        return list(dict.fromkeys([*self.notes, *reach]))

    def groups_out_of_reach(self) -> list[str]:
        """Why groups of recordings cannot differ significantly: there are too few recordings."""
        return [
            note for dyad in self.pairs[self.options.looks].dyads[:1] for note in dyad.out_of_reach(self.options.alpha)
        ]

    def following(self) -> list[str]:
        """Who follows whom, how often and how soon."""
        lines = []
        for follower, leader in ((self.options.infant, self.options.partner), self.options.looks):
            chances = [opportunity for opportunity in self.attention.opportunities if opportunity.follower == follower]
            latencies = [opportunity.latency for opportunity in chances if opportunity.latency == opportunity.latency]
            if chances:
                median = f", median latency {np.median(latencies):.2f} s" if latencies else ""
                lines.append(
                    f"{follower} follows {len(latencies)} of {count(len(chances), 'look')} of {leader} "
                    f"({len(latencies) / len(chances):.0%}) within {self.options.follow_within_s:g} s{median}"
                )
        return lines

    def over_lags(self) -> list[str]:
        """The lag that stands out, in both directions of looks."""
        from jointattn_mj.recordings.lags import lag_words

        lines = []
        for pair in (self.options.looks, self.options.looks[::-1]):
            result = self.pairs[pair]
            lines += [
                lag_words(f"{pair[0]} -> {pair[1]}", scan, result.step, self.options.alpha) for _, scan in result.scans
            ]
        return lines

    def _agreement(self) -> list[str]:
        return [f"Two coders, {agreed.tier}: kappa {agreed.kappa:.2f}" for agreed in self.agreements]


def run_report(
    options: ReportOptions, progress: Callable[[int], object] = lambda done: None, source: Any = None
) -> RecordingReport:
    """Read the files, analyse them, and write the page and its tables.

    Args:
        options: What is read, how it is analysed, and where the page goes.
        progress: Called with the number of surrogates and resamples drawn since the last call.
        source: A table of pandas, polars or pyarrow in place of ``options.file``.

    Raises:
        SeriesError: The files cannot be read or analysed.
        ConfigError: The surrogates would take more than half an hour, and ``yes`` is not said.
        OutputError: ``out`` holds a report, or cannot be written.
    """
    from jointattn_mj.recordings.report_page import write_page

    if (options.out / PAGE).exists():
        raise OutputError(f"{options.out / PAGE} is there already; choose another folder")
    reading = {field.name: getattr(options, field.name) for field in fields(ReadOptions)}
    coding = replace(read(options.file if source is None else source, **reading), by=options.group_columns)
    events, group_of = coding.events, groups_of(options, coding)
    second = None if options.second is None else read(options.second, **reading).events
    new = not options.out.exists()
    try:
        with held(options.out):
            report = analyse(events, second, options, progress, group_of)
            write_page(report, options.out)
    except BaseException:
        if new:
            with suppress(OSError):  # something is in it
                options.out.rmdir()
        raise
    return report


def analyse(
    events: Events,
    second: Events | None,
    options: ReportOptions,
    progress: Callable[[int], object],
    group_of: Mapping[str, str] | None = None,
) -> RecordingReport:
    """All that the page shows.

    Args:
        events: What is coded.
        second: The same, by a second coder.
        options: How it is analysed.
        progress: Called with the number of surrogates and resamples drawn since the last call.
        group_of: Group of each recording by its name, where recordings are compared.

    Raises:
        SeriesError: A tier is not there, or the events cannot be sampled or measured.
    """
    attention = joint_attention(events, options.rules)
    how = {field.name: getattr(options, field.name) for field in fields(SampleOptions)}
    tiers = list(dict.fromkeys([*options.looks, *(options.tiers or events.tier_names)]))
    asked = _events(options, tiers)
    every = dict.fromkeys([*tiers, *(tier for event in asked for tier in event)])
    steps = without_gaps(attention).steps(options.step, every, **how)
    still = [tier for tier in every if tier not in options.looks and len(steps.labels[tier]) == 1]
    tiers = [tier for tier in tiers if tier not in still]
    asked = [event for event in asked if not set(event) & set(still)]

    def measured(source: str, target: str, action: str | None = None) -> MeasureResult:
        of_looks = action is None and {source, target} == set(options.looks)
        how = MeasureOptions(
            options.file, source=(source,), target=(target,), condition=() if action is None else (action,),
            measures=("te",) if action is None else ("sac",), lag=options.lag, method=options.method,
            scan=options.scan if of_looks else None, by=options.by, groups=options.groups,
            surrogates=options.surrogates, resamples=options.resamples, seed=options.seed, yes=options.yes,
        )  # fmt: skip
        return run_measure(how, progress, steps, group_of)

    pairs = {(source, target): measured(source, target) for source in tiers for target in tiers if source != target}
    sac = {(sensor, action, result): measured(sensor, result, action) for sensor, action, result in asked}
    lag = delay_in_steps("lag", options.lag, options.step)
    sequential = SequentialOptions(lag=lag, surrogates=options.surrogates, seed=options.seed)
    transitions = {pair: lag_table(steps, *pair, sequential) for pair in (options.looks, options.looks[::-1])}
    several = len(set(steps.groups)) >= ENOUGH_RECORDINGS
    over = {pair: yules_q_over(steps, *pair, sequential) for pair in transitions} if several else {}
    agreements: tuple[Agreement, ...] = ()
    if second is not None:
        same = AgreementOptions(
            step=options.step, tolerance_s=options.tolerance_s, resamples=options.resamples, seed=options.seed
        )
        agreements = agreement(events, second, None, same)
    named = {
        **{f"{source} -> {target}": result for (source, target), result in pairs.items()},
        **{f"({sensor}, {action}) -> {result}": tested for (sensor, action, result), tested in sac.items()},
    }
    left_out = [f"tier {tier!r} is not ranked, as it has the same value in all steps" for tier in still]
    notes = dict.fromkeys([*steps.notes(), *left_out, *_notes(named, options), *_font_notes(events)])
    return RecordingReport(
        options, events, attention, steps, pairs, _adjusted(pairs), sac, _adjusted(sac), transitions, agreements,
        tuple(notes), over, group_of, options.out,
    )  # fmt: skip


def _notes(results: Mapping[str, MeasureResult], options: ReportOptions) -> list[str]:
    """Notes on all results: on tests once for all of them together, then what else is said of any."""
    asked = options.method, options.surrogates
    tested = {name: result.measured[0].significance for name, result in results.items()}
    alone = {
        note
        for test in tested.items()
        for note in notes_on_tests([(results[test[0]].measured[0].name, test[1])], *asked)
    }
    every = (note for result in results.values() for note in result.notes)
    return [*notes_on_tests(list(tested.items()), *asked), *(note for note in every if note not in alone)]


def _font_notes(events: Events) -> list[str]:
    """Which characters of tiers and codes the figures cannot show."""
    from jointattn_mj.io.figures import without_font  # drawing takes half a second to import

    codes = (code for code in events.table.arrow["code"].unique().to_pylist() if code)
    boxes = without_font([*events.tier_names, *codes])
    if not boxes:
        return []
    return [
        f"no font of this computer has {' '.join(boxes[:10])}{' ...' if len(boxes) > 10 else ''}: PNG figures show "
        "boxes in their place. Install one, such as Noto Sans CJK"
    ]


def _events(options: ReportOptions, tiers: Sequence[str]) -> list[Event]:
    """Events whose SAC is ranked."""
    sensors, actions = options.sensors or (options.partner,), options.actions or (options.infant,)
    others = [tier for tier in (*tiers, MUTUAL, SHARED) if tier not in (*sensors, *actions)]
    return [
        (sensor, action, result)
        for sensor in sensors
        for action in actions
        if sensor != action
        for result in options.results or others
    ]


def _adjusted(results: Mapping[Of, MeasureResult]) -> dict[Of, float]:
    """p of each, corrected by Holm for their number."""
    p = adjust([_value(result)["p"] for result in results.values()], "holm")
    return dict(zip(results, map(float, p), strict=True))


def _value(result: MeasureResult) -> dict[str, Any]:
    """Transfer entropy: of several recordings their mean, with an interval over recordings; else of all steps."""
    row = result.rows()[0]
    told = {name: row[name] for name in ("effective", "low", "high", "p")}
    if result.dyads:
        every = result.dyads[0].groups[0]
        told = {"effective": every.mean, "low": every.interval[0], "high": every.interval[1], "p": every.p}
    unit = count(result.dyads[0].groups[0].dyads, "recording") if result.dyads else "all steps"
    return {**told, "of": unit, "all_steps": row["effective"], "transitions": row["transitions"],
            "method": row["method"], "inflation": row["inflation"]}  # fmt: skip


def _first_measure(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows of the first measure, transfer entropy."""
    return [row for row in rows if row["measure"] == rows[0]["measure"]]


def write_tables(report: RecordingReport, folder: Path) -> list[str]:
    """Write each table that has rows as CSV, and all of them with settings and versions as report.json.

    Returns:
        Names of the files.
    """
    tables = {name: rows for name, rows in report.results().items() if rows}
    for name, rows in tables.items():
        names = list(dict.fromkeys(key for row in rows for key in row))
        _write_csv(folder / f"{name}.csv", names, ([row.get(key, "") for key in names] for row in rows))
    events = report.event_columns()
    _write_csv(folder / "events.csv", list(events), zip(*events.values(), strict=True))
    document = {
        "config": plain(report.options), "versions": versions(), "main": report.main(), "methods": report.methods(),
        "notes": report.all_notes(), **plain(tables),
    }  # fmt: skip
    write_text(folder / "report.json", json.dumps(without_nan(document), indent=1, ensure_ascii=False) + "\n")
    write_text(folder / "methods.txt", report.methods() + "\n")
    return [*(f"{name}.csv" for name in (*tables, "events")), "report.json", "methods.txt"]


def _write_csv(path: Path, names: Sequence[str], rows: Iterable[Iterable[Any]]) -> None:
    def write(temporary: Path) -> None:
        with temporary.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(names)
            writer.writerows(rows)

    write_whole(path, write)


def write_text(path: Path, text: str) -> None:
    """Write a text file, whole or not at all."""
    write_whole(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))
