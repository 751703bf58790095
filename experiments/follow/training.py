"""A run of PPO on a task, and how good it is on episodes of its own now and then."""

from typing import TYPE_CHECKING, Any

import numpy as np

from jointattn_mj.adapters.registration import IDS
from jointattn_mj.io.extras import extra
from jointattn_mj.tasks import load
from jointattn_mj.tasks.agents import AGENTS
from jointattn_mj.viewing.play import play_episodes

extra("rl", "stable_baselines3")
import gymnasium  # noqa: E402
import torch  # noqa: E402
from stable_baselines3 import PPO  # noqa: E402
from stable_baselines3.common.evaluation import evaluate_policy  # noqa: E402
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv  # noqa: E402

from .images import SmallImage, SmallPatch  # noqa: E402

if TYPE_CHECKING:
    from .sweep import Training

BASELINES = ("oracle", "random", "zero")


def train(config: "Training", seed: int) -> dict[str, Any]:
    """Steps of experience, mean reward a step of what was learned from them, and what baselines earn."""
    torch.set_num_threads(1)
    learner_seed, test_seed = (int(part) for part in np.random.SeedSequence(seed).generate_state(2))
    practice, test = _copies(config, config.copies), _copies(config, 1)
    learner = _learner(config, practice, learner_seed)
    steps, rewards = [0], [tested(learner, test, test_seed, config.episodes)]
    while learner.num_timesteps < config.steps:
        learner.learn(config.every, reset_num_timesteps=False)
        steps.append(learner.num_timesteps)
        rewards.append(tested(learner, test, test_seed, config.episodes))
    practice.close()
    test.close()
    return {"steps": steps, "reward": rewards, **{name: earned(config, name, test_seed) for name in BASELINES}}


def tested(learner: PPO, environment: VecEnv, seed: int, episodes: int) -> float:
    """Mean reward a step in the first ``episodes`` of a seed, of the most likely actions.

    Args:
        learner: A trained agent.
        environment: Many worlds of the task.
        seed: Of the episodes.
        episodes: Number of episodes.
    """
    environment.seed(seed)
    returns, lengths = evaluate_policy(learner, environment, episodes, return_episode_rewards=True, warn=False)
    return float(sum(returns) / sum(lengths))


def earned(config: "Training", agent: str, seed: int) -> float:
    """The same of an agent of ``jointattn play``, in the same episodes; none of the baselines needs an image.

    Args:
        config: Task and number of episodes.
        agent: Name of the agent.
        seed: Of the episodes.
    """
    task = IDS[config.environment]
    environment = load("joint_attention", task, task_kwargs={"random": seed, "camera": False})
    played = play_episodes(environment, AGENTS[agent](environment, seed), config.episodes)
    environment.close()
    return float(np.mean([episode.reward_a_step for episode in played]))


def _copies(config: "Training", number: int) -> VecEnv:
    """So many copies of the task, in this process; each gets a seed of its own from the learner."""
    return DummyVecEnv([lambda: _environment(config)] * number)


def _environment(config: "Training") -> gymnasium.Env:
    height, side = config.image_height, config.patch_side
    made = gymnasium.make(
        f"jointattn_mj:{config.environment}", camera=height is not None, truth=config.truth, face_patch=side is not None
    )
    made = made if height is None else SmallImage(made, height)
    return made if side is None else SmallPatch(made, side)


def _learner(config: "Training", environment: VecEnv, seed: int) -> PPO:
    return PPO(
        "MultiInputPolicy", environment, seed=seed, device="cpu", learning_rate=config.learning_rate,
        n_steps=config.rollout, batch_size=config.batch, n_epochs=config.epochs, gamma=config.discount,
        gae_lambda=config.trace,
        policy_kwargs={"log_std_init": float(np.log(config.spread)), "normalize_images": False},
    )  # fmt: skip
