"""``jointattn measure``: how much one recorded variable says about what another does next."""

from collections.abc import Callable
from dataclasses import dataclass

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
from jointattn_mj.contingency.series import check_base
from jointattn_mj.contingency.significance import Significance, assess_steps
from jointattn_mj.contingency.table import Steps, steps
from jointattn_mj.errors import ConfigError, SeriesError
from jointattn_mj.io.results import bracket, number, result_paths, share, write_results
from jointattn_mj.recordings.options import RecordingTestOptions
from jointattn_mj.recordings.patience import patient
from jointattn_mj.recordings.steps import Recordings

ALONE = (TRANSFER, MUTUAL)
CONDITIONED = (CONTINGENCY, COMBINED, TRANSFER, MUTUAL, CONDITIONAL_MUTUAL)


@dataclass(frozen=True)
class MeasureOptions(RecordingTestOptions):
    """What is measured, and how it is tested."""

    source: tuple[str, ...]
    """Column whose influence is asked for, such as a sensor; several are taken jointly."""
    target: tuple[str, ...]
    """Column that may be influenced, the result."""
    condition: tuple[str, ...] = ()
    """Column that is known anyway, such as an action: gives T^C (eq. 4.3) and SAC (eq. 5.2) too."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (self.source and self.target):
            raise ConfigError("measure needs at least one column each for `source` and `target`")

    @property
    def tests(self) -> int:
        """Number of measures."""
        return len(CONDITIONED if self.condition else ALONE)


@dataclass(frozen=True)
class Measured:
    """One measure of the series; values in units of the base."""

    name: str
    significance: Significance
    miller_madow: float
    degrees_of_freedom: float
    normalised: float
    """Effective value, divided by the bound ``smallest``."""


@dataclass(frozen=True)
class MeasureResult:
    """All measures of the series."""

    title: str
    measured: tuple[Measured, ...]
    granger: float
    """Linear Granger causality, given the condition if there is one; NaN where there are too many values for it."""
    notes: tuple[str, ...]

    def rows(self) -> list[dict[str, float | str | int]]:
        """A row a measure."""
        return [
            {
                "measure": one.name,
                "plug_in": one.significance.value,
                "miller_madow": one.miller_madow,
                "degrees_of_freedom": one.degrees_of_freedom,
                "effective": one.significance.corrected,
                "low": one.significance.interval[0],
                "high": one.significance.interval[1],
                "normalised": one.normalised,
                "z": one.significance.z,
                "p": one.significance.p,
                "transitions": one.significance.transitions,
                "linear_granger": self.granger,
            }
            for one in self.measured
        ]

    def text(self) -> str:
        """A table to read."""
        lines = [
            self.title,
            "",
            f"{'measure':14}{'plug-in':>10}{'Miller-M.':>11}{'df':>10}{'effective':>11}{'95% interval':>22}"
            f"{'share':>9}{'p':>9}",
        ]
        for one in self.measured:
            found = one.significance
            lines.append(
                f"{one.name:14}{number(found.value):>10}{number(one.miller_madow):>11}"
                f"{number(one.degrees_of_freedom):>10}{number(found.corrected):>11}{bracket(found.interval):>22}"
                f"{share(one.normalised):>9}{found.p:9.4f}"
            )
        lines += [
            f"{'linear Granger':14}{number(self.granger):>10}",
            "",
            "effective: plug-in less the mean of permutations of the source within its context; share: of the most",
            "that is possible. Miller-M. and df: plug-in less analytic estimates of its bias.",
        ]
        return "\n".join([*lines, *(f"Note: {note}." for note in self.notes)])


def run_measure(
    options: MeasureOptions, progress: Callable[[int], object] = lambda done: None, data: Recordings | None = None
) -> MeasureResult:
    """Read the file, measure, test; ``progress`` is told of surrogates and resamples as they are drawn.

    ``data`` is what the file has, where it is read already.

    Raises:
        SeriesError: The file or a column cannot be measured.
        ConfigError: The surrogates would take more than half an hour, and ``yes`` is not said.
        OutputError: ``out`` is there already or cannot be written.
    """
    paths = None if options.out is None else result_paths(options.out, "measures")
    data = data or options.read(options.file, [*options.source, *options.target, *options.condition])
    source, target = data.joined(options.source)[0], data.joined(options.target)[0]
    condition = data.joined(options.condition)[0] if options.condition else None
    given = steps(source, target, condition, data.groups)
    progress = patient(progress, options.draws, options.yes)
    streams = np.random.SeedSequence(options.seed).spawn(len(CONDITIONED))
    measured = tuple(
        _measured(given, measure, options, np.random.default_rng(stream), progress)
        for measure, stream in zip(CONDITIONED if options.condition else ALONE, streams, strict=False)
    )
    notes = [*data.notes(), *exchange_notes([one.significance for one in measured])]
    try:
        granger = linear_granger(source, target, condition, options.base)
    except SeriesError as error:
        granger = float("nan")
        notes.append(str(error))
    result = MeasureResult(_title(options, data), measured, granger, tuple(notes))
    if paths is not None:
        write_results(paths, result.rows(), options, notes=result.notes)
    return result


def exchange_notes(found: list[Significance]) -> list[str]:
    """What to know where permutations can change little."""
    least = min(one.exchangeable / one.transitions for one in found)
    if least > 0.5:
        return []
    return [
        f"only {least:.0%} of the steps have another value of the source in the same context and recording to change "
        "places with, so p says little; fewer values, longer recordings, or permuting across recordings help"
    ]


def _measured(
    given: Steps,
    measure: Measure,
    options: MeasureOptions,
    rng: np.random.Generator,
    progress: Callable[[int], object],
) -> Measured:
    unit = check_base(options.base)
    entries = given.entries()
    found = assess_steps(given, measure, options.test(), unit, rng, progress)
    bound = measure.bound(entries, "smallest") / unit
    return Measured(
        measure.name,
        found,
        found.value - measure.bias(entries, "miller_madow") / unit,
        found.value - measure.bias(entries, "degrees_of_freedom") / unit,
        found.corrected / bound if bound > 1e-12 else 0.0,
    )


def _title(options: MeasureOptions, data: Recordings) -> str:
    given = f" | {' & '.join(options.condition)}" if options.condition else ""
    recordings = len(set(data.groups))
    unit = "bits" if options.base == 2 else f"units of base {options.base:g}"
    return (
        f"{' & '.join(options.source)} -> {' & '.join(options.target)}{given}: {data.transitions} steps in "
        f"{recordings} recording{'s' * (recordings != 1)}, {unit}"
    )
