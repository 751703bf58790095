"""The table of colours that ``FootageAreas`` looks pixels up in."""

from collections.abc import Mapping

import numpy as np

from jointattn_mj.footage.colours import sought_objects
from jointattn_mj.perception.objects import ColourConfig, colour_table

_LEVELS = (np.arange(64) + 0.5) / 64


def label_table(
    objects: tuple[str, ...], picked: Mapping[str, np.ndarray], each: int, config: ColourConfig
) -> tuple[np.ndarray, np.ndarray]:
    """The label of each colour, and the colour of each candidate.

    Args:
        objects: What is searched for, as ``PerceiveConfig`` has it.
        picked: Colours of objects that were picked, (64^3,) bool, by name; they go before nominal ones.
        each: Areas that are followed of each object.
        config: How near a colour must be to a nominal one.

    Returns:
        (64^3,) uint8, 0 for none and k + 1 for object k; and (n each, 3), 0..1.
    """
    sought = sought_objects(objects)
    table = np.zeros(64**3, np.uint8)
    coloured = [k for k, wanted in enumerate(sought) if wanted.rgb is not None]
    rgb = np.array([item.rgb if item.rgb is not None else (0.5, 0.5, 0.5) for item in sought], float)
    if coloured:
        labels = colour_table(rgb[coloured], config)
        table = np.concatenate([[0], np.array(coloured) + 1])[labels].astype(np.uint8)
    for k, wanted in enumerate(sought):
        if wanted.name in picked:
            own = picked[wanted.name]
            table[own] = k + 1
            cells = np.flatnonzero(own)
            rgb[k] = [_LEVELS[cells >> shift & 63].mean() for shift in (12, 6, 0)]
    return table, np.repeat(rgb, each, axis=0)
