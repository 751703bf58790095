"""Frames of a session in which the robot decides nothing: those before the next draw, and those of a gaze shift's way.

What the robot does in them is known beforehand. So the world runs on by itself, and percepts, interests and rows of the
log follow together, in compiled code. Everything comes out as it does frame by frame.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from jointattn_mj.gaze_following.agent import GazeFollower
from jointattn_mj.gaze_following.attention import AttentionSelector
from jointattn_mj.gaze_following.tables import FrameTable
from jointattn_mj.perception.percept import Percept
from jointattn_mj.perception.state import StatePerception
from jointattn_mj.scene.caregiver import TransferScript
from jointattn_mj.scene.world import AlignedObservation, World, WorldObservation

if TYPE_CHECKING:
    from jointattn_mj.gaze_following.session import SessionRun

LEAST = 3
"""Fewer frames are as fast one by one."""
SETTLING = 8
"""So many frames are looked ahead for the end of a gaze shift, where that can be foreseen."""
OBSERVATIONS = (WorldObservation, AlignedObservation)
"""What a robot observes of a world that ``runs`` with the head's angles as they are."""


_NAMES = {
    World: ("step", "before_step", "head_moves"),
    TransferScript: ("advance", "_play"),
    GazeFollower: ("act", "_choose", "_turn", "_hold"),
    FrameTable: ("add",),
    StatePerception: ("perceive",),
    AttentionSelector: ("advance", "consider", "draw"),
}
"""Methods that a frame calls, and that are left out here."""


def _methods() -> tuple[Any, ...]:
    """These methods, written out: this is asked many times a second."""
    return (
        World.step, World.before_step, World.head_moves, TransferScript.advance, TransferScript._play,
        GazeFollower.act, GazeFollower._choose, GazeFollower._turn, GazeFollower._hold, FrameTable.add,
        StatePerception.perceive, AttentionSelector.advance, AttentionSelector.consider, AttentionSelector.draw,
    )  # fmt: skip


_METHODS = _methods()


def pass_by(session: SessionRun, most: int) -> int:
    """Simulate the coming frames in which nothing is decided, ``most`` at most.

    Returns:
        How many these were; 0 where the next frame has to be looked at by itself, or where a part of the session is of
        another class than those here or has methods of its own, and may do something in every frame.
    """
    world, robot, frames = session.world, session.robot, session.frames
    if not session.frame:  # notes where the face is
        return 0
    if type(robot) is not GazeFollower or (count := min(most, _undecided(robot))) < LEAST or not _all_usual(session):
        return 0
    most = min(most, frames.room)
    references = _references(world, robot, min(count, most), most)
    count = len(references)
    perceiver: Any = robot.perceiver
    attention: Any = robot.attention
    robot.pass_by(references)
    tape = world.run(np.radians(references))
    if robot.shift is not None:
        history, percepts = frames.levels(attention)[None], None
    else:
        percepts = perceiver.perceive_all(tape)
        history = attention.pass_by(robot.attended, percepts.moves)
        robot.percept = Percept(percepts.visible[-1], percepts.px[-1], percepts.moves[-1])
    frames.add_all(world, robot, tape, history, percepts)
    session.frame += count
    return count


def _undecided(robot: GazeFollower) -> int:
    """How many of the coming frames pass without a decision."""
    if robot.shift is not None:
        return robot.frames_on_way
    if type(robot.perceiver) is not StatePerception or type(robot.attention) is not AttentionSelector or robot.waits:
        return 0
    return robot.attention.undrawn


def _references(world: World, robot: GazeFollower, count: int, most: int) -> np.ndarray:
    """References (k, 2), deg, of ``count`` frames, and of those until the head stands still if that is foreseen."""
    if world.config.dynamics == "mujoco" or not robot.commanded_after(count):
        return robot.coming(count)
    references = robot.coming(min(most, count + SETTLING))
    return references[: world.steps_to_rest(np.radians(references), count)]


def _all_usual(session: SessionRun) -> bool:
    """Whether all parts do in such frames what stands here."""
    if _methods() != _METHODS:
        return False  # a class was patched
    world, robot = session.world, session.robot
    if not (_usual(world, World) and _usual(robot, GazeFollower) and _usual(session.frames, FrameTable)):
        return False
    if not (_usual(world.caregiver, TransferScript) and type(session._observation) in OBSERVATIONS and world.runs):
        return False
    perceiver: Any = robot.perceiver
    return robot.shift is not None or (
        _usual(robot.attention, AttentionSelector)
        and _usual(perceiver, StatePerception)
        and perceiver._world is world
        and robot.mean_face is None
    )


def _usual(part: Any, kind: type) -> bool:
    """Whether a part of a session is of this class, and has no method of its own in place of the class's."""
    return type(part) is kind and vars(part).keys().isdisjoint(_NAMES[kind])
