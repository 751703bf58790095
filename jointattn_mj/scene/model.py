"""The 3D scene as one MjModel: robot, caregiver, objects, table, room (section 6.4.1).

World frame: metres, x from the robot to the caregiver, y to the robot's left, z up. Joint angles in radians. A
``SceneConfig`` decides everything; building twice gives the same model byte for byte.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Annotated, Literal

import mujoco
import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.options import TOP_LEVEL, Checked, Choice, Colour, Real
from jointattn_mj.scene import body, room
from jointattn_mj.scene.face import FaceMesh, build_face, identity
from jointattn_mj.scene.objects import OBJECTS, ObjectConfig, object_size
from jointattn_mj.scene.people import IDENTITIES, FaceConfig
from jointattn_mj.scene.shapes import Mesh

IMAGE_WIDTH, IMAGE_HEIGHT = 320, 240  # camera images of section 6.4.1
TIMESTEP = 1 / 30  # one physics step an image: nothing collides, and the servos are damped implicitly
TABLE_Z = 0.71  # height of the table top
HEAD_POSITION = (1.5, 0.0, 1.08)  # centre of the caregiver's head, where its yaw and pitch axes meet
Quality = Literal["fast", "high"]
BLANK = 64  # pixels, edge of a texture to be painted on
ROBOT_GROUP = 3  # geoms of the robot's body, which its own eye does not draw; switch the group on for other views


@dataclass(frozen=True)
class SceneConfig(Checked):
    """What the world looks like; behaviour does not depend on it."""

    caregiver: Annotated[str, Choice(IDENTITIES), TOP_LEVEL] = "robin"
    """Who the caregiver is."""
    face: FaceConfig | None = None
    """Looks of somebody else; None: those of ``caregiver``."""
    clothing: Colour = (0.40, 0.43, 0.48)
    """Colour of the caregiver's clothes: dull, unlike any object."""
    objects: tuple[ObjectConfig, ...] = OBJECTS[:4]
    """The objects on the table: four, as in section 6.4.1."""
    object_size: Annotated[float, Real("[0.01, 0.12]")] = 0.06
    """Edge or diameter of objects, metres: about 16 pixels in the image (choice)."""
    quality: Annotated[Quality, TOP_LEVEL] = "fast"
    """``fast`` for running; ``high``, with shadows, smooth edges and fine meshes, for figures."""

    def __post_init__(self) -> None:
        super().__post_init__()
        names = [o.name for o in self.objects]
        if not names:
            raise ConfigError("objects: expected one at least, for the caregiver to look at and handle; got none")
        if len(set(names)) != len(names) or not all(names):
            raise ConfigError(f"objects: expected distinct, non-empty names; got {names}")


def assets_folder() -> Path:
    """Folder of the MJCF parts and trained weights: the checkout's where there is one, else the installed package's."""
    checkout = Path(__file__).resolve().parents[2] / "assets"
    return checkout if checkout.is_dir() else Path(str(resources.files("jointattn_mj"))) / "assets"


def rest_height(config: SceneConfig) -> float:
    """Height, metres, of an object's centre when it stands on the table."""
    return TABLE_Z + config.object_size / 2 + 0.001


def rest_positions(config: SceneConfig) -> np.ndarray:
    """First positions (n, 3) of objects, at least .13 m apart for up to ten; world frame, metres."""
    count, height = len(config.objects), rest_height(config)
    if count <= 4:
        return np.array([(1.0, y, height) for y in np.linspace(0.3, -0.3, count)]).reshape(-1, 3)
    far = count // 2  # two rows, staggered so that both are seen
    near_row = [(0.93, y + 0.04, height) for y in np.linspace(0.30, -0.30, count - far)]
    return np.array(near_row + [(1.10, y - 0.04, height) for y in np.linspace(0.30, -0.30, far)])


def _part(name: str) -> mujoco.MjSpec:
    return mujoco.MjSpec.from_file(str(assets_folder() / f"{name}.xml"))


