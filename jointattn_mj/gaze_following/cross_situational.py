"""Cross-situational learner: which of the objects in view does a face go with?

A look at the face leaves open which object the caregiver looks at. Over many looks only the right one lies where it
lies with this face and not with others. The learner counts, for each direction, how often something lies there with
each face, and how often with any. The evidence for an object is the log ratio of the two, the pointwise mutual
information of face and location: contingency, as in chapter 4 (T^C subtracts what comes anyway), in place of the
co-occurrence of chapter 6.
"""

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.gate import softmax
from jointattn_mj.gaze_following.learners import LearnerConfig, Locations, PopulationCode, locations_in_view, same_shape
from jointattn_mj.guards.border import numbers

_TINY = 1e-12
"""Stands in for a count of 0 where it divides."""


class CrossSituationalLearner:
    """Counts faces and locations that come together, each object in view by its share in the competition for the face.

    ``LearnerConfig`` says what is paired with a face, whether the base rate counts, how sharply objects compete, and
    how fast counts are forgotten.
    """

    def __init__(self, config: LearnerConfig, inputs: int):
        """Make a learner of ``inputs`` SOM units that has counted nothing."""
        self._config, self._code = config, PopulationCode(config)
        self._counts = np.zeros((inputs + 1, config.units[0] * config.units[1] + 1))

    def __repr__(self) -> str:
        return f"CrossSituationalLearner({self._counts[-1, -1]:.0f} looks at the face, less those forgotten)"

    def predict(self, face: np.ndarray) -> np.ndarray:
        """The command (2,), deg, whose units have the greatest evidence for the face (k,)."""
        with_face, with_any = self._shares(face)
        return self._code.decode((with_face / with_any).reshape(self._code.shape))

    def score(self, face: np.ndarray, locations: Locations) -> np.ndarray:
        """Evidence s_k (n,) for each of the n objects in view: log P(location | face) / P(location), smoothed.

        Without base rate it is log P(location | face).
        """
        return self._evidence(face, self._code.shares(locations_in_view(locations)))

    def learn(self, face: np.ndarray, locations: Locations) -> None:
        """Count one look at the face; without an object in view, and without one reached, nothing is learned."""
        shares = self._code.shares(locations_in_view(locations))
        reached = None
        if locations.reached is not None:
            reached = self._code.shares(numbers("locations.reached", locations.reached, (2,))[None])[0]
        if not len(shares) and reached is None:
            return
        paired, weight = self._paired(face, locations, shares, reached)
        counts = self._counts
        counts *= 1 - self._config.forgetting
        counts[:-1, :-1] += np.multiply.outer(face, paired)
        counts[:-1, -1] += weight * face
        if len(shares):
            counts[-1, :-1] += shares.mean(axis=0)
            counts[-1, -1] += 1

    def weights(self) -> np.ndarray:
        """Counts (k + 1, units + 1): of face and location; last column: of faces; last row: of locations, of looks."""
        return self._counts.copy()

    def load(self, weights: np.ndarray) -> None:
        """Take over what ``weights`` gave.

        Raises:
            ConfigError: It does not fit, or has negative counts.
        """
        counts = same_shape(weights, self._counts)
        if (counts < 0).any():
            raise ConfigError(f"learned weights are counts, 0 or more; got {counts.min():g}")
        self._counts = counts

    def _shares(self, face: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Smoothed P(location | face) and P(location), or 1 without base rate, of all units: (units,) each."""
        counts = self._counts
        given = numbers("activations of the face", face, (len(counts) - 1,))
        with_face = given @ counts[:-1]
        smoothing = self._config.smoothing / (counts.shape[1] - 1)
        share = with_face[:-1] / max(with_face[-1], _TINY) + smoothing
        if self._config.base == "none":
            return share, np.ones(len(share))
        return share, counts[-1, :-1] / max(counts[-1, -1], _TINY) + smoothing

    def _evidence(self, face: np.ndarray, shares: np.ndarray) -> np.ndarray:
        """Evidence (n,) for locations whose bumps are ``shares`` (n, units)."""
        with_face, with_any = self._shares(face)
        evidence: np.ndarray = np.log((shares @ with_face) / (shares @ with_any))
        return evidence

    def _paired(
        self, face: np.ndarray, locations: Locations, shares: np.ndarray, reached: np.ndarray | None
    ) -> tuple[np.ndarray, float]:
        """What is counted with the face: bumps (units,) by their weight, and the sum of weights.

        Args:
            face: Its activations (k,).
            locations: Where objects lay.
            shares: (n, units) bumps of those in view.
            reached: (units,) bump of the one reached; None without one.
        """
        competing = self._counts[-1, -1] >= self._config.compete_after
        weights = softmax((self._config.competition if competing else 0.0) * self._evidence(face, shares))
        if self._config.pairs == "in_view":
            return weights @ shares, float(len(weights) > 0)
        if reached is None:
            return np.zeros(shares.shape[1]), 0.0
        weight = 1.0
        if self._config.competition and len(weights):
            nearest = np.argmin(np.linalg.norm(locations.in_view - locations.reached, axis=1))
            weight = float(weights[nearest])
        return weight * reached, weight
