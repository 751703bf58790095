"""The suite: joint attention as dm_control environments, loaded by domain and task name.

``load("joint_attention", "object_transfer")`` gives an environment with the interface of ``dm_control.suite.load``.
Physics answers geometric questions, Task decides about episodes, observations and reward, Environment steps.
"""

from inspect import signature
from types import NoneType
from typing import Any

from jointattn_mj.tasks import joint_attention
from jointattn_mj.tasks.arguments import require, unknown
from jointattn_mj.tasks.environment import Environment

_DOMAINS = {"joint_attention": joint_attention}

ALL_TASKS: tuple[tuple[str, str], ...] = tuple(
    (domain, task) for domain, module in sorted(_DOMAINS.items()) for task in module.SUITE
)
"""All pairs of domain name and task name."""


def tagged(tag: str) -> tuple[tuple[str, str], ...]:
    """The pairs in ``ALL_TASKS`` whose task has the tag."""
    return tuple((domain, task) for domain, task in ALL_TASKS if task in _DOMAINS[domain].SUITE.tagged(tag))


BENCHMARKING, EASY, HARD = tagged("benchmarking"), tagged("easy"), tagged("hard")
"""The pairs that have a tag, as in dm_control's suite."""
TASKS_BY_DOMAIN = {name: tuple(module.SUITE) for name, module in sorted(_DOMAINS.items())}
"""Names of each domain's tasks."""


def load(
    domain_name: str,
    task_name: str,
    task_kwargs: dict[str, Any] | None = None,
    environment_kwargs: dict[str, Any] | None = None,
    visualize_reward: bool = False,
) -> Environment:
    """Load a task of the suite as a dm_control environment, like ``dm_control.suite.load``.

    Args:
        domain_name: Name of a domain: "joint_attention".
        task_name: Name of a task: "object_transfer", "follow", "turn_taking", or one of these with "_hard".
            ``help(jointattn_mj.tasks.joint_attention)`` describes observations, actions and rewards of each.
        task_kwargs: Arguments of the task, by name. All tasks have these:
            ``random``, the seed; ``camera``, whether observations hold the image; ``truth``, whether they hold the
            ground truth; ``time_limit``, seconds in an episode; ``world``, a ``WorldConfig``; ``people``, names of
            caregivers; ``variation``, ranges of domain randomisation.
        environment_kwargs: Arguments of ``dm_control.rl.control.Environment``, for example ``flat_observation``.
        visualize_reward: Light the robot's eyes while reward is given. The robot's own camera does not see them.

    Returns:
        The environment. Its ``step`` and ``reset`` give ``dm_env.TimeStep``; ``physics`` answers who looks at what;
        ``task.best_action(physics)`` is the oracle's action; ``get_state`` and ``set_state`` save and restore all.

    Raises:
        ConfigError: There is no such domain, task or argument, or an argument is of the wrong kind (a ``ValueError``,
            as in dm_control's suite).

    Examples:
        >>> import jointattn_mj
        >>> env = jointattn_mj.load("joint_attention", "follow", task_kwargs={"random": 0, "camera": False})
        >>> timestep = env.reset()
        >>> timestep = env.step([0.1, -0.2])  # desired pan and tilt of the robot's head, rad
        >>> sorted(timestep.observation), 0 <= timestep.reward <= 1
        (['head_angles'], True)
        >>> env.close()
    """
    if domain_name not in _DOMAINS:
        raise unknown("domain", domain_name, sorted(_DOMAINS))
    suite = _DOMAINS[domain_name].SUITE
    if task_name not in suite:
        raise unknown(f"task of {domain_name}", task_name, suite)
    require("task_kwargs", task_kwargs, dict, NoneType)
    settings = dict(task_kwargs or {})
    if environment_kwargs is not None:
        settings["environment_kwargs"] = environment_kwargs
    known = signature(suite[task_name]).parameters
    for name in settings.keys() - known.keys():
        raise unknown(f"argument of {task_name}", name, known)
    environment: Environment = suite[task_name](**settings)
    environment.task.visualize_reward = visualize_reward
    return environment
