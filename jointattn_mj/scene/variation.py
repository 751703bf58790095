"""Domain randomisation: ranges in which worlds differ, and the world that a seed draws from them.

Each option has a stream of random numbers of its own. Switching one on leaves the others as they are, and a wider range
stretches the same draws.
"""

from __future__ import annotations

import colorsys
from dataclasses import dataclass, fields, replace
from typing import Annotated
from zlib import crc32

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Choice, Colour, Real, Share, Whole, meant, shown
from jointattn_mj.scene.caregiver import CaregiverConfig
from jointattn_mj.scene.dressing import Conditions, Lamp, Surfaces
from jointattn_mj.scene.layout import LayoutConfig
from jointattn_mj.scene.model import SceneConfig
from jointattn_mj.scene.objects import SHAPES, ObjectConfig, Shape
from jointattn_mj.scene.people import IDENTITIES
from jointattn_mj.scene.sensor import Sensor
from jointattn_mj.scene.world import AS_USUAL, WorldConfig

SMALLEST_M, LARGEST_M = 0.01, 0.12
"""Smallest and largest object, metres."""
Part = Annotated[float, Real("[0, 0.9]")]
"""A share s, for factors from 1 - s to 1 + s."""


@dataclass(frozen=True)
class VariationConfig(Checked):
    """Ranges of what may differ; 0, or an empty list, changes nothing. A share s means a factor from 1 - s to 1 + s."""

    light_angle_deg: Annotated[float, Real("[0, 90]")] = 0.0
    """Largest angle, degrees, by which the lamp is moved around the table, and up or down."""
    light_strength: Part = 0.0
    """Share by which direct light and ambient light are each stronger or weaker."""
    light_tint: Part = 0.0
    """Share by which red, green and blue of all light are each stronger or weaker."""
    surface_colours: Part = 0.0
    """Share by which red, green and blue of table, wall, floor and clothes are each stronger or weaker."""
    textures: Share = 0.0
    """Largest share by which stripes, checks or blotches darken these; an image then takes 1.7 times as long."""
    people: tuple[Annotated[str, Choice(IDENTITIES)], ...] = ()
    """Names of caregivers, one of whom is drawn."""
    camera_noise: Annotated[float, Real("[0, 64]")] = 0.0
    """Largest standard deviation of noise, grey values of 0..255; an image then takes 1.4 times as long."""
    camera_brightness: Part = 0.0
    """Share by which images are brighter or darker."""
    camera_delay: Annotated[int, Whole("[0, 30]")] = 0
    """Largest delay of images, frames of 1/30 s."""
    object_shapes: tuple[Shape, ...] = ()
    """Shapes, one of which is drawn for each object: box, cylinder, sphere."""
    object_size: Part = 0.0
    """Share by which all objects together are larger or smaller; they stay between 1 and 12 cm."""
    object_hue_deg: Annotated[float, Real("[0, 180]")] = 0.0
    """Largest change of each object's hue, degrees. Hues of ``objects.OBJECTS`` are 25 apart, and perception knows a
    colour again up to 20."""
    object_shade: Part = 0.0
    """Share by which each object's saturation and brightness are each higher or lower."""
    layout: Annotated[float, Real("[0, 0.45]")] = 0.0
    """Largest share by which each edge of the area for objects moves inwards; many objects may then find no room."""
    pace: Part = 0.0
    """Share by which the caregiver is slower or faster in everything (``CaregiverConfig.at_pace``)."""

    @property
    def on(self) -> bool:
        """Whether anything may differ."""
        return self != VariationConfig()


PRESETS: dict[str, VariationConfig] = {
    "none": VariationConfig(),
    "lights": VariationConfig(light_angle_deg=25, light_strength=0.25, light_tint=0.08),
    "textures": VariationConfig(surface_colours=0.15, textures=0.35),
    "people": VariationConfig(people=tuple(IDENTITIES)),
    "camera": VariationConfig(camera_noise=5, camera_brightness=0.15, camera_delay=3),
    "objects": VariationConfig(object_shapes=SHAPES, object_size=0.25, object_hue_deg=8, object_shade=0.12),
    "layout": VariationConfig(layout=0.12),
    "pace": VariationConfig(pace=0.3),
}
"""Presets: moderate ranges by name; "all" is all of them.

Measured in object_transfer, 60 draws each, while the caregiver looks at the robot: OpenCV's frontal cascade finds the
face in 60 of 60 images with each preset and with none, and in 59 with "all". Colour areas find every object in view by
the colours that the robot expects (240 of 240 each).
"""


def _together(*parts: VariationConfig) -> VariationConfig:
    """All ranges of the parts; where two have the same one, the last counts."""
    varied = {
        option.name: getattr(part, option.name)
        for part in parts
        for option in fields(part)
        if getattr(part, option.name) != option.default
    }
    return VariationConfig(**varied)


PRESETS["all"] = _together(*PRESETS.values())
Variation = Annotated[str, Choice(PRESETS, joined="+")]
"""Names of presets, joined by +."""


def variation_of(asked: VariationConfig | str) -> VariationConfig:
    """Ranges from the names of presets.

    Args:
        asked: Names of presets, such as "lights", "lights+pace" or "all"; or ranges, which are returned as they are.

    Raises:
        ConfigError: No preset is called that.
    """
    if isinstance(asked, VariationConfig):
        return asked
    names = asked.split("+")
    unknown = [name for name in names if name not in PRESETS]
    if unknown:
        known = f"some of {', '.join(PRESETS)}, joined by +"
        raise ConfigError(f"variation: expected {known}; got {shown(asked)}{meant(asked, PRESETS)}")
    return _together(*(PRESETS[name] for name in names))


