"""Where objects lie in turn taking: anywhere on the table, within the robot's first view, or outside it."""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Real, Whole
from jointattn_mj.scene.layout import LayoutConfig

Rectangle = tuple[float, float, float, float]  # x from, x to, y from, y to; world frame, metres

IN_VIEW: tuple[Rectangle, ...] = ((*LayoutConfig.x_range, *LayoutConfig.y_range),)
"""The part of the table that chapter 6 uses; all of it is seen while the robot looks at the face."""
OUTSIDE: tuple[Rectangle, ...] = ((0.50, 0.70, 0.43, 0.55), (0.50, 0.70, -0.55, -0.43))
"""The table's corners at the robot: more than 31 degrees to either side, beyond the image's edge."""
TABLE: tuple[Rectangle, ...] = ((0.50, 1.12, -0.55, 0.55),)
"""Both, and what lies between; near the robot it is also below the first view."""
REGIONS = {"in_view": IN_VIEW, "outside": OUTSIDE, "table": TABLE}

TRIES = 300
"""Draws for one object after which its table is begun anew."""


@dataclass(frozen=True)
class ObjectTableConfig(Checked):
    """What lies on the table."""

    objects: Annotated[int, Whole("[1, 1000]")] = 5
    """How many objects."""
    region: Literal["table", "in_view", "outside"] = "table"
    """Where they may lie; ``table`` mixes places in view and outside."""
    spacing: Annotated[float, Real("[0, 10]")] = 0.13
    """Least distance between two, metres, as in ``scene.layout``."""


def draw_locations(region: tuple[Rectangle, ...], count: int, rng: np.random.Generator) -> np.ndarray:
    """(count, 2) places, uniform over the rectangles together."""
    corners = np.array(region)
    size = corners[:, 1::2] - corners[:, ::2]
    which = rng.choice(len(corners), size=count, p=size.prod(axis=1) / size.prod(axis=1).sum())
    return corners[which, ::2] + size[which] * rng.random((count, 2))


def draw_tables(config: ObjectTableConfig, count: int, rng: np.random.Generator) -> np.ndarray:
    """(count, objects, 2) places, each table's at least ``spacing`` apart.

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
    """One go at ``count`` tables, object by object; those that got full stay NaN."""
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
