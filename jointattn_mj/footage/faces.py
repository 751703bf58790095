"""The map of faces (section 6.3.3) from a video: an even sample of the face patterns seen, learned when it is over.

The map's schedules run over 1800 patterns, three minutes of a session. Videos are shorter or longer than that, so
patterns are kept, 1800 at the most and each with the same chance, and drawn from until the schedules are over.
"""

from typing import Any

import numpy as np
import pyarrow as pa

from jointattn_mj.gaze_following.columns import described
from jointattn_mj.perception.som import SOM, SOMConfig

KEPT = 1800
"""Face patterns kept: the three minutes of section 6.4.1 at ten looks a second."""
EVERY = 3
"""Images with a face from one that is kept to the next, as where the robot gets to know a caregiver (6.4.1)."""
MEANINGS = {
    "time_s": "time in the video",
    "row": "row of the cell of the map that is most like this face",
    "column": "its column",
    "activation": "how active that cell is, 0..1, of 1 for all cells",
}


class FaceAlbum:
    """Keeps face patterns; from more of them than fit, every one has the same chance to be kept."""

    def __init__(self, capacity: int, dimension: int, rng: np.random.Generator):
        self.visible = 0
        self._rng = rng
        self._patterns = np.zeros((capacity, dimension), np.float32)
        self._times = np.zeros(capacity)

    def add(self, pattern: np.ndarray, time_s: float) -> None:
        """Offer one pattern."""
        slot = self.visible if self.visible < len(self._times) else int(self._rng.integers(self.visible + 1))
        if slot < len(self._times):
            self._patterns[slot], self._times[slot] = pattern, time_s
        self.visible += 1

    @property
    def patterns(self) -> np.ndarray:
        """Those that are kept, (m, dimension), in order of time."""
        kept = min(self.visible, len(self._times))
        return self._patterns[np.argsort(self._times[:kept], kind="stable")]

    @property
    def times(self) -> np.ndarray:
        """When they were seen, (m,), s."""
        return np.sort(self._times[: min(self.visible, len(self._times))])

    def __getstate__(self) -> dict[str, Any]:
        """Only the patterns that are kept, in the order of their slots."""
        kept = min(self.visible, len(self._times))
        filled = {"_patterns": self._patterns[:kept], "_times": self._times[:kept]}
        return {**vars(self), **filled, "_capacity": len(self._times)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        patterns, times, capacity = (state.pop(name) for name in ("_patterns", "_times", "_capacity"))
        self.__init__(capacity, patterns.shape[1], state["_rng"])  # type: ignore[misc]
        self.visible = state["visible"]
        self._patterns[: len(patterns)], self._times[: len(times)] = patterns, times

    def learn(self, config: SOMConfig) -> SOM:
        """A map of the patterns that are kept; there is one at least."""
        som = SOM(self._patterns.shape[1], config, self._rng)
        som.train(self.patterns, self._rng)
        return som

    def table(self, som: SOM) -> pa.Table:
        """Which cell each of the patterns belongs to."""
        active = [som.activations(pattern) for pattern in self.patterns]
        cells = np.array([int(one.argmax()) for one in active])
        columns = {
            "time_s": self.times,
            "row": (cells // som.config.columns).astype(np.int32),
            "column": (cells % som.config.columns).astype(np.int32),
            "activation": np.array([float(one.max()) for one in active], np.float32),
        }
        return described(pa.table(columns), MEANINGS)
