"""How often combinations of values come in surrogates that move the source as a whole.

An exact test of a combination takes steps as independent. Where looks are long it calls chance an effect; what the
combination's count is by chance must then come from the same surrogates as the measure's.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class SurrogateCounts:
    """Counts of combinations of values in surrogates."""

    columns: np.ndarray
    """int64 (4, cells): r, a, s and n of each combination, as in ``table.Entries``; 0 where the measure has no such
    variable."""
    counts: np.ndarray
    """float32 (surrogates, cells)."""

    def tested(self, columns: np.ndarray, observed: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Test counts against those of the surrogates.

        Args:
            columns: int64 (4, m): the combinations that were observed.
            observed: (m,) how often each came.

        Returns:
            z, p of each alone, and p of all together, (m,) each: the share of surrogates in which the largest z of all
            combinations reaches it (max-T, Westfall and Young 1993).
        """
        sizes = np.maximum(self.columns.max(1), columns.max(1)) + 1
        known, asked = (np.ravel_multi_index(tuple(indices), tuple(sizes)) for indices in (self.columns, columns))
        order = np.argsort(known)
        counts = self.counts[:, order[np.searchsorted(known, asked, sorter=order)]].astype(float)
        mean, sd = counts.mean(0), counts.std(0)
        sound = np.where(sd > 0, sd, 1.0)
        z, by_chance = (observed - mean) / sound, (counts - mean) / sound
        highest = by_chance.max(1)
        p = (1 + (counts >= observed).sum(0)) / (1 + len(counts))
        together = (1 + (highest[:, None] >= z - 1e-9).sum(0)) / (1 + len(counts))
        return np.where(sd > 0, z, 0.0), p, together
