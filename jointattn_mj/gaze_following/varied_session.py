"""Sessions whose world varies with the seed: light, people, objects, pace (see ``scene.variation``)."""

from dataclasses import dataclass

import numpy as np

from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.scene.variation import Variation, VariationConfig, drawn, variation_of
from jointattn_mj.scene.world import AlignedObservation, World, WorldObservation


@dataclass(frozen=True)
class VariedSessionConfig(SessionConfig):
    """What decides a session, and what of its world varies with the seed."""

    variation: Variation = "none"
    """What varies with the seed: lights, textures, people, camera, objects, layout or pace, several of them joined by
    +, or all."""
    knows_delay: bool = True
    """Whether the robot knows how many frames its camera is late: it takes what it sees as seen with the head as it was
    then, and a gaze shift as over when images show that it is. A robot that takes images for those of the present
    lands beside what it looks at, and learns wrong maps."""

    @property
    def ranges(self) -> VariationConfig:
        """Ranges of what ``variation`` names."""
        return variation_of(self.variation)


class VariedSessionRun(SessionRun):
    """A session whose world the seed draws once, at its beginning; the robot expects the usual colours."""

    config: VariedSessionConfig

    def new_world(self, seed: np.random.SeedSequence) -> World:
        """Make scene, caregiver and the robot's body; without variation they are those of ``SessionRun``."""
        world, conditions = drawn(self.config.world, self.config.ranges, seed)
        return World.build(world, seed, conditions)

    def new_observation(self) -> WorldObservation:
        """Make what the robot may know of the world."""
        return (AlignedObservation if self.config.knows_delay else WorldObservation)(self.world)
