"""Changes the light, colours and objects of a compiled scene, in a fraction of a millisecond; compiling takes sixty.

The caregiver and the number of objects stay as they were compiled.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated

import mujoco
import numpy as np
from dm_control.mujoco import Physics

from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Angle, Checked, Real, Seed, Share
from jointattn_mj.scene.model import SceneConfig
from jointattn_mj.scene.objects import object_size
from jointattn_mj.scene.sensor import Sensor
from jointattn_mj.scene.shapes import noise, smoothstep

SURFACES = {"table": "room/table", "wall": "room/wall", "floor": "room/floor", "clothes": "caregiver/cloth"}
"""Fields of ``Surfaces``, and their materials and textures in the model."""
LOWEST_DEG, HIGHEST_DEG = 10.0, 80.0
"""Bounds of the lamp's height above the horizon, degrees."""
Factor = Annotated[float, Real("[0, 100]")]
Factors = tuple[Factor, Factor, Factor]
"""Factors on red, green and blue."""
PLAIN: Factors = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Lamp(Checked):
    """The light of the room, relative to the usual one. The defaults change nothing."""

    azimuth_deg: Annotated[float, Real("[-360, 360]")] = 0.0
    """How far the lamp is moved around the table, degrees, anticlockwise seen from above."""
    elevation_deg: Angle = 0.0
    """How far the lamp is raised, degrees; it stays between 10 and 80 above the horizon."""
    direct: Factors = PLAIN
    """Factors on the lamp's red, green and blue."""
    ambient: Factors = PLAIN
    """Factors on the ambient light's red, green and blue."""


@dataclass(frozen=True)
class Surfaces(Checked):
    """Factors on the colours of large surfaces, and patterns on them. The defaults change nothing."""

    table: Factors = PLAIN
    wall: Factors = PLAIN
    floor: Factors = PLAIN
    clothes: Factors = PLAIN
    contrast: Share = 0.0
    """Share by which a pattern darkens all surfaces; it needs a scene built with ``blank``."""
    seed: Seed = 0
    """Seed of the patterns."""


@dataclass(frozen=True)
class Conditions(Checked):
    """Light, surfaces and camera under which a scene is rendered. The defaults change nothing."""

    lamp: Lamp = field(default_factory=Lamp)
    surfaces: Surfaces = field(default_factory=Surfaces)
    sensor: Sensor = field(default_factory=Sensor)


class Wardrobe:
    """Changes the looks of a model any number of times, always relative to how it was compiled."""

    def __init__(self, model: mujoco.MjModel):
        self._model = model
        self._light = model.light_dir[0].copy(), model.light_diffuse[0].copy(), model.light_ambient[0].copy()
        self._headlight = model.vis.headlight.ambient.copy()
        self._rgba = {name: model.material(kept).rgba.copy() for name, kept in SURFACES.items()}
        self._textures: dict[str, np.ndarray] = {}

    def dress(self, scene: SceneConfig, conditions: Conditions) -> list[int]:
        """Change the model's objects, light and surfaces.

        Args:
            scene: Shapes, sizes and colours of the objects.
            conditions: Light and surfaces.

        Returns:
            Ids of the textures that were painted on.

        Raises:
            ConfigError: Patterns are asked for in a scene without textures.
        """
        self._light_up(conditions.lamp)
        for name, material in SURFACES.items():
            self._model.material(material).rgba[:3] = self._rgba[name][:3] * getattr(conditions.surfaces, name)
        for item in scene.objects:
            _shape(self._model, self._model.geom(f"object/{item.name}").id, item.shape, scene.object_size)
            self._model.geom(f"object/{item.name}").rgba[:3] = item.rgb
        return self._paint(conditions.surfaces)

    def _light_up(self, lamp: Lamp) -> None:
        model, (direction, diffuse, ambient) = self._model, self._light
        model.light_dir[0] = _turned(direction, lamp) if lamp.azimuth_deg or lamp.elevation_deg else direction
        model.light_diffuse[0], model.light_ambient[0] = diffuse * lamp.direct, ambient * lamp.ambient
        model.vis.headlight.ambient[:] = self._headlight * lamp.ambient

    def _paint(self, surfaces: Surfaces) -> list[int]:
        """Paint patterns over the original textures; returns the textures' ids."""
        if not surfaces.contrast and not self._textures:
            return []
        rng, painted = np.random.default_rng(surfaces.seed), []
        for name, kept in SURFACES.items():
            image = self._texture(kept)
            self._textures.setdefault(name, image.copy())
            image[:] = np.round(self._textures[name] * (1 - surfaces.contrast * pattern(rng, len(image)))[..., None])
            painted.append(self._model.texture(kept).id)
        return painted

    def _texture(self, name: str) -> np.ndarray:
        """A texture of the model, (h, w, 3) uint8, as a view to write to."""
        model = self._model
        number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_TEXTURE, name)
        if number < 0:
            raise ConfigError(f"patterns need textures, and {name} has none: build the scene with blank=True")
        begin, height, width = model.tex_adr[number], model.tex_height[number], model.tex_width[number]
        texture: np.ndarray = model.tex_data[begin : begin + 3 * height * width].reshape(height, width, 3)
        return texture


