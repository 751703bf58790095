"""Does somebody look at none of the candidates? Two groups of looks: at a candidate, or at anything else.

In a look at something else, candidates lie where they happen to lie, and there is evidence by chance alone. How much of
it there is by chance is known: faces were put together with locations of other times (see ``learning``). The share of
looks away is how often evidence is as low as it seldom is but by chance, and a single look is away with the probability
that the evidence in it is of this group (a local false discovery rate).
"""

import numpy as np

from jointattn_mj.footage.looks.learning import Evidence

LOOKS = 5
"""Looks over which evidence is averaged: a second."""
LEAST = -6.0
"""Evidence below which looks are alike."""
BINS, PER_BIN = 60, 20
"""Most bins of evidence, and fewest looks in one."""
SHARES = (0.005, 0.9)
"""Least and greatest share of looks away."""


def probability_away(evidence: Evidence, known: np.ndarray, still: np.ndarray, low: float) -> np.ndarray:
    """Probability (n,) that each look is at none of the candidates.

    Args:
        evidence: Of all looks.
        known: (n,) whether the locations of all candidates are known. Of other looks no more than the share is known.
        still: (k,) which candidates never change place, as a partner does not. Chance says nothing of these: a look of
            which they are the best target is not taken for one away.
        low: Share of evidence by chance that counts as low, 0 to 1. With more of it, looks at candidates count, too.
    """
    n, count = evidence.looks.shape
    most, best = _averaged(evidence.looks)
    usable = _all_around(known) & ~still[best]
    by_chance, whose = (
        np.concatenate(parts) for parts in zip(*map(_averaged, evidence.by_chance.reshape(-1, n, count)), strict=True)
    )
    chances = len(evidence.by_chance) // max(n, 1)
    by_chance = by_chance[np.tile(_all_around(known), chances) & ~still[whose]]
    probability = np.zeros(n)
    if usable.sum() < PER_BIN or len(by_chance) < PER_BIN:
        return probability
    seldom = float(np.quantile(by_chance, low))
    share = float(np.clip((most[usable] <= seldom).mean() / max((by_chance <= seldom).mean(), 1e-9), *SHARES))
    probability[usable] = _of_chance(most[usable], by_chance, share)
    probability[~usable & ~still[best]] = share
    return probability


def _of_chance(values: np.ndarray, by_chance: np.ndarray, share: float) -> np.ndarray:
    """Probability (n,) that each value is one of those by chance, which make up a share; it never rises with them."""
    bins = int(np.clip(len(values) // PER_BIN, 2, BINS))
    edges = np.unique(np.quantile(np.concatenate([values, by_chance]), np.linspace(0, 1, bins + 1))[1:-1])
    all_of_them, of_chance = (
        np.bincount(np.searchsorted(edges, ones), minlength=len(edges) + 1) / len(ones) for ones in (values, by_chance)
    )
    shares = np.clip(share * of_chance / np.maximum(all_of_them, 1e-9), 0, 1)
    from scipy.optimize import isotonic_regression  # takes .2 s to import

    falling = isotonic_regression(shares, weights=all_of_them + 1e-9, increasing=False).x
    middles = np.concatenate([edges[:1], (edges[1:] + edges[:-1]) / 2, edges[-1:]])
    probability: np.ndarray = np.interp(values, middles, falling)
    return probability


def _averaged(evidence: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Evidence for the best candidate (n,), over a second around each look, and which one that is."""
    window = np.ones(LOOKS) / LOOKS
    floored = np.maximum(evidence, LEAST)
    over_time = np.stack(
        [np.convolve(column, window, "full")[LOOKS // 2 :][: len(column)] for column in floored.T], axis=1
    )
    return over_time.max(axis=1), over_time.argmax(axis=1)


def _all_around(known: np.ndarray) -> np.ndarray:
    """(n,) where all looks over which evidence is averaged have ``known`` (n,)."""
    around = np.convolve(~known, np.ones(LOOKS), "full")[LOOKS // 2 :][: len(known)]
    flags: np.ndarray = around < 0.5
    return flags
