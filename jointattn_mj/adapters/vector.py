"""Many worlds of ``follow`` in one process: ``gymnasium.make_vec("jointattn_mj:Follow-v0", num_envs=16)``.

All that moves there are the caregiver, by a script, and the robot's head, by servos; neither needs a simulator. Scripts
advance one by one, heads and rewards are worked out for all worlds at once. One renderer for each caregiver draws the
images, in the pose of one world after another. Observations and rewards are those of single environments with the same
seeds, to rounding.
"""

from typing import Annotated, Any

import numpy as np
from dm_env import specs

from jointattn_mj.adapters.gymnasium import JointAttentionEnv, whole_seed
from jointattn_mj.errors import ClosedError, ConfigError, EpisodeError
from jointattn_mj.options import Whole, check_argument, shown
from jointattn_mj.scene.camera import PIVOT
from jointattn_mj.scene.caregiver import TransferScript
from jointattn_mj.scene.servo import Servos, turn
from jointattn_mj.scene.world import steps_per_frame
from jointattn_mj.tasks.actions import checked
from jointattn_mj.tasks.follow import Follow

from gymnasium.vector import AutoresetMode, VectorEnv  # isort: skip  # Gymnasium is known to be there by now
from gymnasium.vector.utils import batch_space  # isort: skip


