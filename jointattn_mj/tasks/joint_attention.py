"""Joint attention with a caregiver at a table, as a dm_control domain: every task in an easy and a hard form.

Nothing here teaches the robot of the dissertation, which learns without reward: the reward is for other learners, and
as a measure. Arguments that all tasks have:

    time_limit: Seconds in an episode.
    random: Seed, or a state to draw one from.
    camera: Whether observations hold the image; without it nothing is rendered.
    truth: Whether observations hold what perfect perception would make of it; see each task's ``truth``.
    world: What things look like, how the caregiver moves, where objects lie.
    people: Names of caregivers; each episode has one of them. None: the one of ``world``.
    variation: How far the world of every episode may differ from ``world``: a ``scene.variation.VariationConfig``, or
        names of its presets, such as "lights+pace" or "all".
    environment_kwargs: Arguments of ``control.Environment``.

A hard form has another caregiver every episode, and twice as many objects nearer to each other, or many more places.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import wraps
from types import NoneType
from typing import Any

from dm_control.utils import containers

from jointattn_mj.development.table.world import CHAPTER_4, CHAPTER_5, TableConfig
from jointattn_mj.scene.caregiver import CaregiverConfig
from jointattn_mj.scene.layout import LayoutConfig
from jointattn_mj.scene.model import OBJECTS, SceneConfig
from jointattn_mj.scene.people import IDENTITIES
from jointattn_mj.scene.variation import VariationConfig
from jointattn_mj.scene.world import WorldConfig
from jointattn_mj.tasks import follow as following
from jointattn_mj.tasks import object_transfer as transfer
from jointattn_mj.tasks import turn_taking as turns
from jointattn_mj.tasks.arguments import require
from jointattn_mj.tasks.environment import Environment, JointAttentionTask, Random

EVERYBODY = tuple(IDENTITIES)
CROWDED = WorldConfig(scene=SceneConfig(objects=OBJECTS[:8]), layout=LayoutConfig(spacing=0.10))
"""Twice as many objects, nearer to each other."""
WANDERING = CaregiverConfig(greet_s=0.3, gaze_s=1.2)
"""Looks up, then at one object after another."""
WANDERING_TIME_LIMIT = 6.0
"""Seconds: three objects."""

SUITE = containers.TaggedTasks()


def _environment(
    make: Callable[..., JointAttentionTask], world: WorldConfig | None, time_limit: float,
    environment_kwargs: dict[str, Any] | None, **settings: Any,
) -> Environment:  # fmt: skip
    require("environment_kwargs", environment_kwargs, dict, NoneType)
    task = make(WorldConfig() if world is None else world, **settings)
    return Environment(task, **{"time_limit": time_limit, **(environment_kwargs or {})})


@SUITE.add("benchmarking", "easy", "chapter6")
def object_transfer(
    time_limit: float = transfer.TIME_LIMIT,
    random: Random = None,
    camera: bool = True,
    truth: bool = False,
    world: WorldConfig | None = None,
    people: Sequence[str] = (),
    variation: VariationConfig | str = "none",
    environment_kwargs: dict[str, Any] | None = None,
) -> Environment:
    """The caregiver takes objects up, observes them, and puts them elsewhere (section 6.4.2)."""
    settings: dict[str, Any] = {"random": random, "camera": camera, "truth": truth, "people": people}
    settings["variation"] = variation
    return _environment(transfer.ObjectTransfer, world, time_limit, environment_kwargs, **settings)


@SUITE.add("benchmarking", "hard")
@wraps(object_transfer, assigned=())  # the same arguments
def object_transfer_hard(**settings: Any) -> Environment:
    """``object_transfer`` with eight objects, nearer to each other, and another caregiver every episode."""
    return object_transfer(**{"world": CROWDED, "people": EVERYBODY} | settings)


@SUITE.add("benchmarking", "easy")
def follow(
    time_limit: float = following.TIME_LIMIT,
    random: Random = None,
    camera: bool = True,
    truth: bool = False,
    world: WorldConfig | None = None,
    people: Sequence[str] = (),
    variation: VariationConfig | str = "none",
    environment_kwargs: dict[str, Any] | None = None,
) -> Environment:
    """The caregiver looks at one object, and the robot is to fixate it; ten steps a second, reward for being near."""
    settings: dict[str, Any] = {"random": random, "camera": camera, "truth": truth, "people": people}
    settings["variation"] = variation
    return _environment(following.Follow, world, time_limit, environment_kwargs, **settings)


@SUITE.add("benchmarking", "hard")
def follow_hard(
    time_limit: float = WANDERING_TIME_LIMIT,
    random: Random = None,
    camera: bool = True,
    truth: bool = False,
    world: WorldConfig | None = None,
    people: Sequence[str] = EVERYBODY,
    variation: VariationConfig | str = "none",
    environment_kwargs: dict[str, Any] | None = None,
) -> Environment:
    """``follow`` with eight objects, a caregiver who looks up and around, and reward for fixating alone."""
    world = replace(CROWDED, behaviour=WANDERING) if world is None else world
    settings: dict[str, Any] = {"random": random, "camera": camera, "truth": truth, "people": people}
    settings["variation"] = variation
    return _environment(following.FollowSparse, world, time_limit, environment_kwargs, **settings)


@SUITE.add("benchmarking", "easy", "chapter5")
def turn_taking(
    time_limit: float = turns.TIME_LIMIT,
    random: Random = None,
    camera: bool = True,
    truth: bool = False,
    world: WorldConfig | None = None,
    people: Sequence[str] = (),
    table: TableConfig = CHAPTER_5,
    variation: VariationConfig | str = "none",
    environment_kwargs: dict[str, Any] | None = None,
) -> Environment:
    """Three places, two objects, gazes in turns (section 5.3.1); a step is a turn, and a second.

    ``table`` decides how many places and objects there are and what the caregiver does; of ``world`` only looks matter,
    so that pace and layout do not vary.
    """
    settings: dict[str, Any] = {"random": random, "camera": camera, "truth": truth, "people": people, "table": table}
    settings["variation"] = variation
    return _environment(turns.TurnTaking, world, time_limit, environment_kwargs, **settings)


@SUITE.add("benchmarking", "hard", "chapter4")
@wraps(turn_taking, assigned=())
def turn_taking_hard(**settings: Any) -> Environment:
    """``turn_taking`` with nine places and three objects of ten kinds (section 4.5.1); people change by the episode."""
    return turn_taking(**{"table": CHAPTER_4, "people": EVERYBODY} | settings)
