"""Perception from the simulator's state: percepts as good and as bad as those from images, without rendering.

It is meant for sweeps, and the only part of perception that knows the world. The face pattern is the direction of the
caregiver's head instead of a grey patch. Errors are those that were measured for perception from images
(``experiments/perception``).
"""

from dataclasses import dataclass
from math import cos, degrees, radians, sin
from typing import Annotated, Any

import numpy as np

from jointattn_mj.guards.restored import check_array
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked, Real, Share, Spread
from jointattn_mj.perception.percept import Observation, Percept
from jointattn_mj.scene.camera import CENTRE_X, CENTRE_Y, FOCAL_PX, PIVOT
from jointattn_mj.scene.caregiver import FRAME_S
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH
from jointattn_mj.scene.motion import note_moves
from jointattn_mj.scene.tape import Tape
from jointattn_mj.scene.world import World

_X, _Y, _Z = PIVOT.tolist()


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
        self._errors = np.array([
            np.where(face, config.face_noise_px, config.object_noise_px),
            np.where(face, config.face_miss, config.object_miss),
            np.where(face, config.face_motion_hit, config.object_motion_hit),
            np.where(face, config.face_motion_false_alarm, config.object_motion_false_alarm),
        ])  # fmt: skip

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore it.

        Raises:
            ValueError: Compiled code cannot use it.
        """
        self.__dict__.update(state)
        count = len(self._world.config.scene.objects) + 1
        check_array("errors", self._errors, (4, count), float)

    def perceive(self, observation: Observation, landed: bool) -> Percept:
        """The percept of this frame; see ``perception.percept.Perceiver``.

        Args:
            observation: Only the head's angles are read, rad.
            landed: Whether the head has just come to rest; then no motion is detected, as with images.
        """
        percepts = self._percepts(self._world.now(), observation.head_angles[None], landed)
        return Percept(percepts.visible[0], percepts.px[0], percepts.moves[0])

    def perceive_all(self, tape: Tape) -> Percept:
        """The percepts of k successive frames of fixation, as ``perceive`` gives them one by one.

        Args:
            tape: The frames.

        Returns:
            Arrays with an axis of k before the others.
        """
        return self._percepts(tape, tape.head, landed=False)

    def _percepts(self, tape: Tape, heads: np.ndarray, landed: bool) -> Percept:
        """Percepts, with an axis of k before the others, of k frames with the head at ``heads`` (k, 2), rad."""
        config, frames, n = self.config, len(tape), self._errors.shape[1]
        draws, noise = np.empty((frames, 2, n)), np.empty((frames, n, 2))
        for frame in range(frames):
            self._rng.random(out=draws[frame])
            self._rng.standard_normal(out=noise[frame])
        percepts = Percept(
            visible=np.empty((frames, n), bool), px=np.empty((frames, n, 2)), moves=np.empty((frames, n), bool)
        )
        _perceive(
            tape.objects, tape.face_speeds, self._world.candidate_points(), heads, landed,
            radians(config.face_moves_above_deg_s), (config.object_moves_above_m_s * FRAME_S) ** 2,
            draws, noise, self._errors, percepts.visible, percepts.px, percepts.moves,
        )  # fmt: skip
        return percepts

    def face_pattern(self) -> np.ndarray:
        """Yaw and pitch of the caregiver's head (2,), degrees, with noise, in place of the 32x32 patch f_v."""
        return self._world.face_angles_deg() + self.config.pattern_noise_deg * self._rng.standard_normal(2)


@njit(cache=True)
def _perceive(
    objects: np.ndarray, face_speeds: np.ndarray, points: np.ndarray, heads: np.ndarray, landed: bool,
    face_above: float, path_above: float, draws: np.ndarray, noise: np.ndarray, errors: np.ndarray,
    visible: np.ndarray, px: np.ndarray, moves: np.ndarray,
) -> None:  # fmt: skip
    """Write the percepts of a tape's frames, as ``pixels_of_points`` sees them, with errors, to the bit as numpy would.

    ``points`` are the objects, which are moved, and the face.
    """
    last = len(points) - 1
    if not len(objects) - 1 == len(heads) == len(face_speeds) or objects.shape[1:] != (last, 3) or heads.shape[1] != 2:
        raise ValueError("the parts of a tape do not fit each other, or the world's objects")
    moving = np.empty(last + 1, np.bool_)
    for t in range(len(heads)):
        for k in range(last):
            for axis in range(3):
                points[k, axis] = objects[t + 1, k, axis]
        note_moves(objects[t + 1], objects[t], face_speeds[t], face_above, path_above, moving)
        pan, tilt = radians(degrees(heads[t, 0])), radians(degrees(heads[t, 1]))
        cos_pan, sin_pan, cos_tilt, sin_tilt = cos(pan), sin(pan), cos(tilt), sin(tilt)
        for k in range(last + 1):
            x, y, z = points[k, 0] - _X, points[k, 1] - _Y, points[k, 2] - _Z
            ahead = cos_pan * x + sin_pan * y
            depth, up = cos_tilt * ahead + sin_tilt * z, cos_tilt * z - sin_tilt * ahead
            left = cos_pan * y - sin_pan * x
            right, down = CENTRE_X - FOCAL_PX * left / depth, CENTRE_Y - FOCAL_PX * up / depth
            inside = -0.5 <= right <= IMAGE_WIDTH - 0.5 and -0.5 <= down <= IMAGE_HEIGHT - 0.5
            visible[t, k] = inside and draws[t, 0, k] >= errors[1, k]
            px[t, k, 0] = right + errors[0, k] * noise[t, k, 0] if visible[t, k] else np.nan
            px[t, k, 1] = down + errors[0, k] * noise[t, k, 1] if visible[t, k] else np.nan
            moves[t, k] = visible[t, k] and not landed and draws[t, 1, k] < errors[2 if moving[k] else 3, k]
