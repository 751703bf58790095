"""``jointattn discover``: which events in a recording are contingent, and which values carry them."""

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from jointattn_mj.contingency.discovery import Finding, discover
from jointattn_mj.contingency.lead import LeadOptions
from jointattn_mj.contingency.names import LOCAL, OF_RECORDED_EVENTS, measure_choice
from jointattn_mj.contingency.significance import Adjust
from jointattn_mj.errors import ConfigError
from jointattn_mj.io.progress import count
from jointattn_mj.io.results import bracket, claimed_paths, number, share, write_results
from jointattn_mj.options import Real, Whole
from jointattn_mj.recordings.measure import notes_on_tests
from jointattn_mj.recordings.methods import holm_notes
from jointattn_mj.recordings.options import RecordingTestOptions
from jointattn_mj.recordings.patience import patient
from jointattn_mj.recordings.steps import Recordings

MOST_SITUATIONS = 5
"""So many are printed of the situations in which an event is contingent."""


@dataclass(frozen=True)
class DiscoverOptions(RecordingTestOptions):
    """Which events are compared, and how they are tested."""

    sensors: tuple[str, ...]
    """Columns of what is sensed, S."""
    actions: tuple[str, ...]
    """Columns of what is done, A."""
    results: tuple[str, ...]
    """Columns of what may come of it, R."""
    measure: Annotated[str, measure_choice(OF_RECORDED_EVENTS)] = "sac"
    """Measure of contingency: sac (eq. 5.2) or tc (T^C, eq. 4.3), means over all steps; or local, SAC where an event is
    surest to be contingent, so that what is rare but strong comes before what is frequent but weak."""
    correction: Adjust = "holm"
    """Correction of p for the number of events."""
    alpha: Annotated[float, Real("[1e-9, 1)")] = 0.05
    """Level of significance."""
    explain: Annotated[int, Whole("[0, 1e6]")] = 3
    """So many of the first events, if significant, also tell which values carry them."""
    local: LeadOptions = field(default_factory=LeadOptions)
    """Measure local: how situations are weighed, and what is drawn from their posterior."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (self.sensors and self.actions and self.results):
            raise ConfigError("discover needs at least one column each for `sensors`, `actions` and `results`")

    @property
    def tests(self) -> int:
        """Number of events."""
        return len(self.sensors) * len(self.actions) * len(self.results)

    @property
    def draws(self) -> int:
        """Surrogates and resamples of all tests; the measure local needs no resamples."""
        return self.surrogates * self.tests if self.measure == LOCAL.short else super().draws


@dataclass(frozen=True, repr=False)
class DiscoverResult:
    """All events, the most contingent first."""

    options: DiscoverOptions
    findings: tuple[Finding, ...]
    labels: dict[str, tuple[str, ...]]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        first = f", first {self.findings[0].event}" if self.findings else ""
        return f"DiscoverResult({len(self.findings)} events{first})"

    def rows(self) -> list[dict[str, Any]]:
        """A row an event."""
        return [
            {
                "rank": rank,
                "sensor": finding.sensor,
                "action": finding.action,
                "result": finding.result,
                "plug_in": finding.significance.value,
                "effective": finding.significance.corrected,
                "low": finding.significance.interval[0],
                "high": finding.significance.interval[1],
                "normalised": finding.normalised,
                "z": finding.significance.z,
                "p": finding.significance.p,
                "p_adjusted": finding.p_adjusted,
                "significant": finding.p_adjusted <= self.options.alpha,
                "transitions": finding.significance.transitions,
                "method": finding.significance.method,
                "inflation": finding.significance.inflation,
                **({} if finding.lead is None else {"first": finding.first, "share_of_steps": finding.lead.share}),
                "values": "; ".join(self._values(finding)),
            }
            for rank, finding in enumerate(self.findings, 1)
        ]

    def situation_rows(self) -> list[dict[str, Any]]:
        """A row an event and situation in which it is surest to be contingent, with measure local; none else."""
        return [
            {
                "rank": rank,
                "sensor": finding.sensor,
                "action": finding.action,
                "result": finding.result,
                "before": self._label(finding.result, situation.result),
                "sensed": self._label(finding.sensor, situation.sensor),
                "transitions": situation.transitions,
                "value": situation.value,
                "low": situation.interval[0],
                "high": situation.interval[1],
            }
            for rank, finding in enumerate(self.findings, 1)
            for situation in (() if finding.lead is None else finding.lead.situations)
        ]

    def text(self) -> str:
        """A table to read, and the values in words."""
        width = max(len(finding.event) for finding in self.findings)
        local = self.options.measure == LOCAL.short
        name = {"sac": "SAC", "tc": "T^C"}.get(self.options.measure, LOCAL.symbol)
        interval, part = f"{self.findings[0].significance.level:.0%} interval", "steps" if local else "share"
        first = f"{'first':>7}" if local else ""
        lines = [
            f"{'event':{width}}{name:>10}{'effective':>11}{interval:>22}{part:>9}{first}{'z':>8}{'p':>9}{'p adj.':>9}"
        ]
        for finding in self.findings:
            significance, lead = finding.significance, finding.lead
            mark = " *" if finding.p_adjusted <= self.options.alpha else ""
            parts = f"{share(finding.normalised if lead is None else lead.share):>9}"
            lines.append(
                f"{finding.event:{width}}{number(significance.value):>10}{number(significance.corrected):>11}{bracket(significance.interval):>22}"
                f"{parts}{'' if finding.first is None else f'{finding.first:7.0%}'}"
                f"{significance.z:8.1f}{significance.p:9.4f}{finding.p_adjusted:9.4f}{mark}"
            )
        for finding in self.findings:
            if finding.values:
                lines += ["", f"{finding.event} is carried by", *(f"  {words}" for words in self._values(finding))]
                lines += self._where(finding)
        how = {"holm": "by Holm", "benjamini_hochberg": "by Benjamini and Hochberg", "none": "not corrected"}
        adjusted = how[self.options.correction]
        if local:
            lines += [
                "",
                f"{LOCAL.symbol}: mean of the posterior where an event is surest to be contingent; steps: their share.",
                "effective: less the mean of surrogates of the sensor; first: probability that it is the highest.",
            ]
        lines += [
            "",
            f"* significant at {self.options.alpha:g}; p adj.: for {count(self.options.tests, 'event')}, {adjusted}.",
        ]
        return "\n".join([*lines, *(f"Note: {note}." for note in self.notes)])

    def _where(self, finding: Finding) -> list[str]:
        """In which situations it is contingent, and how much; of many the first."""
        some = () if finding.lead is None else finding.lead.situations
        lines = [
            f"  {finding.result} {self._label(finding.result, where.result)}, {finding.sensor} "
            f"{self._label(finding.sensor, where.sensor)}: {number(where.value)} {bracket(where.interval)} "
            f"in {where.transitions} steps"
            for where in some[:MOST_SITUATIONS]
        ]
        more = len(some) - len(lines)
        return [*(["and is contingent where"] if some else []), *lines, *([f"  and in {more} others"] if more else [])]

    def _label(self, name: str, value: int) -> str:
        labels = self.labels.get(name)
        return labels[value] if labels else str(value)

    def _values(self, finding: Finding) -> list[str]:
        return [value.words((finding.sensor, finding.action, finding.result), self.labels) for value in finding.values]


def run_discover(
    options: DiscoverOptions, progress: Callable[[int], object] = lambda done: None, coded: Recordings | None = None
) -> DiscoverResult:
    """Read the file, measure and test every event; ``progress`` is told of surrogates and resamples as they are drawn.

    ``coded`` is what the file has, where it is read already.

    Args:
        options: Events, tests, and where the results go.
        progress: Is told of surrogates and resamples as they are drawn.
        coded: What the file has, where it is read already.

    Raises:
        SeriesError: The file or a column cannot be measured.
        ConfigError: The surrogates would take more than half an hour, and ``yes`` is not said.
        OutputError: ``out`` is there already, is about to be, or cannot be written.
    """
    with nullcontext() if options.out is None else claimed_paths(options.out, "events") as paths:
        return _run(options, progress, coded, paths)


def _run(
    options: DiscoverOptions,
    progress: Callable[[int], object],
    coded: Recordings | None,
    paths: tuple[Path, Path] | None,
) -> DiscoverResult:
    """Measure, test, and write where ``paths`` says."""
    coded = coded or options.read(options.file, [*options.sensors, *options.actions, *options.results])
    findings = discover(
        coded.columns,
        options.sensors,
        options.actions,
        options.results,
        measure=options.measure,
        options=options.test(),
        how=options.correction,
        alpha=options.alpha,
        base=options.base,
        seed=options.seed,
        explain=options.explain,
        groups=coded.groups,
        timing=options.timing(coded.step),
        progress=patient(progress, options.draws, options.yes),
        lead=options.local,
    )
    tested = [(finding.event, finding.significance) for finding in findings]
    notes = [*coded.notes(), *notes_on_tests(tested, options.method, options.surrogates)]
    if options.correction == "holm":
        drawn = max(finding.significance.surrogates for finding in findings)
        least = [1 / (finding.significance.surrogates + 1) for finding in findings]
        notes += holm_notes("event", least, drawn, options.surrogates, options.alpha)
    result = DiscoverResult(options, findings, coded.labels, tuple(notes))
    if paths is not None:
        situations = {"situations": result.situation_rows()} if options.measure == LOCAL.short else {}
        write_results(paths, result.rows(), options, notes=result.notes, **situations)
    return result
