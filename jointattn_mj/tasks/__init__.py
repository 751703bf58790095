"""The suite: worlds as dm_control environments, loaded by domain and task name.

``load("joint_attention", "object_transfer")`` gives an environment with the interface of ``dm_control.suite.load``.
Physics answers geometry, Task decides episodes, Environment steps.
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
    """The pairs in ``ALL_TASKS`` whose task bears ``tag``."""
    return tuple((domain, task) for domain, task in ALL_TASKS if task in _DOMAINS[domain].SUITE.tagged(tag))


BENCHMARKING, EASY, HARD = tagged("benchmarking"), tagged("easy"), tagged("hard")
"""Pairs that bear a tag, as in dm_control's suite."""
TASKS_BY_DOMAIN = {name: tuple(module.SUITE) for name, module in sorted(_DOMAINS.items())}
"""Names of a domain's tasks."""


def load(
    domain_name: str,
    task_name: str,
    task_kwargs: dict[str, Any] | None = None,
    environment_kwargs: dict[str, Any] | None = None,
    visualize_reward: bool = False,
) -> Environment:
    """An environment of the suite, as ``dm_control.suite.load`` gives it.

    Args:
        domain_name: Name of a domain.
        task_name: Name of a task in it.
        task_kwargs: Arguments of the task, for example ``random`` (its seed).
        environment_kwargs: Arguments of the environment, for example ``time_limit`` (s) or ``flat_observation``.
        visualize_reward: Light the robot's eyes while reward is given; its own camera does not see them.

    Raises:
        ConfigError: There is no such domain, task or argument, or an argument is of the wrong kind (a ``ValueError``,
            as in dm_control's suite).
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
    environment = suite[task_name](**settings)
    environment.task.visualize_reward = visualize_reward
    return environment
