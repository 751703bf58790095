"""An agent in a task, step by step in real time, for a window or a browser to draw."""

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
    """Acts in an environment of the suite."""

    def act(self, timestep: TimeStep) -> Any:
        """The action for a time step."""


class Show:
    """An agent that acts in one episode after the other.

    Attributes:
        episode: Number of the episode, from 1 on.
        reward: Sum of rewards in this episode.
        seconds_a_step: How long a step of the task lasts.
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
        world: World = self._environment.task.world
        return world

    @property
    def robot(self) -> GazeFollower | None:
        """The robot of chapter 6, if that is the agent."""
        robot = getattr(self._agent, "robot", None)
        return robot if isinstance(robot, GazeFollower) else None

    def restart(self) -> None:
        """Start the next episode."""
        self.episode, self.reward, self._step = self.episode + 1, 0.0, 0
        self._answer(self._environment.reset())

    def advance(self) -> None:
        """Take one step; after the last of an episode, start the next."""
        timestep = self._environment.step(self._action)
        if timestep.last():
            self.restart()
            return
        self.reward += timestep.reward or 0.0
        self._step += 1
        self._answer(timestep)

    def _answer(self, timestep: TimeStep) -> None:
        """Let the agent decide about the next step, so that its percepts can be drawn before that."""
        self._action = self._agent.act(timestep)

    def eye(self) -> np.ndarray:
        """The robot's view with overlays, uint8 (480, 640, 3) RGB; it holds until the next call."""
        if self._eye is None or self._eye[0] is not self.world:
            self._eye = self.world, EyeView(self.world)
        return self._eye[1].draw(self.world, self.robot)

    def sights(self) -> list[tuple[Sight, Colour]]:
        """Lines of sight of robot and caregiver, and their colours: green while both end at the same object."""
        robot, person = sights(self.world)
        together = robot.hit == person.hit and robot.hit in range(len(self.world.caregiver.objects))
        return [(robot, GREEN if together else ROBOT), (person, GREEN if together else PERSON)]

    def words(self) -> str:
        """The line of text below the robot's view: episode, time and reward."""
        seconds = self._step * self.seconds_a_step
        return f"episode {self.episode}, {seconds:.1f} s, reward {self.reward:.1f}"


def in_real_time(show: Show, draw: Callable[[], None], goes_on: Callable[[], bool], paused: Callable[[], bool]) -> None:
    """Advance and draw in real time, or as fast as this machine can.

    Args:
        show: What is shown.
        draw: Called after each step.
        goes_on: Asked before each step; False ends the show.
        paused: Asked before each step; while True nothing advances.
    """
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
