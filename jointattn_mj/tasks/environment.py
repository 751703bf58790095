"""What all tasks share: seeds of episodes, caregivers, observations, saved states, and dm_control's interface."""

from abc import abstractmethod
from collections import OrderedDict
from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from typing import Any, ClassVar, Self

import numpy as np
from dm_control.mujoco.wrapper import MjModel
from dm_control.rl import control
from dm_env import specs

from jointattn_mj.errors import ConfigError, ObservationError, StateError
from jointattn_mj.guards.closing import Closable
from jointattn_mj.options import shown
from jointattn_mj.scene import snapshot
from jointattn_mj.scene.caregiver import FRAME_S, TransferScript
from jointattn_mj.scene.dressing import Conditions
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH, build_model
from jointattn_mj.scene.people import FaceConfig
from jointattn_mj.scene.variation import VariationConfig, drawn, variation_of
from jointattn_mj.scene.world import AS_USUAL, World, WorldConfig
from jointattn_mj.tasks.actions import checked
from jointattn_mj.tasks.arguments import require, unknown
from jointattn_mj.tasks.face_patch import SPEC, FacePatch
from jointattn_mj.tasks.physics import Physics
from jointattn_mj.tasks.state import EnvironmentState

LOWEST = np.radians([-45.0, -35.0])
HIGHEST = np.radians([45.0, 15.0])
"""Bounds of the head's (pan, tilt), rad: they reach all objects and the caregiver's face, with room to spare."""
LENSES = ("robot/lens_left", "robot/lens_right")
LENS_RGBA, LENS_LIT = (0.55, 0.80, 0.88, 1.0), (0.25, 0.95, 0.35, 1.0)
"""Colours of the robot's eyes: as in assets/robot.xml, and while reward is given (``visualize_reward``)."""

PEOPLE = 2**31
"""Child of an episode's seed that draws the caregiver; the first children belong to the world."""

SeedLike = np.random.RandomState | int | None
"""A seed, a state that one is drawn from, or None: any seed."""

_SETTINGS = ("flat_observation", "legacy_step")
"""Arguments of ``control.Environment`` that are passed on to it."""


class TaskObservation(OrderedDict[str, np.ndarray]):
    """The observation of a task's time step: a dictionary, as in dm_control, with the robot's part as attributes.

    It is a ``perception.percept.Observation``: the robots of this package take it as it is.
    """

    @property
    def image(self) -> np.ndarray:
        """``camera``: the image, uint8 (240, 320, 3) RGB."""
        return self._part("camera")

    @property
    def head_angles(self) -> np.ndarray:
        """Pan and tilt of the robot's head, (2,), rad."""
        return self._part("head_angles")

    @property
    def head_moves(self) -> bool:
        """Whether the robot's head turns."""
        return bool(self._part("head_moves"))

    def _part(self, name: str) -> np.ndarray:
        if name not in self:
            raise ObservationError(f"expected an observation with {name}; this task gives {', '.join(self)}")
        return self[name]


