"""The mean of a person's faces, from which each face deviates: norm-based coding (Leopold et al., 2001).

What a face shows all the time says whose it is; how it deviates from that says where it is turned. A map that has
learned the deviations of one person's faces serves for another person too, once the mean of these is known.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.guards.restored import check_array, check_whole
from jointattn_mj.options import Checked, Whole
from jointattn_mj.perception.som import standardised


@dataclass(frozen=True)
class MeanFaceConfig(Checked):
    """Whether and how faces are coded as deviations from their mean. From the state a face has none."""

    subtracted: bool = False
    """Whether a face is coded by how it deviates from this person's mean, rather than as it is (the dissertation)."""
    every: Annotated[int, Whole("[1, 1e6]")] = 3
    """A face counts for the mean every N frames while it is looked at: ten a second, as in familiarisation."""
    known: Annotated[int, Whole("[0, 1e6]")] = 5
    """Faces that a mean from an earlier session counts as much as: half a second. The caregiver may be another."""
    most: Annotated[int, Whole("[1, 1e9]")] = 1800
    """Faces over which the mean is taken, three minutes; older ones are forgotten exponentially."""

    ADVANCED: ClassVar = ("every", "known", "most")


class MeanFace:
    """The running mean of standardised face patterns.

    Attributes:
        config: Options.
        mean: (d,) float64, zeros before the first face.
        count: Number of faces that it counts as much as.
    """

    def __init__(self, dimension: int, config: MeanFaceConfig = MeanFaceConfig()):
        """Begin without a face.

        Args:
            dimension: Numbers in a pattern, d.
            config: Options.
        """
        self.config = config
        self.mean = np.zeros(dimension)
        self.count = 0
        self._waits = 0  # frames until a face counts again

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore it.

        Raises:
            ValueError: It is no mean of faces.
        """
        self.__dict__.update(state)
        check_array("the mean face", self.mean, self.mean.shape[:1], float)
        check_whole("faces", self.count, 0, self.config.most)

    def __repr__(self) -> str:
        return f"MeanFace({len(self.mean)} numbers, counts as {self.count} faces)"

    def look(self, pattern: Callable[[], np.ndarray]) -> None:
        """Look at a face for one frame; in some of them its ``pattern()`` counts."""
        self._waits = (self._waits or self.config.every) - 1
        if self._waits == 0:
            self.update(pattern())

    def update(self, pattern: np.ndarray) -> None:
        """Let a face pattern (d,) count."""
        self.count = min(self.count + 1, self.config.most)
        self.mean += (standardised(pattern) - self.mean) / self.count

    def deviation(self, pattern: np.ndarray) -> np.ndarray:
        """How a face pattern (d,) deviates from the mean, (d,) float64: both with zero mean and unit variance."""
        deviation: np.ndarray = standardised(pattern) - self.mean
        return deviation

    @classmethod
    def from_array(cls, mean: np.ndarray, config: MeanFaceConfig) -> "MeanFace":
        """Begin with the mean (d,) of an earlier session.

        Raises:
            ConfigError: It is no row of finite numbers.
        """
        mean = np.asarray(mean)
        if mean.ndim != 1 or mean.dtype.kind != "f" or not np.isfinite(mean).all():
            raise ConfigError(f"mean face: expected a row of finite numbers; got {mean.dtype} {mean.shape}")
        known = cls(len(mean), config)
        known.mean, known.count = mean.astype(float), config.known
        return known
