"""The domain "joint_attention": a robot and a caregiver at a table, every task in an easy and a hard form.

The robots of the dissertation learn without reward. Reward is for other learners, and serves as a measure. A hard form
has another caregiver every episode, and either twice as many objects nearer to each other, or many more spots.

Arguments that all tasks have:

    time_limit: Seconds in an episode; nothing else ends one.
    random: Seed, or a numpy ``RandomState`` to draw one from; None draws one.
    camera: Whether observations hold the image. Without it nothing is rendered, and no OpenGL is needed.
    truth: Whether observations hold the ground truth, which is what perfect perception would make of the image.
    face_patch: Whether observations hold the caregiver's face as the robot's own detector finds it in the image: grey
        values, and whether there was one. Before the first episode the detector sees the face of each of ``people`` in
        250 images, of which ``variation`` changes nothing.
    world: A ``scene.world.WorldConfig``: what things look like, how the caregiver moves, where objects lie.
    people: Names of caregivers, one of whom is drawn for each episode; empty: the caregiver of ``world``.
    variation: Domain randomisation, drawn for each episode: a ``scene.variation.VariationConfig``, or names of its
        presets, such as "lights+pace" or "all".
    environment_kwargs: Arguments of ``dm_control.rl.control.Environment``.

Angles of the head are pan, positive to the robot's left, and tilt, positive upwards. Actions beyond the bounds are
clipped to them.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import wraps
from types import NoneType
from typing import Any, TypeVar

from dm_control.utils import containers

from jointattn_mj.development.table.world import CHAPTER_4, CHAPTER_5, TableConfig
from jointattn_mj.scene.caregiver import CaregiverConfig
from jointattn_mj.scene.layout import LayoutConfig
from jointattn_mj.scene.model import SceneConfig
from jointattn_mj.scene.objects import OBJECTS
from jointattn_mj.scene.people import IDENTITIES
from jointattn_mj.scene.variation import VariationConfig
from jointattn_mj.scene.world import WorldConfig
from jointattn_mj.tasks import follow as following
from jointattn_mj.tasks import object_transfer as transfer
from jointattn_mj.tasks import turn_taking as turns
from jointattn_mj.tasks.arguments import require
from jointattn_mj.tasks.environment import Environment, JointAttentionTask, SeedLike

EVERYBODY = tuple(IDENTITIES)
"""Names of all caregivers."""
CROWDED = WorldConfig(scene=SceneConfig(objects=OBJECTS[:8]), layout=LayoutConfig(spacing=0.10))
"""Twice as many objects, nearer to each other."""
WANDERING = CaregiverConfig(greet_s=0.3, gaze_s=1.2)
"""Looks at the robot briefly, then at one object after another."""
WANDERING_TIME_LIMIT = 6.0
"""Seconds in an episode of ``follow_hard``: time for three objects."""

SUITE = containers.TaggedTasks()
"""The tasks by name."""
Maker = TypeVar("Maker", bound=Callable[..., Environment])


def task(*tags: str) -> Callable[[Maker], Maker]:
    """Add the decorated function, which makes a task's environment, to ``SUITE`` under its own name, with tags."""
    decorator: Callable[[Maker], Maker] = SUITE.add(*tags)
    return decorator


def _environment(
    make: Callable[..., JointAttentionTask], world: WorldConfig | None, time_limit: float,
    environment_kwargs: dict[str, Any] | None, **settings: Any,
) -> Environment:  # fmt: skip
    """The environment of a task that ``make`` builds from a world and ``settings``."""
    require("environment_kwargs", environment_kwargs, dict, NoneType)
    task = make(WorldConfig() if world is None else world, **settings)
    return Environment(task, **{"time_limit": time_limit, **(environment_kwargs or {})})


@task("benchmarking", "easy", "chapter6")
def object_transfer(
    time_limit: float = transfer.TIME_LIMIT,
    random: SeedLike = None,
    camera: bool = True,
    truth: bool = False,
    world: WorldConfig | None = None,
    people: Sequence[str] = (),
    variation: VariationConfig | str = "none",
    environment_kwargs: dict[str, Any] | None = None,
    face_patch: bool = False,
) -> Environment:
    """Look at the object that the caregiver takes up, observes, and puts elsewhere (section 6.4.2).

    The caregiver's script goes on whatever the robot does. For the arguments see the module.

    | name | shape | type, unit | what it is |
    |---|---|---|---|
    | `observation["camera"]` | (240, 320, 3) | uint8, RGB | the robot's image, 30 a second; with `camera=True` |
    | `observation["head_angles"]` | (2,) | float, rad | pan and tilt of the robot's head |
    | `observation["face_patch"]` | (32, 32) | uint8 | the face, grey (`face_patch=True`); 0 where none was found |
    | `observation["face_visible"]` | () | bool | whether a face was found; with `face_patch=True` |
    | `observation["truth"]` | (2,) | float, rad | ground truth (`truth=True`): yaw and pitch of the caregiver's head |
    | `observation["head_moves"]` | () | bool | whether the robot's head turns |
    | action | (2,) | float, rad | desired pan, -45 to 45 degrees, and tilt, -35 to 15 degrees |
    | reward | () | 0 or 1 | 1 while robot and caregiver look at the same object |
    | step, episode | | s | 1/30; 60 |
    """
    settings: dict[str, Any] = {"random": random, "camera": camera, "truth": truth, "face_patch": face_patch}
    settings |= {"people": people, "variation": variation}
    return _environment(transfer.ObjectTransfer, world, time_limit, environment_kwargs, **settings)


