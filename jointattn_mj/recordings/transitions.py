"""``jointattn transitions``: lag-sequential analysis of coded interaction."""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, ClassVar

import tyro

from jointattn_mj.errors import ConfigError
from jointattn_mj.io.progress import count
from jointattn_mj.io.results import claimed_paths, share, write_results
from jointattn_mj.options import Real, Seed, Whole
from jointattn_mj.recordings.delays import check_delay, delay_in_steps, lag_title
from jointattn_mj.recordings.reader import ReadOptions
from jointattn_mj.recordings.sequential import (
    LagTable,
    OverRecordings,
    SequentialOptions,
    Unit,
    lag_table,
    yules_q_over,
)
from jointattn_mj.recordings.steps import Recordings

TOGETHER = "0"
"""A lag for what occurs at the same time."""
BETWEEN = ":"
"""Stands between the two codes of a pair that cannot occur."""


@dataclass(frozen=True, kw_only=True)
class TransitionOptions(ReadOptions):
    """Which codes are counted as following which, and how that is tested."""

    file: tyro.conf.Positional[Path] = field(kw_only=False)
    """A file of events or steps, or a folder of such files, each a recording."""
    given: str
    """Tier or column of the earlier code."""
    target: str | None = None
    """Tier or column of the later code; by default the same."""
    lag: str = "1"
    """From the earlier to the later code: steps, a time such as 0.5s, or events; 0 for what occurs together."""
    unit: Unit = "steps"
    """What is counted. steps: every step. onsets: steps in which a new value of the target begins. events: values of
    one tier, each once however long it lasts."""
    impossible: tuple[str, ...] = ()
    """Pairs of codes that cannot follow each other, such as face:away; they are left out of what is expected. A code
    cannot follow itself where events are counted."""
    surrogates: Annotated[int, Whole("[0, 1e7]")] = 1000
    """Circular shifts behind p by shifts; 0: none."""
    level: Annotated[float, Real("(0, 1)")] = 0.95
    """Coverage of the intervals."""
    seed: Seed = 0
    """Random seed of the shifts."""
    out: Path | None = None
    """Also write the rows here, as .csv and, with config and versions, as .json."""

    ADVANCED: ClassVar[Sequence[str]] = ("level",)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.lag.strip() != TOGETHER:
            check_delay("lag", self.lag)
        for pair in self.impossible:
            if pair.count(BETWEEN) != 1:
                raise ConfigError(f"impossible: expected two codes with a colon between them; got {pair!r}")

    @property
    def both(self) -> tuple[str, str]:
        """The tiers of the earlier and of the later code."""
        return self.given, self.given if self.target is None else self.target

    def sequential(self, step: float | None) -> SequentialOptions:
        """How transitions are counted, with steps of so many seconds."""
        together = self.lag.strip() == TOGETHER
        lag = 0 if together else delay_in_steps("lag", self.lag, None if self.unit == "events" else step)
        return SequentialOptions(lag, self.unit, self.level, self.surrogates, self.seed)


@dataclass(frozen=True)
class TransitionResult:
    """What follows what, of all recordings' steps, and the mean over recordings."""

    title: str
    table: LagTable
    over: OverRecordings | None
    """None: of one recording."""
    notes: tuple[str, ...]

    def rows(self) -> list[dict[str, Any]]:
        """A row a pair of codes that can occur."""
        rows = self.table.rows()
        if self.over is None:
            return rows
        return [{**row, **more} for row, more in zip(rows, self.over.rows(self.table.possible), strict=True)]

    def text(self) -> str:
        """A table to read."""
        rows, shifts = self.rows(), self.table.p_shift is not None
        pairs = [f"{row['given']} -> {row['target']}" for row in rows]
        width = max(map(len, pairs))
        means = f"{'mean Q':>8}{'interval':>16}{'p':>8}" if self.over else ""
        head = f"{'times':>7}{'share':>8}{'expected':>10}{'residual':>10}{'odds ratio':>12}{'interval':>18}{'Q':>7}"
        lines = [self.title, "", f"{'':{width}}{head}{'p shift' if shifts else '':>9}{means}"]
        for pair, row in zip(pairs, rows, strict=True):
            line = (
                f"{pair:{width}}{row['count']:7}{share(row['conditional']):>8}{row['expected']:10.1f}"
                f"{_told(row['adjusted_residual']):>10}{_told(row['odds_ratio']):>12}"
                f"{_bounds(row['odds_ratio_low'], row['odds_ratio_high']):>18}{_told(row['yules_q']):>7}"
            )
            line += f"{row['p_shift']:9.4f}" if shifts else ""
            if self.over:
                bounds = _bounds(row["q_low"], row["q_high"])
                line += f"{_told(row['q_mean']):>8}{bounds:>16}{_told(row['q_p'], 4):>8}"
            lines.append(line.rstrip())
        pearson, likelihood = self.table.chi_squared
        lines += [
            "",
            f"Whole table: chi-squared {pearson:.2f}, likelihood ratio {likelihood:.2f}, "
            f"{count(self.table.degrees_of_freedom, 'degree')} of freedom.",
        ]
        return "\n".join([*lines, *(f"Note: {note}." for note in self.notes)])


def run_transitions(options: TransitionOptions, coded: Recordings | None = None) -> TransitionResult:
    """Read the file, count what follows what, and write the rows if asked for.

    Args:
        options: What is read and counted.
        coded: What the file has, where it is read already.

    Raises:
        SeriesError: The file cannot be read, or there is nothing to count.
        OutputError: ``out`` is there already or cannot be written.
    """
    with nullcontext() if options.out is None else claimed_paths(options.out, "transitions") as paths:
        coded = coded or options.read(options.file, options.both)
        how = options.sequential(coded.step)
        pairs = [tuple(code.strip() for code in pair.split(BETWEEN)) for pair in options.impossible]
        impossible = [(first, second) for first, second in pairs]
        table = lag_table(coded, *options.both, how, impossible)
        recordings = len(set(coded.groups))
        whole = bool(table.possible.all())
        over = yules_q_over(coded, *options.both, how, impossible) if recordings > 1 and whole else None
        lag = lag_title(how.lag, None if options.unit == "events" else coded.step) if how.lag else "together"
        title = (
            f"{options.both[0]} -> {options.both[1]}: {table.total:,} pairs of {options.unit}, {lag}, "
            f"{count(recordings, 'recording')}"
        )
        notes = list(coded.notes())
        if options.unit == "steps":
            notes.append(
                "residuals and odds ratios take steps as independent; p by shifts holds for long looks, too"
                if table.p_shift is not None
                else "residuals and odds ratios take steps as independent, which they are not where looks last long"
            )
        if over is not None:
            notes.append(
                "mean Q is the mean of the recordings' own values of Yule's Q, with Student's t over recordings"
            )
        result = TransitionResult(title, table, over, tuple(notes))
        if paths is not None:
            write_results(paths, result.rows(), options, notes=result.notes)
    return result


def _told(value: float, digits: int = 2) -> str:
    """A dash for what is not defined."""
    return "-" if value != value else f"{value:.{digits}f}"


def _bounds(low: float, high: float) -> str:
    return "-" if low != low else f"[{low:.2f}, {high:.2f}]"
