"""What an experiment is: settings, one pure function for a trial, and an analysis that reads stored trials."""

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
    """How a sentence of the dissertation fared here."""

    REPRODUCED = "reproduced"
    PARTLY = "partly"
    NOT = "not reproduced"
    EXTENSION = "extension"
    """The dissertation has no counterpart."""
    UNDECIDED = "undecided"
    """Too few runs to say."""

    @classmethod
    def of_share(cls, ours: Estimate, published: float) -> Verdict:
        """What our share says of a published one above one half: partly where the whole interval lies below it,
        undecided where the interval holds one half too, for then as few as that would have given the same."""
        if ours.high < published:
            return cls.PARTLY
        return cls.REPRODUCED if ours.low > 0.5 else cls.UNDECIDED

    @classmethod
    def of_most(cls, ours: Estimate) -> Verdict:
        """Whether our share is that of most, or of less than half; undecided where the interval holds one half."""
        return cls.REPRODUCED if ours.low > 0.5 else cls.NOT if ours.high < 0.5 else cls.UNDECIDED

    @classmethod
    def of_all(cls, verdicts: Iterable[Verdict]) -> Verdict:
        """What several come to: the one that all share of those that decide something, partly where they differ."""
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
    """A dataclass or a plain dict: all that a trial needs but its seed."""
    runs: Annotated[int, Whole("[0, 1e6]")]
    """Seeds by default."""


@dataclass(frozen=True)
class Trial:
    """A finished trial, as read from its file."""

    setting: str
    seed: int
    result: dict[str, Any]


Trials = Mapping[str, Sequence[Trial]]
"""By setting id, ordered by seed; only what is stored: a setting without a trial is missing."""


@dataclass(frozen=True)
class Comparison:
    """One row of the table of claims."""

    what: str
    """What is compared, such as "FG, SCf, SC are the first three modules, in this order"."""
    dissertation: str
    """What stands there, such as "90% of ten runs"."""
    ours: Estimate | None
    """Our value with 95% interval and n; None where a sentence must do."""
    verdict: Verdict
    note: str = ""
    """Why, in a sentence."""


@dataclass(frozen=True)
class Claim:
    """A claim of the dissertation, how it is tried, and how what came out is read."""

    id: str
    """Such as "5.2"."""
    title: str
    source: str
    """Where it stands, such as "section 5.3.2, Fig. 5.3"."""
    says: str
    """What the dissertation claims, in one or two sentences."""
    settings: Mapping[str, Setting]
    trial: Callable[[Any, int], dict[str, Any]]
    """(config, seed) -> numbers, strings, lists and dicts, None for what is missing. Pure: the same for ever."""
    analyse: Callable[[Trials], list[Comparison]]
    draw: Callable[[Trials], Mapping[str, Figure]]
    """Figures by file stem; copes with missing settings and few runs."""
    first_seed: int = 0
    version: int = 1
    """Raised when the meaning of a trial changes: stored files of another version are not used."""
    film: Path | None = None
    """A short video (MP4) to show beside the figures."""

    def __post_init__(self) -> None:
        if not self.settings:
            raise ConfigError(f"claim {self.id} needs at least one setting")