@task("benchmarking", "hard")
@wraps(object_transfer, assigned=())  # the same arguments
def object_transfer_hard(**settings: Any) -> Environment:
    """``object_transfer`` with eight objects, nearer to each other, and one of six caregivers every episode.

    Observations, action, reward and episode are those of ``object_transfer``.
    """
    hard: dict[str, Any] = {"world": CROWDED, "people": EVERYBODY, **settings}
    return object_transfer(**hard)


@task("benchmarking", "easy")
def follow(
    time_limit: float = following.TIME_LIMIT,
    random: SeedLike = None,
    camera: bool = True,
    truth: bool = False,
    world: WorldConfig | None = None,
    people: Sequence[str] = (),
    variation: VariationConfig | str = "none",
    environment_kwargs: dict[str, Any] | None = None,
    face_patch: bool = False,
) -> Environment:
    """Fixate the object that the caregiver looks at: one of four, the same for the whole episode.

    For the arguments see the module.

    | name | shape | type, unit | what it is |
    |---|---|---|---|
    | `observation["camera"]` | (240, 320, 3) | uint8, RGB | the robot's image; with `camera=True` |
    | `observation["head_angles"]` | (2,) | float, rad | pan and tilt of the robot's head |
    | `observation["face_patch"]` | (32, 32) | uint8 | the face, grey (`face_patch=True`); 0 where none was found |
    | `observation["face_visible"]` | () | bool | whether a face was found; with `face_patch=True` |
    | `observation["truth"]` | (2,) | float, rad | ground truth (`truth=True`): yaw and pitch of the caregiver's head |
    | action | (2,) | float, rad | desired pan, -45 to 45 degrees, and tilt, -35 to 15 degrees |
    | reward | () | 0 to 1 | 1 within 3.5 degrees of the object, falling to 0 in a straight line 20 degrees further |
    | step, episode | | s | 0.1; 3 |
    """
    settings: dict[str, Any] = {"random": random, "camera": camera, "truth": truth, "face_patch": face_patch}
    settings |= {"people": people, "variation": variation}
    return _environment(following.Follow, world, time_limit, environment_kwargs, **settings)


@task("benchmarking", "hard")
def follow_hard(
    time_limit: float = WANDERING_TIME_LIMIT,
    random: SeedLike = None,
    camera: bool = True,
    truth: bool = False,
    world: WorldConfig | None = None,
    people: Sequence[str] = EVERYBODY,
    variation: VariationConfig | str = "none",
    environment_kwargs: dict[str, Any] | None = None,
    face_patch: bool = False,
) -> Environment:
    """``follow`` with eight objects and one of six caregivers, who looks at the robot, then at object after object.

    Arguments, observations and action are those of ``follow``.

    | name | shape | type, unit | what it is |
    |---|---|---|---|
    | reward | () | 0 or 1 | 1 while the caregiver's object is within 3.5 degrees of the robot's gaze, none nearer |
    | step, episode | | s | 0.1; 6 |
    """
    world = replace(CROWDED, behaviour=WANDERING) if world is None else world
    settings: dict[str, Any] = {"random": random, "camera": camera, "truth": truth, "face_patch": face_patch}
    settings |= {"people": people, "variation": variation}
    return _environment(following.FollowSparse, world, time_limit, environment_kwargs, **settings)


@task("benchmarking", "easy", "chapter5")
def turn_taking(
    time_limit: float = turns.TIME_LIMIT,
    random: SeedLike = None,
    camera: bool = True,
    truth: bool = False,
    world: WorldConfig | None = None,
    people: Sequence[str] = (),
    table: TableConfig = CHAPTER_5,
    variation: VariationConfig | str = "none",
    environment_kwargs: dict[str, Any] | None = None,
    face_patch: bool = False,
) -> Environment:
    """Turn-taking at the table of chapter 5: three spots, two objects, both shift their gaze once a step (5.3.1).

    ``table`` sets spots, objects and the caregiver's rules. Of ``world`` only looks matter, so that ``variation``
    changes neither pace nor layout. For the other arguments see the module.

    | name | shape | type, unit | what it is |
    |---|---|---|---|
    | `observation["camera"]` | (240, 320, 3) | uint8, RGB | image at the end of the step, with `camera=True` |
    | `observation["head_angles"]` | (2,) | float, rad | pan and tilt of the robot's head |
    | `observation["face_patch"]` | (32, 32) | uint8 | the face, grey (`face_patch=True`); 0 where none was found |
    | `observation["face_visible"]` | () | bool | whether a face was found; with `face_patch=True` |
    | `observation["sensors"]` | (2,) | int | ground truth (`truth=True`): values of the sensory variables (Table 5.1) |
    | `observation["results"]` | (2,) or (3,) | int | ground truth (`truth=True`): values of the resultant variables |
    | action | (2,) | int | spot to look at, or the number of spots for the caregiver's face; gesture |
    | reward | () | 0 or 1 | 1 where robot or caregiver looks at the object that the other looked at |
    | step, episode | | s | 1; 1000 |
    """
    settings: dict[str, Any] = {"random": random, "camera": camera, "truth": truth, "face_patch": face_patch}
    settings |= {"people": people, "table": table, "variation": variation}
    return _environment(turns.TurnTaking, world, time_limit, environment_kwargs, **settings)


@task("benchmarking", "hard", "chapter4")
@wraps(turn_taking, assigned=())
def turn_taking_hard(**settings: Any) -> Environment:
    """``turn_taking`` at the table of chapter 4: nine spots, three objects of ten kinds (4.5.1), one of six caregivers.

    Observations, action, reward and episode are those of ``turn_taking``, with more values of each.
    """
    hard: dict[str, Any] = {"table": CHAPTER_4, "people": EVERYBODY, **settings}
    return turn_taking(**hard)
