"""Perception from the simulator's state: percepts as good and as bad as those from images, without rendering.

It is meant for sweeps, and the only part of perception that knows the world. The face pattern is the direction of the
caregiver's head instead of a grey patch. Errors are those that were measured for perception from images
(``experiments/perception``).
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
    """Noise, misses and false alarms. Defaults are those of perception from images, measured in closed loop over six
    caregivers by ``python -m experiments.perception.measure``."""

    face_noise_px: Annotated[float, Real("[0, 1000]")] = 0.55
    """Standard deviation of the face's position on each axis, pixels."""
    face_miss: Share = 0.0
    """Probability that a visible face is not detected."""
    object_noise_px: Annotated[float, Real("[0, 1000]")] = 0.25
    """Standard deviation of an object's position on each axis, pixels."""
    object_miss: Share = 0.0005
    """Probability that a visible object is not detected."""
    pattern_noise_deg: Spread = 1.03
    """Standard deviation of yaw and pitch in the face pattern, degrees: how well the map can tell faces apart."""
    face_moves_above_deg_s: Annotated[float, Real("[0, 1e6]")] = 4.0
    """Speed of the caregiver's head above which the face moves, degrees per second."""
    object_moves_above_m_s: Annotated[float, Real("[0, 1e6]")] = 0.05
    """Speed above which an object moves, metres per second."""
    face_motion_hit: Share = 0.977
    """Probability that the motion of a turning face is detected."""
    face_motion_false_alarm: Share = 0.025
    """Probability that motion is detected in a still face."""
    object_motion_hit: Share = 0.983
    """Probability that the motion of a moving object is detected."""
    object_motion_false_alarm: Share = 0.012
    """Probability that motion is detected in a still object."""


class StatePerception:
    """Percepts from the world's state and the camera's geometry."""

    pattern_size = 2

    def __init__(self, config: StateConfig, world: World, rng: np.random.Generator):
        """Perceive a world.

        Args:
            config: Noise, misses and false alarms.
            world: The world.
            rng: Draws the errors.
        """
        self.config, self._world, self._rng = config, world, rng
        objects = len(world.config.scene.objects)
        face = np.arange(objects + 1) == objects
        self._noise = np.where(face, config.face_noise_px, config.object_noise_px)[:, None]
        self._miss = np.where(face, config.face_miss, config.object_miss)
        self._hit = np.where(face, config.face_motion_hit, config.object_motion_hit)
        self._alarm = np.where(face, config.face_motion_false_alarm, config.object_motion_false_alarm)

    def perceive(self, observation: Observation, landed: bool) -> Percept:
        """The percept of this frame; see ``perception.percept.Perceiver``.

        Args:
            observation: Only the head's angles are read, rad.
            landed: Whether the head has just come to rest; then no motion is detected, as with images.
        """
        pixels = pixels_of_points(self._world.candidate_points(), np.degrees(observation.head_angles))
        draws = self._rng.random((2, len(pixels)))
        visible = in_image(pixels) & (draws[0] >= self._miss)
        pixels += self._noise * self._rng.standard_normal(pixels.shape)
        pixels[~visible] = np.nan
        moving = self._world.moving(self.config.face_moves_above_deg_s, self.config.object_moves_above_m_s)
        moves = visible & (draws[1] < np.where(moving, self._hit, self._alarm)) & (not landed)
        return Percept(visible=visible, px=pixels, moves=moves)

    def face_pattern(self) -> np.ndarray:
        """Yaw and pitch of the caregiver's head (2,), degrees, with noise, in place of the 32x32 patch f_v."""
        return self._world.face_angles_deg() + self.config.pattern_noise_deg * self._rng.standard_normal(2)
