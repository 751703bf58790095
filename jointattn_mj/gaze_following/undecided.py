"""Frames of a session in which the robot decides nothing: those before the next draw, and those of a gaze shift's way.

What the robot does in them is known beforehand. So the world runs on by itself, and percepts, interests and rows of the
log follow together, in compiled code. Everything comes out as it does frame by frame.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from jointattn_mj.gaze_following.agent import GazeFollower
from jointattn_mj.gaze_following.attention import AttentionSelector
from jointattn_mj.perception.percept import Percept
from jointattn_mj.perception.state import StatePerception
from jointattn_mj.scene.world import World

if TYPE_CHECKING:
    from jointattn_mj.gaze_following.session import SessionRun

LEAST = 3
"""Fewer frames are as fast one by one."""


def pass_by(session: SessionRun, most: int) -> int:
    """Simulate the coming frames in which nothing is decided, ``most`` at most.

    Returns:
        How many these were; 0 where the next frame has to be looked at by itself, or where a part of the session is of
        another class than those here, and may do something in every frame.
    """
    world, robot, frames = session.world, session.robot, session.frames
    attention, perceiver = robot.attention, robot.perceiver
    most = min(most, frames.room)
    if type(world) is not World or type(robot) is not GazeFollower or not world.runs:
        return 0
    if robot.shift is not None:
        if (count := min(most, robot.frames_on_way)) < LEAST:
            return 0
        tape = world.run(robot.go_on(count))
        history = np.array([[attention.saliency, attention.motion, attention.interest]])
        frames.add_all(world, robot, tape, history, None)
    else:
        if type(perceiver) is not StatePerception or type(attention) is not AttentionSelector or robot.waits:
            return 0
        if (count := min(most, attention.undrawn)) < LEAST:
            return 0
        tape = world.run(robot.go_on(count))
        percepts = perceiver.perceive_all(tape)
        history = attention.pass_by(robot.attended, percepts.moves)
        robot.percept = Percept(percepts.visible[-1], percepts.px[-1], percepts.moves[-1])
        frames.add_all(world, robot, tape, history, percepts)
    session.frame += count
    return count
