"""Layouts of objects in turn taking: anywhere on the table, within the robot's first view, or outside it."""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Real, Whole
from jointattn_mj.scene.layout import LayoutConfig

Rectangle = tuple[float, float, float, float]  # x from, x to, y from, y to; world frame, metres

IN_VIEW: tuple[Rectangle, ...] = ((*LayoutConfig.x_range, *LayoutConfig.y_range),)
"""Part of the table that chapter 6 uses; all of it is in view while the robot looks at the face."""
OUTSIDE: tuple[Rectangle, ...] = ((0.50, 0.70, 0.43, 0.55), (0.50, 0.70, -0.55, -0.43))
"""Corners of the table near the robot, more than 31 degrees to either side, beyond the edge of the image."""
TABLE: tuple[Rectangle, ...] = ((0.50, 1.12, -0.55, 0.55),)
"""The whole table; its part near the robot is also below the first view."""
REGIONS = {"in_view": IN_VIEW, "outside": OUTSIDE, "table": TABLE}

TRIES = 300
"""Draws for one object after which its layout is begun anew."""


@dataclass(frozen=True)
class ObjectTableConfig(Checked):
    """Number and region of objects."""

    objects: Annotated[int, Whole("[1, 1000]")] = 5
    """Number of objects."""
    region: Literal["table", "in_view", "outside"] = "table"
    """Region of objects; ``table`` mixes locations in view and outside."""
    spacing: Annotated[float, Real("[0, 10]")] = 0.13
    """Least distance between two objects, metres, as in ``scene.layout``."""


def draw_locations(region: tuple[Rectangle, ...], count: int, rng: np.random.Generator) -> np.ndarray:
    """Random locations, uniform over all rectangles together.

    Args:
        region: Rectangles.
        count: How many locations.
        rng: For the draws.

    Returns:
        (count, 2) world frame, m.
    """
    corners = np.array(region)
    size = corners[:, 1::2] - corners[:, ::2]
    which = rng.choice(len(corners), size=count, p=size.prod(axis=1) / size.prod(axis=1).sum())
    locations: np.ndarray = corners[which, ::2] + size[which] * rng.random((count, 2))
    return locations


def draw_tables(config: ObjectTableConfig, count: int, rng: np.random.Generator) -> np.ndarray:
    """Random layouts whose objects are at least ``spacing`` apart.

    Args:
        config: Number and region of objects.
        count: How many layouts.
        rng: For the draws.

    Returns:
        (count, objects, 2) locations, world frame, m.

    Raises:
        ConfigError: So many objects do not fit.
    """
    region = REGIONS[config.region]
    tables = np.full((count, config.objects, 2), np.nan)
    for _ in range(TRIES):
        begun = np.flatnonzero(np.isnan(tables).any(axis=(1, 2)))
        if not len(begun):
            return tables
        tables[begun] = _fill(config, region, len(begun), rng)
    raise ConfigError(f"no room for {config.objects} objects {config.spacing} m apart in the region {config.region!r}")


def _fill(config: ObjectTableConfig, region: tuple[Rectangle, ...], count: int, rng: np.random.Generator) -> np.ndarray:
    """Try ``count`` layouts, object by object; those without room for all objects are NaN."""
    tables = np.full((count, config.objects, 2), np.nan)
    todo = np.arange(count)
    for i in range(config.objects):
        waiting = todo
        for _ in range(TRIES):
            locations = draw_locations(region, len(waiting), rng)
            apart = np.linalg.norm(tables[waiting, :i] - locations[:, None], axis=2)
            free = (apart >= config.spacing).all(axis=1)
            tables[waiting[free], i] = locations[free]
            waiting = waiting[~free]
            if not len(waiting):
                break
        tables[waiting] = np.nan
        todo = np.setdiff1d(todo, waiting, assume_unique=True)
    return tables
