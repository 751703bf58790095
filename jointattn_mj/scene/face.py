"""A caregiver's face: mesh and painted texture from a ``FaceConfig``."""

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
    """A head ready to draw. Head frame: x out of the nose, y to the person's left, z up; metres.

    Attributes:
        vertices: (n, 3) metres.
        faces: (m, 3) indices of vertices.
        uv: (n, 2) texture coordinates, v upwards.
        texture: (h, w, 3) uint8, first row at v = 0.
        normals: (n, 3) unit vectors.
        eyeball: Around its own centre, the iris along x.
        eye_texture: (h, w, 3) uint8, the iris in its middle.
        eye_centre: Of the left eye, metres; the right one is its mirror image in y.
    """

    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    texture: np.ndarray
    normals: np.ndarray
    eyeball: Mesh
    eye_texture: np.ndarray
    eye_centre: tuple[float, float, float]

    def __repr__(self) -> str:
        return f"FaceMesh({len(self.vertices)} vertices, {len(self.faces)} triangles)"


def identity(name: str) -> FaceConfig:
    """The face of a person, by name.

    Raises:
        ConfigError: Nobody is called that.
    """
    if name not in IDENTITIES:
        raise ConfigError(f"caregiver: expected one of {', '.join(IDENTITIES)}; got {name!r}")
    return IDENTITIES[name]


def build_face(config: FaceConfig, detail: int = 1, texture_size: int = 256) -> FaceMesh:
    """Build the head of a person.

    Args:
        config: The face.
        detail: Fineness of the mesh: 1 for images of 320x240, 3 for figures.
        texture_size: Edge of the texture, pixels.
    """
    mesh = face_shape.head(config, detail)
    return FaceMesh(
        mesh.vertices, mesh.faces, mesh.uv, face_paint.skin_and_hair(config, texture_size), mesh.normals,
        face_shape.eyeball(detail), face_paint.iris(config, 16 * 2 ** min(detail, 3)),
        (face_shape.eye_depth(config), face_shape.EYE_Y, face_shape.EYE_Z),
    )  # fmt: skip