class FollowVector(VectorEnv[dict[str, np.ndarray], np.ndarray, np.ndarray]):
    """Worlds of ``follow`` or ``follow_hard`` with Gymnasium's interface for vectors.

    Spaces, arguments and episodes are those of the single environment; arrays have the worlds as their first axis. A
    world whose episode has ended begins the next one at the next step, which ignores its action.
    """

    metadata: dict[str, Any] = {"autoreset_mode": AutoresetMode.NEXT_STEP, "render_modes": []}  # noqa: RUF012

    def __init__(self, task: str, num_envs: int = 1, render_mode: None = None, **task_kwargs: Any):
        """Make the worlds.

        Args:
            task: "follow" or "follow_hard".
            num_envs: Number of worlds.
            render_mode: None: these worlds have no ``render``.
            task_kwargs: Arguments of the task, such as ``camera``, ``truth``, ``face_patch``, ``people``.

        Raises:
            ConfigError: There is no such argument, ``num_envs`` is no number of worlds, or ``variation`` or
                ``render_mode`` is asked for, which takes a renderer a world.
        """
        if render_mode is not None:
            raise _needs_renderers("render_mode")
        check_argument("num_envs", num_envs, Annotated[int, Whole("[1, 1e6]")])
        self._single = JointAttentionEnv(task, **task_kwargs)
        environment = self._single.environment
        if environment.task.varies:
            self._single.close()
            raise _needs_renderers("variation")
        self.num_envs = num_envs
        self.single_observation_space = self._single.observation_space
        self.single_action_space = self._single.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._episodes = [_Episodes(environment.task.twin()) for _ in range(num_envs)]
        self._rewards, self._limit = environment.task.rewards, environment.step_limit
        self._bounds = environment.action_spec()
        self._scaled = specs.BoundedArray((num_envs, 2), np.float32, -1, 1, f"{self._bounds.name}, of each world")
        world = environment.task.world
        self._servos, self._turns = Servos.of_model(world.model), world.frames * steps_per_frame(world.model)
        self._angles, self._speeds = np.zeros((2, num_envs, 2))  # of the heads, rad and rad/s
        self._points = np.zeros((num_envs, len(world.candidate_points()), 3))  # that stay in an episode
        self._steps = np.full(num_envs, -1)  # in this episode; -1: there is none

    def __repr__(self) -> str:
        """In one line: ``FollowVector(4 worlds)``."""
        return f"{type(self).__name__}({'closed' if self.closed else f'{self.num_envs} worlds'})"

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Start an episode in each world.

        Args:
            seed: Of the first world, the others have the next ones; or one for each; None: everybody's next episode.
            options: None, since there are none.

        Returns:
            Observations, and an empty dictionary.

        Raises:
            ConfigError: ``seed`` is no whole number of 0 or more, nor one for each world, or there are ``options``.
            ClosedError: After ``close``.
        """
        self._check_open()
        if options:
            raise ConfigError(f"reset takes no options; got {shown(options)}")
        seeds: list[int | None]
        if seed is None:
            seeds = [None] * self.num_envs
        elif isinstance(seed, (list, tuple)) or (isinstance(seed, np.ndarray) and seed.ndim):
            seeds = list(seed)
        else:
            seeds = [whole_seed(seed) + i for i in range(self.num_envs)]
        if len(seeds) != self.num_envs:
            raise ConfigError(f"`seed` must be one number or {self.num_envs}, one for each world; got {len(seeds)}")
        for episodes, own in zip(self._episodes, seeds, strict=True):
            if own is not None:
                episodes.task.seed(whole_seed(own))
        self._begin(np.arange(self.num_envs))
        return self._observe(), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Take a step in each world.

        Args:
            actions: (num_envs, 2), scaled: -1 and 1 stand for the bounds, to which what is beyond is clipped.

        Returns:
            Observations; rewards (num_envs,); terminated (never) and truncated (when time is up), (num_envs,) bool; an
            empty dictionary.

        Raises:
            ActionError: Actions are not finite, have another shape, or are no numbers; nothing has changed then.
            EpisodeError: Before ``reset``.
            ClosedError: After ``close``.
        """
        self._check_open()
        low, high = self._bounds.minimum, self._bounds.maximum
        commands = low + (high - low) * (checked(actions, self._scaled) + 1) / 2
        if (self._steps < 0).any():
            raise EpisodeError("no episode is going on: call reset()")
        over = self._steps == self._limit
        going = ~over
        turn(self._servos, self._angles, self._speeds, commands, self._turns)
        for world in np.flatnonzero(going):
            self._episodes[world].advance()
        self._steps += going
        self._begin(np.flatnonzero(over))
        rewards = np.where(going, self._earned(), 0.0)
        return self._observe(), rewards, np.zeros(self.num_envs, bool), self._steps == self._limit, {}

    def close_extras(self, **settings: Any) -> None:
        """Free models, data and rendering contexts."""
        self._single.close()
        for episodes in self._episodes:  # of a copy, each of which has worlds of its own
            episodes.task.close()

    def _check_open(self) -> None:
        if self.closed:
            raise ClosedError(f"this {type(self).__name__} is closed; make another")

    def _begin(self, worlds: np.ndarray) -> None:
        """Begin the next episode in some worlds, with the head straight ahead."""
        for world in worlds:
            self._episodes[world].begin()
            self._points[world] = self._episodes[world].points() - PIVOT
        self._angles[worlds] = self._speeds[worlds] = self._steps[worlds] = 0

    def _earned(self) -> np.ndarray:
        """Rewards (num_envs,) now."""
        targets = [-1 if episode.script.target is None else episode.script.target for episode in self._episodes]
        pan, tilt = self._angles.T
        ahead = np.stack([np.cos(tilt) * np.cos(pan), np.cos(tilt) * np.sin(pan), np.sin(tilt)], axis=1)
        across = np.linalg.norm(np.cross(self._points, ahead[:, None]), axis=2)
        angles = np.arctan2(across, np.einsum("ijk,ik->ij", self._points, ahead))
        return np.where(np.array(targets) >= 0, self._rewards(angles, np.array(targets)), 0.0)

    def _observe(self) -> dict[str, np.ndarray]:
        """Observations of all worlds: new arrays."""
        spaces: dict[str, Any] = self.observation_space.spaces  # type: ignore[attr-defined]
        if spaces.keys() <= {"head_angles", "truth"}:
            observed = {"head_angles": self._angles.copy(), "truth": self._gazes()}
            return {name: observed[name] for name in spaces}
        observed = {name: np.empty(space.shape, space.dtype) for name, space in spaces.items()}
        for world, (episode, head) in enumerate(zip(self._episodes, self._angles, strict=True)):
            for name, value in episode.observe(head).items():
                observed[name][world] = value  # before the next image is drawn: memory that is near
        return observed

    def _gazes(self) -> np.ndarray:
        """Yaw and pitch of the caregivers' heads, (num_envs, 2), rad."""
        return np.stack([episode.script.joints[:2] for episode in self._episodes])


def _needs_renderers(argument: str) -> ConfigError:
    return ConfigError(
        f"`{argument}` needs a renderer for each world: make them with vectorization_mode='sync' or 'async'"
    )


class _Episodes:
    """The episodes of one world: a task with seeds of its own, in bodies that it shares with others."""

    script: TransferScript

    def __init__(self, task: Follow):
        self.task = task

    def begin(self) -> None:
        """Begin the next one."""
        _, self.script = self.task.cast_script()

    def advance(self) -> None:
        """Advance the caregiver by a step."""
        for _ in range(self.task.world.frames):
            self.script.advance()

    def points(self) -> np.ndarray:
        """Centres of the n objects, which stay, and of the caregiver's head, (n + 1, 3), world frame, metres."""
        return np.vstack([self.script.objects, self.task.world.candidate_points()[-1:]])

    def observe(self, head: np.ndarray) -> dict[str, np.ndarray]:
        """What the robot observes with its head at (2,), rad."""
        self.task.world.show(head, self.script)
        return self.task.observe_anew()