def _add_mesh(spec: mujoco.MjSpec, name: str, mesh: Mesh | FaceMesh, texture: np.ndarray | None = None) -> None:
    """Add a mesh as asset ``name``, and where given a texture (h, w, 3) uint8 and a material of the same name."""
    part = spec.add_mesh(name=name)
    part.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # open surfaces
    part.uservert, part.userface = mesh.vertices.ravel(), mesh.faces.ravel()
    part.usernormal, part.usertexcoord = mesh.normals.ravel(), mesh.uv.ravel()
    if texture is not None:
        _add_texture(spec, name, texture)


def _add_texture(spec: mujoco.MjSpec, name: str, texture: np.ndarray, rgb: tuple[float, ...] = (1.0, 1.0, 1.0)) -> None:
    """Add a dull material ``name`` with a texture (h, w, 3) uint8 of the same name, times ``rgb``."""
    height, width, _ = texture.shape
    image = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, height=height, width=width, nchannel=3)
    image.data = texture.tobytes()
    roles = [""] * int(mujoco.mjtTextureRole.mjNTEXROLE)
    roles[mujoco.mjtTextureRole.mjTEXROLE_RGB] = image.name
    spec.add_material(name=name, textures=roles, rgba=(*rgb, 1), specular=0, shininess=0)


def _add_colour(spec: mujoco.MjSpec, name: str, rgb: tuple[float, ...], blank: bool = False) -> None:
    """Add a dull material ``name``; with ``blank`` it has a white texture, to be painted on."""
    if blank:
        _add_texture(spec, name, np.full((BLANK, BLANK, 3), 255, np.uint8), rgb)
    else:
        spec.add_material(name=name, rgba=(*rgb, 1), specular=0, shininess=0)


def _add_caregiver(spec: mujoco.MjSpec, config: SceneConfig, high: bool, blank: bool) -> None:
    part = _part("caregiver")
    person = config.face or identity(config.caregiver)
    looks = build_face(person, *((3, 1024) if high else (1, 64)))
    _add_mesh(part, "head", looks, looks.texture)
    _add_mesh(part, "eyeball", looks.eyeball, looks.eye_texture)
    x, y, z = looks.eye_centre
    part.body("eye_left").pos, part.body("eye_right").pos = (x, y, z), (x, -y, z)
    _add_mesh(part, "trunk", body.trunk(high))
    _add_mesh(part, "upper_arm", body.upper_arm(part.body("elbow").pos[0], high))
    _add_mesh(part, "forearm", body.forearm(part.body("wrist").pos[0], high))
    _add_mesh(part, "hand", body.hand(high))
    _add_mesh(part, "neck", body.neck(high))
    _add_colour(part, "skin", tuple(0.93 * c for c in person.skin))
    if high:
        _add_texture(part, "cloth", body.cloth(config.clothing, 512))
    else:
        _add_colour(part, "cloth", config.clothing, blank)
    stand = spec.worldbody.add_body(name="caregiver", pos=(HEAD_POSITION[0], HEAD_POSITION[1], 0), quat=(0, 0, 0, 1))
    spec.attach(part, prefix="caregiver/", frame=stand.add_frame())


def _add_room(spec: mujoco.MjSpec, high: bool, blank: bool) -> None:
    part = _part("table")
    _add_mesh(part, "table", room.table(half_x=0.42, half_y=0.60, thickness=0.04, relief=not high))
    _add_mesh(part, "wall", room.wall(half_y=3.6, height=2.6, relief=not high))
    _add_mesh(part, "floor", room.floor(low_x=-2.2, high_x=2.2, half_y=3.6))
    _add_mesh(part, "side_walls", room.side_walls(low_x=-2.2, high_x=2.2, half_y=3.6, height=2.6))
    if high:
        _add_texture(part, "table", room.wood(512))
        _add_texture(part, "wall", room.plaster(512, height=2.6))
        _add_texture(part, "floor", room.carpet(512))
    else:  # the same colours without textures
        for name, rgb in (("table", room.WOOD), ("wall", room.PLASTER), ("floor", room.CARPET)):
            _add_colour(part, name, rgb, blank)
    spec.attach(part, prefix="room/", frame=spec.worldbody.add_frame())


