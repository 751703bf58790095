"""Categories of face patterns that nobody named: cells of the self-organising map, grouped by how near they lie.

The map (``perception.som``) puts similar faces on neighbouring cells. Cells on which faces fall are joined, nearest
groups first, and of all the stages of that the one is kept in which faces are most clearly nearer to their own group
than to the next: by the mean silhouette (Rousseeuw, 1987). So how many categories there are is found, not given.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import pdist, squareform

from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Whole
from jointattn_mj.perception.som import SOM


@dataclass(frozen=True)
class GroupingConfig(Checked):
    """How cells become categories."""

    most: Annotated[int, Whole("[2, 120]")] = 12
    """Categories that are looked for at most; a table with 9 places needs 10."""
    linkage: Literal["average", "complete", "single", "ward"] = "average"
    """Distance of two groups of cells: ``average``, ``complete``, ``single`` or ``ward`` of those of their patterns."""


class FaceCategories:
    """A map that has been learned, and the group of each of its cells.

    Attributes:
        som: The map.
        group: (cells,) category of each cell, 0 to count - 1; a cell on which no face fell has that of the nearest one.
        count: How many there are.
    """

    def __init__(self, som: SOM, patterns: np.ndarray, config: GroupingConfig = GroupingConfig()):
        """``patterns`` (n, d) are faces like those that the map has learned from, two or more."""
        if len(patterns) < 2:
            raise ConfigError(f"grouping needs two face patterns or more; got {len(patterns)}")
        self.som = som
        hits = np.bincount([som.winner(pattern) for pattern in patterns], minlength=len(som.weights))
        used = np.flatnonzero(hits)
        groups = grouped(som.weights[used], hits[used], config)
        to_used = np.square(som.weights[:, None] - som.weights[used]).sum(axis=2)
        self.group = groups[to_used.argmin(axis=1)]
        self.count = int(groups.max()) + 1

    def of(self, pattern: np.ndarray) -> int:
        """The category of a face pattern (d,)."""
        return int(self.group[self.som.winner(pattern)])


def grouped(points: np.ndarray, weights: np.ndarray, config: GroupingConfig) -> np.ndarray:
    """Groups (n,) of points (n, d), each of which stands for ``weights`` (n,) faces."""
    if len(points) < 3:
        return np.arange(len(points))
    apart = pdist(points)
    tree, distances = linkage(points, config.linkage), squareform(apart)
    stages = [fcluster(tree, count, "maxclust") - 1 for count in range(2, min(config.most, len(points) - 1) + 1)]
    return max(stages, key=lambda groups: silhouette(distances, groups, weights))


def silhouette(distances: np.ndarray, groups: np.ndarray, weights: np.ndarray) -> float:
    """Mean silhouette, -1..1, of points that stand for ``weights`` (n,) faces each, which lie upon each other.

    Args:
        distances: (n, n) between points.
        groups: (n,) of each point, 0 to k - 1, k of 2 or more.
        weights: (n,) whole numbers above 0.
    """
    member = np.eye(groups.max() + 1)[groups] * weights[:, None]
    size, total = member.sum(axis=0), distances @ member
    own = total[np.arange(len(groups)), groups] / np.maximum(size[groups] - 1, 1)
    other = np.where(np.eye(len(size), dtype=bool)[groups], np.inf, total / size).min(axis=1)
    with np.errstate(invalid="ignore"):
        clear = np.nan_to_num((other - own) / np.maximum(own, other))
    clear[size[groups] == 1] = 0.0
    return float(np.average(clear, weights=weights))
