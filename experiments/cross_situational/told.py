"""Perception from images, of which one part at a time is told by the state: where do images lose?"""

from typing import Literal, get_args

import numpy as np

from jointattn_mj.perception.percept import Observation, Percept
from jointattn_mj.perception.pixels import PixelPerception
from jointattn_mj.perception.state import StateConfig, StatePerception
from jointattn_mj.scene.world import World

Part = Literal["face_pattern", "positions", "motion", "all"]
"""The face pattern (the head's yaw and pitch in place of a grey patch), where face and objects are, what moves."""
PARTS: tuple[Part, ...] = get_args(Part)
EXACT = StateConfig(
    face_noise_px=0.0,
    object_noise_px=0.0,
    object_miss=0.0,
    pattern_noise_deg=0.0,
    face_motion_hit=1.0,
    face_motion_false_alarm=0.0,
    object_motion_hit=1.0,
    object_motion_false_alarm=0.0,
)
"""The state without the errors that images have."""


class PartlyTold:
    """A ``Perceiver`` of images that is told one part of its percept, or all of it, without error."""

    def __init__(self, seen: PixelPerception, world: World, part: Part):
        """Let the state of ``world`` replace a part of what ``seen`` perceives."""
        self._seen, self._part = seen, part
        self._exact = StatePerception(EXACT, world, np.random.default_rng(0))
        self.pattern_size = (self._exact if self._tells("face_pattern") else seen).pattern_size

    def _tells(self, part: Part) -> bool:
        return self._part in (part, "all")

    def perceive(self, observation: Observation, landed: bool) -> Percept:
        """See ``Perceiver``."""
        seen, exact = self._seen.perceive(observation, landed), self._exact.perceive(observation, landed)
        where = exact if self._tells("positions") else seen
        visible = where.visible.copy()
        visible[-1] &= seen.visible[-1] or self._tells("face_pattern")
        moves = (exact if self._tells("motion") else seen).moves
        return Percept(visible=visible, px=np.where(visible[:, None], where.px, np.nan), moves=moves & visible)

    def face_pattern(self) -> np.ndarray:
        """See ``Perceiver``."""
        return (self._exact if self._tells("face_pattern") else self._seen).face_pattern()
