"""At which candidate does somebody look? Cross-situational learning over all looks of a video at once.

As in ``gaze_following.cross_situational``, a candidate has evidence by how much more often something lies where it lies
with this face than with any (pointwise mutual information). Here all looks are stored: expectation and maximisation
alternate over them, and a hidden Markov model smooths what comes out, for a look lasts.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from jointattn_mj.footage.looks.config import LooksConfig

MOST_UNITS = 64
"""Most units along one axis of the grid of locations."""
SPACING = 1.25
"""Distance of these units, in standard deviations of a bump."""
LEAST_SHARE = 1e-4
"""Share of a unit in a bump that is kept."""
NEVER = -30.0
"""Evidence for a candidate of which no location is known."""
PARTS = 5
"""Parts of a video, each of which is judged by what was learned from the others."""
CHANCES = 8
"""Shifts of faces against locations that show what evidence there is by chance."""
ASIDE = 0.7
"""Standard deviation of where one looks by the yaw alone, in those of the candidates' locations."""


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

    def shares(self, locations: np.ndarray) -> sparse.csr_matrix:
        """Share of each unit in the bumps of ``locations`` (n, 2): (n, units) float32; rows only of known locations."""
        known = np.isfinite(locations).all(-1)
        bumps = []
        for axis, units in enumerate(self._axes):
            given = np.clip(np.where(known, locations[:, axis], units[0]), units[0], units[-1])
            exponent = -0.5 * ((units - given[:, None]) / self._tuning) ** 2
            bump = np.exp(exponent - exponent.max(axis=1, keepdims=True))
            bumps.append((bump / bump.sum(axis=1, keepdims=True)).astype(np.float32))
        shares: np.ndarray = (bumps[0][:, :, None] * bumps[1][:, None, :]).reshape(len(locations), -1)
        shares[~known] = 0
        shares[shares < LEAST_SHARE] = 0
        return sparse.csr_matrix(shares)


@dataclass(frozen=True, eq=False)
class Evidence:
    """Evidence for each candidate, log P(location | face) / P(location), smoothed; ``NEVER`` where it is nowhere known.

    Attributes:
        looks: (n, k) in each look, learned from the other parts of the video.
        by_chance: (``CHANCES`` n, k) where faces are put together with locations of other times, one after the other.
    """

    looks: np.ndarray
    by_chance: np.ndarray


def learn_evidence(
    faces: np.ndarray,
    locations: np.ndarray,
    config: LooksConfig,
    first: np.ndarray | None = None,
    labels: np.ndarray | None = None,
    block: int = 1,
) -> Evidence:
    """Evidence for each candidate in each look, learned from all of them.

    Where somebody looks at none of the candidates, learning takes the nearest for the target, and this look then speaks
    for that. So the evidence in a look is of what was learned from other parts of the video. What evidence there is
    where somebody looks elsewhere is seen by shifting faces against locations, by tenths of the video and more.

    Args:
        faces: (n, u) activations of a map of faces, each row summing to 1.
        locations: (n, k, 2) of candidates, from the face, in heights of the face's square; NaN where not known.
        config: ``tuning``, ``rounds`` and ``smoothing``.
        first: (n, k) how probable each target is before anything is learned; None for alike.
        labels: (n,) the target of looks that a person has coded, k for none of the candidates; -1 for all others.
        block: Looks that follow each other and err alike; at most a fifth of all is taken.
    """
    known = np.isfinite(locations).all(-1)
    if not known.any():
        return Evidence(np.full(known.shape, NEVER), np.full((CHANCES * len(known), known.shape[1]), NEVER))
    faces, (n, count) = faces.astype(np.float32), known.shape
    code = LocationCode(locations, config.tuning)
    shares = [code.shares(locations[:, k]) for k in range(count)]
    smoothing = config.smoothing / code.units
    with_any = sum(np.asarray(share.sum(axis=0)).ravel().astype(float) for share in shares) / known.sum() + smoothing
    base = np.stack([np.log(np.maximum(share @ with_any, 1e-12)) for share in shares], axis=1)
    spread = np.stack([np.asarray(share.sum(axis=1)).ravel() for share in shares], axis=1)

    def together(weights: np.ndarray, looks: np.ndarray) -> np.ndarray:
        """How often each location (units) goes with each face (u) in some of the looks."""
        parts = (share[looks].T @ (weights[looks, k, None] * faces[looks]) for k, share in enumerate(shares))
        counts: np.ndarray = sum(parts, np.zeros((code.units, faces.shape[1]), np.float32))
        return counts

    def compared(counts: np.ndarray, faces: np.ndarray, looks: np.ndarray) -> np.ndarray:
        total = np.maximum(faces @ counts.sum(axis=0), 1e-9)
        with_face = np.stack([np.einsum("nu,nu->n", share[looks] @ counts, faces) for share in shares], axis=1)
        likely = with_face / total[:, None] + smoothing * spread[looks]
        return np.where(known[looks], np.log(np.maximum(likely, 1e-12)) - base[looks], NEVER)

    everything = np.arange(n)
    weights = known.astype(float) if first is None else first * known
    weights = weights / np.maximum(weights.sum(axis=1, keepdims=True), 1e-12)
    for left in reversed(range(config.rounds)):
        if labels is not None:
            weights[labels >= 0] = np.eye(count + 1)[labels[labels >= 0], :count] * known[labels >= 0]
        weights = weights.astype(np.float32)
        if left:
            weights = posterior(config.sharpness * compared(together(weights, everything), faces, everything)) * known
    part = everything // max(1, min(block, -(-n // PARTS))) % PARTS
    counts = [together(weights, np.flatnonzero(part == number)) for number in range(PARTS)]
    whole, evidence = np.sum(counts, axis=0), np.empty(known.shape)
    for number in range(PARTS):
        looks = np.flatnonzero(part == number)
        evidence[looks] = compared(whole - counts[number], faces[looks], looks)
    lags = np.linspace(0.1, 0.9, CHANCES) * n
    chance = [compared(whole, np.roll(faces, round(lag), axis=0), everything) for lag in lags]
    return Evidence(evidence, np.concatenate(chance))


