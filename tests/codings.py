"""Codings of looks for tests: independent people, and dyads of whom one follows the other.

Looks have lognormal lengths with a median of 10 steps and a spread (standard deviation of the logarithm) of .5 to 1.5,
as codings of people have.
"""

import numpy as np

STEPS = 5400
Pair = tuple[np.ndarray, np.ndarray]


def looks(steps: int, rng: np.random.Generator, spread: float, median: float = 10, places: int = 3) -> np.ndarray:
    """Where somebody looks, step by step; a spread of 0 is a new place at every step."""
    if spread == 0:
        return rng.integers(0, places, steps)
    lengths = np.maximum(1, rng.lognormal(np.log(median), spread, steps)).astype(int)
    codes = (rng.integers(places) + np.cumsum(rng.integers(1, places, len(lengths)))) % places
    return np.repeat(codes, lengths)[:steps]


def dyad(rng: np.random.Generator, spread: float, share: float = 0.5) -> Pair:
    """Somebody, and a partner who follows this share of looks after some 8 steps."""
    leader, follower = looks(STEPS, rng, spread), looks(STEPS, rng, spread)
    for t in np.flatnonzero(np.diff(leader)) + 1:
        then = t + 1 + int(rng.gamma(4, 2))
        if then < STEPS and rng.random() < share:
            stop = then + int(np.argmax(np.append(follower[then:] != follower[then], True)))
            follower[then:stop] = leader[t]
    return leader, follower
