"""Sessions in worlds that the seed draws: other light, people, objects, pace (``scene.variation``)."""

from dataclasses import dataclass

import numpy as np

from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.scene.variation import Variation, VariationConfig, drawn, variation_of
from jointattn_mj.scene.world import World


@dataclass(frozen=True)
class VariedSessionConfig(SessionConfig):
    """A session, and how far its world may differ."""

    variation: Variation = "none"
    """What about the world the seed decides: lights, textures, people, camera, objects, layout, pace; all, or some of
    them joined by +."""

    @property
    def ranges(self) -> VariationConfig:
        """What ``variation`` names."""
        return variation_of(self.variation)


class VariedSessionRun(SessionRun):
    """A session whose world is drawn anew with every seed, and then stays; the robot expects the usual colours."""

    config: VariedSessionConfig

    def new_world(self, seed: np.random.SeedSequence) -> World:
        """See ``SessionRun``; with nothing to vary it is the same world."""
        world, conditions = drawn(self.config.world, self.config.ranges, seed)
        return World.build(world, seed, conditions)