def aside(yaw_deg: np.ndarray, locations: np.ndarray) -> np.ndarray | None:
    """How probable each candidate is as the target, (n, k), by the side to which the head is turned.

    It is where learning starts, and keeps it from taking left for right in videos in which little is moved.

    Args:
        yaw_deg: (n,) yaw of the head, positive to the right of the image; NaN where not known.
        locations: (n, k, 2) of candidates, from the face; NaN where not known.

    Returns:
        The probabilities, alike where the yaw is not known; None where it is known of too few looks.
    """
    known, across = np.isfinite(yaw_deg), locations[..., 0]
    if known.mean() < 0.5 or not np.isfinite(across).any() or np.std(yaw_deg[known]) < 1e-6:
        return None
    spread = float(np.nanstd(across))
    turned = (yaw_deg - np.mean(yaw_deg[known])) / np.std(yaw_deg[known])
    off = across - np.nanmean(across) - spread * np.where(known, turned, 0)[:, None]
    log = np.where(np.isfinite(off), -0.5 * (off / max(ASIDE * spread, 1e-9)) ** 2, NEVER)
    log[~known] = 0
    return posterior(log)


def posterior(evidence: np.ndarray) -> np.ndarray:
    """Posterior (n, k) of targets that are alike beforehand, by the evidence (n, k) of each look alone."""
    odds = np.exp(evidence - evidence.max(axis=1, keepdims=True))
    shares: np.ndarray = odds / odds.sum(axis=1, keepdims=True)
    return shares


def smoothed(evidence: np.ndarray, stay: float, trust: float, prior: np.ndarray | None = None) -> np.ndarray:
    """Posterior of targets given all looks, before and after, by the forward-backward algorithm.

    Args:
        evidence: (n, k) log likelihoods, up to a constant in each look; n at least 1.
        stay: Probability of the same target in the next look, 0 to 1, if the others are alike.
        trust: Weight of each look's evidence, 0 to 1.
        prior: (k,) share of each target in the looks; None for alike.

    Returns:
        (n, k), each row summing to 1.
    """
    n, k = evidence.shape
    if k == 1:
        return np.ones((n, 1))
    shares = np.full(k, 1 / k) if prior is None else prior / prior.sum()
    likelihood = np.exp(trust * (evidence - evidence.max(axis=1, keepdims=True)))
    leave = (1 - stay) * k / (k - 1)
    forward, backward = np.empty((n, k)), np.ones((n, k))
    past = shares
    for i in range(n):
        past = likelihood[i] * (leave * shares + (1 - leave) * past)
        past = forward[i] = past / past.sum()
    for i in range(n - 2, -1, -1):
        future = likelihood[i + 1] * backward[i + 1]
        future = leave * (shares * future).sum() + (1 - leave) * future
        backward[i] = future / future.sum()
    both = forward * backward
    posterior: np.ndarray = both / both.sum(axis=1, keepdims=True)
    return posterior
