"""The scene for the 3D view: shapes, poses, and lines of sight. It is the ground truth, which the robot does not know.

World frame, metres. A body's entity is ``world/<body>``, with underscores for slashes; those of its geoms are below it.
"""

from typing import Any

import mujoco
import numpy as np
import rerun as rr

from jointattn_mj.adapters.rerun.entities import EYE, PERSONS_GAZE, ROBOTS_GAZE, WORLD
from jointattn_mj.adapters.rerun.rows import Rows
from jointattn_mj.gaze_following.session import SessionRun
from jointattn_mj.scene.camera import FOCAL_PX
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH
from jointattn_mj.scene.world import World
from jointattn_mj.video.onlooker import sights
from jointattn_mj.video.paint import GREEN, PERSON, ROBOT

LEFT_OUT = ("room/wall", "room/side_walls")
"""Geoms that would hide the scene from most sides."""
EYE_CAMERA = "robot/eye"
_LINE_M = 0.005
_GEOM = mujoco.mjtGeom
_OF_COLOUR_TEXTURE = int(mujoco.mjtTextureRole.mjTEXROLE_RGB)


def entity(body: str) -> str:
    """Entity of a body."""
    return WORLD if body == "world" else f"{WORLD}/{body.replace('/', '_')}"


def log_shapes(log: rr.RecordingStream, model: mujoco.MjModel) -> None:
    """Log all geoms, static, below their bodies."""
    log.log(WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    for number in range(model.ngeom):
        name, body = model.geom(number).name, model.body(model.geom_bodyid[number]).name
        if name in LEFT_OUT:
            continue
        path = f"{entity(body)}/{name.split('/')[-1]}"
        pose = rr.Transform3D(
            translation=model.geom_pos[number], quaternion=rr.Quaternion(xyzw=_xyzw(model.geom_quat[number]))
        )
        log.log(path, shape(model, number), pose, static=True)


def shape(model: mujoco.MjModel, geom: int) -> Any:
    """A geom as an archetype of Rerun's, in its own frame."""
    size, material = model.geom_size[geom], model.geom_matid[geom]
    rgba = model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom]
    look: dict[str, Any] = {"colors": [np.round(255 * rgba).astype(np.uint8)], "fill_mode": "solid"}
    match model.geom_type[geom]:
        case _GEOM.mjGEOM_MESH:
            return _mesh(model, model.geom_dataid[geom], rgba, model.mat_texid[material, _OF_COLOUR_TEXTURE])
        case _GEOM.mjGEOM_BOX:
            return rr.Boxes3D(half_sizes=[size], **look)
        case _GEOM.mjGEOM_CYLINDER:
            return rr.Cylinders3D(lengths=[2 * size[1]], radii=[size[0]], **look)
        case _GEOM.mjGEOM_CAPSULE:
            begin = [(0, 0, -size[1])]  # Rerun's capsules begin at their origin
            return rr.Capsules3D(lengths=[2 * size[1]], radii=[size[0]], translations=begin, **look)
        case _GEOM.mjGEOM_SPHERE:
            return rr.Ellipsoids3D(half_sizes=[size[[0, 0, 0]]], **look)
        case _:
            return rr.Ellipsoids3D(half_sizes=[size], **look)


def _mesh(model: mujoco.MjModel, mesh: int, rgba: np.ndarray, texture: int) -> rr.Mesh3D:
    """A mesh, with its texture if it has one; each corner is a vertex, since it has a normal and a texel of its own."""
    faces = slice(model.mesh_faceadr[mesh], model.mesh_faceadr[mesh] + model.mesh_facenum[mesh])
    corners = model.mesh_face[faces].ravel() + model.mesh_vertadr[mesh]
    normals = model.mesh_facenormal[faces].ravel() + model.mesh_normaladr[mesh]
    look: dict[str, Any] = {"albedo_factor": rgba}
    if texture >= 0:
        texels = model.mesh_facetexcoord[faces].ravel() + model.mesh_texcoordadr[mesh]
        size = model.tex_height[texture], model.tex_width[texture], model.tex_nchannel[texture]
        start = model.tex_adr[texture]
        look["albedo_texture"] = model.tex_data[start : start + int(np.prod(size))].reshape(size)
        look["vertex_texcoords"] = model.mesh_texcoord[texels]
    return rr.Mesh3D(
        vertex_positions=model.mesh_vert[corners],
        vertex_normals=model.mesh_normal[normals],
        triangle_indices=np.arange(len(corners)).reshape(-1, 3),
        **look,
    )


class Scene:
    """Logs shapes once, then the poses of bodies that moved, the eye's pose, and both lines of sight."""

    def __init__(self, rows: Rows, world: World):
        self._rows, log = rows, rows.log
        model = world.model
        self._paths = [entity(model.body(number).name) for number in range(model.nbody)]
        self._last = np.full((model.nbody, 7), np.nan)
        log_shapes(log, model)
        eye = rr.Pinhole(
            focal_length=FOCAL_PX, width=IMAGE_WIDTH, height=IMAGE_HEIGHT, image_plane_distance=0.15,
            camera_xyz=rr.ViewCoordinates.RUB,
        )  # fmt: skip
        log.log(EYE, eye, static=True)
        for path in (ROBOTS_GAZE, PERSONS_GAZE):
            log.log(path, rr.Arrows3D.from_fields(radii=_LINE_M), static=True)

    def write(self, session: SessionRun) -> None:
        """Log a frame."""
        world = session.world
        now = np.hstack([world.data.xpos, world.data.xquat])
        for number in np.flatnonzero((now != self._last).any(axis=1)):
            if number > 0:  # the world itself has no pose
                position, rotation = now[None, number, :3], _xyzw(now[None, number, 3:])
                self._rows.add(self._paths[number], rr.Transform3D, translation=position, quaternion=rotation)
        self._last = now
        eye = world.data.camera(EYE_CAMERA)
        self._rows.add(EYE, rr.Transform3D, translation=eye.xpos[None].copy(), mat3x3=_by_columns(eye.xmat)[None])
        robot, person = sights(world)
        together = robot.hit in range(len(session.names) - 1) and robot.hit == person.hit
        for path, sight, ink in ((ROBOTS_GAZE, robot, ROBOT), (PERSONS_GAZE, person, PERSON)):
            colour = np.array([GREEN if together else ink], np.uint8)
            way = (sight.end - sight.start)[None]
            self._rows.add(path, rr.Arrows3D, origins=sight.start[None], vectors=way, colors=colour)


def _by_columns(matrix: np.ndarray) -> np.ndarray:
    """A rotation (9,) from MuJoCo's order, row by row, to Rerun's, column by column."""
    return matrix.reshape(3, 3).T.ravel()


def _xyzw(quaternion: np.ndarray) -> np.ndarray:
    """Quaternions (..., 4) from MuJoCo's order (w, x, y, z) to Rerun's."""
    return np.roll(quaternion, -1, axis=-1)
