"""Table, wall and floor: a handful of triangles each, and muted textures that no object's colour resembles."""

from __future__ import annotations

import numpy as np

from jointattn_mj.scene.shapes import Mesh, grid, merge, noise, smoothstep, to_bytes

WOOD, PLASTER, CARPET = (0.66, 0.61, 0.545), (0.63, 0.64, 0.63), (0.50, 0.48, 0.46)  # muted colours, rgb
PANEL = 0.80  # m, height of the wall's darker base


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


def _relief(corner: tuple[float, float, float], right: tuple[float, float, float], up: tuple[float, float, float],
            cells: tuple[int, int], rough: tuple[float, float], seed: int) -> Mesh:  # fmt: skip
    """A flat rectangle of cells (across, upwards) whose normals waver by `rough` (rad, about up and about right).

    Shading then varies as a texture would make it, without the cost of one (a third of an image).
    """
    rng = np.random.default_rng(seed)
    s, t = np.meshgrid(np.linspace(0, 1, cells[0] + 1), np.linspace(1, 0, cells[1] + 1))
    c, r, u = (np.array(a, float) for a in (corner, right, up))
    flat = grid(c + s[..., None] * r + t[..., None] * u, np.stack([s, t], -1))
    wander = np.clip(rng.standard_normal((2, len(flat.vertices), 1)), -1.5, 1.5)
    normals = flat.normals + rough[0] * wander[0] * r / np.linalg.norm(r) + rough[1] * wander[1] * u / np.linalg.norm(u)
    return Mesh(flat.vertices, flat.faces, flat.uv, normals / np.linalg.norm(normals, axis=1, keepdims=True))


def table(half_x: float, half_y: float, thickness: float, relief: bool) -> Mesh:
    """Table top around its middle; the robot sits at -x. relief: grain from normals, for a geom without texture.

    Args:
        half_x: Half of its depth, metres.
        half_y: Half of its breadth, metres.
        thickness: Metres.
        relief: Grain from normals, for a geom without texture.
    """
    x, y, t = 2 * half_x, 2 * half_y, thickness
    z, edge = t / 2, (0, 0, 1, 0.06)
    top = (-half_x, half_y, z), (0, -y, 0), (x, 0, 0)
    return merge(
        _relief(*top, (3, 10), (0.02, 0.14), seed=21) if relief else _quad(*top, (0, 0.1, 1, 1)),
        _quad((-half_x, half_y, -z), (0, -y, 0), (0, 0, t), edge),
        _quad((half_x, -half_y, -z), (0, y, 0), (0, 0, t), edge),
        _quad((-half_x, -half_y, -z), (x, 0, 0), (0, 0, t), edge),
        _quad((half_x, half_y, -z), (-x, 0, 0), (0, 0, t), edge),
        _quad((-half_x, -half_y, -z), (0, y, 0), (x, 0, 0), edge),
    )


def wall(half_y: float, height: float, relief: bool) -> Mesh:
    """The wall that faces the robot, its lower edge at z = 0. relief: plaster from normals, the base in shade.

    Args:
        half_y: Half of its breadth, metres.
        height: Metres.
        relief: Plaster from normals, the base in shade.
    """
    if not relief:
        return _quad((0, half_y, 0), (0, -2 * half_y, 0), (0, 0, height), (0, 0, 1, 1))
    base = _quad((0, half_y, 0), (0, -2 * half_y, 0), (0, 0, PANEL), (0, 0, 1, 1))
    dark = Mesh(base.vertices, base.faces, base.uv, base.normals - np.array([0, 0, 0.75]))
    upper = (0, half_y, PANEL), (0, -2 * half_y, 0), (0, 0, height - PANEL)
    return merge(dark, _relief(*upper, (17, 6), (0.12, 0.16), seed=22))


def floor(low_x: float, high_x: float, half_y: float) -> Mesh:
    """A flat floor at z = 0, seen from above.

    Args:
        low_x: Where it begins, metres.
        high_x: Where it ends, metres.
        half_y: Half of its breadth, metres.
    """
    return _quad((low_x, half_y, 0), (0, -2 * half_y, 0), (high_x - low_x, 0, 0), (0, 0, 1, 1))


def side_walls(low_x: float, high_x: float, half_y: float, height: float) -> Mesh:
    """What an onlooker sees beside and behind the robot.

    Args:
        low_x: Where they begin, metres.
        high_x: Where they end, metres.
        half_y: Half of the distance between them, metres.
        height: Metres.
    """
    length = high_x - low_x
    return merge(
        _quad((low_x, half_y, 0), (length, 0, 0), (0, 0, height), (0, 0, 1, 1)),
        _quad((high_x, -half_y, 0), (-length, 0, 0), (0, 0, height), (0, 0, 1, 1)),
        _quad((low_x, -half_y, 0), (0, 2 * half_y, 0), (0, 0, height), (0, 0, 1, 1)),
    )


def wood(size: int) -> np.ndarray:
    """Pale wood, grain along u (across the table)."""
    rng = np.random.default_rng(11)
    grain = 0.060 * noise(rng, (size, size), (size // 3, 3)) + 0.045 * noise(rng, (size, size), (9, 4))
    return to_bytes(np.array(WOOD) * (1 + grain)[..., None])


def plaster(size: int, height: float) -> np.ndarray:
    """A plastered wall above a darker panelled base."""
    rng = np.random.default_rng(12)
    shape = (size, size)
    z = np.broadcast_to(((np.arange(size) + 0.5) / size * height)[:, None], shape)
    cloudy = 0.050 * noise(rng, shape, (12, 30)) + 0.025 * noise(rng, shape, (size // 3, size // 3))
    upper = np.array(PLASTER) * (1 + cloudy)[..., None]
    panel = 0.06 * (np.arange(size) * 24 / size % 1 < 0.12)
    lower = np.array([0.45, 0.46, 0.46]) * (1 + 0.5 * cloudy - panel[None])[..., None]
    return to_bytes(lower + (upper - lower) * smoothstep(z, PANEL - 0.01, PANEL + 0.01)[..., None])


def carpet(size: int) -> np.ndarray:
    """A dull floor."""
    rng = np.random.default_rng(13)
    return to_bytes(np.array(CARPET) * (1 + 0.05 * noise(rng, (size, size), (size // 2, size // 2)))[..., None])