def _options(spec: mujoco.MjSpec) -> None:
    spec.option.timestep = TIMESTEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.memory = 1 << 20  # without contacts some kilobytes are used; by default it is 14 MiB
    spec.option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_CONTACT)


def _visuals(spec: mujoco.MjSpec, high: bool) -> None:
    """Quick drawing for running (no shadows, no multisampling, few slices), or fine drawing for figures."""
    visual = spec.visual
    visual.global_.offwidth, visual.global_.offheight = (1280, 960) if high else (IMAGE_WIDTH, IMAGE_HEIGHT)
    visual.quality.offsamples = 2 if high else 0
    visual.quality.shadowsize = 2048 if high else 0
    visual.quality.numslices, visual.quality.numstacks = (32, 16) if high else (12, 6)
    visual.quality.numquads = 1
    visual.map.znear, visual.map.zfar = 0.05, 10.0
    visual.map.shadowclip = 2.2
    spec.stat.extent, spec.stat.center = 1.0, (0.85, 0, 0.8)
    # With shadows, a light's own ambient part is missing in its shadow: the headlight gives it instead (at some cost).
    ambient, none = (0.48, 0.48, 0.48), (0, 0, 0)
    headlight = visual.headlight
    headlight.active = high
    headlight.ambient, headlight.diffuse, headlight.specular = ambient, none, none
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=(-0.8, 0.35, 2.2),
        dir=(0.74, -0.13, -0.50),
        castshadow=high,
        ambient=none if high else ambient,
        diffuse=(0.62, 0.62, 0.62),
        specular=none,
    )


def _add_objects(spec: mujoco.MjSpec, config: SceneConfig) -> None:
    for item, position in zip(config.objects, rest_positions(config), strict=True):
        body = spec.worldbody.add_body(name=f"object/{item.name}", mocap=True, pos=position)
        kind, size = object_size(item.shape, config.object_size)
        body.add_geom(name=f"object/{item.name}", type=kind, size=size, rgba=(*item.rgb, 1), contype=0, conaffinity=0)


def _add_onlooker(spec: mujoco.MjSpec, position: tuple[float, float, float], at: tuple[float, float, float]) -> None:
    """Add the camera ``third_person`` at ``position``, upright, looking at the point ``at``; world frame, metres."""
    ahead = np.subtract(at, position)
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right = right / np.linalg.norm(right)
    up = np.cross(right, ahead) / np.linalg.norm(ahead)
    rotation = np.column_stack([right, up, -ahead / np.linalg.norm(ahead)])
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, rotation.ravel())
    spec.worldbody.add_camera(name="third_person", pos=position, quat=quat, fovy=48)


def build_model(config: SceneConfig | None = None, blank: bool = False) -> mujoco.MjModel:
    """Compile the scene. Bodies come in drawing order, near to far: people, objects, table, wall, floor.

    Args:
        config: What it looks like; None for the defaults.
        blank: Give plain surfaces white textures, to be painted on by ``scene.dressing``. Images then take longer.
    """
    config = config or SceneConfig()
    high = config.quality == "high"
    spec = mujoco.MjSpec()
    spec.modelname = "jointattn"
    _options(spec)
    _visuals(spec, high)
    _add_onlooker(spec, position=(0.25, -1.75, 1.50), at=(0.80, 0.0, 0.80))
    _add_caregiver(spec, config, high, blank)
    spec.attach(_part("robot"), prefix="robot/", frame=spec.worldbody.add_frame())
    _add_objects(spec, config)
    _add_room(spec, high, blank)
    return spec.compile()


def build_robot() -> mujoco.MjModel:
    """Compile the robot's body alone: its head moves as in the scene."""
    spec = _part("robot")
    _options(spec)
    return spec.compile()
