"""What all tasks share: episodes with a seed each, people who take turns, images, and the interface of dm_control."""

from abc import abstractmethod
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from dm_control.mujoco.wrapper import MjModel
from dm_control.rl import control
from dm_env import specs

from jointattn_mj.errors import ConfigError, StateError
from jointattn_mj.guards.closing import Closable
from jointattn_mj.scene import snapshot
from jointattn_mj.scene.caregiver import FRAME_S
from jointattn_mj.scene.dressing import Conditions
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH, build_model
from jointattn_mj.scene.people import FaceConfig
from jointattn_mj.scene.variation import VariationConfig, drawn, variation_of
from jointattn_mj.scene.world import World, WorldConfig
from jointattn_mj.tasks.actions import checked
from jointattn_mj.tasks.arguments import require, unknown
from jointattn_mj.tasks.physics import Physics
from jointattn_mj.tasks.state import EnvironmentState

LOWEST = np.radians([-45.0, -35.0])
HIGHEST = np.radians([45.0, 15.0])
"""Bounds of the head's (pan, tilt), rad: wherever objects lie, and her face, with room to spare."""
LENSES = ("robot/lens_left", "robot/lens_right")
LENS_RGBA, LENS_LIT = (0.55, 0.80, 0.88, 1.0), (0.25, 0.95, 0.35, 1.0)
"""The robot's eyes, seen from outside: as in assets/robot.xml, and while reward is given (``visualize_reward``)."""

PEOPLE = 2**31
"""Child of an episode's seed that draws who sits there; the first children belong to the world."""

Random = np.random.RandomState | int | None

_SETTINGS = ("flat_observation", "legacy_step")
"""Of ``control.Environment``, beside the time limit and the control timestep."""


