"""Options that ``measure`` and ``discover`` have in common: the file, the permutation test, and where results go."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from jointattn_mj.contingency.significance import TestOptions
from jointattn_mj.options import Real, Seed, Whole
from jointattn_mj.recordings.reader import ReadOptions


@dataclass(frozen=True, kw_only=True)
class RecordingTestOptions(ReadOptions):
    """A recording of people, and how contingency in it is tested."""

    file: tyro.conf.Positional[Path] = field(kw_only=False)
    """A file, or a folder of files, each a recording: coded events of ELAN, BORIS, Datavyu, Observer, INTERACT or any
    table with onset and offset, which --step samples; or a CSV, Parquet or Excel table with a row for every step."""
    base: Annotated[float, Real("(1, 1e6]")] = 2
    """Base of the logarithm: 2 for bits."""
    surrogates: Annotated[int, Whole("[1, 1e9]")] = 1000
    """Permutations of the source within its context, behind effective values and p."""
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

    def test(self) -> TestOptions:
        """Return how significance is found."""
        return TestOptions(self.surrogates, across_recordings=self.across_recordings, resamples=self.resamples)

    @property
    def tests(self) -> int:
        """Number of values that are tested."""
        raise NotImplementedError

    @property
    def draws(self) -> int:
        """Surrogates and resamples of all tests."""
        return (self.surrogates + self.resamples) * self.tests
