"""A third person's view of robot and caregiver with lines of sight, for people: it uses the simulator's state."""

import copy
from typing import NamedTuple

import mujoco
import numpy as np
from dm_control.mujoco.wrapper import MjModel

from jointattn_mj.scene.camera import PIVOT
from jointattn_mj.scene.model import ROBOT_GROUP, TABLE_Z
from jointattn_mj.scene.placing import place
from jointattn_mj.scene.redrawing import RedrawingEye
from jointattn_mj.scene.rendering import RenderingPhysics
from jointattn_mj.scene.world import World
from jointattn_mj.video.paint import GREEN, PERSON, ROBOT, Colour, disc, lines

HIT_DEG = 4.0
"""A line of sight that passes a thing within this angle ends there; for the robot 3.5 deg is looking at it."""
_INSIDE = 0.03  # m, of it that is hidden in the thing where it ends
_LINE_PX, _DOT_PX = 2, 3.5  # how wide it is drawn, and the radius of the dot where it ends at nothing
_STILL = 1e-3  # m and rad; smaller movements, of a fifth of a pixel, are shown with the next larger one
_FARTHEST = 1.35  # m, length of a line of sight that meets nothing
_START = 0.10  # m, where it leaves the head
_FOVY_DEG = 33.5  # a little tighter than the camera's own: both heads just fit
_LEFT, _DOWN = 0.045, 0.022  # rad, turn of the camera towards the middle between the two
_LAMP, _AMBIENT, _FILL = np.array([0.58, 0.55, 0.49]), np.array([0.50, 0.50, 0.51]), np.array([0.13, 0.13, 0.13])
"""Light of the onlooker's model (rgb): a warm lamp, light from all around, and light from the camera."""
_ROOM = {"table": (1.16, 1.04, 0.86), "wall": (1.16, 1.18, 1.16), "floor": (1.10, 1.06, 1.0)}
"""Factors on the room's colours (rgb) in the onlooker's model."""
_SIDE_WALLS = (0.93, 0.93, 0.90)


class Sight(NamedTuple):
    """A line of sight in the world, metres."""

    start: np.ndarray  # (3,)
    end: np.ndarray  # (3,)
    hit: int | None  # number of the target at which it ends


def line_of_sight(start: np.ndarray, ahead: np.ndarray, targets: np.ndarray) -> Sight:
    """The line of sight of somebody; it ends at a thing, at the table, or after ``_FARTHEST``.

    Args:
        start: Eyes, (3,) metres in the world.
        ahead: Direction of gaze, (3,) unit vector.
        targets: (k, 3) metres; one of them may end the line.
    """
    to = targets - start
    along = to @ ahead
    off = np.degrees(np.arctan2(np.linalg.norm(to - along[:, None] * ahead, axis=1), along))
    nearest = int(np.argmin(off))
    begin = start + _START * ahead
    if off[nearest] <= HIT_DEG:
        return Sight(begin, start + along[nearest] * ahead, nearest)
    to_table = (TABLE_Z - start[2]) / ahead[2] if ahead[2] < 0 else np.inf
    return Sight(begin, start + min(to_table, _FARTHEST) * ahead, None)


def sights(world: World) -> tuple[Sight, Sight]:
    """The robot's and the caregiver's line of sight now; they hit objects by their number, or n, each other's face."""
    data, candidates = world.data, world.candidate_points()
    robot = line_of_sight(PIVOT, data.body("robot/tilt").xmat.reshape(3, 3)[:, 0], candidates)
    eyes = [data.body(f"caregiver/eye_{side}") for side in ("left", "right")]
    ahead = np.mean([eye.xmat.reshape(3, 3)[:, 0] for eye in eyes], axis=0)
    between = np.mean([eye.xpos for eye in eyes], axis=0)
    person = line_of_sight(between, ahead / np.linalg.norm(ahead), np.vstack([candidates[:-1], PIVOT]))
    return robot, person


