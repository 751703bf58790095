"""Joint attention with a caregiver at a table (section 6.4), as a dm_control domain.

The robot turns its head; reward is given while robot and caregiver look at the same object. Nothing here teaches the
robot of the dissertation, which learns without reward: the reward is for other learners, and as a measure.
"""

from collections import OrderedDict
from functools import cached_property
from typing import Any

import numpy as np
from dm_control import mujoco
from dm_control.mujoco.wrapper import MjModel
from dm_control.rl import control
from dm_control.utils import containers
from dm_env import specs

from jointattn_mj.errors import ConfigError
from jointattn_mj.scene.camera import PIVOT, in_picture, pixels_of_points
from jointattn_mj.scene.caregiver import FRAME_S
from jointattn_mj.scene.model import PICTURE_HEIGHT, PICTURE_WIDTH, build_model
from jointattn_mj.scene.world import HEAD_JOINTS, World, WorldConfig

DEFAULT_TIME_LIMIT = 60.0
"""Seconds in an episode: seven or eight transfers of an object."""
LOWEST = np.radians([-45.0, -35.0])
HIGHEST = np.radians([45.0, 15.0])
"""Bounds of the action, (pan, tilt), rad: wherever objects lie, and her face, with room to spare."""
ROBOT_RADIUS = np.radians(3.5)
"""The robot looks at what is so near to its line of sight ("around the center of the view", 6.3.1)."""
CAREGIVER_RADIUS = np.radians(5.0)
"""The same for the caregiver, whose eyes sit before the centre about which her head turns: her line of sight passes an
object at up to two degrees."""
LENSES = ("robot/lens_left", "robot/lens_right")
LENS_RGBA, LENS_LIT = (0.55, 0.80, 0.88, 1.0), (0.25, 0.95, 0.35, 1.0)
"""The robot's eyes, seen from outside: as in assets/robot.xml, and while reward is given (``visualize_reward``)."""

SUITE = containers.TaggedTasks()


@SUITE.add("benchmarking", "chapter6")
def object_transfer(
    time_limit: float = DEFAULT_TIME_LIMIT,
    random: np.random.RandomState | int | None = None,
    camera: bool = True,
    world: WorldConfig | None = None,
    environment_kwargs: dict[str, Any] | None = None,
) -> "Environment":
    """The caregiver takes objects up, observes them, and puts them elsewhere (section 6.4.2).

    Args:
        time_limit: Seconds in an episode.
        random: Seed, or a state to draw one from.
        camera: Whether observations hold the picture; without it nothing is rendered.
        world: What things look like and how the caregiver moves.
        environment_kwargs: Arguments of ``control.Environment``.

    Raises:
        ConfigError: The control timestep was to be changed.
    """
    settings = {"time_limit": time_limit, **(environment_kwargs or {})}
    if {"control_timestep", "n_sub_steps"} & settings.keys():
        raise ConfigError("the control timestep is that of the caregiver and the camera, 1/30 s; leave it out")
    world = world or WorldConfig()
    physics = Physics.from_model(MjModel(build_model(world.scene)))
    return Environment(physics, ObjectTransfer(world, random, camera), control_timestep=FRAME_S, **settings)


class Environment(control.Environment):
    """dm_control's environment, which gives its OpenGL context back when closed."""

    def observation_spec(self) -> OrderedDict[str, specs.Array]:
        """The task's, or one array if observations are flattened."""
        spec = super().observation_spec()
        if self._flat_observation:
            size = sum(int(np.prod(part.shape)) for part in spec.values())
            key = control.FLAT_OBSERVATION_KEY
            return OrderedDict({key: specs.Array((size,), float, name=key)})
        return spec

    def close(self) -> None:
        """Free model, data and rendering context."""
        self.physics.free()
        super().close()


