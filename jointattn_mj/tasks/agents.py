"""Who can act in a task: baselines, and the robots of chapters 5 and 6."""

from collections.abc import Callable
from typing import Any

import numpy as np
from dm_env import TimeStep

from jointattn_mj.development.agent import Developer, DeveloperConfig
from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.agent import GazeFollower, RobotConfig
from jointattn_mj.io.weights import read_weights
from jointattn_mj.perception.pixels import PixelConfig, PixelPerception
from jointattn_mj.scene.model import assets_folder
from jointattn_mj.tasks.environment import Environment
from jointattn_mj.tasks.turn_taking import TurnTaking


class Zero:
    """Does nothing, or what is nearest to nothing."""

    def __init__(self, environment: Environment, seed: int):
        spec = environment.action_spec()
        self._action = np.clip(np.zeros(spec.shape, spec.dtype), spec.minimum, spec.maximum)

    def act(self, timestep: TimeStep) -> Any:
        """The same at every step."""
        return self._action


class Random:
    """Draws every action evenly from all that there are."""

    def __init__(self, environment: Environment, seed: int):
        self._spec, self._rng = environment.action_spec(), np.random.default_rng(seed)

    def act(self, timestep: TimeStep) -> Any:
        """Whatever is observed."""
        low, high = self._spec.minimum, self._spec.maximum
        if np.issubdtype(self._spec.dtype, np.integer):
            return self._rng.integers(low, high, endpoint=True)
        return self._rng.uniform(low, high)


class Oracle:
    """Knows everything, and does what the task holds best."""

    def __init__(self, environment: Environment, seed: int):
        self._environment = environment

    def act(self, timestep: TimeStep) -> Any:
        """What the task's ``best_action`` says."""
        return self._environment.task.best_action(self._environment.physics)


class TrainedGazeFollower:
    """The robot of chapter 6 after one session of 26 minutes, which goes on learning.

    Attributes:
        robot: Its mind. Every episode begins with a new one that knows what the last one had learned.
    """

    def __init__(self, environment: Environment, seed: int):
        """Raises ConfigError: The task does not give what it needs."""
        if not {"camera", "head_moves"} <= environment.observation_spec().keys():
            raise ConfigError(
                "gaze_follower needs 30 images a second; object_transfer and object_transfer_hard give them"
            )
        self._environment, self._seeds = environment, np.random.SeedSequence(seed)
        self._weights = read_weights(assets_folder() / "trained" / "robin.npz")
        self.robot: GazeFollower | None = None

    def act(self, timestep: TimeStep) -> Any:
        """Percept, attention, and a motor command."""
        if self.robot is None or timestep.first():
            self._weights = self._weights if self.robot is None else self.robot.weights()
            self.robot = self._new()
        return self.robot.act(timestep.observation)

    def _new(self) -> GazeFollower:
        objects = self._environment.task.world.config.scene.objects
        perceiver = PixelPerception(PixelConfig(), np.array([item.rgb for item in objects]))
        robot = GazeFollower(RobotConfig(), perceiver, len(objects), self._seeds.spawn(1)[0])
        robot.load(self._weights)
        return robot


class RunningDeveloper:
    """The mind of chapter 5, which develops as it goes on from episode to episode; it knows the truth of its variables.

    The first turn of an episode counts for it as what came of the last turn of the one before.

    Attributes:
        mind: With the modules that it has made.
    """

    def __init__(self, environment: Environment, seed: int):
        """Raises ConfigError: The task does not give what it needs."""
        task = environment.task
        if not isinstance(task, TurnTaking) or "sensors" not in environment.observation_spec():
            raise ConfigError("developer lives in turns: play turn_taking or turn_taking_hard, with truth=True")
        self.agent = Developer(task.variables, DeveloperConfig(), np.random.SeedSequence(seed))

    def act(self, timestep: TimeStep) -> Any:
        """Learn from what has come of the last turn, and choose gaze and gesture."""
        return self.agent.act(timestep.observation["sensors"], timestep.observation["results"])


AGENTS: dict[str, Callable[[Environment, int], Any]] = {
    "zero": Zero,
    "random": Random,
    "oracle": Oracle,
    "gaze_follower": TrainedGazeFollower,
    "developer": RunningDeveloper,
}
"""What makes each agent, from the environment and a seed."""
