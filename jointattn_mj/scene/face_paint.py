"""Paints the head: skin, brows, lashes, lips, hair, and the shade that software lighting leaves out.

Coordinates are those of ``face_shape``: azimuth, and (y, z) of the average face, metres. Random detail is seeded.
"""

from __future__ import annotations

import numpy as np

from jointattn_mj.scene import face_shape as shape
from jointattn_mj.scene.people import FaceConfig
from jointattn_mj.scene.shapes import bump, curve, noise, smoothstep, to_bytes


def _blend(image: np.ndarray, colour: tuple[float, ...] | np.ndarray, weight: np.ndarray) -> np.ndarray:
    weight = np.clip(weight, 0, 1)[..., None]
    blended: np.ndarray = image * (1 - weight) + np.asarray(colour) * weight
    return blended


def _shade(config: FaceConfig, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Factor on the skin's brightness: corners that see less light, ridges that see more."""
    side = np.abs(y)
    shade: np.ndarray = (
        1
        - 0.32 * bump((side - 0.029) / 0.0150, (z - 0.010) / 0.0085)  # between brow and lid
        - 0.17 * bump((side - 0.0165) / 0.0055, (z - 0.006) / 0.0100)  # beside the bridge of the nose
        - 0.10 * bump((side - 0.032) / 0.0140, (z + 0.009) / 0.0050)  # under the eye
        - 0.20 * bump((side - 0.0175 * config.nose_width) / 0.0040, (z + 0.034) / 0.0090)
        - 0.32 * bump(y / 0.0130, (z + 0.0455) / 0.0036)  # under the nose
        - 0.13 * bump((side - 0.027) / 0.0050, (z + 0.052) / 0.0130) * (0.4 + config.age)
        - 0.20 * bump(y / 0.0190, (z + 0.0790) / 0.0042)  # under the lower lip
        - 0.22 * smoothstep(z, -0.100, -0.118)  # under the chin
        + 0.10 * bump(y / 0.0042, (z + 0.010) / 0.0220)  # ridge of the nose
        + 0.06 * bump(y / 0.0060, (z + 0.031) / 0.0050)
        + 0.05 * bump(y / 0.0300, (z - 0.046) / 0.0160)  # forehead
        + 0.06 * bump((side - 0.040) / 0.0150, (z + 0.020) / 0.0120)  # cheekbones
        + 0.04 * bump(y / 0.0120, (z + 0.099) / 0.0090)
        - 0.14 * smoothstep(side, 0.055, 0.074) * smoothstep(z, 0.05, -0.02)
    )
    return shade


def _folds(config: FaceConfig, side: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Lines of age, from 0 to 1: on the forehead, beside the eyes, from nose to mouth."""
    forehead = sum(bump((z - level - 0.04 * side**2 * 8) / 0.0011) for level in (0.040, 0.048, 0.056))
    forehead = forehead * smoothstep(side, 0.045, 0.025)
    feet = (
        bump((side - 0.055) / 0.004) * (0.5 + 0.5 * np.cos(2 * np.pi * (z - 0.004) / 0.006)) * bump((z - 0.003) / 0.007)
    )
    mouth_line = bump((side - (0.017 + 0.35 * (-0.036 - z))) / 0.0018) * bump((z + 0.048) / 0.010)
    folds: np.ndarray = 0.35 * forehead + 0.5 * feet + 0.9 * mouth_line
    return folds


def _skin(config: FaceConfig, y: np.ndarray, z: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    side, size = np.abs(y), y.shape
    image = np.broadcast_to(np.array(config.skin), (*size, 3)).copy()
    warm = np.array([1.05, 0.86, 0.84])
    blush = 0.55 * bump((side - 0.041) / 0.014, (z + 0.026) / 0.013) + 0.45 * bump(y / 0.010, (z + 0.030) / 0.010)
    image *= 1 + (warm - 1) * np.clip(blush, 0, 1)[..., None]
    beard = config.stubble * smoothstep(z, -0.034, -0.052) * (1 - bump(y / 0.020, (z + 0.063) / 0.007))
    image = _blend(image, np.array(config.skin) * 0.55 + np.array(config.hair) * 0.2, 0.62 * beard)
    image *= 1.05  # the shade below takes as much away
    blotches = 0.5 * noise(rng, size, (24, 24)) + 0.5 * noise(rng, size, (64, 64))
    image *= (_shade(config, y, z) + 0.022 * blotches)[..., None]
    image *= (1 - 0.30 * config.age * _folds(config, side, z))[..., None]
    return image


def _lips(config: FaceConfig, image: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    side = np.abs(y)
    wide = 0.0245
    taper = np.clip(1 - (side / wide) ** 2, 0, 1)
    line = -0.0630 + 0.0016 * (side / wide) ** 2
    bow = 0.0018 * (bump((side - 0.006) / 0.004) - bump(y / 0.0025))
    top = line + config.lip_fullness * (0.0068 * taper**0.8 + bow)
    low = line - config.lip_fullness * 0.0086 * taper**0.6
    inside = smoothstep(top - z, -0.0008, 0.0010) * smoothstep(z - low, -0.0010, 0.0012) * (side < wide)
    colour = np.array(config.lips) * (1 + 0.16 * bump(y / 0.012, (z + 0.0690) / 0.0028) - 0.10 * (z > line))[..., None]
    image = _blend(image, colour, 0.88 * inside)
    gap = bump((z - line) / 0.0010) * smoothstep(side, wide + 0.002, wide - 0.004)
    return _blend(image, np.array(config.lips) * 0.30, 0.85 * gap)


def _brows(config: FaceConfig, image: np.ndarray, y: np.ndarray, z: np.ndarray, strand: np.ndarray) -> np.ndarray:
    side = np.abs(y)
    arch = curve(side, [(0.010, 0.0225), (0.020, 0.0245), (0.034, 0.0285), (0.042, 0.0280), (0.054, 0.0215)])
    thick = config.brow * curve(side, [(0.010, 0.0032), (0.022, 0.0040), (0.040, 0.0030), (0.054, 0.0012)])
    inside = smoothstep(np.abs(z - arch), thick * 1.25, thick * 0.55) * smoothstep(side, 0.0095, 0.0135)
    inside *= smoothstep(side, 0.0545, 0.0500)
    colour = np.array(config.hair) * 0.75 + 0.02
    return _blend(image, np.minimum(colour, np.array(config.skin) * 0.62), inside * (0.82 + 0.16 * strand))


def _lids(config: FaceConfig, image: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    upper, lower = shape.lid_rims(config, y)
    across = (np.abs(y) - shape.EYE_Y) / shape.EYE_HALF_WIDTH
    open_here = smoothstep(np.abs(across), 1.12, 0.92)
    dark = np.array(config.skin) * 0.16
    image = _blend(
        image, np.array(config.skin) * (0.62, 0.50, 0.48), 0.8 * bump((z - upper - 0.0042) / 0.0008) * open_here
    )
    image = _blend(image, dark, 0.95 * smoothstep(z, upper + 0.0024, upper + 0.0008) * (z > lower) * open_here)
    lower_lash = smoothstep(np.abs(z - lower + 0.0004), 0.0013, 0.0004) * open_here
    return _blend(image, np.array(config.skin) * (0.50, 0.36, 0.33), 0.75 * lower_lash)


def _nostrils(image: np.ndarray, config: FaceConfig, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    hole = bump((np.abs(y) - 0.0070 * config.nose_width) / 0.0026, (z + 0.0418) / 0.0016)
    return _blend(image, np.array(config.skin) * 0.18, 0.9 * smoothstep(hole, 0.25, 0.7))


def skin_and_hair(config: FaceConfig, size: int) -> np.ndarray:
    """The head's texture, (size, size, 3) uint8, rows from v = 0 (chin) to v = 1 (crown).

    It is painted fine and averaged down: a texture no finer than the image's pixels spares the renderer its mipmaps.
    """
    times = -(-256 // size)
    fine = _paint(config, size * times)
    return to_bytes(fine.reshape(size, times, size, times, 3).mean(axis=(1, 3)))


def _paint(config: FaceConfig, size: int) -> np.ndarray:
    rng = np.random.default_rng(config.seed)
    v, u = np.meshgrid((np.arange(size) + 0.5) / size, (np.arange(size) + 0.5) / size, indexing="ij")
    azimuth, z = shape.texture_azimuth(u), shape.BOTTOM + v * (shape.TOP - shape.BOTTOM)
    ahead = np.cos(np.radians(azimuth)) > 0
    y = np.where(ahead, shape.half_breadth(config, z) * np.sin(np.radians(azimuth)), 0.09 * np.sign(azimuth))
    strand = np.clip(
        0.6 * noise(rng, (size, size), (6, size // 3)) + 0.4 * noise(rng, (size, size), (10, size // 6)), -1.5, 1.5
    )

    image = _skin(config, y, z, rng)
    image = _nostrils(_lips(config, image, y, z), config, y, z)
    image = _lids(config, _brows(config, image, y, z, strand), y, z)

    hair = shape.hair_thickness(config, azimuth + 2.0 * strand, z)
    light = 1 + 0.22 * strand + 0.25 * bump((z - 0.085) / 0.012) * smoothstep(np.abs(azimuth), 120, 20)
    image = image * (1 - 0.25 * bump((hair - 0.15) / 0.15))[..., None]
    return _blend(image, np.array(config.hair) * light[..., None], hair)


def iris(config: FaceConfig, size: int) -> np.ndarray:
    """An eyeball's texture, (size, size, 3) uint8; distance from the middle stands for the angle off the pupil."""
    rng = np.random.default_rng(config.seed + 1000)
    row, column = np.meshgrid(*[(np.arange(size) + 0.5) / size * 2 - 1] * 2, indexing="ij")
    angle = 85 * np.hypot(row, column)  # degrees
    ray = np.interp((np.arctan2(row, column) / (2 * np.pi)) % 1, np.linspace(0, 1, 24), rng.uniform(-1, 1, 24))
    image = np.broadcast_to(np.array([0.80, 0.78, 0.76]), (size, size, 3)).copy()
    image = _blend(image, np.array([0.62, 0.45, 0.41]), 0.7 * smoothstep(angle, 45, 80))
    colour = np.array(config.eyes) * (1 + 0.25 * ray * (angle < 26))[..., None]
    image = _blend(image, colour, smoothstep(angle, 31, 28))
    image = _blend(image, np.array(config.eyes) * 0.35, bump((angle - 28) / 2.2))
    return to_bytes(_blend(image, np.array([0.02, 0.02, 0.02]), smoothstep(angle, 13, 10.5)))
