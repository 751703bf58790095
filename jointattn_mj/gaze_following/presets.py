"""Robots of chapter 6 by name: the dissertation's, and one that learns what is contingent."""

from typing import Literal

from jointattn_mj.gaze_following.agent import RobotConfig
from jointattn_mj.gaze_following.gate import GazeConfig
from jointattn_mj.gaze_following.learners import LearnerConfig
from jointattn_mj.perception.mean_face import MeanFaceConfig
from jointattn_mj.perception.som import SOMConfig

Preset = Literal["thesis", "cross_situational"]
LEARNER = LearnerConfig(
    code="cross_situational", pairs="in_view", base="in_view", competition=1.0, forgetting=0.005
)  # fmt: skip
"""Pairs a face with all objects in view, by how much more often something lies there with this face than anyway."""
GAZE = GazeConfig(
    gate_midpoint=30.0, gate_width=5.0, commands="object", wait_for_still_face=True, read_again=True
)  # fmt: skip
"""Looks at the object that goes best with a face, once the face is still. The gate is half open after 30 pairs rather
than 150: the counts are right by then."""
SOM = SOMConfig(rows=13, columns=13, sigma_start=6.0)
"""Twice the patterns of the dissertation's map: directions are told apart more finely than 81 patterns tell them."""
MEAN_FACE = MeanFaceConfig(subtracted=True)
"""What was learned from one person then serves for others, too."""
PRESETS = {
    "thesis": RobotConfig(),
    "cross_situational": RobotConfig(learner=LEARNER, gaze=GAZE, som=SOM, mean_face=MEAN_FACE, face_at="remembered"),
}
"""Settings of a robot by the name of the preset."""
