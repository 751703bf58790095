"""Episodes of a task played by an agent, and the returns that they give."""

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jointattn_mj.sweeps.statistics import Estimate, mean_interval
from jointattn_mj.tasks.environment import Environment


@dataclass(frozen=True)
class Episode:
    """The return of one episode."""

    episode: int
    """Its number, from 1 on."""
    steps: int
    reward_sum: float
    """The return, without discount."""
    reward_a_step: float
    """The same as a share of the most that there is, 1 a step."""


def play_episodes(
    environment: Environment,
    agent: Any,
    episodes: int,
    film: Path | None = None,
    progress: Callable[[], object] = lambda: None,
) -> list[Episode]:
    """Play episodes one after the other; the agent keeps what it learns.

    Args:
        environment: The task; it is left open.
        agent: Has ``act(timestep)``, which gives an action.
        episodes: Their number, at least 1.
        film: Where to leave a video of the first episode; None leaves none.
        progress: Called after each episode.

    Returns:
        An entry an episode.

    Raises:
        GLError, VideoError: Images or a video are asked for and cannot be made.
    """
    played = []
    for number in range(1, episodes + 1):
        with _film(environment, film) if film is not None and number == 1 else nullcontext() as watch:
            played.append(_episode(environment, agent, number, watch))
        progress()
    return played


def mean_return(episodes: list[Episode]) -> Estimate:
    """The mean return of episodes, with its interval."""
    return mean_interval([episode.reward_sum for episode in episodes])


def _film(environment: Environment, path: Path) -> Any:
    from jointattn_mj.viewing.film import TaskFilm

    return TaskFilm(path, environment.control_timestep())


def _episode(environment: Environment, agent: Any, number: int, film: Any) -> Episode:
    timestep, steps, total = environment.reset(), 0, 0.0
    while not timestep.last():
        action = agent.act(timestep)
        if film is not None:
            film.add(environment.task.world, getattr(agent, "robot", None))
        timestep = environment.step(action)
        steps += 1
        total += timestep.reward
    return Episode(number, steps, total, total / steps)
