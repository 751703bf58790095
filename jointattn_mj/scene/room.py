"""Table, wall and floor: a handful of triangles each, and muted textures that no object's colour resembles."""

from __future__ import annotations

import numpy as np

from jointattn_mj.scene.shapes import Mesh, merge, noise, smoothstep, to_bytes


def _quad(corner: tuple[float, float, float], right: tuple[float, float, float], up: tuple[float, float, float],
          box: tuple[float, float, float, float]) -> Mesh:  # fmt: skip
    """A rectangle from its lower left corner, as seen from in front; box: texture (u0, v0, u1, v1)."""
    c, r, u = (np.array(a, float) for a in (corner, right, up))
    normal = np.cross(r, u)
    return Mesh(
        np.array([c, c + r, c + r + u, c + u]), np.array([[0, 1, 2], [0, 2, 3]]),
        np.array([(box[0], box[1]), (box[2], box[1]), (box[2], box[3]), (box[0], box[3])], float),
        np.repeat(normal[None] / np.linalg.norm(normal), 4, 0),
    )  # fmt: skip


def table(half_x: float, half_y: float, thickness: float) -> Mesh:
    """Table top around its middle; the robot sits at -x."""
    x, y, t = 2 * half_x, 2 * half_y, thickness
    z = t / 2
    return merge(
        _quad((-half_x, half_y, z), (0, -y, 0), (x, 0, 0), (0, 0.1, 1, 1)),
        _quad((-half_x, half_y, -z), (0, -y, 0), (0, 0, t), (0, 0, 1, 0.06)),
        _quad((half_x, -half_y, -z), (0, y, 0), (0, 0, t), (0, 0, 1, 0.06)),
        _quad((-half_x, -half_y, -z), (x, 0, 0), (0, 0, t), (0, 0, 1, 0.06)),
        _quad((half_x, half_y, -z), (-x, 0, 0), (0, 0, t), (0, 0, 1, 0.06)),
    )


def wall(half_y: float, height: float) -> Mesh:
    """The wall that faces the robot, its lower edge at z = 0."""
    return _quad((0, half_y, 0), (0, -2 * half_y, 0), (0, 0, height), (0, 0, 1, 1))


def floor(half_x: float, half_y: float) -> Mesh:
    """A flat floor around the origin, seen from above."""
    return _quad((-half_x, half_y, 0), (0, -2 * half_y, 0), (2 * half_x, 0, 0), (0, 0, 1, 1))


def wood(size: int) -> np.ndarray:
    """Pale wood, grain along u (across the table)."""
    rng = np.random.default_rng(11)
    grain = 0.060 * noise(rng, (size, size), (size // 3, 3)) + 0.045 * noise(rng, (size, size), (9, 4))
    return to_bytes(np.array([0.66, 0.61, 0.545]) * (1 + grain)[..., None])


def plaster(size: int, height: float) -> np.ndarray:
    """A plastered wall above a darker panelled base."""
    rng = np.random.default_rng(12)
    shape = (size, size)
    z = np.broadcast_to(((np.arange(size) + 0.5) / size * height)[:, None], shape)
    cloudy = 0.050 * noise(rng, shape, (12, 30)) + 0.025 * noise(rng, shape, (size // 3, size // 3))
    upper = np.array([0.63, 0.64, 0.63]) * (1 + cloudy)[..., None]
    panel = 0.06 * (np.arange(size) * 24 / size % 1 < 0.12)
    lower = np.array([0.45, 0.46, 0.46]) * (1 + 0.5 * cloudy - panel[None])[..., None]
    return to_bytes(lower + (upper - lower) * smoothstep(z, 0.78, 0.82)[..., None])


def carpet(size: int) -> np.ndarray:
    """A dull floor."""
    rng = np.random.default_rng(13)
    return to_bytes(
        np.array([0.40, 0.385, 0.37]) * (1 + 0.05 * noise(rng, (size, size), (size // 2, size // 2)))[..., None]
    )
