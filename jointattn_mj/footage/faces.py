"""The map of faces (section 6.3.3) of a video, learned from an even sample of its face patterns when it is over.

The map's schedules run over 1800 patterns, three minutes of a session, and videos are shorter or longer. At most 1800
patterns are kept, each with the same probability, and drawn from until the schedules are over.
"""

from typing import Any

import numpy as np
import pyarrow as pa

from jointattn_mj.gaze_following.columns import described
from jointattn_mj.perception.som import SOM, SOMConfig

KEPT = 1800
"""Most face patterns that are kept: three minutes of section 6.4.1 at ten a second."""
EVERY = 3
"""Offer the pattern of every N-th image with a face, as in familiarisation (6.4.1)."""
MEANINGS = {
    "time_s": "time in the video",
    "row": "row of the map's unit that is most like this face",
    "column": "its column",
    "activation": "activation of that unit, 0..1; those of all units sum to 1",
}


class FaceAlbum:
    """Keeps an even sample of face patterns.

    Attributes:
        offered: Number of patterns that were offered so far.
    """

    def __init__(self, capacity: int, dimension: int, rng: np.random.Generator):
        """Make an empty album.

        Args:
            capacity: Most patterns that are kept.
            dimension: Numbers in a pattern, d.
            rng: Draws which patterns are kept.
        """
        self.offered = 0
        self._rng = rng
        self._patterns = np.zeros((capacity, dimension), np.float32)
        self._times = np.zeros(capacity)

    def add(self, pattern: np.ndarray, time_s: float) -> None:
        """Offer the pattern (d,) of a face at ``time_s`` seconds of the video."""
        slot = self.offered if self.offered < len(self._times) else int(self._rng.integers(self.offered + 1))
        if slot < len(self._times):
            self._patterns[slot], self._times[slot] = pattern, time_s
        self.offered += 1

    @property
    def patterns(self) -> np.ndarray:
        """Patterns that are kept, (m, d), in order of time."""
        kept = min(self.offered, len(self._times))
        return self._patterns[np.argsort(self._times[:kept], kind="stable")]

    @property
    def times(self) -> np.ndarray:
        """Their times in the video, (m,), s."""
        return np.sort(self._times[: min(self.offered, len(self._times))])

    def __getstate__(self) -> dict[str, Any]:
        """State for a checkpoint, without empty slots."""
        kept = min(self.offered, len(self._times))
        filled = {"_patterns": self._patterns[:kept], "_times": self._times[:kept]}
        return {**vars(self), **filled, "_capacity": len(self._times)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        patterns, times, capacity = (state.pop(name) for name in ("_patterns", "_times", "_capacity"))
        self.__init__(capacity, patterns.shape[1], state["_rng"])  # type: ignore[misc]
        self.offered = state["offered"]
        self._patterns[: len(patterns)], self._times[: len(times)] = patterns, times

    def learn(self, config: SOMConfig) -> SOM:
        """A map learned from the patterns that are kept; there must be one."""
        som = SOM(self._patterns.shape[1], config, self._rng)
        som.train(self.patterns, self._rng)
        return som

    def table(self, som: SOM, start_s: float = 0.0) -> pa.Table:
        """Table of the patterns that are kept, with the unit of ``som`` that is most like each.

        Args:
            som: The map.
            start_s: Time of the first frame, s.
        """
        active = [som.activations(pattern) for pattern in self.patterns]
        units = np.array([int(activation.argmax()) for activation in active])
        columns = {
            "time_s": start_s + self.times,
            "row": (units // som.config.columns).astype(np.int32),
            "column": (units % som.config.columns).astype(np.int32),
            "activation": np.array([float(activation.max()) for activation in active], np.float32),
        }
        return described(pa.table(columns), MEANINGS)
