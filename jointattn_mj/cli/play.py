"""``jointattn play``: an agent plays episodes of a task of the suite."""

from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from jointattn_mj.cli.running import one_thread
from jointattn_mj.errors import ConfigError
from jointattn_mj.io.files import free_name, held
from jointattn_mj.io.progress import Progress
from jointattn_mj.io.results import result_paths, write_results
from jointattn_mj.options import FLAT, Checked, Choice, Real, Seed, Whole
from jointattn_mj.sweeps.statistics import mean_interval
from jointattn_mj.tasks import TASKS_BY_DOMAIN, load
from jointattn_mj.tasks.agents import AGENTS, TrainedGazeFollower
from jointattn_mj.tasks.environment import Environment
from jointattn_mj.viewing.play import Episode, mean_return, play_episodes

LESS = "a shorter episode"
DOMAIN = "joint_attention"


@dataclass(frozen=True)
class PlayOptions(Checked):
    """Who plays what, and where the results go."""

    task: tyro.conf.Positional[Annotated[str, Choice(TASKS_BY_DOMAIN[DOMAIN])]]
    """Task of the suite."""
    agent: Literal["zero", "random", "oracle", "gaze_follower", "developer"]
    """Who acts. zero and random know nothing, oracle knows the state of the world; gaze_follower is the robot of
    chapter 6 after one session (for object_transfer), developer the agent of chapter 5 (for turn_taking; it is told the
    values of its variables)."""
    episodes: Annotated[int, Whole("[1, 1e6]")] = 10
    """Number of episodes."""
    seed: Seed = 0
    """Seed of all randomness."""
    time_limit: Annotated[float, Real("(0, 1e9]")] | None = None
    """Length of an episode in seconds; by default the task's own."""
    out: Path | None = None
    """Folder for the results; made when missing."""
    video: bool = False
    """Also leave a video of the first episode there."""
    preset: Literal["thesis", "cross_situational"] = "thesis"
    """Robot that agent gaze_follower is: chapter 6 as it is written, or the one that learns which of the objects in
    view goes with a face. Either has had its 26 minutes of learning."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.video and self.out is None:
            raise ConfigError("--video needs a folder to leave the video in; name one with --out")
        if self.preset != "thesis" and self.agent != "gaze_follower":
            raise ConfigError(f"--preset {self.preset} is a robot of --agent gaze_follower; got --agent {self.agent}")


def play(options: Annotated[PlayOptions, FLAT]) -> None:
    """Let an agent play episodes of a task of the suite, and print its returns with 95% intervals.

    Baselines for learners. Leaves in --out: episodes.csv, episodes.json (with config and versions), and with --video a
    video.
    """
    one_thread()
    environment = environment_for(options)
    agent = agent_for(options, environment)
    with nullcontext() if options.out is None else held(options.out):
        paths = None if options.out is None else result_paths(options.out / "episodes", "episodes")
        film = free_name(options.out / "video.mp4") if options.video and options.out is not None else None
        with Progress("playing", options.episodes, "episodes") as shown:
            episodes = play_episodes(environment, agent, options.episodes, film, shown.add)
        environment.close()
        if paths is not None:
            rows = [vars(episode) for episode in episodes]
            write_results(paths, rows, options, mean_return=mean_return(episodes))
        print(table(options, episodes))


def environment_for(options: PlayOptions) -> Environment:
    """The task with what its agent observes; nothing is rendered that the agent does not use."""
    observes: dict[str, Any] = {"camera": options.agent == "gaze_follower", "truth": options.agent == "developer"}
    if options.time_limit is not None:
        observes["time_limit"] = options.time_limit
    return load(DOMAIN, options.task, task_kwargs={"random": options.seed, **observes})


def agent_for(options: PlayOptions, environment: Environment) -> Any:
    """Who acts in the task."""
    if options.agent == "gaze_follower":
        return TrainedGazeFollower(environment, options.seed, options.preset)
    return AGENTS[options.agent](environment, options.seed)


def table(options: PlayOptions, episodes: list[Episode]) -> str:
    """The return of each episode, their mean and its interval, to read."""
    lines = [
        f"{options.agent} in {options.task}, seed {options.seed}",
        "",
        f"{'episode':>8}{'steps':>8}{'return':>12}{'a step':>10}",
    ]
    lines += [
        f"{episode.episode:8}{episode.steps:8}{episode.reward_sum:12.2f}{episode.reward_a_step:10.3f}"
        for episode in episodes
    ]
    total, share = mean_return(episodes), mean_interval([episode.reward_a_step for episode in episodes])
    lines += ["", f"mean return {total}; reward a step {share}"]
    return "\n".join([*lines, "With 95% bootstrap intervals."] if len(episodes) > 1 else lines)
