"""``jointattn play``: what an agent earns in a task, episode by episode."""

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from jointattn_mj.errors import ConfigError
from jointattn_mj.io.files import free_name, held
from jointattn_mj.io.progress import Progress
from jointattn_mj.io.results import result_paths, write_results
from jointattn_mj.options import Checked, Choice, Real, Seed, Whole
from jointattn_mj.sweeps.statistics import Estimate, mean_interval
from jointattn_mj.tasks import TASKS_BY_DOMAIN, load
from jointattn_mj.tasks.agents import AGENTS
from jointattn_mj.tasks.environment import Environment

DOMAIN = "joint_attention"


@dataclass(frozen=True)
class PlayOptions(Checked):
    """Who plays what."""

    task: tyro.conf.Positional[Annotated[str, Choice(TASKS_BY_DOMAIN[DOMAIN])]]
    """Task of the suite."""
    agent: Literal["zero", "random", "oracle", "gaze_follower", "developer"]
    """zero and random know nothing, the oracle everything; gaze_follower is the robot of chapter 6 after one session
    (in object_transfer), developer the mind of chapter 5 (in turn_taking, told the truth of its variables)."""
    episodes: Annotated[int, Whole("[1, 1e6]")] = 10
    """How many are played."""
    seed: Seed = 0
    """All randomness comes from it."""
    time_limit: Annotated[float, Real("(0, 1e9]")] | None = None
    """Seconds in an episode; the task's own where not given."""
    out: Path | None = None
    """Folder for the results; made when missing."""
    video: bool = False
    """Also leave a video of the first episode there."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.video and self.out is None:
            raise ConfigError("--video needs a folder to leave the video in; name one with --out")


@dataclass(frozen=True)
class Episode:
    """What one episode brought."""

    episode: int
    """Its number, from 1 on."""
    steps: int
    reward_sum: float
    """The return, without discount."""
    reward_a_step: float
    """The same as a share of the most that there is, 1 a step."""


def play(options: PlayOptions) -> None:
    """Play, print a table, and leave results where asked for.

    Raises:
        ConfigError: No such task, or an agent that cannot live in it.
        OutputError: The folder holds results already, or cannot be written to.
        GLError, VideoError: Images or video were asked for and cannot be made.
    """
    environment = environment_for(options)
    agent = AGENTS[options.agent](environment, options.seed)
    with nullcontext() if options.out is None else held(options.out):
        paths = None if options.out is None else result_paths(options.out / "episodes", "episodes")
        with Progress("playing", options.episodes, "episodes") as shown:
            episodes = play_episodes(environment, agent, options, shown.add)
        environment.close()
        if paths is not None:
            rows = [vars(episode) for episode in episodes]
            write_results(paths, rows, options, mean_return=mean_return(episodes))
        print(table(options, episodes))


def environment_for(options: PlayOptions) -> Environment:
    """The task with what the agent observes; nothing is rendered that nobody looks at."""
    observes: dict[str, Any] = {"camera": options.agent == "gaze_follower", "truth": options.agent == "developer"}
    if options.time_limit is not None:
        observes["time_limit"] = options.time_limit
    return load(DOMAIN, options.task, task_kwargs={"random": options.seed, **observes})


def play_episodes(
    environment: Environment, agent: Any, options: PlayOptions, progress: Callable[[], object] = lambda: None
) -> list[Episode]:
    """All episodes, one after the other; ``progress`` is called after each."""
    episodes = []
    for number in range(1, options.episodes + 1):
        film = _film(environment, options) if options.video and number == 1 else nullcontext()
        with film as watch:
            episodes.append(_episode(environment, agent, number, watch))
        progress()
    return episodes


def table(options: PlayOptions, episodes: list[Episode]) -> str:
    """Returns, their mean and its interval, to read."""
    lines = [
        f"{options.agent} in {options.task}, seed {options.seed}",
        "",
        f"{'episode':>8}{'steps':>8}{'return':>12}{'a step':>10}",
    ]
    lines += [f"{one.episode:8}{one.steps:8}{one.reward_sum:12.2f}{one.reward_a_step:10.3f}" for one in episodes]
    total, share = mean_return(episodes), mean_interval([one.reward_a_step for one in episodes])
    lines += ["", f"mean return {total}; reward a step {share}"]
    return "\n".join([*lines, "With 95% bootstrap intervals."] if len(episodes) > 1 else lines)


def mean_return(episodes: list[Episode]) -> Estimate:
    """Of all episodes, with its interval."""
    return mean_interval([one.reward_sum for one in episodes])


def _film(environment: Environment, options: PlayOptions) -> Any:
    from jointattn_mj.viewing.film import TaskFilm

    assert options.out is not None
    return TaskFilm(free_name(options.out / "video.mp4"), environment.control_timestep())


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
