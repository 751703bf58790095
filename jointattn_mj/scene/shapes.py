"""Tools to generate smooth triangle meshes and seamless textures, in numpy alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Mesh:
    """Triangles with normals and texture coordinates.

    Attributes:
        vertices: (n, 3) metres.
        faces: (m, 3) indices of vertices, anticlockwise.
        uv: (n, 2) texture coordinates, 0 to 1, v upwards.
        normals: (n, 3) unit vectors.
    """

    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    normals: np.ndarray

    def __repr__(self) -> str:
        return f"Mesh({len(self.vertices)} vertices, {len(self.faces)} triangles)"


def bump(*scaled: np.ndarray) -> np.ndarray:
    """Gaussian exp(-sum(s^2)/2) of coordinates already divided by their widths."""
    height: np.ndarray = np.exp(-0.5 * sum(s * s for s in scaled))
    return height


def smoothstep(x: np.ndarray, low: float | np.ndarray, high: float | np.ndarray) -> np.ndarray:
    """0 below ``low``, 1 above ``high`` (the reverse where low > high), smooth between.

    Args:
        x: Of any shape.
        low: Where the result is 0.
        high: Where it is 1.
    """
    t = np.clip((np.asarray(x, float) - low) / (high - low), 0, 1)
    risen: np.ndarray = t * t * (3 - 2 * t)
    return risen


def curve(x: np.ndarray, knots: list[tuple[float, float]]) -> np.ndarray:
    """A smooth curve at ``x`` through ``knots`` (x, y) with rising x, without overshoot: cubic, harmonic slopes."""
    kx, ky = np.array(knots, float).T
    step = np.diff(kx)
    slope = np.diff(ky) / step
    tangent = np.zeros_like(ky)
    same = slope[1:] * slope[:-1] > 0
    tangent[1:-1][same] = 2 * slope[1:][same] * slope[:-1][same] / (slope[1:] + slope[:-1])[same]
    tangent[0], tangent[-1] = slope[0], slope[-1]
    x = np.clip(x, kx[0], kx[-1])
    i = np.clip(np.searchsorted(kx, x, side="right") - 1, 0, len(step) - 1)
    t = (x - kx[i]) / step[i]
    y: np.ndarray = (
        (1 + 2 * t) * (1 - t) ** 2 * ky[i]
        + t * (1 - t) ** 2 * step[i] * tangent[i]
        + t * t * (3 - 2 * t) * ky[i + 1]
        + t * t * (t - 1) * step[i] * tangent[i + 1]
    )
    return y


def refine(values: np.ndarray, factor: int) -> np.ndarray:
    """Insert ``factor`` - 1 evenly spaced values between neighbours of ``values`` (n,)."""
    index = np.arange((len(values) - 1) * factor + 1) / factor
    refined: np.ndarray = np.interp(index, np.arange(len(values)), values)
    return refined


def grid(points: np.ndarray, uv: np.ndarray) -> Mesh:
    """A mesh over a grid of points.

    Args:
        points: (rows, columns, 3) metres, rows from top to bottom, columns anticlockwise seen from above. A closed
            surface repeats its first column as the last; normals along that seam are made equal.
        uv: (rows, columns, 2) texture coordinates.
    """
    rows, columns = points.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]
    faces = np.concatenate([np.stack([a, c, d], -1).reshape(-1, 3), np.stack([a, d, b], -1).reshape(-1, 3)])
    vertices = points.reshape(-1, 3)
    corner = vertices[faces]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    faces = faces[area > 1e-10]
    return Mesh(vertices, faces, uv.reshape(-1, 2), _normals(vertices, faces))


def _normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Area-weighted vertex normals (n, 3); vertices at the same point share one."""
    corner = vertices[faces]
    face_normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    _, point = np.unique(np.round(vertices, 7), axis=0, return_inverse=True)
    total = np.zeros((point.max() + 1, 3))
    for k in range(3):
        np.add.at(total, point[faces[:, k]], face_normal)
    total = total[point]
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(length > 0, total / np.maximum(length, 1e-20), (0, 0, 1))


def merge(*meshes: Mesh) -> Mesh:
    """All meshes as one, which is drawn in one call."""
    offsets = np.cumsum([0] + [len(m.vertices) for m in meshes[:-1]])
    return Mesh(
        np.concatenate([m.vertices for m in meshes]),
        np.concatenate([m.faces + k for m, k in zip(meshes, offsets, strict=True)]),
        np.concatenate([m.uv for m in meshes]),
        np.concatenate([m.normals for m in meshes]),
    )


def tube(
    centres: np.ndarray,
    radii: np.ndarray,
    sides: int,
    up: tuple[float, float, float],
    box: tuple[float, float, float, float],
    power: float = 2.0,
) -> Mesh:
    """A limb around a line; an end is closed where its radii are 0.

    Args:
        centres: (n, 3) points of the line, metres.
        radii: (n, 2) sideways and along ``up``, metres.
        sides: Corners of a cross-section.
        up: Direction of the second radius.
        box: (u0, v0, u1, v1) part of the texture that it uses.
        power: Shape of the cross-section: 2 is an ellipse, more is boxier.
    """
    ahead = np.gradient(centres, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    side = np.cross(up, ahead)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    upward = np.cross(ahead, side)
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    cos, sin = np.cos(angle), np.sin(angle)
    size = (np.abs(cos) ** power + np.abs(sin) ** power) ** (-1 / power)
    across = radii[:, :1, None] * side[:, None] * (cos * size)[None, :, None]
    points = centres[:, None] + across + radii[:, 1:, None] * upward[:, None] * (sin * size)[None, :, None]
    points[:, -1] = points[:, 0]
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(centres, axis=0), axis=1))])
    u = box[0] + (box[2] - box[0]) * angle / (2 * np.pi)
    v = box[3] + (box[1] - box[3]) * along / along[-1]
    uv = np.stack(np.broadcast_arrays(u[None, :], v[:, None]), -1)
    return grid(points[:, ::-1], uv[:, ::-1])


def noise(rng: np.random.Generator, shape: tuple[int, int], cells: tuple[int, int]) -> np.ndarray:
    """A smooth random field of ``shape``, mean 0 and about unit spread, seamless; ``cells`` says how fine it is.

    Args:
        rng: Draws it.
        shape: Rows and columns.
        cells: How many random values there are in rows and columns, with smooth transitions between.
    """
    values = rng.standard_normal(cells)
    for axis in (0, 1):
        at = np.arange(shape[axis]) * cells[axis] / shape[axis]
        low = at.astype(int)
        t = smoothstep(at - low, 0, 1)
        t = t[:, None] if axis == 0 else t
        first, second = np.take(values, low, axis), np.take(values, (low + 1) % cells[axis], axis)
        values = first * (1 - t) + second * t
    return values


def to_bytes(rgb: np.ndarray) -> np.ndarray:
    """Colours from 0 to 1 as uint8."""
    return np.clip(np.round(rgb * 255), 0, 255).astype(np.uint8)
