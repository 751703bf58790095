"""The caregiver below the head: seated trunk with neck, two arms in sleeves, hands with fingers.

Trunk frame: the caregiver's (origin on the floor below her, x towards the robot). Limb frames: the limb lies along x
from its joint. All parts share one texture: cloth, and a strip of skin (`SKIN`).
"""

from __future__ import annotations

import numpy as np

from jointattn_mj.scene.people import Colour, FaceConfig
from jointattn_mj.scene.shapes import Mesh, merge, noise, to_bytes, tube

CLOTH = (0.0, 0.14, 1.0, 1.0)  # parts of the texture (u0, v0, u1, v1)
SKIN = (0.0, 0.02, 1.0, 0.10)
SLEEVE = (0.0, 0.20, 0.5, 0.60)


def _limb(profile: list[tuple[float, float, float]], sides: int, box: tuple[float, float, float, float]) -> Mesh:
    """A limb along x from (x, half breadth in y, half thickness in z)."""
    x, breadth, thickness = np.array(profile, float).T
    centres = np.stack([x, 0 * x, 0 * x], -1)
    return tube(centres, np.stack([breadth, thickness], -1), sides, (0, 0, 1), box)


def _line(
    points: list[tuple[float, float, float]], radii: list[float], sides: int, up: tuple[float, float, float]
) -> Mesh:
    """A bent limb of round section through `points`."""
    return tube(np.array(points, float), np.repeat(np.array(radii)[:, None], 2, 1), sides, up, SKIN)


def trunk(fine: bool) -> Mesh:
    """Trunk, neck, and the arm that rests in her lap."""
    sides = 24 if fine else 12
    z, breadth, depth, x = np.array([
        (0.430, 0.000, 0.000, -0.03), (0.432, 0.165, 0.115, -0.03), (0.560, 0.150, 0.104, -0.03),
        (0.680, 0.156, 0.106, -0.03), (0.770, 0.172, 0.108, -0.03), (0.828, 0.186, 0.096, -0.03),
        (0.868, 0.176, 0.078, -0.03), (0.893, 0.118, 0.066, -0.03), (0.910, 0.068, 0.060, -0.026),
        (0.924, 0.060, 0.058, -0.022), (0.920, 0.050, 0.050, -0.020),
    ]).T  # fmt: skip
    if not fine:
        z, breadth, depth, x = (np.delete(values, (4, 10)) for values in (z, breadth, depth, x))
    chest = tube(np.stack([x, 0 * x, z], -1), np.stack([breadth, depth], -1), sides, (1, 0, 0), CLOTH, power=2.3)
    neck = tube(
        np.array([(-0.022, 0, 0.900), (-0.018, 0, 0.950), (-0.010, 0, 1.010)]),
        np.array([(0.056, 0.055), (0.051, 0.052), (0.049, 0.050)]), sides, (1, 0, 0), SKIN,
    )  # fmt: skip
    arm = tube(
        np.array([
            (-0.015, 0.148, 0.866), (-0.015, 0.152, 0.866), (-0.014, 0.172, 0.860), (-0.010, 0.198, 0.832), (-0.004, 0.225, 0.730),
            (0.005, 0.248, 0.620), (0.035, 0.245, 0.560), (0.110, 0.205, 0.545), (0.205, 0.145, 0.545),
            (0.225, 0.132, 0.546), (0.226, 0.131, 0.546),
        ]),
        np.array([0.0, 0.030, 0.047, 0.053, 0.047, 0.042, 0.039, 0.035, 0.027, 0.026, 0.0])[:, None].repeat(2, 1),
        sides // 2 + 2, (0, 0.3, 1), SLEEVE,
    )  # fmt: skip
    return merge(chest, neck, arm)


def upper_arm(length: float, fine: bool) -> Mesh:
    """Sleeve from the shoulder to the elbow."""
    profile = [
        (-0.052, 0, 0), (-0.040, 0.036, 0.034), (-0.005, 0.053, 0.052), (0.10, 0.049, 0.048),
        (length - 0.10, 0.042, 0.041), (length + 0.01, 0.038, 0.038), (length + 0.034, 0.022, 0.022), (length + 0.042, 0, 0),
    ]  # fmt: skip
    return _limb(profile, 16 if fine else 9, SLEEVE)


def forearm(length: float, fine: bool) -> Mesh:
    """Sleeve from the elbow to the wrist."""
    profile = [
        (-0.036, 0, 0), (-0.026, 0.024, 0.024), (0.0, 0.037, 0.037), (0.09, 0.039, 0.037), (0.21, 0.034, 0.031),
        (length - 0.03, 0.028, 0.024), (length - 0.008, 0.029, 0.025), (length - 0.006, 0, 0),
    ]  # fmt: skip
    return _limb(profile, 16 if fine else 9, SLEEVE)


def hand(fine: bool) -> Mesh:
    """A right hand, palm towards -z, fingers along x over the top of what it holds, the thumb behind it."""
    palm = _limb(
        [(-0.03, 0.022, 0.018), (0.004, 0.025, 0.018), (0.030, 0.037, 0.016), (0.055, 0.040, 0.013), (0.066, 0.036, 0.008),
         (0.070, 0, 0)], 14 if fine else 8, SKIN,
    )  # fmt: skip
    sides = 10 if fine else 5
    fingers = []
    for y, reach in ((-0.028, 0.86), (-0.0095, 0.97), (0.0095, 1.0), (0.028, 0.94)):
        path = [
            (0.052, 0.9 * y, 0.002),
            (0.080, y, 0.034),
            (0.100, y, 0.047),
            (0.115, 0.98 * y, 0.040),
            (0.119, 0.97 * y, 0.034),
        ]
        path = [(0.052 + (px - 0.052) * reach, py, pz * reach) for px, py, pz in path]
        fingers.append(_line(path, [0.0095, 0.0090, 0.0082, 0.0068, 0.0], sides, (0, 1, 0)))
    thumb = _line(
        [(0.012, 0.024, -0.006), (0.036, 0.042, -0.016), (0.058, 0.042, -0.034), (0.070, 0.034, -0.048), (0.072, 0.032, -0.051)],
        [0.013, 0.0115, 0.0100, 0.0080, 0.0], sides, (0, 1, 0),
    )  # fmt: skip
    return merge(palm, *fingers, thumb)


def clothes_and_skin(face: FaceConfig, clothing: Colour, size: int) -> np.ndarray:
    """Texture (size, size, 3) uint8 of trunk and arms: a knitted pullover, and her skin below v = .12."""
    rng = np.random.default_rng(face.seed + 2000)
    v = np.broadcast_to(((np.arange(size) + 0.5) / size)[:, None], (size, size))
    wool = 0.075 * noise(rng, (size, size), (22, 26)) + 0.05 * noise(rng, (size, size), (size // 3, size // 3))
    bands = 0.10 * np.sign(np.sin(2 * np.pi * v * 14)) * (np.abs(np.sin(2 * np.pi * v * 14)) > 0.3)
    cloth = np.array(clothing) * (1 + wool + bands)[..., None]
    skin = np.array(face.skin) * (0.95 + 0.03 * noise(rng, (size, size), (32, 32)))[..., None]
    return to_bytes(np.where((v < 0.12)[..., None], skin, cloth))
