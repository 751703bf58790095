"""``jointattn agreement``: Cohen's kappa of two coders of the same recordings."""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Annotated, Any, ClassVar

import tyro

from jointattn_mj.io.results import claimed_paths, share, write_results
from jointattn_mj.options import Real, Seed, Whole
from jointattn_mj.recordings.agreement import Agreement, AgreementOptions, agreement
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.reader import read
from jointattn_mj.recordings.sources import SourceOptions


@dataclass(frozen=True, kw_only=True)
class CoderOptions(SourceOptions):
    """Whose codings are compared, and how."""

    first: tyro.conf.Positional[Path] = field(kw_only=False)
    """Events of the first coder: a file, or a folder of files, each a recording."""
    second: tyro.conf.Positional[Path] = field(kw_only=False)
    """Events of the second coder. Recordings are matched by name, or one with one whatever their names."""
    tiers: tuple[str, ...] = ()
    """Tiers that are compared; by default all that both coders have."""
    step: Annotated[float, Real("[1e-3, 1e3]")] = 0.1
    """Unit of time in seconds."""
    tolerance_s: Annotated[float, Real("[0, 60]")] = 0.0
    """A unit counts as agreement if the other coder has the same code within so many seconds before or after."""
    resamples: Annotated[int, Whole("[0, 1e6]")] = 500
    """Bootstrap resamples of blocks of time behind the interval; 0 leaves it out."""
    block_s: Annotated[float, Real("(0, 1e5]")] = 30.0
    """Seconds of a block: longer than looks last, as units within one look tell the same."""
    level: Annotated[float, Real("(0, 1)")] = 0.95
    """Coverage of the interval."""
    seed: Seed = 0
    """Random seed of the resamples."""
    out: Path | None = None
    """Also write the rows here, as .csv and, with config and versions, as .json."""

    ADVANCED: ClassVar[Sequence[str]] = ("block_s", "level")

    def events(self, path: Path) -> Events:
        """The events of one coder."""
        return read(path, **{field.name: getattr(self, field.name) for field in fields(SourceOptions)}).events


@dataclass(frozen=True)
class AgreementResult:
    """How far two coders agree, tier by tier."""

    tiers: tuple[Agreement, ...]

    def rows(self) -> list[dict[str, Any]]:
        """A row a tier."""
        return [compared.row() for compared in self.tiers]

    def text(self) -> str:
        """A table to read, and for each tier kappa by code and what was taken for what."""
        width = max(len(compared.tier) for compared in self.tiers)
        lines = [f"{'tier':{width}}{'kappa':>8}{'95% interval'.replace('95', str(self._percent)):>16}{'observed':>10}"
                 f"{'by chance':>11}{'highest':>9}{'units':>9}"]  # fmt: skip
        for compared in self.tiers:
            bounds = f"[{compared.interval[0]:.2f}, {compared.interval[1]:.2f}]"
            lines.append(
                f"{compared.tier:{width}}{compared.kappa:8.3f}{bounds:>16}{share(compared.observed):>10}{share(compared.expected):>11}"
                f"{compared.kappa_max:9.3f}{compared.matrix.sum():9,.0f}"
            )
        for compared in self.tiers:
            codes = ", ".join(f"{code} {value:.2f}" for code, value in compared.by_code().items())
            lines += ["", f"{compared.tier}, kappa by code: {codes}", *_confusions(compared)]
        first = self.tiers[0]
        lines += [
            "",
            f"Units of {first.step:g} s, tolerance {first.tolerance_s:g} s; nothing coded is a code of its own.",
        ]
        notes = dict.fromkeys(note for compared in self.tiers for note in compared.notes())
        lines += [f"Note: {note}." for note in notes]
        return "\n".join(lines)

    @property
    def _percent(self) -> str:
        return f"{100 * self.tiers[0].level:g}"


def run_agreement(options: CoderOptions) -> AgreementResult:
    """Read two coders' events, compare them, and write the rows if asked for.

    Raises:
        SeriesError: The files cannot be read, or have nothing in common.
        OutputError: ``out`` is there already or cannot be written.
    """
    with nullcontext() if options.out is None else claimed_paths(options.out, "agreement") as paths:
        how = AgreementOptions(**{field.name: getattr(options, field.name) for field in fields(AgreementOptions)})
        tiers = agreement(options.events(options.first), options.events(options.second), options.tiers or None, how)
        result = AgreementResult(tiers)
        if paths is not None:
            matrices = {
                compared.tier: {"codes": compared.labels, "units": compared.matrix.tolist()} for compared in tiers
            }
            write_results(paths, result.rows(), options, matrices=matrices)
    return result


def _confusions(compared: Agreement) -> list[str]:
    """The table of codes: first coder's in rows, second coder's in columns."""
    width = max(8, *(len(label) + 2 for label in compared.labels))
    lines = [" " * width + "".join(f"{label:>{width}}" for label in compared.labels) + "  (second coder)"]
    for label, row in zip(compared.labels, compared.matrix, strict=True):
        lines.append(f"{label:{width}}" + "".join(f"{units:{width}.0f}" for units in row))
    return lines