def drawn(world: WorldConfig, ranges: VariationConfig, seed: np.random.SeedSequence) -> tuple[WorldConfig, Conditions]:
    """Draw a world.

    Args:
        world: The world from which the drawn one differs.
        ranges: How far.
        seed: Decides the draws; it is not changed, and no child of it is used up.

    Returns:
        Looks, behaviour and layout; and light, surfaces and camera. With nothing to vary these are ``world`` itself and
        the usual conditions.
    """
    if not ranges.on:
        return world, AS_USUAL
    draw = _Draw(ranges, seed)
    scene, behaviour, layout = (
        _scene(world.scene, draw),
        _behaviour(world.behaviour, draw),
        _layout(world.layout, draw),
    )
    varied = replace(world, scene=scene, behaviour=behaviour, layout=layout)
    return varied, Conditions(_lamp(draw), _surfaces(draw), _sensor(draw))


class _Draw:
    """Draws for options, each from a stream of its own, which the option's name and the seed decide."""

    def __init__(self, ranges: VariationConfig, seed: np.random.SeedSequence):
        self.ranges, self._seed = ranges, seed

    def stream(self, option: str) -> np.random.Generator:
        """The option's stream, from its start."""
        key = (*self._seed.spawn_key, crc32(option.encode()))
        return np.random.default_rng(np.random.SeedSequence(self._seed.entropy, spawn_key=key))

    def around(self, option: str, count: int) -> np.ndarray:
        """Uniform numbers (count,) from minus the option's value to plus that."""
        numbers: np.ndarray = getattr(self.ranges, option) * self.stream(option).uniform(-1, 1, count)
        return numbers

    def up_to(self, option: str, count: int = 1) -> np.ndarray:
        """Uniform numbers (count,) from 0 to the option's value."""
        numbers: np.ndarray = getattr(self.ranges, option) * self.stream(option).uniform(0, 1, count)
        return numbers

    def seed(self, option: str) -> int:
        """A seed for what is drawn elsewhere; 0 with the option off."""
        return int(self.stream(f"{option} seed").integers(2**32)) if getattr(self.ranges, option) else 0


def _colour(channels: np.ndarray) -> Colour:
    red, green, blue = channels.tolist()
    return red, green, blue


def _lamp(draw: _Draw) -> Lamp:
    azimuth, elevation = draw.around("light_angle_deg", 2).tolist()
    tint = 1 + draw.around("light_tint", 3)
    direct, ambient = 1 + draw.around("light_strength", 2)
    return Lamp(azimuth, elevation, _colour(direct * tint), _colour(ambient * tint))


def _surfaces(draw: _Draw) -> Surfaces:
    table, wall, floor, clothes = (_colour(1 + part) for part in draw.around("surface_colours", 12).reshape(4, 3))
    contrast = float(draw.up_to("textures")[0])
    return Surfaces(table, wall, floor, clothes, contrast, draw.seed("textures"))


def _sensor(draw: _Draw) -> Sensor:
    brightness = 1 + float(draw.around("camera_brightness", 1)[0])
    delay = int(draw.stream("camera_delay").uniform() * (draw.ranges.camera_delay + 1))
    return Sensor(brightness, float(draw.up_to("camera_noise")[0]), delay, draw.seed("camera_noise"))


def _scene(scene: SceneConfig, draw: _Draw) -> SceneConfig:
    if draw.ranges.people:
        scene = replace(scene, caregiver=str(draw.stream("people").choice(draw.ranges.people)), face=None)
    size = scene.object_size * (1 + float(draw.around("object_size", 1)[0]))
    size = scene.object_size if size == scene.object_size else min(max(size, SMALLEST_M), LARGEST_M)
    return replace(scene, objects=_objects(scene.objects, draw), object_size=size)


def _objects(objects: tuple[ObjectConfig, ...], draw: _Draw) -> tuple[ObjectConfig, ...]:
    """Draw shape and colour of each object; objects that look alike stay alike."""
    looks = [(item.rgb, item.shape) for item in objects]
    alike = [looks.index(look) for look in looks]
    count = len(objects)
    hues, shades = draw.around("object_hue_deg", count), 1 + draw.around("object_shade", 2 * count).reshape(-1, 2)
    shapes = [item.shape for item in objects]
    if draw.ranges.object_shapes:
        shapes = draw.stream("object_shapes").choice(draw.ranges.object_shapes, count).tolist()
    return tuple(
        replace(item, rgb=_shaded(item.rgb, hues[kind], *shades[kind]), shape=shapes[kind])
        for item, kind in zip(objects, alike, strict=True)
    )


def _shaded(rgb: Colour, hue_deg: float, saturation: float, value: float) -> Colour:
    """A colour with its hue shifted, degrees, and its saturation and value multiplied."""
    if hue_deg == 0 and saturation == value == 1:
        return rgb
    h, s, v = colorsys.rgb_to_hsv(*rgb)
    return colorsys.hsv_to_rgb((h + float(hue_deg) / 360) % 1, min(float(saturation) * s, 1), min(float(value) * v, 1))


def _behaviour(behaviour: CaregiverConfig, draw: _Draw) -> CaregiverConfig:
    return behaviour.at_pace(1 + float(draw.around("pace", 1)[0]))


def _layout(layout: LayoutConfig, draw: _Draw) -> LayoutConfig:
    near, far, right, left = draw.up_to("layout", 4).tolist()
    return replace(layout, x_range=_narrowed(layout.x_range, near, far), y_range=_narrowed(layout.y_range, right, left))


def _narrowed(edges: tuple[float, float], low: float, high: float) -> tuple[float, float]:
    length = edges[1] - edges[0]
    return edges[0] + low * length, edges[1] - high * length