class JointAttentionTask(control.Task):  # type: ignore[misc]
    """A task: its worlds, observations and saved states. The k-th episode has the k-th child of the task's seed.

    Attributes:
        world: The world of the episode: bodies and the caregiver's script.
        visualize_reward: Whether the robot's eyes light up while reward is given.
    """

    kind: ClassVar[type[World]] = World
    """Class of the task's worlds."""
    world: World

    def __init__(
        self, config: WorldConfig, random: SeedLike = None, camera: bool = True, truth: bool = False,
        people: Sequence[str] = (), variation: VariationConfig | str = "none", face_patch: bool = False,
    ):  # fmt: skip
        """Make a task.

        Args:
            config: The world.
            random: Seed, or a state to draw one from; None draws one.
            camera: Whether observations hold the image.
            truth: Whether observations hold the ground truth.
            people: Names of caregivers, one of whom is drawn for each episode; empty: the caregiver of ``config``.
            variation: How far the world of each episode may differ from ``config``: ranges, or names of presets.
            face_patch: Whether observations hold the caregiver's face, as the robot's own detector finds it.

        Raises:
            ConfigError: An argument is of the wrong kind, a name is unknown, or the world's dynamics are not MuJoCo's.
        """
        require("world", config, WorldConfig)
        require("camera", camera, bool)
        require("truth", truth, bool)
        require("face_patch", face_patch, bool)
        require("people", people, tuple, list)
        require("variation", variation, VariationConfig, str)
        if config.dynamics != "mujoco":
            raise ConfigError(
                f"an environment steps MuJoCo's physics: world.dynamics must be mujoco; got {config.dynamics}"
            )
        self._configs = [replace(config, scene=replace(config.scene, caregiver=name, face=None)) for name in people]
        self._configs = self._configs or [config]
        self._variation = variation_of(variation)
        self._worlds: dict[tuple[str, FaceConfig | None], World] = {}
        self._camera, self._truth, self._face_patch = camera, truth, face_patch
        self._face: FacePatch | None = None  # once an episode needs it
        self._face_parts: dict[str, np.ndarray] | None = None  # of the face in this step, once it was observed
        self.visualize_reward = False
        self._action_spec = self.actions()
        self.seed(random)

    def seed(self, random: SeedLike) -> None:
        """Start again with the first episode of another seed.

        Args:
            random: The seed, or a state to draw one from; None draws one.

        Raises:
            ConfigError: ``random`` is none of these.
        """
        entropy = random.randint(2**31, size=4).tolist() if isinstance(random, np.random.RandomState) else random
        try:
            self._seeds = np.random.SeedSequence(entropy)
        except (TypeError, ValueError) as error:
            raise ConfigError(
                f"random: expected a whole number of 0 or more as seed, or None; got {shown(random)}"
            ) from error
        self.random = np.random.RandomState(np.random.MT19937(self._seeds))
        """Random numbers for wrappers of dm_control, which take their noise from here; tasks draw none."""

    def cast(self) -> World:
        """Choose the world of the next episode by its seed: the caregiver, and what else varies."""
        casting = np.random.default_rng(self._next_seed(PEOPLE))
        chosen = self._configs[int(casting.integers(len(self._configs)))]
        self._drawn = drawn(chosen, self._variation, self._next_seed())
        self.world = self._world_of(*self._drawn)
        return self.world

    def cast_script(self) -> tuple[World, TransferScript]:
        """Begin the next episode outside of its world, which several tasks may then share: the world and the script."""
        world = self.cast()
        (seed,) = self._seeds.spawn(1)
        self._begin_to_see()
        return world, world.script(seed)

    def twin(self) -> Self:
        """Another task with episodes of its own, in the same worlds."""
        other = object.__new__(type(self))  # a copy would have worlds of its own
        other.__dict__.update(vars(self))
        if self._face_patch:
            other._face = copy(self._known_face())
        return other

    def observe_anew(self) -> dict[str, np.ndarray]:
        """Observe the world as it is, after bodies were moved outside of a step; arrays hold until the next call."""
        self._face_parts = None
        usual = getattr(self.get_observation, "__func__", None) is JointAttentionTask.get_observation
        return self._observed() if usual else self.get_observation(self.world.physics)

    @property
    def varies(self) -> bool:
        """Whether worlds differ from episode to episode by more than the caregiver."""
        return self._variation.on

    def _world_of(self, config: WorldConfig, conditions: Conditions) -> World:
        """The world with that caregiver; compiled when it is first needed."""
        who = config.scene.caregiver, config.scene.face
        if who not in self._worlds:
            physics = Physics.from_model(MjModel(build_model(config.scene, blank=self._variation.textures > 0)))
            physics.scripted = True
            self._worlds[who] = self.kind(config, physics, np.random.SeedSequence(0), conditions)
        return self._worlds[who]

    def _next_seed(self, *child: int) -> np.random.SeedSequence:
        """The next episode's seed, which ``initialize_episode`` will spawn, or a child of it."""
        seeds = self._seeds
        return np.random.SeedSequence(seeds.entropy, spawn_key=(*seeds.spawn_key, seeds.n_children_spawned, *child))

    def initialize_episode(self, physics: Physics) -> None:
        """Start the next episode: everything that its seed decides."""
        (seed,) = self._seeds.spawn(1)
        self._begin_to_see()
        self.world.vary(*self._drawn)
        self.world.reset(seed)
        self.begin(seed)
        self.after_step(physics)

    def _begin_to_see(self) -> None:
        self._face_parts = None
        if self._face_patch:
            self._known_face().begin()

    def begin(self, seed: np.random.SeedSequence) -> None:
        """What a task adds to the start of an episode; ``seed`` is the episode's."""

    def before_step(self, action: Any, physics: Physics) -> None:
        """Prepare a step with an action; numbers beyond the bounds of ``action_spec`` are clipped to them.

        Raises:
            ActionError: The action is not finite, has another shape, or is no numbers; nothing has changed then.
        """
        action = checked(action, self._action_spec)
        self._face_parts = None
        self.act(action)

    def act(self, action: np.ndarray) -> None:
        """Advance the caregiver's script, and set the head's servos to ``action`` (2,), pan and tilt, rad."""
        self.world.before_step(action)

    def after_step(self, physics: Physics) -> None:
        """Light the robot's eyes where there is reward and ``visualize_reward``."""
        if self.visualize_reward:
            lit = self.get_reward(physics) > 0
            for geom in LENSES:
                physics.named.model.geom_rgba[geom] = LENS_LIT if lit else LENS_RGBA

    def action_spec(self, physics: Physics) -> specs.BoundedArray:
        """Shape and bounds of an action; see ``actions``."""
        return self._action_spec

    def actions(self) -> specs.BoundedArray:
        """Shape and bounds of an action: desired pan and tilt of the head, (2,), rad."""
        return specs.BoundedArray((2,), float, LOWEST, HIGHEST, name="desired pan\tdesired tilt")

    def observation_spec(self, physics: Physics) -> OrderedDict[str, specs.Array]:
        """Shapes and bounds of what ``get_observation`` returns."""
        spec: OrderedDict[str, specs.Array] = OrderedDict()
        if self._camera:
            spec["camera"] = specs.BoundedArray((IMAGE_HEIGHT, IMAGE_WIDTH, 3), np.uint8, 0, 255, name="camera")
        spec["head_angles"] = specs.BoundedArray((2,), float, -np.pi, np.pi, name="head_angles")
        if self._face_patch:
            spec |= SPEC
        return spec | (self.truth_spec() if self._truth else {})

    def get_observation(self, physics: Physics) -> TaskObservation:
        """Image, the head's pan and tilt (rad), face, and ground truth, as asked for; new arrays at each call."""
        return TaskObservation((name, value.copy()) for name, value in self._observed().items())

    def _observed(self) -> dict[str, np.ndarray]:
        """What ``get_observation`` copies."""
        observed = {"camera": self.world.image()} if self._camera else {}
        observed["head_angles"] = self.world.head_angles()
        if self._face_patch:
            if self._face_parts is None:
                self._face_parts = self._known_face().observe(self.world.image(), observed["head_angles"])
            observed |= self._face_parts
        return observed | self.truth() if self._truth else observed

    def _known_face(self) -> FacePatch:
        """The robot that knows all caregivers' faces; made in worlds that are reset before they are used."""
        if self._face is None:
            worlds = ((self._world_of(config, AS_USUAL), config.behaviour.head_share) for config in self._configs)
            self._face = FacePatch(worlds)
        return self._face

    def truth_spec(self) -> dict[str, specs.Array]:
        """Shapes and bounds of what ``truth`` returns."""
        return {"truth": specs.BoundedArray((2,), float, -np.pi, np.pi, name="truth")}

    def truth(self) -> dict[str, np.ndarray]:
        """Ground truth, as perfect perception would give it: yaw and pitch of the caregiver's head, (2,), rad."""
        return {"truth": self.world.face_angles().copy()}

    @abstractmethod
    def best_action(self, physics: Physics) -> np.ndarray:
        """The action of an oracle, which knows all of the world."""

    @property
    def built(self) -> tuple[Any, ...]:
        """What the task was built with, as far as its future depends on it. Tasks with equal ``built`` share states."""
        return type(self).__qualname__, tuple(self._configs), self._variation

    def get_state(self) -> dict[str, Any]:
        """Bodies, the caregiver's script and random streams, as plain data."""
        seeds, random = self._seeds.state, snapshot.take(self.random)
        face = None if self._face is None else self._face.get_state()
        return {
            "seeds": seeds,
            "random": random,
            "world": self.world.get_state(),
            "face": face,
            "seen": self._face_parts,
        }

    def set_state(self, state: dict[str, Any]) -> None:
        """Go back to a state of this task, or of one with equal ``built``."""
        self._seeds = np.random.SeedSequence(**state["seeds"])
        snapshot.put(self.random, state["random"])
        if self._face_patch:
            self._known_face().set_state(state["face"])
            self._face_parts = state["seen"]
        self._take_up(state["world"])

    def _take_up(self, state: dict[str, Any]) -> None:
        """Make the world of a saved state the task's own."""
        self.world = self._world_of(state["config"], state["conditions"])
        self.world.set_state(state)
        self.after_step(self.world.physics)

    def __getstate__(self) -> dict[str, Any]:
        """A copy has a world of its own, and compiles those of other caregivers when it needs them."""
        return {**vars(self), "_worlds": {}, "world": self.world.get_state()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._take_up(state["world"])

    def close(self) -> None:
        """Free all models, data and rendering contexts."""
        for world in self._worlds.values():
            world.close()


class Environment(Closable, control.Environment):  # type: ignore[misc]
    """dm_control's environment, in which each episode may have a physics of its own, and whose state can be saved.

    Copies (``copy.deepcopy``, ``pickle``) go on as the original does. After ``close`` everything raises
    ``ClosedError``.
    """

    _task: JointAttentionTask
    _physics: Physics

    def __init__(self, task: JointAttentionTask, time_limit: float, **settings: Any):
        """Make an environment.

        Args:
            task: The task.
            time_limit: Seconds in an episode.
            settings: Arguments of ``control.Environment``: ``flat_observation``, ``legacy_step``.

        Raises:
            ConfigError: The control timestep was to be changed, the time is not positive, or a setting is unknown.
        """
        kind = task.kind
        if {"control_timestep", "n_sub_steps"} & settings.keys():
            raise ConfigError(f"the control timestep of this task is {kind.frames}/30 s; leave it out")
        for name in settings.keys() - _SETTINGS:
            raise unknown("argument of an environment", name, ("time_limit", *_SETTINGS))
        if not isinstance(time_limit, (int, float)) or not time_limit > 0:
            raise ConfigError(f"time_limit must be a positive number of seconds; got {shown(time_limit)}")
        control_timestep = kind.frames * FRAME_S
        super().__init__(
            task.cast().physics, task, time_limit=time_limit, control_timestep=control_timestep, **settings
        )  # fmt: skip
        self._step_limit = np.ceil(time_limit / control_timestep - 1e-6)  # 3 s of 0.1 s are 30 steps, not 31

    def __repr__(self) -> str:
        """Task and step of the episode: ``Environment(Follow, step 3 of 30)``."""
        if self.closed:
            return f"{type(self).__name__}(closed)"
        return f"{type(self).__name__}({type(self._task).__name__}, step {self._step_count} of {self.step_limit})"

    def reset(self) -> Any:
        """Start the next episode; returns its first time step."""
        self._switch_to(self._task.cast().physics, self._physics.legacy_step)
        return super().reset()

    def observation_spec(self) -> OrderedDict[str, specs.Array]:
        """Shapes and bounds of observations: the task's, or one array if observations are flattened."""
        spec: OrderedDict[str, specs.Array] = super().observation_spec()
        if self._flat_observation:
            size = sum(int(np.prod(part.shape)) for part in spec.values())
            key = control.FLAT_OBSERVATION_KEY
            return OrderedDict({key: specs.Array((size,), float, name=key)})
        return spec

    @property
    def step_limit(self) -> int:
        """Steps in an episode."""
        return int(self._step_limit)

    @property
    def over(self) -> bool:
        """Whether no episode is under way, so that the next step starts one."""
        return self._reset_next_step

    def get_state(self) -> EnvironmentState:
        """Save the environment: bodies, the caregiver's script, clock and random streams.

        Returns:
            All that the future depends on. Nothing that happens later changes it, and it can be pickled. Model
            parameters that were changed by hand are not in it.
        """
        return EnvironmentState(self._task.built, self._step_count, self._reset_next_step, self._task.get_state())

    def set_state(self, state: EnvironmentState) -> None:
        """Go back to a saved state. The same actions then bring the same observations and rewards.

        Args:
            state: What ``get_state`` gave, of this environment or of one with the same task, world, people, variation
                and table. Images, ground truth and time limit may differ. It can be used any number of times.

        Raises:
            StateError: ``state`` is no such state, or belongs to an environment that was built otherwise.
        """
        if not isinstance(state, EnvironmentState):
            raise StateError(f"expected what get_state of an environment gives; got {type(state).__name__}")
        if state.built != self._task.built:
            raise StateError(
                f"the state is one of {state.built[0]}, this environment is {self._task.built[0]}, and both must be "
                "built with the same task, world, people, variation and table; load this one as the other was"
            )
        self._task.set_state(state.task)
        self._step_count, self._reset_next_step = state.steps, state.over
        self._switch_to(self._task.world.physics, self._physics.legacy_step)

    def _switch_to(self, physics: Physics, legacy_step: bool) -> None:
        self._physics = physics
        self._physics.legacy_step = legacy_step

    def __getstate__(self) -> dict[str, Any]:
        """The physics is pickled with the task, to whose worlds it belongs."""
        return {**vars(self), "_physics": self._physics.legacy_step}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._switch_to(self._task.world.physics, state["_physics"])

    def close(self) -> None:
        """Free models, data and rendering contexts."""
        if not self.closed:
            self._task.close()
            super().close()
            self._shut()
