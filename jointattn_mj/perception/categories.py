"""Categories of face patterns that nobody named: cells of the self-organising map, grouped by how near they lie.

The map (``perception.som``) puts similar faces on neighbouring cells; faces that differ much leave cells between them
on which no face falls. Cells on which faces do fall are joined, nearest groups first, and joining stops where the next
merger would have to reach farther than the last one by the largest factor: how many categories there are is found.
"""

from dataclasses import dataclass

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage

from jointattn_mj.errors import ConfigError
from jointattn_mj.perception.som import SOM


@dataclass(frozen=True)
class GroupingConfig:
    """How cells become categories."""

    least: int = 2
    """Categories that are looked for at least: where faces form a continuum there is no gap to stop at."""
    most: int = 12
    """Categories that are looked for at most; the table with 9 places needs 10."""
    linkage: str = "average"
    """Distance of two groups of cells: ``average``, ``complete``, ``single`` or ``ward`` of those of their patterns."""
    least_share: float = 0.002
    """A cell counts as used if at least this share of the faces fell on it: fewer were cut out wrongly."""

    def __post_init__(self) -> None:
        if self.linkage not in ("average", "complete", "single", "ward"):
            raise ConfigError(f"linkage must be average, complete, single or ward; got {self.linkage!r}")
        if not 2 <= self.least <= self.most or not 0 <= self.least_share < 1:
            raise ConfigError(
                "least starts at 2, most at least, and least_share lies in [0, 1); "
                f"got {self.least}, {self.most}, {self.least_share}"
            )


class FaceCategories:
    """A map that has been learned, and the group of each of its cells.

    Attributes:
        som: The map.
        group: (cells,) category of each cell, 0 to count - 1.
        count: How many there are.
    """

    def __init__(self, som: SOM, patterns: np.ndarray, config: GroupingConfig = GroupingConfig()):
        """``patterns`` (n, d) are faces like those that the map has learned from, two or more."""
        if len(patterns) < 2:
            raise ConfigError(f"grouping needs two face patterns or more; got {len(patterns)}")
        self.som = som
        hits = np.bincount([som.winner(pattern) for pattern in patterns], minlength=len(som.weights))
        used = np.flatnonzero(hits > config.least_share * len(patterns))
        groups = _groups(som.weights[used], config)
        to_used = np.square(som.weights[:, None] - som.weights[used]).sum(axis=2)
        self.group = groups[to_used.argmin(axis=1)]
        self.count = int(groups.max()) + 1

    def of(self, pattern: np.ndarray) -> int:
        """The category of a face pattern (d,)."""
        return int(self.group[self.som.winner(pattern)])


def _groups(points: np.ndarray, config: GroupingConfig) -> np.ndarray:
    """Groups (n,) of points (n, d), where joining goes on farthest without a merger; one where there is one point."""
    if len(points) <= config.least:
        return np.arange(len(points))
    tree = linkage(points, config.linkage)
    strides = tree[::-1, 2][config.least - 2 : config.most]
    with np.errstate(divide="ignore"):
        count = config.least + int((strides[:-1] / strides[1:]).argmax())
    return fcluster(tree, count, "maxclust") - 1
