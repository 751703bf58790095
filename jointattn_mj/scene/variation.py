"""Domain randomisation: how far a world may differ from the one that was asked for, and the world that a seed draws.

Each option is drawn from a stream of its own, so that switching one on leaves the others as they are, and a wider range
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
from jointattn_mj.scene.model import SHAPES, ObjectConfig, SceneConfig, Shape
from jointattn_mj.scene.people import IDENTITIES
from jointattn_mj.scene.sensor import Sensor
from jointattn_mj.scene.world import AS_USUAL, WorldConfig

DURATIONS = ("greet_s", "turn_s", "reach_s", "lift_s", "observe_s", "put_s", "gaze_s", "withdraw_s")
"""What ``pace`` stretches."""
SMALLEST_M, LARGEST_M = 0.01, 0.12
"""Objects of other sizes the scene does not have."""
Part = Annotated[float, Real("[0, 0.9]")]
"""Of a factor 1 +- this."""


@dataclass(frozen=True)
class VariationConfig(Checked):
    """Ranges, each for one thing; 0, or nobody and nothing, leaves that as it is. A share s means a factor 1 +- s."""

    light_angle_deg: Annotated[float, Real("[0, 90]")] = 0.0
    """The lamp is moved by up to so much around the table, and up or down."""
    light_strength: Part = 0.0
    """Share by which direct light, and light from all around, are each stronger or weaker."""
    light_tint: Part = 0.0
    """Share by which all light is more or less red, green and blue."""
    surface_colours: Part = 0.0
    """The same for each of table, wall, floor and clothes."""
    textures: Share = 0.0
    """Largest share by which stripes, checks or blotches darken these; a frame then takes 1.7 times as long."""
    people: tuple[Annotated[str, Choice(IDENTITIES)], ...] = ()
    """Names of caregivers, one of whom is there."""
    camera_noise: Annotated[float, Real("[0, 64]")] = 0.0
    """Largest standard deviation of noise, grey values of 0..255; a frame then takes 1.4 times as long."""
    camera_brightness: Part = 0.0
    """Share by which images are brighter or darker."""
    camera_delay: Annotated[int, Whole("[0, 30]")] = 0
    """Most frames (1/30 s) by which images come late."""
    object_shapes: tuple[Shape, ...] = ()
    """Shapes, one of which each object has: box, cylinder, sphere."""
    object_size: Part = 0.0
    """Share by which all objects are larger or smaller; they stay between 1 and 12 cm."""
    object_hue_deg: Annotated[float, Real("[0, 180]")] = 0.0
    """Each object's hue differs by up to so much; those of ``model.OBJECTS`` lie 25 degrees apart, and perception by
    colour areas knows them up to 20."""
    object_shade: Part = 0.0
    """Share by which each object's saturation, and its brightness, are more or less."""
    layout: Annotated[float, Real("[0, 0.45]")] = 0.0
    """Largest share of its length by which each edge of the part of the table that objects lie on moves inwards; with
    many objects there may be no room for them."""
    pace: Part = 0.0
    """Share by which everything that she does takes more or less time."""

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
"""Moderate ranges by name; "all" is all of them.

Measured in object_transfer, 60 draws each: OpenCV's frontal cascade finds the caregiver's face, while she looks at the
robot, in 60 of 60 images with each of them, and as usual; with "all" in 59. Colour areas find every object that is in
view, by the colours that the robot expects (240 of 240 each).
"""


def _together(*parts: VariationConfig) -> VariationConfig:
    """All that any of the parts varies; of two that vary the same thing the last has its way."""
    varied = {
        option.name: getattr(part, option.name)
        for part in parts
        for option in fields(part)
        if getattr(part, option.name) != option.default
    }
    return VariationConfig(**varied)


PRESETS["all"] = _together(*PRESETS.values())
Variation = Annotated[str, Choice(PRESETS, joined="+")]
"""Names of presets."""


def variation_of(asked: VariationConfig | str) -> VariationConfig:
    """Ranges as they are, or by the names of presets: "lights", "lights+pace", "all".

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
    """A world within ``ranges`` of ``world``, and under which conditions it is seen; ``seed`` is left as it was.

    With nothing to vary this is ``world`` itself, under the usual conditions.
    """
    if not ranges.on:
        return world, AS_USUAL
    draw = _Draw(ranges, seed)
    varied = WorldConfig(
        scene=_scene(world.scene, draw), behaviour=_behaviour(world.behaviour, draw), layout=_layout(world.layout, draw)
    )
    return varied, Conditions(_lamp(draw), _surfaces(draw), _sensor(draw))


class _Draw:
    """Draws for options, each from a stream of its own that its name and the seed decide."""

    def __init__(self, ranges: VariationConfig, seed: np.random.SeedSequence):
        self.ranges, self._seed = ranges, seed

    def stream(self, option: str) -> np.random.Generator:
        """The beginning of the option's stream."""
        key = (*self._seed.spawn_key, crc32(option.encode()))
        return np.random.default_rng(np.random.SeedSequence(self._seed.entropy, spawn_key=key))

    def around(self, option: str, count: int) -> np.ndarray:
        """Numbers (count,) from minus the option to it."""
        return getattr(self.ranges, option) * self.stream(option).uniform(-1, 1, count)

    def up_to(self, option: str, count: int = 1) -> np.ndarray:
        """Numbers (count,) from 0 to the option."""
        return getattr(self.ranges, option) * self.stream(option).uniform(0, 1, count)

    def seed(self, option: str) -> int:
        """Of what is to be drawn elsewhere; 0 with the option off."""
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
    """Each another shape and colour; objects that look alike go on looking alike."""
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
    """A colour with its hue moved on, and its saturation and value multiplied."""
    if hue_deg == 0 and saturation == value == 1:
        return rgb
    h, s, v = colorsys.rgb_to_hsv(*rgb)
    return colorsys.hsv_to_rgb((h + float(hue_deg) / 360) % 1, min(float(saturation) * s, 1), min(float(value) * v, 1))


def _behaviour(behaviour: CaregiverConfig, draw: _Draw) -> CaregiverConfig:
    factor = 1 + float(draw.around("pace", 1)[0])
    return replace(behaviour, **{name: getattr(behaviour, name) * factor for name in DURATIONS})


def _layout(layout: LayoutConfig, draw: _Draw) -> LayoutConfig:
    near, far, right, left = draw.up_to("layout", 4).tolist()
    return replace(layout, x_range=_narrowed(layout.x_range, near, far), y_range=_narrowed(layout.y_range, right, left))


def _narrowed(edges: tuple[float, float], low: float, high: float) -> tuple[float, float]:
    length = edges[1] - edges[0]
    return edges[0] + low * length, edges[1] - high * length
