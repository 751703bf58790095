"""What came out for one claim: its findings beside the dissertation's, and where figures and report are."""

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import pyarrow as pa

from jointattn_mj.api.claims import experiments_registry
from jointattn_mj.errors import ConfigError, OutputError
from jointattn_mj.io.progress import count
from jointattn_mj.io.table import Table
from jointattn_mj.options import path_of
from jointattn_mj.sweeps.claim import Comparison, Verdict
from jointattn_mj.sweeps.registry import Entry, Registry
from jointattn_mj.sweeps.report import chapter, finding_row
from jointattn_mj.sweeps.store import Store

WIDTH = 110
"""Characters of a row of a result's repr."""


@dataclass(frozen=True, eq=False, repr=False)
class ClaimResult:
    """One claim of the dissertation and what came out here. Its repr is a short table of findings.

    Two results are equal if they are of the same claim and folder, and findings and runs are the same.

    Attributes:
        entry: Id, title and source of the claim, and what the dissertation says.
        verdict: Of all findings together.
        findings: What was compared, the dissertation's value, ours with 95% interval, and the verdict on each.
        runs: Stored runs of each setting.
        figures: Figures by name, as PNG files.
        report: The page on all claims in the folder.
        notes: What a reader should know, such as failed trials.
        folder: Where trials, figures and report lie.

    Examples:
        >>> from jointattn_mj import ClaimResult, run_claim
        >>> result = run_claim("5.2", out="out/claims", runs=1)
        >>> ClaimResult.open("out/claims", "5.2") == result
        True
        >>> result.table().columns[:3]
        ('what', 'dissertation', 'value')
    """

    entry: Entry
    verdict: Verdict
    findings: tuple[Comparison, ...]
    runs: Mapping[str, int]
    figures: Mapping[str, Path]
    report: Path
    notes: tuple[str, ...]
    folder: Path

    @classmethod
    def open(cls, folder: str | PathLike[str], claim: str, registry: Registry | None = None) -> "ClaimResult":
        """The result of a claim whose trials are in ``folder``.

        Args:
            folder: What ``--out`` or ``run_claim(out=...)`` named.
            claim: Id of the claim, such as ``"4.4"``.
            registry: Claims of your own; by default those of the dissertation.

        Returns:
            The result, equal to the one that ``run_claim`` returned.

        Raises:
            ConfigError: There is no such claim.
            OutputError: The folder holds no trials of it.

        Examples:
            >>> from jointattn_mj import ClaimResult, run_claim
            >>> _ = run_claim("5.2", out="out/claims", runs=1)
            >>> ClaimResult.open("out/claims", "5.2").entry.title
            'Gaze following, looking back, gaze alternation'
        """
        path = path_of(folder, "folder")
        registry = experiments_registry() if registry is None else registry
        if claim not in registry.entries:
            raise ConfigError(f"no claim has the id {claim!r}; there are {', '.join(registry)}")
        told = chapter(registry, claim, Store(path))
        if not told.runs:
            raise OutputError(f"{path} holds no trials of claim {claim}; run_claim({claim!r}, out=...) computes them")
        return cls(
            entry=told.entry,
            verdict=told.verdict,
            findings=tuple(told.findings),
            runs={name: len(seeds) for name, seeds in told.seeds.items()},
            figures={stem: path / "figures" / f"{claim}-{stem}.png" for stem in told.figures},
            report=path / "report.html",
            notes=(*told.notes, *told.trouble),
            folder=path,
        )

    def table(self) -> Table:
        """Give the findings as a table.

        Returns:
            A row a finding: value, 95% interval, standard deviation, number of runs, verdict.

        Examples:
            >>> from jointattn_mj import run_claim
            >>> len(run_claim("5.2", out="out/claims", runs=1).table()) > 1
            True
        """
        rows = [finding_row(finding) for finding in self.findings]
        texts, whole = ("what", "dissertation", "verdict", "note"), ("n",)
        names = ("what", "dissertation", "value", "low", "high", "sd", "n", "verdict", "note")
        kinds = [pa.string() if name in texts else pa.int64() if name in whole else pa.float64() for name in names]
        return Table(pa.Table.from_pylist(rows, pa.schema(list(zip(names, kinds, strict=True)))))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ClaimResult):
            return NotImplemented
        own, given = (
            (result.entry, result.runs, result.figures, result.notes, result.folder, list(map(repr, result.findings)))
            for result in (self, other)
        )  # NaN in an interval differs from itself, and its text does not
        return own == given

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        runs = max(self.runs.values(), default=0)
        amount = f"up to {count(runs, 'run')}" if runs > 1 else "1 run"
        head = f"ClaimResult {self.entry.id} ({self.entry.title}): {self.verdict}, {amount}, in {self.folder}"
        rows = [("what", "dissertation", "here", "verdict")]
        for finding in self.findings:
            rows.append((finding.what, finding.dissertation, str(finding.ours or "-"), str(finding.verdict)))
        room = (44, 22, 22, 16)
        lines = ["  ".join(_cut(text, width) for text, width in zip(row, room, strict=True)).rstrip() for row in rows]
        return "\n".join([head if len(head) <= WIDTH else _cut(head, WIDTH).rstrip(), *lines])


def _cut(text: str, width: int) -> str:
    return (text if len(text) <= width else f"{text[: width - 3]}...").ljust(width)