class JointAttentionTask(control.Task):
    """An episode with the caregiver, whose k-th seed is the k-th child of the task's.

    Attributes:
        world: Body and script of the episode; there from the first on.
        visualize_reward: Whether the robot's eyes light up while reward is given.
    """

    kind: ClassVar[type[World]] = World
    """What the world does by itself."""
    world: World

    def __init__(
        self, config: WorldConfig, random: Random = None, camera: bool = True, truth: bool = False,
        people: Sequence[str] = (), variation: VariationConfig | str = "none",
    ):  # fmt: skip
        """``people``: names of caregivers of whom each episode has one; nobody: the one of ``config``.

        ``variation``: how far every episode's world may differ from ``config``, as ranges or by the name of a preset.
        """
        require("world", config, WorldConfig)
        require("camera", camera, bool)
        require("truth", truth, bool)
        require("people", people, tuple, list)
        require("variation", variation, VariationConfig, str)
        self._configs = [replace(config, scene=replace(config.scene, caregiver=name, face=None)) for name in people]
        self._configs = self._configs or [config]
        self._variation = variation_of(variation)
        self._worlds: dict[tuple[str, FaceConfig | None], World] = {}
        self._camera, self._truth = camera, truth
        self.visualize_reward = False
        self._action_spec = self.actions()
        self.seed(random)

    def seed(self, random: Random) -> None:
        """Begin anew with the episodes of another seed, or of one that a state draws; None draws one.

        Raises:
            ConfigError: No whole number of 0 or more, no state, and not None.
        """
        entropy = random.randint(2**31, size=4).tolist() if isinstance(random, np.random.RandomState) else random
        try:
            self._seeds = np.random.SeedSequence(entropy)
        except (TypeError, ValueError) as error:
            raise ConfigError(
                f"random: expected a whole number of 0 or more as seed, or None; got {random!r}"
            ) from error
        self.random = np.random.RandomState(np.random.MT19937(self._seeds))
        """For wrappers of dm_control, which take their noise from it; no task does."""

    def cast(self) -> World:
        """The world of the next episode, as its seed has it: one of the people, and what else varies."""
        casting = np.random.default_rng(self._next_seed(PEOPLE))
        chosen = self._configs[int(casting.integers(len(self._configs)))]
        self._drawn = drawn(chosen, self._variation, self._next_seed())
        self.world = self._world_of(*self._drawn)
        return self.world

    def _world_of(self, config: WorldConfig, conditions: Conditions) -> World:
        """The one in which that person sits; compiled when it is first needed."""
        who = config.scene.caregiver, config.scene.face
        if who not in self._worlds:
            physics = Physics.from_model(MjModel(build_model(config.scene, blank=self._variation.textures > 0)))
            physics.scripted = True
            self._worlds[who] = self.kind(config, physics, np.random.SeedSequence(0), conditions)
        return self._worlds[who]

    def _next_seed(self, *child: int) -> np.random.SeedSequence:
        """The seed that ``initialize_episode`` will spawn, or a child of it."""
        seeds = self._seeds
        return np.random.SeedSequence(seeds.entropy, spawn_key=(*seeds.spawn_key, seeds.n_children_spawned, *child))

    def initialize_episode(self, physics: Physics) -> None:
        """Another table, and everything that the episode's seed decides."""
        (seed,) = self._seeds.spawn(1)
        self.world.vary(*self._drawn)
        self.world.reset(seed)
        self.begin(seed)
        self.after_step(physics)

    def begin(self, seed: np.random.SeedSequence) -> None:
        """What else an episode begins with."""

    def before_step(self, action: Any, physics: Physics) -> None:
        """Take up an action for the step to come; numbers beyond the bounds of ``action_spec`` are clipped to them.

        Raises:
            ActionError: Not finite, of another shape, or no numbers; nothing has changed then.
        """
        self.act(checked(action, self._action_spec))

    def act(self, action: np.ndarray) -> None:
        """The caregiver's script for this step; ``action`` (2,) is the desired pan and tilt, rad."""
        self.world.before_step(action)

    def after_step(self, physics: Physics) -> None:
        """Light the robot's eyes, where that was asked for."""
        if self.visualize_reward:
            lit = self.get_reward(physics) > 0
            for geom in LENSES:
                physics.named.model.geom_rgba[geom] = LENS_LIT if lit else LENS_RGBA

    def action_spec(self, physics: Physics) -> specs.BoundedArray:
        """What an action is; see ``actions``."""
        return self._action_spec

    def actions(self) -> specs.BoundedArray:
        """Desired pan and tilt of the head, (2,), rad; pan positive to the robot's left, tilt upwards."""
        return specs.BoundedArray((2,), float, LOWEST, HIGHEST, name="desired pan\tdesired tilt")

    def observation_spec(self, physics: Physics) -> OrderedDict[str, specs.Array]:
        """What ``get_observation`` returns."""
        spec: OrderedDict[str, specs.Array] = OrderedDict()
        if self._camera:
            spec["camera"] = specs.BoundedArray((IMAGE_HEIGHT, IMAGE_WIDTH, 3), np.uint8, 0, 255, name="camera")
        spec["head_angles"] = specs.BoundedArray((2,), float, -np.pi, np.pi, name="head_angles")
        return spec | (self.truth_spec() if self._truth else {})

    def get_observation(self, physics: Physics) -> OrderedDict[str, np.ndarray]:
        """The image and the head's pan and tilt (rad), where asked for the truth; arrays of the caller's own."""
        observation: OrderedDict[str, np.ndarray] = OrderedDict()
        if self._camera:
            observation["camera"] = self.world.image().copy()
        observation["head_angles"] = self.world.head_angles()
        return observation | (self.truth() if self._truth else {})

    def truth_spec(self) -> dict[str, specs.Array]:
        """What ``truth`` returns."""
        return {"truth": specs.BoundedArray((2,), float, -np.pi, np.pi, name="truth")}

    def truth(self) -> dict[str, np.ndarray]:
        """What perfect perception would make of the image: yaw and pitch of the caregiver's head, (2,), rad."""
        return {"truth": self.world.face_angles().copy()}

    @abstractmethod
    def best_action(self, physics: Physics) -> np.ndarray:
        """What somebody does who knows everything."""

    @property
    def built(self) -> tuple[Any, ...]:
        """All that a task was built with and its future depends on; states go from one to another where it is equal."""
        return type(self).__qualname__, tuple(self._configs), self._variation

    def get_state(self) -> dict[str, Any]:
        """Bodies, script and random streams, as plain data."""
        seeds, random = self._seeds.state, snapshot.take(self.random)
        return {"seeds": seeds, "random": random, "world": self.world.get_state()}

    def set_state(self, state: dict[str, Any]) -> None:
        """Go back to a state of this task, or of one that is ``built`` alike."""
        self._seeds = np.random.SeedSequence(**state["seeds"])
        snapshot.put(self.random, state["random"])
        self._take_up(state["world"])

    def _take_up(self, state: dict[str, Any]) -> None:
        """Let that be the world."""
        self.world = self._world_of(state["config"], state["conditions"])
        self.world.set_state(state)
        self.after_step(self.world.physics)

    def __getstate__(self) -> dict[str, Any]:
        """A copy has a world of its own, and compiles those of other people when it needs them."""
        return {**vars(self), "_worlds": {}, "world": self.world.get_state()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._take_up(state["world"])

    def close(self) -> None:
        """Free all models, data and rendering contexts."""
        for world in self._worlds.values():
            world.close()


class Environment(Closable, control.Environment):
    """dm_control's environment, in which every episode may have a physics of its own.

    Copies (``copy.deepcopy``, ``pickle``) go on as the original does. What has been closed raises ``ClosedError``.
    """

    _task: JointAttentionTask
    _physics: Physics

    def __init__(self, task: JointAttentionTask, time_limit: float, **settings: Any):
        """``settings``: those of ``control.Environment``.

        Raises:
            ConfigError: The control timestep was to be changed, the time is none, or there is no such setting.
        """
        kind = task.kind
        if {"control_timestep", "n_sub_steps"} & settings.keys():
            raise ConfigError(f"the control timestep of this task is {kind.frames}/30 s; leave it out")
        for name in settings.keys() - _SETTINGS:
            raise unknown("argument of an environment", name, ("time_limit", *_SETTINGS))
        if not isinstance(time_limit, (int, float)) or not time_limit > 0:
            raise ConfigError(f"time_limit must be a positive number of seconds; got {time_limit!r}")
        control_timestep = kind.frames * FRAME_S
        super().__init__(
            task.cast().physics, task, time_limit=time_limit, control_timestep=control_timestep, **settings
        )  # fmt: skip
        self._step_limit = np.ceil(time_limit / control_timestep - 1e-6)  # 3 s of 0.1 s are 30 steps, not 31

    def reset(self) -> Any:
        """Begin an episode with one of the people."""
        self._switch_to(self._task.cast().physics, self._physics.legacy_step)
        return super().reset()

    def observation_spec(self) -> OrderedDict[str, specs.Array]:
        """The task's, or one array if observations are flattened."""
        spec = super().observation_spec()
        if self._flat_observation:
            size = sum(int(np.prod(part.shape)) for part in spec.values())
            key = control.FLAT_OBSERVATION_KEY
            return OrderedDict({key: specs.Array((size,), float, name=key)})
        return spec

    @property
    def over(self) -> bool:
        """Whether no episode is going on, and the next step begins one."""
        return self._reset_next_step

    def get_state(self) -> EnvironmentState:
        """Bodies, the caregiver's script, clock and random streams: all that the future depends on.

        Nothing that happens later changes what is returned; it can be pickled. Model parameters that were changed by
        hand are not in it.
        """
        return EnvironmentState(self._task.built, self._step_count, self._reset_next_step, self._task.get_state())

    def set_state(self, state: EnvironmentState) -> None:
        """Go back to ``state``, of this environment or of one that was built alike; it can be used again.

        From there on the same actions bring the same observations and rewards, those of later episodes included.
        Environments with and without images or truth, and with other time limits, are alike.

        Raises:
            StateError: ``state`` is none, or of an environment of another task, world, people, variation or table.
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
        """Body and script stay together: the physics is the task's."""
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
