"""At which candidate does somebody look? Cross-situational learning over all looks of a video at once.

As in ``gaze_following.cross_situational``, a candidate has evidence by how much more often something lies where it lies
with this face than with any (pointwise mutual information). Here all looks are stored: expectation and maximisation
alternate over them, and a hidden Markov model smooths what comes out, for a look lasts.
"""

import numpy as np

from jointattn_mj.footage.looks.config import LooksConfig

MOST_UNITS = 48
"""Most units along one axis of the grid of locations."""
SPACING = 1.25
"""Distance of these units, in standard deviations of a bump."""
NEVER = -30.0
"""Evidence for a candidate of which no location is known."""


class LocationCode:
    """Code of locations by bumps of activity on a grid of units that covers those of a video."""

    def __init__(self, locations: np.ndarray, tuning: float):
        """Lay out the grid.

        Args:
            locations: (n, k, 2), NaN where not known; at least one is.
            tuning: Standard deviation of a bump.
        """
        known = locations[np.isfinite(locations).all(-1)]
        self._tuning, self._axes = tuning, []
        for low, high in np.quantile(known, (0.005, 0.995), axis=0).T:
            count = int(np.clip(np.ceil((high - low) / (SPACING * tuning)) + 1, 2, MOST_UNITS))
            self._axes.append(np.linspace(low, high, count))
        self.units = len(self._axes[0]) * len(self._axes[1])

    def shares(self, locations: np.ndarray) -> np.ndarray:
        """Share of each unit in the bumps of ``locations`` (n, 2): (n, units) float32, zeros where one is NaN."""
        known = np.isfinite(locations).all(-1)
        bumps = []
        for axis, units in enumerate(self._axes):
            given = np.clip(np.where(known, locations[:, axis], units[0]), units[0], units[-1])
            exponent = -0.5 * ((units - given[:, None]) / self._tuning) ** 2
            bump = np.exp(exponent - exponent.max(axis=1, keepdims=True))
            bumps.append((bump / bump.sum(axis=1, keepdims=True)).astype(np.float32))
        shares: np.ndarray = (bumps[0][:, :, None] * bumps[1][:, None, :]).reshape(len(locations), -1)
        shares[~known] = 0
        return shares


def learn_evidence(faces: np.ndarray, locations: np.ndarray, config: LooksConfig) -> np.ndarray:
    """Evidence for each candidate in each look, learned from all of them.

    Args:
        faces: (n, u) activations of a map of faces, each row summing to 1.
        locations: (n, k, 2) of candidates, from the face, in heights of the face's square; NaN where not known.
        config: ``tuning``, ``rounds`` and ``smoothing``.

    Returns:
        (n, k) log P(location | face) / P(location), smoothed; ``NEVER`` where a location is not known.
    """
    known = np.isfinite(locations).all(-1)
    if not known.any():
        return np.full(known.shape, NEVER)
    faces = faces.astype(np.float32)
    code = LocationCode(locations, config.tuning)
    shares = [code.shares(locations[:, k]) for k in range(locations.shape[1])]
    smoothing = config.smoothing / code.units
    with_any = sum(share.sum(axis=0, dtype=float) for share in shares) / known.sum() + smoothing
    base = np.stack([np.log(np.maximum(share @ with_any, 1e-12)) for share in shares], axis=1)
    weights = known / np.maximum(known.sum(axis=1, keepdims=True), 1)
    evidence = np.zeros(known.shape)
    for _ in range(config.rounds):
        weights = weights.astype(np.float32)
        counts = sum(faces.T @ (weights[:, k, None] * one) for k, one in enumerate(shares))
        with_face = faces @ counts
        with_face = with_face / np.maximum(with_face.sum(axis=1, keepdims=True), 1e-9) + smoothing
        likelihood = np.stack([np.einsum("nb,nb->n", with_face, share) for share in shares], axis=1)
        evidence = np.where(known, np.log(np.maximum(likelihood, 1e-12)) - base, NEVER)
        weights = posterior(evidence) * known
    return evidence


def posterior(evidence: np.ndarray) -> np.ndarray:
    """Posterior (n, k) of targets that are alike beforehand, by the evidence (n, k) of each look alone."""
    odds = np.exp(evidence - evidence.max(axis=1, keepdims=True))
    shares: np.ndarray = odds / odds.sum(axis=1, keepdims=True)
    return shares


def smoothed(evidence: np.ndarray, stay: float, trust: float) -> np.ndarray:
    """Posterior of targets given all looks, before and after, by the forward-backward algorithm.

    Args:
        evidence: (n, k) log likelihoods, up to a constant in each look; n at least 1.
        stay: Probability of the same target in the next look, 0 to 1.
        trust: Weight of each look's evidence, 0 to 1.

    Returns:
        (n, k), each row summing to 1.
    """
    n, k = evidence.shape
    if k == 1:
        return np.ones((n, 1))
    likelihood = np.exp(trust * (evidence - evidence.max(axis=1, keepdims=True)))
    leave = (1 - stay) / (k - 1)
    forward, backward = np.empty((n, k)), np.ones((n, k))
    past = np.full(k, 1 / k)
    for i in range(n):
        past = likelihood[i] * (leave + (stay - leave) * past)
        past = forward[i] = past / past.sum()
    for i in range(n - 2, -1, -1):
        future = likelihood[i + 1] * backward[i + 1]
        future = leave * future.sum() + (stay - leave) * future
        backward[i] = future / future.sum()
    both = forward * backward
    shares: np.ndarray = both / both.sum(axis=1, keepdims=True)
    return shares
