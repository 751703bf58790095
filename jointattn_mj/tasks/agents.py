"""Agents for the tasks: baselines, and the robots of chapters 5 and 6."""

from collections.abc import Callable
from typing import Any

import numpy as np
from dm_env import TimeStep

from jointattn_mj.development.agent import Developer, DeveloperConfig
from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.agent import GazeFollower
from jointattn_mj.gaze_following.presets import PRESETS
from jointattn_mj.io.weights import read_weights
from jointattn_mj.perception.pixels import PixelConfig, PixelPerception
from jointattn_mj.scene.model import assets_folder
from jointattn_mj.tasks.environment import Environment
from jointattn_mj.tasks.turn_taking import TurnTaking


class Zero:
    """Always takes the action 0, or the one nearest to it within the bounds."""

    def __init__(self, environment: Environment, seed: int):
        spec = environment.action_spec()
        self._action = np.clip(np.zeros(spec.shape, spec.dtype), spec.minimum, spec.maximum)

    def act(self, timestep: TimeStep) -> Any:
        """Return the same action at every step."""
        return self._action


class Random:
    """Draws actions uniformly within the bounds."""

    def __init__(self, environment: Environment, seed: int):
        self._spec, self._rng = environment.action_spec(), np.random.default_rng(seed)

    def act(self, timestep: TimeStep) -> Any:
        """Return a uniformly random action."""
        low, high = self._spec.minimum, self._spec.maximum
        if np.issubdtype(self._spec.dtype, np.integer):
            return self._rng.integers(low, high, endpoint=True)
        return self._rng.uniform(low, high)


class Oracle:
    """Knows all of the world, and takes the task's best action."""

    def __init__(self, environment: Environment, seed: int):
        self._environment = environment

    def act(self, timestep: TimeStep) -> Any:
        """Return the task's ``best_action``."""
        return self._environment.task.best_action(self._environment.physics)


class TrainedGazeFollower:
    """The robot of chapter 6 after one session of 26 minutes; it goes on learning.

    Attributes:
        robot: The agent of the session. Each episode has a new one with what the last one had learned.
    """

    def __init__(self, environment: Environment, seed: int, preset: str = "thesis"):
        """Make the agent.

        Args:
            environment: The task.
            seed: Draws all of its random numbers.
            preset: Name of the robot, one of ``PRESETS``.

        Raises:
            ConfigError: The task does not give the observations that it needs.
        """
        if not {"camera", "head_moves"} <= environment.observation_spec().keys():
            raise ConfigError(
                "gaze_follower needs 30 images a second; object_transfer and object_transfer_hard give them"
            )
        self._environment, self._seeds = environment, np.random.SeedSequence(seed)
        self._config = PRESETS[preset]
        self._weights = read_weights(assets_folder() / "trained" / TRAINED[preset])
        self.robot: GazeFollower | None = None

    def act(self, timestep: TimeStep) -> Any:
        """Perceive, attend, and return the desired pan and tilt, (2,), rad."""
        if self.robot is None or timestep.first():
            self._weights = self._weights if self.robot is None else self.robot.weights()
            self.robot = self._new()
        return self.robot.act(timestep.observation)

    def _new(self) -> GazeFollower:
        objects = self._environment.task.world.config.scene.objects
        rgb = np.array([item.rgb for item in objects])
        perceiver = PixelPerception(PixelConfig(), rgb, face_at=self._config.face_at)
        robot = GazeFollower(self._config, perceiver, len(objects), self._seeds.spawn(1)[0])
        robot.load(self._weights)
        return robot


class RunningDeveloper:
    """The developing agent of chapter 5, which is given the ground truth and develops across episodes.

    It takes the first step of an episode for the result of the last step of the episode before.

    Attributes:
        agent: The agent, with the modules that it has made.
    """

    def __init__(self, environment: Environment, seed: int):
        """Make the agent; ``seed`` draws all of its random numbers.

        Raises:
            ConfigError: The task does not give the observations that it needs.
        """
        task = environment.task
        if not isinstance(task, TurnTaking) or "sensors" not in environment.observation_spec():
            raise ConfigError("developer needs the table's variables; play turn_taking(_hard) with truth=True")
        self.agent = Developer(task.variables, DeveloperConfig(), np.random.SeedSequence(seed))

    def act(self, timestep: TimeStep) -> Any:
        """Learn from the results of the last step, and return gaze and gesture, (2,) int."""
        return self.agent.act(timestep.observation["sensors"], timestep.observation["results"])


TRAINED = {"thesis": "robin.npz", "cross_situational": "robin_cross_situational.npz"}
"""Files with what a robot knew after its session, by the name of its preset."""
AGENTS: dict[str, Callable[[Environment, int], Any]] = {
    "zero": Zero,
    "random": Random,
    "oracle": Oracle,
    "gaze_follower": TrainedGazeFollower,
    "developer": RunningDeveloper,
}
"""Names of agents, and what makes each from an environment and a seed."""
