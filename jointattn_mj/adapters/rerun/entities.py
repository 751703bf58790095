"""Where in a log things are: paths of its entities, and its two timelines."""

import numpy as np
import rerun as rr

from jointattn_mj.scene.caregiver import FRAME_S

WORLD = "world"
EYE = f"{WORLD}/robot_eye"
IMAGE, VISIBLE, FLOW, GOAL = (f"{EYE}/{name}" for name in ("image", "seen", "flow", "goal"))
ROBOTS_GAZE, PERSONS_GAZE = f"{WORLD}/gaze/robot", f"{WORLD}/gaze/person"
INTEREST, FACES, ACTIVATIONS = "mind/interest", "mind/faces", "mind/activations"
DECIDES = "mind/decides"
GATE, SUCCESS = f"{DECIDES}/learner", f"{DECIDES}/success"
HEAD = "head"
DOINGS = "doings"
ROBOT_LOOKS, PERSON_LOOKS, PERSON_DOES = (
    f"{DOINGS}/{name}" for name in ("robot_looks_at", "person_looks_at", "person")
)
SHIFTS = "shifts"


def go_to(log: rr.RecordingStream, frame: int) -> None:
    """What is logged from now on belongs to this frame of a session."""
    log.set_time("frame", sequence=frame)
    log.set_time("time", duration=frame * FRAME_S)


def columns_of(frames: list[int]) -> tuple[rr.TimeColumn, rr.TimeColumn]:
    """Both timelines at many frames."""
    return rr.TimeColumn("frame", sequence=frames), rr.TimeColumn("time", duration=np.array(frames) * FRAME_S)
