"""A caregiver's face: mesh and painted texture from a `FaceConfig` (looks are the only thing it decides)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.scene import face_paint, face_shape
from jointattn_mj.scene.people import IDENTITIES, FaceConfig
from jointattn_mj.scene.shapes import Mesh

__all__ = ["IDENTITIES", "FaceConfig", "FaceMesh", "build_face", "identity"]


@dataclass(frozen=True)
class FaceMesh:
    """A head ready to draw; head frame (x out of the nose, y to her left, z up, metres).

    vertices (n, 3); faces (m, 3) indices; uv (n, 2), v upwards; texture (h, w, 3) uint8, first row at v = 0.
    """

    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    texture: np.ndarray
    normals: np.ndarray
    eyeball: Mesh  # around its own centre, the iris along x
    eye_texture: np.ndarray  # (h, w, 3) uint8, the iris in its middle
    eye_centre: tuple[float, float, float]  # of the left eye; the right one is its mirror image in y


def identity(name: str) -> FaceConfig:
    """Look up a person by name.

    Raises:
        ConfigError: Nobody is called that.
    """
    if name not in IDENTITIES:
        raise ConfigError(f"caregiver: expected one of {', '.join(IDENTITIES)}; got {name!r}")
    return IDENTITIES[name]


def build_face(config: FaceConfig, detail: int = 1, texture_size: int = 256) -> FaceMesh:
    """The head for one person; `detail` 1 suits images of 320x240, 3 suits figures."""
    mesh = face_shape.head(config, detail)
    return FaceMesh(
        mesh.vertices, mesh.faces, mesh.uv, face_paint.skin_and_hair(config, texture_size), mesh.normals,
        face_shape.eyeball(detail), face_paint.iris(config, 16 * 2 ** min(detail, 3)),
        (face_shape.eye_depth(config), face_shape.EYE_Y, face_shape.EYE_Z),
    )  # fmt: skip
