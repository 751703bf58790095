"""Options that ``measure`` and ``discover`` have in common: the file, the permutation test, and where results go."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, ClassVar

import tyro

from jointattn_mj.contingency.lagged import Timing
from jointattn_mj.contingency.significance import Method, TestOptions
from jointattn_mj.options import Count, Real, Seed, Whole
from jointattn_mj.recordings.delays import check_delay, delay_in_steps
from jointattn_mj.recordings.reader import ReadOptions


@dataclass(frozen=True, kw_only=True)
class RecordingTestOptions(ReadOptions):
    """A recording of people, and how contingency in it is tested."""

    file: tyro.conf.Positional[Path] = field(kw_only=False)
    """A file, or a folder of files, each a recording: coded events of ELAN, BORIS, Datavyu, Observer, INTERACT or any
    table with onset and offset, which --step samples; or a CSV, Parquet or Excel table with a row for every step."""
    base: Annotated[float, Real("(1, 1e6]")] = 2
    """Base of the logarithm: 2 for bits."""
    lag: str = "1"
    """From source and condition to the result: steps, such as 3, or a time, such as 0.5s or 500ms."""
    source_history: Count = 1
    """Values of the source taken as one: the one at the lag, and those before it."""
    target_history: Count = 1
    """Past values of the target that are known anyway: what its own past explains is taken off."""
    surrogates: Annotated[int, Whole("[1, 1e9]")] = 1000
    """Surrogates of the source, behind effective values and p."""
    method: Method = "auto"
    """How surrogates are made. permutation: within the context, right where the source or the result is fresh at every
    step. shift: the source is shifted in a circle within its recording, right for long looks, too. bootstrap: it is put
    together from its own blocks. partners: it is taken from other recordings. auto: permutation or, where the measured
    autocorrelation forbids it, shift, or partners where recordings are short and at least 8."""
    resamples: Annotated[int, Whole("[0, 1e9]")] = 500
    """Bootstrap resamples behind the intervals; 0 leaves these out."""
    seed: Seed = 0
    """Random seed of permutations and resamples."""
    across_recordings: bool = False
    """Permute among all recordings: for many short ones of the same kind."""
    out: Path | None = None
    """Also write the rows here, as .csv and, with config and versions, as .json."""
    yes: bool = False
    """Go on however long the surrogates take; without it, more than half an hour is refused."""

    ADVANCED: ClassVar[Sequence[str]] = ("base", "resamples", "across_recordings", "yes")

    def test(self) -> TestOptions:
        """Return how significance is found."""
        return TestOptions(
            self.surrogates,
            across_recordings=self.across_recordings,
            resamples=self.resamples,
            method=self.method,
        )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_delay("lag", self.lag)

    def timing(self, step: float | None) -> Timing:
        """Lag and histories in steps of so many seconds; None: their length is not known."""
        return Timing(delay_in_steps("lag", self.lag, step), self.source_history, self.target_history)

    @property
    def tests(self) -> int:
        """Number of values that are tested."""
        raise NotImplementedError

    @property
    def draws(self) -> int:
        """Surrogates and resamples of all tests."""
        return (self.surrogates + self.resamples) * self.tests
