"""The objects on the table: name, colour and shape of each, and how large they are in the model."""

import colorsys
from dataclasses import dataclass
from typing import Literal, get_args

import mujoco

from jointattn_mj.options import Checked, Colour

Shape = Literal["box", "cylinder", "sphere"]
SHAPES: tuple[Shape, ...] = get_args(Shape)


@dataclass(frozen=True)
class ObjectConfig(Checked):
    """One object on the table."""

    name: str
    """Its label everywhere: in logs, tables, films and percepts."""
    rgb: Colour
    """Its colour, red, green and blue from 0 to 1: in the robot's images, and so in every video. It is saturated, since
    objects are told apart as colour areas (section 6.4.1)."""
    shape: Shape = "box"


def _hue(degrees: float, saturation: float = 1.0, value: float = 0.85) -> tuple[float, float, float]:
    return colorsys.hsv_to_rgb(degrees / 360, saturation, value)


OBJECTS: tuple[ObjectConfig, ...] = (
    ObjectConfig("red", _hue(0, 0.95, 0.86), "box"),
    ObjectConfig("yellow", _hue(54, 1.0, 0.92), "cylinder"),
    ObjectConfig("blue", _hue(232, 0.90, 0.86), "box"),
    ObjectConfig("green", _hue(128, 0.95, 0.66), "sphere"),
    ObjectConfig("magenta", _hue(308, 0.95, 0.86), "cylinder"),
    ObjectConfig("cyan", _hue(180, 1.0, 0.82), "sphere"),
    ObjectConfig("orange", _hue(27, 1.0, 0.95), "sphere"),
    ObjectConfig("violet", _hue(270, 0.88, 0.80), "box"),
    ObjectConfig("lime", _hue(88, 1.0, 0.85), "cylinder"),
    ObjectConfig("azure", _hue(206, 1.0, 0.92), "cylinder"),
)
"""Colour and shape of ten objects, hues at least 25 degrees apart; the first four are the dissertation's (6.4.1).

Marks that films and figures draw for an object take their colour from here too (``video.paint.ink_of``).
"""


def object_size(shape: str, edge: float) -> tuple[mujoco.mjtGeom, tuple[float, float, float]]:
    """MuJoCo's type and size of an object's geom.

    Args:
        shape: One of ``SHAPES``.
        edge: Edge or diameter, metres.
    """
    half = edge / 2
    return {
        "box": (mujoco.mjtGeom.mjGEOM_BOX, (half, half, half)),
        "cylinder": (mujoco.mjtGeom.mjGEOM_CYLINDER, (half * 0.9, half, 0)),
        "sphere": (mujoco.mjtGeom.mjGEOM_SPHERE, (half, 0, 0)),
    }[shape]
