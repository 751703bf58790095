"""An agent in a task, step by step in real time, as whoever shows it needs it."""

import time
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from dm_env import TimeStep

from jointattn_mj.gaze_following.agent import GazeFollower
from jointattn_mj.scene.world import World
from jointattn_mj.tasks.environment import Environment
from jointattn_mj.video.onlooker import Sight, sights
from jointattn_mj.video.paint import GREEN, PERSON, ROBOT, Colour
from jointattn_mj.viewing.eye import EyeView


class Agent(Protocol):
    """Whoever acts in an environment of the suite."""

    def act(self, timestep: TimeStep) -> Any:
        """The action that answers a time step."""


class Show:
    """Lives through one episode after the other.

    Attributes:
        reward: Sum of rewards in this episode.
        episode: Number of the episode, from 1 on.
    """

    def __init__(self, environment: Environment, agent: Agent):
        self._environment, self._agent = environment, agent
        self._eye: tuple[World, EyeView] | None = None
        self.seconds_a_step: float = environment.control_timestep()
        self.episode, self.reward = 0, 0.0
        self.restart()

    @property
    def world(self) -> World:
        """The world of this episode; another episode may have another."""
        return self._environment.task.world

    @property
    def mind(self) -> GazeFollower | None:
        """The robot's mind, if the agent has one that perceives images."""
        mind = getattr(self._agent, "robot", None)
        return mind if isinstance(mind, GazeFollower) else None

    def restart(self) -> None:
        """Begin another episode."""
        self.episode, self.reward, self._step = self.episode + 1, 0.0, 0
        self._answer(self._environment.reset())

    def advance(self) -> None:
        """One step; after the last one of an episode the next begins."""
        timestep = self._environment.step(self._action)
        if timestep.last():
            self.restart()
            return
        self.reward += timestep.reward or 0.0
        self._step += 1
        self._answer(timestep)

    def _answer(self, timestep: TimeStep) -> None:
        """Let the agent perceive and decide; nothing moves before the next step, and what it perceived can be shown."""
        self._action = self._agent.act(timestep)

    def eye(self) -> np.ndarray:
        """The robot's view with overlays, uint8 (480, 640, 3); it holds until the next one."""
        if self._eye is None or self._eye[0] is not self.world:
            self._eye = self.world, EyeView(self.world)
        return self._eye[1].draw(self.world, self.mind)

    def sights(self) -> list[tuple[Sight, Colour]]:
        """The robot's line of sight and the person's; green while both end at the same object."""
        robot, person = sights(self.world)
        together = robot.hit == person.hit and robot.hit in range(len(self.world.caregiver.objects))
        return [(robot, GREEN if together else ROBOT), (person, GREEN if together else PERSON)]

    def words(self) -> str:
        """How far it is."""
        seconds = self._step * self.seconds_a_step
        return f"episode {self.episode}, {seconds:.1f} s, reward {self.reward:.1f}"


def in_real_time(show: Show, draw: Callable[[], None], goes_on: Callable[[], bool], paused: Callable[[], bool]) -> None:
    """Advance and draw as fast as time goes, or as fast as this machine can, until ``goes_on`` says no."""
    due = time.perf_counter()
    while goes_on():
        if paused():
            time.sleep(0.05)
            due = time.perf_counter()
            continue
        show.advance()
        draw()
        due = max(due + show.seconds_a_step, time.perf_counter() - show.seconds_a_step)
        time.sleep(max(0.0, due - time.perf_counter()))