class Onlooker:
    """Renders the camera third_person with the robot's body and both lines of sight.

    It has a physics of its own, into which it copies poses: the world's, with smooth edges, a tighter view and light
    for people. The world and the robot's camera stay as they are.

    Attributes:
        together: Whether both looked at the same object in the last image.
    """

    def __init__(self, world: World, width: int, height: int):
        """Make a camera on ``world`` with images of ``width`` times ``height`` pixels."""
        model = copy.copy(world.model)
        model.vis.global_.offwidth, model.vis.global_.offheight = width, height
        model.vis.quality.offsamples = 4
        _light(model)
        view = model.camera("third_person")
        view.fovy[:] = _FOVY_DEG
        turn, quat = np.empty(4), view.quat.copy()
        mujoco.mju_euler2Quat(turn, np.array([-_DOWN, _LEFT, 0.0]), "xyz")
        mujoco.mju_mulQuat(view.quat, quat, turn)
        self._world = world
        self._physics = RenderingPhysics.from_model(MjModel(model))
        self._eye = _EyeOutside(self._physics, width, height)
        self.together = False

    def render(self) -> np.ndarray:
        """The image now, uint8 (height, width, 3), which holds until the next one; sets ``together``."""
        model, data, now = self._physics.model.ptr, self._physics.data.ptr, self._world.data
        data.qpos[:], data.mocap_pos[:], data.mocap_quat[:] = now.qpos, now.mocap_pos, now.mocap_quat
        place(model, data)
        image = self._eye.render().copy()
        robot, person = sights(self._world)
        objects = range(len(self._world.caregiver.objects))
        self.together = robot.hit in objects and robot.hit == person.hit
        self._draw(image, person, GREEN if self.together else PERSON)
        self._draw(image, robot, GREEN if self.together else ROBOT)
        return image

    def close(self) -> None:
        """Free model, data and rendering context."""
        self._physics.free()

    def _draw(self, image: np.ndarray, sight: Sight, colour: Colour) -> None:
        """Draw a line of sight up to the surface of a thing, or with a dot where it ends at none."""
        along = sight.end - sight.start
        end = sight.end if sight.hit is None else sight.end - _INSIDE * along / np.linalg.norm(along)
        ends = self._eye.pixels_of(np.array([sight.start, end]))
        lines(image, [ends], colour, _LINE_PX)
        if sight.hit is None:
            disc(image, ends[1], _DOT_PX, colour)


class _EyeOutside(RedrawingEye):
    """Renders third_person with the robot's body; drawing what moves takes a fifth of the time of whole images."""

    def __init__(self, physics: RenderingPhysics, width: int, height: int):
        super().__init__(physics, "third_person", width, height, groups=[ROBOT_GROUP], apart="robot/")

    def pixels_of(self, points: np.ndarray) -> np.ndarray:
        """Where points (k, 3), world frame, metres, appear: pixels (k, 2)."""
        height, width = self._size
        right, up, behind = ((points - self._eye) @ self._axes.reshape(3, 3)).T
        x, y = (width - 1) / 2 - self._focal * right / behind, (height - 1) / 2 + self._focal * up / behind
        return np.column_stack([x, y])

    def _poses(self) -> tuple[np.ndarray, np.ndarray]:
        positions, orientations = super()._poses()
        return np.round(positions / _STILL) * _STILL, np.round(orientations / _STILL) * _STILL


def _light(model: mujoco.MjModel) -> None:
    """Replace the light of ``model``, an onlooker's own, by a brighter and warmer one."""
    model.light_diffuse[0], model.light_ambient[0] = _LAMP, 0.0
    headlight = model.vis.headlight
    headlight.active = 1
    headlight.ambient[:], headlight.diffuse[:], headlight.specular[:] = _AMBIENT, _FILL, 0.0
    for name, factor in _ROOM.items():
        rgba = model.material(f"room/{name}").rgba
        rgba[:3] = np.minimum(rgba[:3] * factor, 1)
    model.geom("room/side_walls").rgba[:3] = _SIDE_WALLS