def upload(physics: Physics, textures: list[int]) -> None:
    """Send painted textures (ids) to OpenGL, if the physics has rendered already; else the first image reads them."""
    contexts = physics._contexts  # the public name would open a context where there is none
    if contexts is None:
        return
    with contexts.gl.make_current() as thread:
        for texture in textures:
            thread.call(mujoco.mjr_uploadTexture, physics.model.ptr, contexts.mujoco.ptr, texture)


def _turned(direction: np.ndarray, lamp: Lamp) -> np.ndarray:
    """The direction (3,) of the light after the lamp has moved."""
    x, y, z = direction
    azimuth = np.arctan2(y, x) + np.radians(lamp.azimuth_deg)
    height = np.degrees(np.arctan2(-z, np.hypot(x, y))) + lamp.elevation_deg
    height = np.radians(np.clip(height, LOWEST_DEG, HIGHEST_DEG))
    return np.array([np.cos(height) * np.cos(azimuth), np.cos(height) * np.sin(azimuth), -np.sin(height)])


def _shape(model: mujoco.MjModel, geom: int, shape: str, edge: float) -> None:
    """Give a geom another shape, and the bounds that the compiler would work out; ``edge`` in metres."""
    kind, size = object_size(shape, edge)
    radius, height, _ = size
    half = {"box": size, "cylinder": (radius, radius, height), "sphere": (radius, radius, radius)}[shape]
    model.geom_type[geom], model.geom_size[geom] = kind, size
    model.geom_aabb[geom] = (0, 0, 0, *half)
    model.geom_rbound[geom] = {"cylinder": np.hypot(radius, height), "sphere": radius}.get(shape, np.linalg.norm(size))


def pattern(rng: np.random.Generator, size: int) -> np.ndarray:
    """Stripes, checks or blotches: (size, size), 0 to 1, seamless when repeated."""
    make: tuple[Callable[[np.random.Generator, int], np.ndarray], ...] = (_stripes, _checks, _blotches)
    return make[rng.integers(len(make))](rng, size)


def _waves(rng: np.random.Generator, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Waves along u and along v, three to nine on the texture: both (size, size), -1 to 1."""
    along = 2 * np.pi * (np.arange(size) + 0.5) / size
    u, v = (np.sin(rng.integers(3, 10) * along + rng.uniform(0, 2 * np.pi)) for _ in range(2))
    return np.broadcast_to(u, (size, size)), np.broadcast_to(v[:, None], (size, size))


def _stripes(rng: np.random.Generator, size: int) -> np.ndarray:
    return smoothstep(_waves(rng, size)[rng.integers(2)], -0.3, 0.3)


def _checks(rng: np.random.Generator, size: int) -> np.ndarray:
    u, v = _waves(rng, size)
    return smoothstep(u * v, -0.15, 0.15)


def _blotches(rng: np.random.Generator, size: int) -> np.ndarray:
    cells = int(rng.integers(4, 13))
    return smoothstep(noise(rng, (size, size), (cells, cells)), -1.0, 1.0)
