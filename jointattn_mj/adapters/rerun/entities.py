"""Entities of a log, and its two timelines, ``frame`` and ``time`` (seconds).

| entity | what it shows |
|---|---|
| `world/<body>` | pose and shapes of a body; world frame, metres |
| `world/robot_eye`, `.../image` | pose of the robot's camera, and its images |
| `world/robot_eye/visible` | boxes around detected candidates |
| `world/robot_eye/flow` | optical flow of textured blocks, enlarged |
| `world/robot_eye/goal` | goal of the gaze shift, and the learner's guess |
| `world/gaze/robot`, `world/gaze/person` | lines of sight of robot and caregiver, green on the same object |
| `agent/interest` | interest of each candidate (eq. 6.1) |
| `agent/faces`, `agent/activations` | the map's faces, and its activations when the robot turns away from a face |
| `agent/decides/learner` | probability that the learner decides (eq. 6.8) |
| `agent/decides/success` | rate of success (eq. 6.9) |
| `head` | pan and tilt of the robot's head, degrees |
| `doings/robot_looks_at`, `doings/person_looks_at` | what robot and caregiver look at |
| `doings/person` | what the caregiver does |
| `shifts` | a line for each gaze shift that ended |
"""

import numpy as np
import rerun as rr

from jointattn_mj.scene.caregiver import FRAME_S

WORLD = "world"
EYE = f"{WORLD}/robot_eye"
IMAGE, VISIBLE, FLOW, GOAL = (f"{EYE}/{name}" for name in ("image", "visible", "flow", "goal"))
ROBOTS_GAZE, PERSONS_GAZE = f"{WORLD}/gaze/robot", f"{WORLD}/gaze/person"
INTEREST, FACES, ACTIVATIONS = "agent/interest", "agent/faces", "agent/activations"
DECIDES = "agent/decides"
GATE, SUCCESS = f"{DECIDES}/learner", f"{DECIDES}/success"
HEAD = "head"
DOINGS = "doings"
ROBOT_LOOKS, PERSON_LOOKS, PERSON_DOES = (
    f"{DOINGS}/{name}" for name in ("robot_looks_at", "person_looks_at", "person")
)
SHIFTS = "shifts"


def go_to(log: rr.RecordingStream, frame: int) -> None:
    """Let what is logged from now on belong to this frame of the session."""
    log.set_time("frame", sequence=frame)
    log.set_time("time", duration=frame * FRAME_S)


def columns_of(frames: list[int]) -> tuple[rr.TimeColumn, rr.TimeColumn]:
    """Both timelines at these frames."""
    return rr.TimeColumn("frame", sequence=frames), rr.TimeColumn("time", duration=np.array(frames) * FRAME_S)