class Physics(mujoco.Physics):
    """Who looks where. Targets are numbered as a robot numbers its candidates: the objects, then the partner's face.

    Points in the world frame, metres; angles in radians.
    """

    @cached_property
    def object_names(self) -> tuple[str, ...]:
        """Names of the objects, without their prefix."""
        bodies = (self.model.id2name(i, "body") for i in range(self.model.nbody))
        return tuple(name.removeprefix("object/") for name in bodies if name.startswith("object/"))

    @cached_property
    def _object_ids(self) -> np.ndarray:
        return np.array([self.model.name2id(f"object/{name}", "body") for name in self.object_names])

    @cached_property
    def _ids(self) -> dict[str, int]:
        kinds = {"robot/eye": "camera", "caregiver/face": "site"}
        kinds |= {"caregiver/eye_left": "body", "caregiver/eye_right": "body"}
        return {name: self.model.name2id(name, kind) for name, kind in kinds.items()}

    def object_positions(self) -> np.ndarray:
        """Centres of the objects, (n, 3)."""
        return self.data.xpos[self._object_ids]

    def face_position(self) -> np.ndarray:
        """Centre of the caregiver's head, (3,)."""
        return self.data.site_xpos[self._ids["caregiver/face"]].copy()

    def head_angles(self) -> np.ndarray:
        """Pan and tilt of the robot's head, (2,)."""
        return np.array([self.named.data.qpos[name][0] for name in HEAD_JOINTS])

    def robot_sight(self) -> tuple[np.ndarray, np.ndarray]:
        """Where the robot's line of sight begins, (3,), and its direction, a unit vector (3,)."""
        eye = self._ids["robot/eye"]
        return self.data.cam_xpos[eye].copy(), -self.data.cam_xmat[eye].reshape(3, 3)[:, 2]

    def caregiver_sight(self) -> tuple[np.ndarray, np.ndarray]:
        """The same for the caregiver: from midway between her eyes, along the mean of their directions."""
        eyes = [self._ids["caregiver/eye_left"], self._ids["caregiver/eye_right"]]
        ahead = self.data.xmat[eyes].reshape(2, 3, 3)[:, :, 0].sum(axis=0)
        return self.data.xpos[eyes].mean(axis=0), ahead / np.linalg.norm(ahead)

    def robot_to_targets(self) -> np.ndarray:
        """Angles (n + 1,) from the robot's line of sight to the objects and to the caregiver's face."""
        return _angles(*self.robot_sight(), np.vstack([self.object_positions(), self.face_position()]))

    def caregiver_to_targets(self) -> np.ndarray:
        """Angles (n + 1,) from the caregiver's line of sight to the objects and to the robot's face."""
        return _angles(*self.caregiver_sight(), np.vstack([self.object_positions(), PIVOT]))

    def robot_fixates(self, radius: float = ROBOT_RADIUS) -> int | None:
        """Index of the target nearest to the robot's line of sight, n for her face; None beyond ``radius``."""
        return _nearest(self.robot_to_targets(), radius)

    def caregiver_fixates(self, radius: float = CAREGIVER_RADIUS) -> int | None:
        """The same for the caregiver; n if she looks at the robot."""
        return _nearest(self.caregiver_to_targets(), radius)

    def joint_attention(self) -> bool:
        """Whether both look at the same object."""
        fixated = self.robot_fixates()
        return fixated is not None and fixated < len(self.object_names) and fixated == self.caregiver_fixates()

    def in_view(self) -> np.ndarray:
        """Which targets' centres lie inside the robot's picture, hidden or not: (n + 1,) bool."""
        targets = np.vstack([self.object_positions(), self.face_position()])
        pixels = pixels_of_points(targets, np.degrees(self.head_angles()))
        return in_picture(pixels) & (self.robot_to_targets() < np.pi / 2)


def _angles(origin: np.ndarray, direction: np.ndarray, points: np.ndarray) -> np.ndarray:
    along = points - origin
    across = np.linalg.norm(np.cross(along, direction), axis=1)
    return np.arctan2(across, along @ direction)


def _nearest(angles: np.ndarray, radius: float) -> int | None:
    nearest = int(np.argmin(angles))
    return nearest if angles[nearest] <= radius else None


class ObjectTransfer(control.Task):
    """Episodes with a caregiver who goes on whatever the robot does; every episode begins with another table.

    Attributes:
        world: Body and script; made at the first episode.
        visualize_reward: Whether the robot's eyes light up while reward is given.
    """

    world: World

    def __init__(self, config: WorldConfig, random: np.random.RandomState | int | None = None, camera: bool = True):
        self.config, self._camera = config, camera
        self.visualize_reward = False
        entropy = random.randint(2**31, size=4).tolist() if isinstance(random, np.random.RandomState) else random
        self._seeds = np.random.SeedSequence(entropy)

    def initialize_episode(self, physics: Physics) -> None:
        """Another table, the caregiver about to greet. The k-th episode's seed is the k-th child of the task's."""
        (seed,) = self._seeds.spawn(1)
        if hasattr(self, "world"):
            self.world.reset(seed)
        else:
            self.world = World(self.config, physics, seed)
        self.after_step(physics)

    def before_step(self, action: np.ndarray, physics: Physics) -> None:
        """One frame's script for the caregiver; ``action`` (2,) is the desired pan and tilt, rad."""
        self.world.before_step(action)

    def after_step(self, physics: Physics) -> None:
        """Light the robot's eyes, where that was asked for."""
        if self.visualize_reward:
            lit = bool(self.get_reward(physics))
            for geom in LENSES:
                physics.named.model.geom_rgba[geom] = LENS_LIT if lit else LENS_RGBA

    def action_spec(self, physics: Physics) -> specs.BoundedArray:
        """Desired pan and tilt of the head, (2,), rad; pan positive to the robot's left, tilt upwards."""
        return specs.BoundedArray((2,), float, LOWEST, HIGHEST, name="desired pan\tdesired tilt")

    def observation_spec(self, physics: Physics) -> OrderedDict[str, specs.Array]:
        """What ``get_observation`` returns."""
        spec: OrderedDict[str, specs.Array] = OrderedDict()
        if self._camera:
            spec["camera"] = specs.BoundedArray((PICTURE_HEIGHT, PICTURE_WIDTH, 3), np.uint8, 0, 255, name="camera")
        spec["head_angles"] = specs.Array((2,), float, name="head_angles")
        spec["head_moves"] = specs.Array((), bool, name="head_moves")
        return spec

    def get_observation(self, physics: Physics) -> OrderedDict[str, np.ndarray]:
        """The picture, the head's pan and tilt (rad), and whether it turns; arrays of the caller's own."""
        observation: OrderedDict[str, np.ndarray] = OrderedDict()
        if self._camera:
            observation["camera"] = self.world.picture().copy()
        observation["head_angles"] = self.world.head_angles()
        observation["head_moves"] = np.array(self.world.head_moves())
        return observation

    def get_reward(self, physics: Physics) -> float:
        """1 while both look at the same object, else 0."""
        return float(physics.joint_attention())
