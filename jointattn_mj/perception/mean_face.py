"""The mean of a person's faces, from which each face deviates: norm-based coding (Leopold et al., 2001).

What a face shows all the time says whose it is; how it deviates from that says where it is turned. How much a face
changes when it turns differs from person to person, for dark hair around a light face outweighs the features. So a
deviation is counted in units of this person's spread. A map that has learned the deviations of one person's faces
serves for another person too, once mean and spread of these are known.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.guards.restored import check_array, check_whole
from jointattn_mj.options import Checked, Whole
from jointattn_mj.perception.som import pattern_of


@dataclass(frozen=True)
class MeanFaceConfig(Checked):
    """Whether and how faces are coded as deviations from their mean. From the state a face has none."""

    subtracted: bool = False
    """Whether a face is coded by how it deviates from this person's mean, rather than as it is (the dissertation)."""
    every: Annotated[int, Whole("[1, 1e6]")] = 3
    """A face counts for the mean every N frames while it is looked at: ten a second, as in familiarisation."""
    known: Annotated[int, Whole("[0, 1e6]")] = 20
    """How many faces the mean and spread of an earlier session count as: those of two seconds. More faces of this
    session soon outweigh them, for the caregiver may be another."""
    most: Annotated[int, Whole("[1, 1e9]")] = 1800
    """Faces over which mean and spread are taken, three minutes; older ones are forgotten exponentially."""

    ADVANCED: ClassVar = ("every", "known", "most")


_FLAT = 1e-6
"""Spread below which faces do not differ; patterns have unit variance."""
_MOST_SPREAD = 2.0
"""Standardised patterns lie no farther apart, root mean squared."""


class MeanFace:
    """Running mean and spread of standardised face patterns. It can be pickled.

    Attributes:
        config: Options.
        count: Number of faces of this session that count.
    """

    def __init__(self, dimension: int, config: MeanFaceConfig = MeanFaceConfig()):
        """Begin without a face.

        Args:
            dimension: Numbers in a pattern, d.
            config: Options.
        """
        self.config = config
        self.count = 0
        self._known = 0  # faces that what is known from an earlier session counts as much as
        self._means = np.zeros((2, dimension))  # of an earlier session, and of this
        self._variances = np.zeros(2)  # mean squared deviation from these
        self._waits = 0  # frames until a face counts again

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore it.

        Raises:
            ValueError: It is no mean of faces.
        """
        self.__dict__.update(state)
        size = np.shape(self._means)[-1:]
        most = np.sqrt(size)  # that a number of a standardised pattern can be
        check_array("mean faces", self._means, (2, *size), float, -most, most)
        check_array("variances of faces", self._variances, (2,), float, 0, _MOST_SPREAD**2)
        check_whole("faces", self.count, 0, self.config.most)
        check_whole("known faces", self._known, 0, self.config.known)
        check_whole("frames until a face counts again", self._waits, 0, self.config.every)

    def __repr__(self) -> str:
        return f"MeanFace({self._means.shape[1]} numbers, counts as {self._known + self.count} faces)"

    @property
    def mean(self) -> np.ndarray:
        """(d,) float64, zeros before the first face."""
        return self._weighed(self._means)

    @property
    def spread(self) -> float:
        """Standard deviation of faces about their mean, over all numbers of a pattern; 0 before the second face."""
        return float(np.sqrt(self._weighed(self._variances)))

    def _weighed(self, values: np.ndarray) -> np.ndarray:
        """``values`` (2, ...) of what was known and of this session, by the number of faces of each."""
        counts = np.array([self._known, self.count])
        weighed: np.ndarray = counts @ values / max(1, counts.sum())
        return weighed

    def look(self, pattern: Callable[[], np.ndarray]) -> None:
        """Look at a face for one frame; in some of them its ``pattern()`` counts."""
        self._waits = (self._waits or self.config.every) - 1
        if self._waits == 0:
            self.update(pattern())

    def update(self, pattern: np.ndarray) -> None:
        """Let a face pattern (d,) count.

        Raises:
            ObservationError: NaN, infinity, or no numbers.
            ConfigError: Another number of them.
        """
        standardised = pattern_of(pattern, self._means.shape[1])
        self.count = min(self.count + 1, self.config.most)
        share = 1 / self.count
        change = standardised - self._means[1]
        self._means[1] += share * change
        self._variances[1] = (1 - share) * (self._variances[1] + share * np.mean(change * change))

    def deviation(self, pattern: np.ndarray) -> np.ndarray:
        """How a face pattern (d,) deviates from the mean, in units of the spread: (d,), zeros without spread.

        Raises:
            ObservationError: NaN, infinity, or no numbers.
            ConfigError: Another number of them.
        """
        deviation: np.ndarray = pattern_of(pattern, self._means.shape[1]) - self.mean
        return deviation / self.spread if self.spread > _FLAT else np.zeros_like(deviation)

    def arrays(self) -> dict[str, np.ndarray]:
        """Mean and spread, by name."""
        return {"mean_face": self.mean, "mean_face_spread": np.array(self.spread)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, np.ndarray], config: MeanFaceConfig) -> "MeanFace":
        """Begin with what the ``arrays`` of an earlier session hold.

        Args:
            arrays: ``mean_face`` (d,) and ``mean_face_spread``, a number, beside others.
            config: Options.

        Raises:
            ConfigError: They are no mean or no spread of standardised patterns.
            KeyError: There is none of that name.
        """
        mean, spread = np.asarray(arrays["mean_face"]), np.asarray(arrays["mean_face_spread"])
        most = float(np.sqrt(mean.size))
        if mean.ndim != 1 or mean.dtype.kind not in "iuf" or not ((mean >= -most) & (mean <= most)).all():
            raise ConfigError(
                f"mean face: expected a row of numbers from -{most:g} to {most:g}, the mean of standardised patterns; "
                f"got {mean.dtype} {mean.shape}"
            )
        if spread.ndim or spread.dtype.kind not in "iuf" or not 0 <= spread <= _MOST_SPREAD:
            given = " ".join(str(spread).split())
            raise ConfigError(f"spread of faces: expected a number from 0 to {_MOST_SPREAD:g}; got {given:.80}")
        known = cls(len(mean), config)
        known._known, known._means[0], known._variances[0] = config.known, mean, float(spread) ** 2
        return known
