"""The caregiver below the head: seated trunk with neck, two arms in sleeves, hands with fingers.

The trunk is in the caregiver's frame: origin on the floor below the head, x towards the robot; metres. A limb lies
along x from its joint. With ``fine`` meshes are fine and clothes have a texture, for figures; else the ribs of clothes
come from normals, which saves a tenth of an image's time.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jointattn_mj.options import Colour
from jointattn_mj.scene.shapes import Mesh, merge, noise, to_bytes, tube

WHOLE = (0.0, 0.0, 1.0, 1.0)  # parts of the cloth's texture (u0, v0, u1, v1)
SLEEVE = (0.0, 0.1, 0.5, 0.6)


def _limb(profile: list[tuple[float, float, float]], sides: int, box: tuple[float, float, float, float]) -> Mesh:
    """A limb along x from (x, half breadth in y, half thickness in z)."""
    x, breadth, thickness = np.array(profile, float).T
    centres = np.stack([x, 0 * x, 0 * x], -1)
    return tube(centres, np.stack([breadth, thickness], -1), sides, (0, 0, 1), box)


def _line(
    points: list[tuple[float, float, float]], radii: list[float], sides: int, up: tuple[float, float, float]
) -> Mesh:
    """A bent limb of round section through `points`."""
    return tube(np.array(points, float), np.repeat(np.array(radii)[:, None], 2, 1), sides, up, WHOLE)


def _knit(mesh: Mesh, sides: int) -> Mesh:
    """Ribs without a texture: a tube whose normals lean up and down from ring to ring, and waver a little."""
    rng = np.random.default_rng(31)
    ring = np.arange(len(mesh.vertices)) // (sides + 1)
    along = np.gradient(mesh.vertices.reshape(-1, sides + 1, 3), axis=0).reshape(-1, 3)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    lean = np.where(ring % 2, 0.38, -0.38) + 0.12 * np.clip(rng.standard_normal(len(ring)), -2, 2)
    lean[sides :: sides + 1] = lean[:: sides + 1]  # no seam
    normals = mesh.normals + lean[:, None] * along
    return replace(mesh, normals=normals / np.linalg.norm(normals, axis=1, keepdims=True))


def trunk(fine: bool) -> Mesh:
    """Trunk, and the arm that rests in the lap."""
    sides = 24 if fine else 12
    z, breadth, depth, x = np.array([
        (0.430, 0.000, 0.000, -0.030), (0.432, 0.165, 0.115, -0.030), (0.560, 0.150, 0.104, -0.030),
        (0.665, 0.155, 0.106, -0.030), (0.695, 0.159, 0.107, -0.030), (0.725, 0.164, 0.108, -0.030),
        (0.755, 0.170, 0.108, -0.030), (0.785, 0.177, 0.106, -0.030), (0.812, 0.183, 0.101, -0.030),
        (0.838, 0.186, 0.092, -0.030), (0.862, 0.180, 0.080, -0.030), (0.882, 0.150, 0.070, -0.030),
        (0.898, 0.104, 0.063, -0.028), (0.911, 0.068, 0.060, -0.026), (0.924, 0.060, 0.058, -0.022),
    ]).T  # fmt: skip
    centres, radii = np.stack([x, 0 * x, z], -1), np.stack([breadth, depth], -1)
    chest = tube(centres, radii, sides, (1, 0, 0), WHOLE, power=2.3)
    sleeve = np.array([
        (-0.015, 0.148, 0.866), (-0.015, 0.152, 0.866), (-0.014, 0.172, 0.860), (-0.010, 0.198, 0.832),
        (-0.007, 0.212, 0.780), (-0.004, 0.225, 0.730), (0.005, 0.248, 0.620), (0.035, 0.245, 0.560),
        (0.110, 0.205, 0.545), (0.205, 0.145, 0.545), (0.225, 0.132, 0.546), (0.226, 0.131, 0.546),
    ])  # fmt: skip
    thickness = np.array([0.0, 0.030, 0.047, 0.053, 0.050, 0.047, 0.042, 0.039, 0.035, 0.027, 0.026, 0.0])
    sides_of_arm = 16 if fine else 8
    arm = tube(sleeve, np.repeat(thickness[:, None], 2, 1), sides_of_arm, (0, 0.3, 1), SLEEVE)
    return merge(chest, arm) if fine else merge(_knit(chest, sides), _knit(arm, sides_of_arm))


def neck(fine: bool) -> Mesh:
    """Bare neck, from inside the collar to inside the head."""
    centres = np.array([(-0.022, 0, 0.895), (-0.018, 0, 0.950), (-0.010, 0, 1.010)])
    radii = np.array([(0.048, 0.044), (0.051, 0.052), (0.049, 0.050)])
    return tube(centres, radii, 20 if fine else 10, (1, 0, 0), WHOLE)


def _sleeve(profile: list[tuple[float, float, float]], fine: bool) -> Mesh:
    sides = 16 if fine else 9
    limb = _limb(profile, sides, SLEEVE)
    return limb if fine else _knit(limb, sides)


def upper_arm(length: float, fine: bool) -> Mesh:
    """Sleeve from the shoulder to the elbow."""
    ribs = [(length * k, 0.051 - 0.013 * k, 0.050 - 0.012 * k) for k in (0.12, 0.28, 0.44, 0.60, 0.76, 0.9)]
    start = [(-0.052, 0, 0), (-0.040, 0.036, 0.034), (-0.005, 0.053, 0.052)]
    end = [(length + 0.01, 0.038, 0.038), (length + 0.034, 0.022, 0.022), (length + 0.042, 0, 0)]
    return _sleeve(start + ribs + end, fine)


def forearm(length: float, fine: bool) -> Mesh:
    """Sleeve from the elbow to the wrist."""
    profile = [
        (-0.036, 0, 0), (-0.026, 0.024, 0.024), (0.0, 0.037, 0.037), (0.06, 0.039, 0.038), (0.12, 0.038, 0.036),
        (0.18, 0.036, 0.033), (0.24, 0.033, 0.030), (length - 0.07, 0.030, 0.026), (length - 0.03, 0.028, 0.024),
        (length - 0.008, 0.029, 0.025), (length - 0.006, 0, 0),
    ]  # fmt: skip
    return _sleeve(profile, fine)


def hand(fine: bool) -> Mesh:
    """A right hand, palm towards -z, fingers along x over what it holds, the thumb behind it."""
    palm = _limb(
        [(-0.03, 0.022, 0.018), (0.004, 0.025, 0.018), (0.030, 0.037, 0.016), (0.055, 0.040, 0.013),
         (0.066, 0.036, 0.008), (0.070, 0, 0)], 14 if fine else 8, WHOLE,
    )  # fmt: skip
    sides = 10 if fine else 4
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
        [(0.012, 0.024, -0.006), (0.036, 0.042, -0.016), (0.058, 0.042, -0.034), (0.070, 0.034, -0.048),
         (0.072, 0.032, -0.051)],
        [0.013, 0.0115, 0.0100, 0.0080, 0.0], sides, (0, 1, 0),
    )  # fmt: skip
    return merge(palm, *fingers, thumb)


def cloth(colour: Colour, size: int) -> np.ndarray:
    """Texture (size, size, 3) uint8 of a knitted pullover."""
    rng = np.random.default_rng(32)
    v = np.broadcast_to(((np.arange(size) + 0.5) / size)[:, None], (size, size))
    wool = 0.06 * noise(rng, (size, size), (22, 26)) + 0.04 * noise(rng, (size, size), (size // 3, size // 3))
    bands = np.sin(2 * np.pi * v * 14)
    return to_bytes(np.array(colour) * (1 + wool + 0.10 * np.sign(bands) * (np.abs(bands) > 0.3))[..., None])
