"""The suite's tasks as Gymnasium environments: ``gymnasium.make("jointattn_mj:Follow-v0", truth=True)``."""

from typing import Any

import numpy as np
from dm_control.mujoco.wrapper import MjvOption
from dm_env import TimeStep, specs

from jointattn_mj.errors import ConfigError, EpisodeError
from jointattn_mj.io.extras import extra
from jointattn_mj.options import shown
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH, ROBOT_GROUP
from jointattn_mj.tasks import load
from jointattn_mj.tasks.actions import checked
from jointattn_mj.tasks.arguments import unknown
from jointattn_mj.tasks.state import EnvironmentState

extra("gym", "gymnasium")
import gymnasium  # noqa: E402
from gymnasium import spaces  # noqa: E402

DOMAIN = "joint_attention"


class JointAttentionEnv(gymnasium.Env[dict[str, Any], np.ndarray]):
    """A task of the suite with Gymnasium's interface.

    Observations are a ``Dict`` with the task's keys. Angles, as actions, are scaled: -1 and 1 stand for the task's
    bounds; choices are ``MultiDiscrete``. Episodes end by truncation at the time limit. ``render`` shows the scene from
    the side.

    Attributes:
        environment: The dm_control environment behind it; its ``physics`` answers who looks where.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012

    def __init__(self, task: str, render_mode: str | None = None, **task_kwargs: Any):
        """Make an environment.

        Args:
            task: Name of a task: "object_transfer", "follow", "turn_taking", or one of these with "_hard".
            render_mode: "rgb_array", or None not to render.
            task_kwargs: Arguments of the task, such as ``camera``, ``truth``, ``people``, ``time_limit``, ``random``.

        Raises:
            ConfigError: There is no such task, render mode or argument.
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise unknown("render_mode", render_mode, self.metadata["render_modes"])
        self.environment = load(DOMAIN, task, task_kwargs=task_kwargs)
        fps = max(1, round(1 / self.environment.control_timestep()))
        self.metadata = {**self.metadata, "render_fps": fps}
        self.render_mode = render_mode
        self._bounds = self.environment.action_spec()
        self._scaled = specs.BoundedArray(self._bounds.shape, np.float32, -1, 1, self._bounds.name)
        self._chooses = np.issubdtype(self._bounds.dtype, np.integer)
        self.action_space = (
            _space(self._bounds) if self._chooses else spaces.Box(-1.0, 1.0, self._bounds.shape, np.float32)
        )
        self.observation_space = spaces.Dict(
            {name: _space(spec) for name, spec in self.environment.observation_spec().items()}
        )

    def __repr__(self) -> str:
        """Around that of ``environment``: ``JointAttentionEnv(Environment(Follow, step 3 of 30))``."""
        return f"{type(self).__name__}({self.environment!r})"

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[dict[str, Any], dict]:
        """Start an episode.

        Args:
            seed: Start with the first episode of this seed; None: the next episode.
            options: None, since there are none.

        Returns:
            The observation, and an empty dictionary.

        Raises:
            ConfigError: ``seed`` is no whole number of 0 or more, or there are ``options``.
        """
        if options:
            raise ConfigError(f"reset takes no options; got {shown(options)}")
        if seed is not None:
            seed = whole_seed(seed)
        super().reset(seed=seed)
        if seed is not None:
            self.environment.task.seed(seed)
        return self._observed(self.environment.reset()), {}

    def step(self, action: np.ndarray) -> tuple[dict[str, Any], float, bool, bool, dict]:
        """Take a step.

        Args:
            action: (2,); angles beyond the bounds are clipped to them, choices are rounded to whole numbers.

        Returns:
            Observation, reward, terminated (never), truncated (when time is up), and an empty dictionary.

        Raises:
            ActionError: The action is not finite, has another shape, or is no numbers; nothing has changed then.
            EpisodeError: Before ``reset``, or after the end of an episode.
        """
        if self.environment.over:
            raise EpisodeError("no episode is going on: it has ended, or none has begun; call reset()")
        if not self._chooses:
            low, high = self._bounds.minimum, self._bounds.maximum
            action = low + (high - low) * (checked(action, self._scaled) + 1) / 2
        timestep = self.environment.step(action)
        terminated = timestep.last() and timestep.discount == 0
        return self._observed(timestep), float(timestep.reward), terminated, timestep.last() and not terminated, {}

    def render(self) -> np.ndarray | None:
        """Render robot and caregiver from the side: uint8 (240, 320, 3) RGB, or None without ``render_mode``."""
        if self.render_mode is None:
            return None
        option = MjvOption()
        option.geomgroup[ROBOT_GROUP] = 1
        image: np.ndarray = self.environment.physics.render(
            IMAGE_HEIGHT, IMAGE_WIDTH, camera_id="third_person", scene_option=option
        )
        return image

    def get_state(self) -> EnvironmentState:
        """Save the environment, as its dm_control form does; with wrappers, call ``env.unwrapped.get_state()``."""
        return self.environment.get_state()

    def set_state(self, state: EnvironmentState) -> None:
        """Go back to a saved state; what wrappers keep for themselves stays as it is."""
        self.environment.set_state(state)

    def close(self) -> None:
        """Free models, data and rendering contexts."""
        self.environment.close()

    def _observed(self, timestep: TimeStep) -> dict[str, Any]:
        """The observation, in which booleans become arrays (1,) of 0 or 1."""
        return {
            name: value if value.ndim else np.atleast_1d(value).astype(np.int8)
            for name, value in timestep.observation.items()
        }


def whole_seed(seed: Any) -> int:
    """A seed as ``int``; numpy's whole numbers are accepted too."""
    if isinstance(seed, (int, np.integer)) and not isinstance(seed, bool) and seed >= 0:
        return int(seed)
    raise ConfigError(f"seed: expected a whole number of 0 or more, or None; got {shown(seed)}")


def _space(spec: specs.Array) -> spaces.Space:
    if not isinstance(spec, specs.BoundedArray):
        return spaces.MultiBinary(max(1, int(np.prod(spec.shape))))
    low, high = (np.broadcast_to(bound, spec.shape) for bound in (spec.minimum, spec.maximum))
    if np.issubdtype(spec.dtype, np.signedinteger):
        return spaces.MultiDiscrete(high - low + 1, dtype=spec.dtype.type, start=low)
    return spaces.Box(low, high, spec.shape, spec.dtype.type)
