"""A claim of the dissertation as an experiment: settings, a pure function that computes a trial, and an analysis.

A setting is one condition of the experiment, with a number of runs. A trial is a setting with a seed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from jointattn_mj.sweeps.statistics import Estimate


class Verdict(StrEnum):
    """Whether a sentence of the dissertation was reproduced."""

    REPRODUCED = "reproduced"
    PARTLY = "partly"
    NOT = "not reproduced"
    EXTENSION = "extension"
    """The dissertation has no value to compare with."""
    UNDECIDED = "undecided"
    """Too few runs to decide."""

    @classmethod
    def of_share(cls, ours: Estimate, published: float) -> Verdict:
        """Verdict on a published share above one half.

        It is partly if our whole interval lies below the published share, and undecided if the interval holds one half.
        """
        if ours.high < published:
            return cls.PARTLY
        return cls.REPRODUCED if ours.low > 0.5 else cls.UNDECIDED

    @classmethod
    def of_most(cls, ours: Estimate) -> Verdict:
        """Verdict on "most": reproduced if our interval lies above one half, not reproduced if it lies below."""
        return cls.REPRODUCED if ours.low > 0.5 else cls.NOT if ours.high < 0.5 else cls.UNDECIDED

    @classmethod
    def of_all(cls, verdicts: Iterable[Verdict]) -> Verdict:
        """Verdict of several together: the one on which all that decide something agree, or partly."""
        given = set(verdicts)
        decided = given - {cls.EXTENSION, cls.UNDECIDED}
        if len(decided) == 1:
            return decided.pop()
        if decided:
            return cls.PARTLY
        return cls.EXTENSION if given == {cls.EXTENSION} else cls.UNDECIDED


@dataclass(frozen=True)
class Setting(Checked):
    """One condition of an experiment."""

    config: Any
    """A dataclass or a plain dict: all that a trial needs besides its seed."""
    runs: Annotated[int, Whole("[0, 1e6]")]
    """Number of runs, each with a seed of its own."""


@dataclass(frozen=True)
class Trial:
    """A finished trial, as read from its file."""

    setting: str
    """Id of the setting."""
    seed: int
    result: dict[str, Any]

    def __repr__(self) -> str:
        return f"Trial({self.setting!r}, seed={self.seed}, {', '.join(self.result)})"


Trials = Mapping[str, Sequence[Trial]]
"""Stored trials by the id of their setting, sorted by seed. A setting without trials is missing."""


@dataclass(frozen=True)
class Comparison:
    """One row of the table of claims."""

    what: str
    """The quantity, such as "FG, SCf, SC are the first three modules, in this order"."""
    dissertation: str
    """The published value, such as "90% of ten runs"."""
    ours: Estimate | None
    """Our value with 95% interval and n; None if there is no number."""
    verdict: Verdict
    note: str = ""
    """A sentence that explains the verdict or the value."""

    def __repr__(self) -> str:
        return f"Comparison({self.what}: {self.ours}; dissertation: {self.dissertation}; {self.verdict})"


@dataclass(frozen=True)
class Claim:
    """A claim of the dissertation, the settings that test it, and the analysis of their trials."""

    id: str
    """Such as "5.2"."""
    title: str
    source: str
    """Where the claim stands, such as "section 5.3.2, Fig. 5.3"."""
    says: str
    """The claim in one or two sentences."""
    settings: Mapping[str, Setting]
    trial: Callable[[Any, int], dict[str, Any]]
    """Compute a trial from a config and a seed. The same arguments always give the same result, which holds numbers,
    strings, lists and dicts, and None for a missing value."""
    analyse: Callable[[Trials], list[Comparison]]
    """Compare stored trials with the dissertation. Settings may be missing, and runs few."""
    draw: Callable[[Trials], Mapping[str, Figure]]
    """Draw stored trials; figures by the stem of their file. Settings may be missing, and runs few."""
    first_seed: int = 0
    """Seed of the first run of every setting."""
    version: int = 1
    """Raised when the meaning of a trial changes: stored trials of other versions are not used."""
    film: Path | None = None
    """A short video (MP4) that the report shows."""

    def __repr__(self) -> str:
        return f"Claim({self.id!r}, {self.title!r}, {len(self.settings)} settings)"

    def __post_init__(self) -> None:
        if not self.settings:
            raise ConfigError(f"claim {self.id} needs at least one setting")
