"""Categories of face patterns without labels: units of the self-organising map, grouped by similarity.

The map (``perception.som``) has similar faces on neighbouring units. Units that are the nearest of some face are joined
step by step, nearest groups first. The number of groups is the one with the largest mean silhouette (Rousseeuw, 1987):
faces are then most clearly nearer to their own group than to the next.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Whole
from jointattn_mj.perception.som import SOM


@dataclass(frozen=True)
class GroupingConfig(Checked):
    """How units of the map become categories."""

    most: Annotated[int, Whole("[2, 120]")] = 12
    """Largest number of categories; a table with 9 spots needs 10."""
    linkage: Literal["average", "complete", "single", "ward"] = "average"
    """Distance of two groups of units (see ``scipy.cluster.hierarchy.linkage``)."""


class FaceCategories:
    """A trained map, and the category of each of its units.

    Attributes:
        som: The map.
        group: (units,) category of each unit, 0 to count - 1; a unit that is nearest to no face has the category of the
            nearest unit that is.
        count: Number of categories.
    """

    def __init__(self, som: SOM, patterns: np.ndarray, config: GroupingConfig = GroupingConfig()):
        """Group the units of a map.

        Args:
            som: The map.
            patterns: (n, d) two or more faces like those that the map has learned from.
            config: How.

        Raises:
            ConfigError: Fewer than two patterns.
        """
        if len(patterns) < 2:
            raise ConfigError(f"grouping needs two face patterns or more; got {len(patterns)}")
        self.som = som
        hits = np.bincount([som.winner(pattern) for pattern in patterns], minlength=len(som.weights))
        used = np.flatnonzero(hits)
        groups = grouped(som.weights[used], hits[used], config)
        to_used = np.square(som.weights[:, None] - som.weights[used]).sum(axis=2)
        self.group = groups[to_used.argmin(axis=1)]
        self.count = int(groups.max()) + 1

    def __repr__(self) -> str:
        return f"FaceCategories({self.count} categories of {len(self.group)} units)"

    def of(self, pattern: np.ndarray) -> int:
        """The category of a face pattern (d,)."""
        return int(self.group[self.som.winner(pattern)])


def grouped(points: np.ndarray, weights: np.ndarray, config: GroupingConfig) -> np.ndarray:
    """Groups (n,) of points, with the largest mean silhouette.

    Args:
        points: (n, d).
        weights: (n,) how many faces each point stands for.
        config: Linkage, and the largest number of groups.
    """
    if len(points) < 3:
        return np.arange(len(points))
    from scipy.cluster.hierarchy import fcluster, linkage  # takes .2 s to import
    from scipy.spatial.distance import pdist, squareform

    apart = pdist(points)
    tree, distances = linkage(points, config.linkage), squareform(apart)
    stages = [fcluster(tree, count, "maxclust") - 1 for count in range(2, min(config.most, len(points) - 1) + 1)]
    return max(stages, key=lambda groups: silhouette(distances, groups, weights))


def silhouette(distances: np.ndarray, groups: np.ndarray, weights: np.ndarray) -> float:
    """Mean silhouette, -1 to 1, of n points, each of which stands for several faces.

    Args:
        distances: (n, n) between points.
        groups: (n,) group of each point, 0 to k - 1; k is 2 or more.
        weights: (n,) how many faces each point stands for, 1 or more.
    """
    member = np.eye(groups.max() + 1)[groups] * weights[:, None]
    size, total = member.sum(axis=0), distances @ member
    own = total[np.arange(len(groups)), groups] / np.maximum(size[groups] - 1, 1)
    other = np.where(np.eye(len(size), dtype=bool)[groups], np.inf, total / size).min(axis=1)
    with np.errstate(invalid="ignore"):
        clear = np.nan_to_num((other - own) / np.maximum(own, other))
    clear[size[groups] == 1] = 0.0
    return float(np.average(clear, weights=weights))
