"""The same ``Percept`` from the simulator's state, as well and as badly as the pixel path sees it.

The only part of a robot's path that knows the world. It renders nothing and is meant for sweeps; its face pattern is
the caregiver's head direction instead of a grey patch, and its errors are those that the pixel path was measured to
make (``experiments/perception``).
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from jointattn_mj.options import Checked, Real, Share, Spread
from jointattn_mj.perception.percept import Observation, Percept
from jointattn_mj.scene.camera import in_image, pixels_of_points
from jointattn_mj.scene.world import World


@dataclass(frozen=True)
class StateConfig(Checked):
    """Noise, misses and false alarms; defaults are the pixel path's, measured in closed loop over six caregivers by
    ``python -m experiments.perception.measure``."""

    face_noise_px: Annotated[float, Real("[0, 1000]")] = 0.55
    """Standard deviation of the face's place, each axis."""
    face_miss: Share = 0.0
    """Chance that a visible face is not found."""
    object_noise_px: Annotated[float, Real("[0, 1000]")] = 0.25
    """Standard deviation of an object's place, each axis."""
    object_miss: Share = 0.0005
    """Chance that a visible object is not found."""
    pattern_noise_deg: Spread = 1.03
    """Standard deviation of head yaw and pitch in the face pattern: how well the SOM can tell faces apart."""
    face_moves_above_deg_s: Annotated[float, Real("[0, 1e6]")] = 4.0
    """Head speed that counts as motion."""
    object_moves_above_m_s: Annotated[float, Real("[0, 1e6]")] = 0.05
    """Object speed that counts as motion."""
    face_motion_hit: Share = 0.977
    """Chance that a turning face is seen to move."""
    face_motion_false_alarm: Share = 0.025
    """Chance that a still face is seen to move."""
    object_motion_hit: Share = 0.983
    """Chance that a moving object is seen to move."""
    object_motion_false_alarm: Share = 0.012
    """Chance that a still object is seen to move."""


class StatePerception:
    """Looks at the world's state through the camera's geometry."""

    pattern_size = 2

    def __init__(self, config: StateConfig, world: World, rng: np.random.Generator):
        self.config, self._world, self._rng = config, world, rng
        objects = len(world.config.scene.objects)
        face = np.arange(objects + 1) == objects
        self._noise = np.where(face, config.face_noise_px, config.object_noise_px)[:, None]
        self._miss = np.where(face, config.face_miss, config.object_miss)
        self._hit = np.where(face, config.face_motion_hit, config.object_motion_hit)
        self._alarm = np.where(face, config.face_motion_false_alarm, config.object_motion_false_alarm)

    def perceive(self, observation: Observation, landed: bool) -> Percept:
        """The percept of this frame; just landed, nothing is seen to move, as in the pixel path."""
        pixels = pixels_of_points(self._world.candidate_points(), np.degrees(observation.head_angles))
        draws = self._rng.random((2, len(pixels)))
        visible = in_image(pixels) & (draws[0] >= self._miss)
        pixels += self._noise * self._rng.standard_normal(pixels.shape)
        pixels[~visible] = np.nan
        moving = self._world.moving(self.config.face_moves_above_deg_s, self.config.object_moves_above_m_s)
        moves = visible & (draws[1] < np.where(moving, self._hit, self._alarm)) & (not landed)
        return Percept(visible=visible, px=pixels, moves=moves)

    def face_pattern(self) -> np.ndarray:
        """Yaw and pitch of her head (2,), deg, with noise: stands for the 32x32 patch f_v."""
        return self._world.face_angles_deg() + self.config.pattern_noise_deg * self._rng.standard_normal(2)
