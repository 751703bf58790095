"""``jointattn measure``: how much one recorded variable says about what another does next."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from jointattn_mj.contingency.granger import linear_granger
from jointattn_mj.contingency.information import (
    COMBINED,
    CONDITIONAL_MUTUAL,
    CONTINGENCY,
    MUTUAL,
    TRANSFER,
    Measure,
)
from jointattn_mj.contingency.lagged import timed
from jointattn_mj.contingency.local import LocalContingency, carriers, local_of_steps
from jointattn_mj.contingency.names import NAMES, full_name, measure_choice
from jointattn_mj.contingency.scan import LagScan, scan_steps
from jointattn_mj.contingency.series import check_base
from jointattn_mj.contingency.significance import MEASURES, Significance, TestOptions, assess_measures
from jointattn_mj.contingency.table import Steps, steps
from jointattn_mj.errors import ConfigError, SeriesError
from jointattn_mj.io.results import bracket, claimed_paths, number, share, write_results
from jointattn_mj.options import Whole
from jointattn_mj.recordings.delays import check_delay, delay_in_steps, lag_title
from jointattn_mj.recordings.dyads import DyadResult, by_dyad, scan_over_dyads
from jointattn_mj.recordings.groups import GroupOptions, groups_of
from jointattn_mj.recordings.lags import draw_lags, lag_rows, lag_words
from jointattn_mj.recordings.methods import WORDS, method_notes
from jointattn_mj.recordings.options import RecordingTestOptions
from jointattn_mj.recordings.patience import patient
from jointattn_mj.recordings.reader import Coding
from jointattn_mj.recordings.steps import Recordings

ALONE = (TRANSFER, MUTUAL)
CONDITIONED = (CONTINGENCY, COMBINED, TRANSFER, MUTUAL, CONDITIONAL_MUTUAL)
Over = Literal["auto", "recordings", "steps"]
ENOUGH_RECORDINGS = 3
"""Recordings from which on ``auto`` has values for each."""
ALPHA = 0.05
"""Measures with a higher p are not told value by value."""
MOST_COMBINATIONS = 100_000
"""Of more combinations of values none is tested."""


@dataclass(frozen=True)
class MeasureOptions(RecordingTestOptions, GroupOptions):
    """What is measured, and how it is tested."""

    source: tuple[str, ...]
    """Column whose influence is asked for, such as a sensor; several are taken jointly."""
    target: tuple[str, ...]
    """Column that may be influenced, the result."""
    condition: tuple[str, ...] = ()
    """Column that is known anyway, such as an action: gives T^C (eq. 4.3) and SAC (eq. 5.2) too."""
    measures: tuple[Annotated[str, measure_choice(name.short for name in NAMES)], ...] = ()
    """Which measures: te, mi, and with a condition sac, tc, cmi. None named: all of these, and linear Granger."""
    scan: str | None = None
    """Also measure at all lags from 1 to this one, in steps or as a time such as 3s, and correct p for their number."""
    over: Over = "auto"
    """Values for each recording, and their mean with an interval over recordings: recordings. steps: only all steps
    together. auto: recordings where there are at least 3."""
    explain: Annotated[int, Whole("[0, 1e6]")] = 3
    """So many values of each measure that is significant at .05 are told: which value of the source brings which result
    about."""

    ADVANCED: ClassVar[Sequence[str]] = ("over", "explain")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.scan is not None:
            check_delay("scan", self.scan)
        without = [measure.name for measure in self._named if measure not in self._possible]
        if without:
            raise ConfigError(f"`measures` names {without[0]}, which needs a `condition`, such as an action; got none")
        if (self.by or self.scan or self.over == "recordings") and not self.scanned:
            names = ", ".join(sorted(full_name(name) for name in ("sac", "tc", "te")))
            raise ConfigError(f"`scan`, `by` and `over='recordings'` need one of {names} among `measures`")
        if self.by is not None and self.over == "steps":
            raise ConfigError("`by` compares recordings, so there must be values for each: leave out `over='steps'`")
        if not (self.source and self.target):
            raise ConfigError("measure needs at least one column each for `source` and `target`")

    @property
    def tests(self) -> int:
        """Number of measures."""
        return len(self.chosen)

    @property
    def chosen(self) -> tuple[Measure, ...]:
        """The measures, in the order of the table that is printed."""
        return tuple(measure for measure in self._possible if measure in self._named or not self.measures)

    @property
    def _possible(self) -> tuple[Measure, ...]:
        return CONDITIONED if self.condition else ALONE

    @property
    def _named(self) -> list[Measure]:
        return [MEASURES[full_name(measure)] for measure in self.measures]

    @property
    def draws(self) -> int:
        """Surrogates and resamples of all tests, and of the lags that are scanned."""
        return super().draws + (0 if self.scan is None else self.surrogates * len(self.scanned))

    @property
    def scanned(self) -> tuple[Measure, ...]:
        """What is measured over lags."""
        return tuple(measure for measure in self.chosen if measure in (CONTINGENCY, COMBINED, TRANSFER))


@dataclass(frozen=True, repr=False)
class Measured:
    """One measure of the series; values in units of the base."""

    name: str
    significance: Significance
    miller_madow: float
    degrees_of_freedom: float
    normalised: float
    """Effective value, divided by the bound ``smallest``."""
    values: tuple[LocalContingency, ...] = ()
    """What each combination of values adds to the measure, most first; none where histories are longer than a step."""

    def __repr__(self) -> str:
        return f"Measured({self.name}: {self.significance!r})"


@dataclass(frozen=True, repr=False)
class MeasureResult:
    """All measures of the series."""

    title: str
    measured: tuple[Measured, ...]
    granger: float
    """Linear Granger causality, given the condition if there is one; NaN where there are too many values for it, or
    where measures were named."""
    notes: tuple[str, ...]
    scans: tuple[tuple[str, LagScan], ...] = ()
    """The measures over lags, if asked for."""
    dyads: tuple[DyadResult, ...] = ()
    """Values for each recording, if there are several."""
    step: float | None = None
    """Seconds of a step, if known."""
    names: tuple[str, str, str] = ("", "", "")
    """Of source, condition and target."""
    labels: Mapping[str, Sequence[str]] = field(default_factory=dict)
    explain: int = 3

    def __repr__(self) -> str:
        values = ", ".join(f"{tested.name} {tested.significance.corrected:.3g}" for tested in self.measured)
        return f"MeasureResult({self.title}; {values})"

    def rows(self) -> list[dict[str, Any]]:
        """A row a measure."""
        return [
            {
                "measure": tested.name,
                "plug_in": tested.significance.value,
                "miller_madow": tested.miller_madow,
                "degrees_of_freedom": tested.degrees_of_freedom,
                "effective": tested.significance.corrected,
                "low": tested.significance.interval[0],
                "high": tested.significance.interval[1],
                "normalised": tested.normalised,
                "z": tested.significance.z,
                "p": tested.significance.p,
                "transitions": tested.significance.transitions,
                "linear_granger": self.granger,
                "method": tested.significance.method,
                "inflation": tested.significance.inflation,
            }
            for tested in self.measured
        ]

    def lag_rows(self) -> list[dict[str, Any]]:
        """A row a measure and lag; none where lags were not scanned."""
        return [row for name, scan in self.scans for row in lag_rows(name, scan, self.step)]

    def dyad_rows(self) -> list[dict[str, Any]]:
        """A row a measure and recording."""
        return [row for dyad in self.dyads for row in dyad.rows()]

    def group_lines(self) -> list[str]:
        """What each group of recordings has, and their comparison, of the first measure, in words."""
        return [line for dyad in self.dyads[:1] for line in dyad.lines()[1:]]

    def value_rows(self) -> list[dict[str, Any]]:
        """A row a measure and combination of values, as labels."""
        return [
            {"measure": tested.name, **self._labelled(value)} for tested in self.measured for value in tested.values
        ]

    def text(self) -> str:
        """A table to read."""
        of_dyads = [line for dyad in self.dyads for line in dyad.lines()]
        lines = [
            self.title,
            "",
            *([*of_dyads, "", "All steps together:"] if of_dyads else []),
            f"{'measure':14}{'plug-in':>10}{'Miller-M.':>11}{'df':>10}{'effective':>11}{'95% interval':>22}"
            f"{'share':>9}{'p':>9}",
        ]
        for tested in self.measured:
            significance = tested.significance
            lines.append(
                f"{tested.name:14}{number(significance.value):>10}{number(tested.miller_madow):>11}"
                f"{number(tested.degrees_of_freedom):>10}{number(significance.corrected):>11}{bracket(significance.interval):>22}"
                f"{share(tested.normalised):>9}{significance.p:9.4f}"
            )
        lines += [
            *([] if np.isnan(self.granger) else [f"{'linear Granger':14}{number(self.granger):>10}"]),
            "",
            "effective: plug-in less the mean of surrogates of the source; share: of the most that is possible.",
            "Miller-M. and df: plug-in less analytic estimates of its bias.",
        ]
        for tested in self.measured:
            carried = carriers(tested.values, most=self.explain) if tested.significance.p <= ALPHA else ()
            if carried:
                lines += [
                    "",
                    f"{tested.name} is carried by",
                    *(f"  {v.words(self.names, self.labels)}" for v in carried),
                ]
        if self.scans:
            lines += ["", *(lag_words(name, scan, self.step) for name, scan in self.scans)]
        return "\n".join([*lines, *(f"Note: {note}." for note in self.notes)])

    def _labelled(self, value: LocalContingency) -> dict[str, Any]:
        def called(name: str, code: int, used: bool) -> str:
            return "" if not used else str(self.labels[name][code]) if name in self.labels else str(code)

        source, condition, target = self.names
        return {
            "before": called(target, value.before, "r" in value.known),
            "source": called(source, value.sensor, True),
            "condition": called(condition, value.action, "a" in value.known),
            "result": called(target, value.result, True),
            "count": value.count,
            "occasions": value.occasions,
            "expected": value.expected,
            "contribution": value.contribution,
            "z": value.z,
            "p": value.p,
            "p_adjusted": value.p_adjusted,
        }


def run_measure(
    options: MeasureOptions,
    progress: Callable[[int], object] = lambda done: None,
    coded: Recordings | None = None,
    group_of: Mapping[str, str] | None = None,
    source: Any = None,
) -> MeasureResult:
    """Read the file, measure, test.

    Args:
        options: What is measured, and how.
        progress: Called with the number of surrogates and resamples drawn since the last call.
        coded: What the file has, where it is read already.
        group_of: Group of each recording by its name, where that is known already.
        source: A table of pandas, polars or pyarrow in place of ``options.file``.

    Raises:
        SeriesError: The file or a column cannot be measured.
        ConfigError: The surrogates would take more than half an hour, and ``yes`` is not said.
        OutputError: ``out`` is there already, is about to be, or cannot be written.
    """
    with nullcontext() if options.out is None else claimed_paths(options.out, "measures") as paths:
        names = (*options.source, *options.target, *options.condition)
        coding = Coding(
            options.file if source is None else source, options, tuple(dict.fromkeys(names)), options.group_columns
        )
        coded = coded or coding.steps(options.step)
        return _run(options, progress, coded, groups_of(options, coding) if group_of is None else group_of, paths)


def _run(
    options: MeasureOptions,
    progress: Callable[[int], object],
    coded: Recordings,
    group_of: Mapping[str, str] | None,
    paths: tuple[Path, Path] | None,
) -> MeasureResult:
    """Measure, test, and write where ``paths`` says."""
    (source, of_source), (target, of_target) = coded.joined(options.source), coded.joined(options.target)
    condition, of_condition = coded.joined(options.condition) if options.condition else (None, ())
    whole = steps(source, target, condition, coded.groups)
    given = timed(whole, options.timing(coded.step))
    progress = patient(progress, options.draws, options.yes)
    streams = np.random.SeedSequence(options.seed).spawn(len(CONDITIONED) + 2)
    measured = _measured(given, options, streams, progress)
    tested = [(value.name, value.significance) for value in measured]
    scans = _scans(whole, coded, options, streams[len(CONDITIONED)], progress)
    dyads = _by_recording(given, coded, options, group_of, streams[-1])
    granger, without_granger = _granger(given, options)
    notes = (
        *coded.notes(),
        *notes_on_tests(tested, options.method, options.surrogates),
        *(_scan_note(scan) for _, scan in scans[:1]),
        *(note for dyad in dyads[:1] for note in dyad.out_of_reach(ALPHA)),
        *without_granger,
    )
    names = " & ".join(options.source), " & ".join(options.condition), " & ".join(options.target)
    labels = dict(zip(names, (of_source, of_condition, of_target), strict=True))
    title = _title(options, coded)
    result = MeasureResult(title, measured, granger, notes, scans, dyads, coded.step, names, labels, options.explain)
    if paths is not None:
        _write(result, paths, options)
    return result


def _write(result: MeasureResult, paths: tuple[Path, Path], options: MeasureOptions) -> None:
    """Write the tables, and curves over lags where these were scanned."""
    more: dict[str, Any] = {}
    if result.scans:
        subject = result.title.split(":")[0]
        draw_lags(_beside(paths[0], "lags"), result.scans, result.step, subject, _unit(options))
        more["lags"] = result.lag_rows()
    if result.dyads:
        more["recordings"] = result.dyad_rows()
        more["groups"] = [asdict(group) for dyad in result.dyads for group in dyad.groups]
        more["comparisons"] = [asdict(pair) for dyad in result.dyads for pair in dyad.comparisons]
    write_results(paths, result.rows(), options, notes=result.notes, **more, values=result.value_rows())


def notes_on_tests(named: Sequence[tuple[str, Significance]], asked: str, surrogates: int) -> list[str]:
    """What to know about p: whether surrogates could change much, and how they were made (see ``method_notes``).

    Args:
        named: Name and test of each measure.
        asked: Method of surrogates that was asked for.
        surrogates: Number of surrogates that was asked for.
    """
    return [*_exchange_notes([significance for _, significance in named]), *method_notes(named, asked, surrogates)]


def _exchange_notes(significances: list[Significance]) -> list[str]:
    """What to know where permutations can change little."""
    least = min(significance.exchangeable / significance.transitions for significance in significances)
    if least > 0.5:
        return []
    return [
        f"only {least:.0%} of the steps have another value of the source in the same context and recording to change "
        "places with, so p says little; fewer values, longer recordings, or permuting across recordings help"
    ]


def _measured(
    given: Steps,
    options: MeasureOptions,
    streams: Sequence[np.random.SeedSequence],
    progress: Callable[[int], object],
) -> tuple[Measured, ...]:
    unit = check_base(options.base)
    entries = given.entries()
    measures, possible = options.chosen, CONDITIONED if options.condition else ALONE
    rngs = [np.random.default_rng(streams[possible.index(measure)]) for measure in measures]
    plain = options.source_history == options.target_history == 1 and len(entries.counts) <= MOST_COMBINATIONS
    assessed = assess_measures(given, measures, options.test(), unit, rngs, progress, plain)
    measured = []
    for measure, significance in zip(measures, assessed, strict=True):
        bound = measure.bound(entries, "smallest") / unit
        measured.append(
            Measured(
                measure.name,
                significance,
                significance.value - measure.bias(entries, "miller_madow") / unit,
                significance.value - measure.bias(entries, "degrees_of_freedom") / unit,
                significance.corrected / bound if bound > 1e-12 else 0.0,
                local_of_steps(given, measure, unit, counts=significance.counts) if plain else (),
            )
        )
    return tuple(measured)


def _over_recordings(coded: Recordings, options: MeasureOptions) -> bool:
    """Whether there are values for each recording."""
    if options.over == "auto":
        return options.by is not None or len(set(coded.groups)) >= ENOUGH_RECORDINGS
    return options.over == "recordings"


def _of_one(options: MeasureOptions) -> TestOptions:
    """How one recording is tested, which has no partners in others."""
    return replace(options.test(), method="auto") if options.method == "partners" else options.test()


def _scans(
    whole: Steps,
    coded: Recordings,
    options: MeasureOptions,
    stream: np.random.SeedSequence,
    progress: Callable[[int], object],
) -> tuple[tuple[str, LagScan], ...]:
    """Names of the measures that were scanned over lags, and what came out; nothing where no scan is asked for."""
    if options.scan is None:
        return ()
    lags = range(1, delay_in_steps("scan", options.scan, coded.step) + 1)
    timing, unit, rng = options.timing(coded.step), check_base(options.base), np.random.default_rng(stream)
    each = _over_recordings(coded, options)

    def scanned(measure: Measure) -> LagScan:
        if each:
            return scan_over_dyads(whole, measure, lags, timing, _of_one(options), unit, stream.spawn(1)[0], progress)
        return scan_steps(whole, measure, lags, timing, options.test(), unit, rng, progress)

    return tuple((measure.name, scanned(measure)) for measure in options.scanned)


def _scan_note(scan: LagScan) -> str:
    """Where p over lags comes from."""
    how = " or ".join(WORDS[method] for method in scan.method.split(" or "))
    means = f"; values are means over {scan.recordings} recordings, and so are those of surrogates" * (
        scan.recordings > 0
    )
    return (
        f"p over lags comes from {scan.surrogates} surrogates, {how}, and the highest of all {len(scan.lags)} lags in "
        f"each (max-T){means}"
    )


def _by_recording(
    given: Steps,
    coded: Recordings,
    options: MeasureOptions,
    group_of: Mapping[str, str] | None,
    stream: np.random.SeedSequence,
) -> tuple[DyadResult, ...]:
    """Values for each recording, where there are several."""
    if not options.scanned or not _over_recordings(coded, options):
        return ()
    names = {number: coded.names[number] if coded.names else str(number) for number in set(coded.groups)}
    unit, streams = check_base(options.base), stream.spawn(len(options.scanned))
    return tuple(
        by_dyad(given, measure, names, _of_one(options), unit, stream, group_of, options.by or "")
        for measure, stream in zip(options.scanned, streams, strict=True)
    )


def _granger(given: Steps, options: MeasureOptions) -> tuple[float, tuple[str, ...]]:
    """Linear Granger causality at the lag of ``given``, or NaN; and why there is none where it was not left out by
    naming measures. It knows no histories."""
    if options.measures:
        return float("nan"), ()
    if given.history is not None:
        return float("nan"), ("linear Granger is of one past value of the target; left out",)
    condition = None if given.condition is None else given.condition.split()
    try:
        return linear_granger(given.source.split(), given.target.split(), condition, options.base), ()
    except SeriesError as error:
        return float("nan"), (str(error),)


def _beside(path: Path, what: str) -> Path:
    """The figure beside a file of results."""
    return path.with_name(f"{path.stem}_{what}.png")


def _unit(options: MeasureOptions) -> str:
    return "bits" if options.base == 2 else f"units of base {options.base:g}"


def _title(options: MeasureOptions, coded: Recordings) -> str:
    given = f" | {' & '.join(options.condition)}" if options.condition else ""
    recordings = len(set(coded.groups))
    steps = delay_in_steps("lag", options.lag, coded.step)
    lag = "" if steps == 1 else f", {lag_title(steps, coded.step)}"
    return (
        f"{' & '.join(options.source)} -> {' & '.join(options.target)}{given}: {coded.transitions} steps in "
        f"{recordings} recording{'s' * (recordings != 1)}{lag}, {_unit(options)}"
    )
