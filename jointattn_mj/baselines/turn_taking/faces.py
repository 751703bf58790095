"""Faces for turn taking: rendered once, detected by the robot's own detector, used many times.

A run of 300,000 attempts cannot render an image for each. A bank of face patterns is made first: the caregiver looks at
thousands of locations on the table, the camera renders the face, and ``PixelPerception`` detects it and cuts out the
32 x 32 grey patch f_v, as in a session. An attempt takes the pattern whose gaze direction is nearest to that of the
attempt's object, after a small jitter. How well this carries over to new faces is tested on a second bank.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from jointattn_mj.baselines.turn_taking.layouts import TABLE, draw_locations
from jointattn_mj.errors import ObservationError
from jointattn_mj.guards.border import numbers
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked, Spread, Whole
from jointattn_mj.perception.pixels import PixelConfig, PixelPerception
from jointattn_mj.perception.sitter import Sitter
from jointattn_mj.perception.som import standardised
from jointattn_mj.scene.camera import directions_to
from jointattn_mj.scene.model import HEAD_POSITION, rest_height
from jointattn_mj.scene.movement import gaze_angles
from jointattn_mj.scene.world import World, WorldConfig

FACE_DIRECTION = directions_to(np.array([HEAD_POSITION]))[0]
"""Direction (2,) of the face from the robot, deg: where its head stands when an attempt begins."""


@dataclass(frozen=True)
class FaceBankConfig(Checked):
    """How a bank of faces is made."""

    faces: Annotated[int, Whole("[2, 1e6]")] = 3000
    """Number of patterns; 3000 over the table are less than a degree of gaze apart."""
    familiar: Annotated[int, Whole("[1, 1e6]")] = 300
    """Images before them, from which the detector learns views of the face."""
    head_noise_deg: Spread = 0.5
    """Standard deviation of the robot's head about the face's direction, degrees: the face then lies on all fractions
    of a pixel."""
    jitter_deg: Spread = 0.5
    """Standard deviation of the jitter of a gaze direction before the nearest pattern is taken, degrees."""


@dataclass(frozen=True)
class FaceBank:
    """Face patterns and the gaze directions that they show."""

    patches: np.ndarray  # (m, 1024) float32 grey values 0..255, as cut out by the detector
    gaze: np.ndarray  # (m, 2) yaw and pitch of the line of sight, deg

    def inputs(self, length: float, mean: np.ndarray | None = None, scale: float | None = None) -> "FaceInputs":
        """Network inputs: standardised patches less their mean, scaled to a root mean square length.

        Args:
            length: Root mean square length of the inputs.
            mean: (d,) mean of another bank, whose robot looks at this one.
            scale: Scale of that bank.
        """
        patterns = np.stack([standardised(patch) for patch in self.patches])
        mean = patterns.mean(axis=0) if mean is None else mean
        patterns -= mean
        scale = length / float(np.sqrt(np.square(patterns).sum(axis=1).mean())) if scale is None else scale
        return FaceInputs(np.ascontiguousarray(patterns * np.float32(scale)), self.gaze, mean, scale)


@dataclass(frozen=True)
class FaceInputs:
    """A bank as inputs of the network."""

    patterns: np.ndarray  # (m, d) float32
    gaze: np.ndarray  # (m, 2) deg
    mean: np.ndarray
    scale: float

    def of_locations(self, locations: np.ndarray, jitter_deg: float, rng: np.random.Generator) -> np.ndarray:
        """Indices of patterns that look at locations on the table.

        Args:
            locations: (..., 2) locations, m.
            jitter_deg: Standard deviation of the jitter of gaze, degrees.
            rng: For the jitter.

        Returns:
            (...,) int.
        """
        gaze = gaze_deg(locations).reshape(-1, 2)
        gaze = gaze + jitter_deg * rng.standard_normal(gaze.shape)
        numbers("gaze of the face bank", self.gaze, (-1, 2))
        if not len(self.gaze):
            raise ObservationError("a face bank needs a face or more; got none")
        nearest: np.ndarray = _nearest(numbers("gaze", gaze, gaze.shape), np.ascontiguousarray(self.gaze))
        return nearest.reshape(locations.shape[:-1])


def gaze_deg(locations: np.ndarray) -> np.ndarray:
    """Yaw and pitch (..., 2) of the caregiver's gaze at objects at ``locations`` (..., 2) on the table, deg."""
    height = np.full((*locations.shape[:-1], 1), rest_height(WorldConfig().scene))
    own = (np.concatenate([locations, height], axis=-1) - HEAD_POSITION) * (-1.0, -1.0, 1.0)
    gaze: np.ndarray = np.degrees(gaze_angles(np.zeros(3), own))
    return gaze


@njit(cache=True)
def _nearest(points: np.ndarray, bank: np.ndarray) -> np.ndarray:
    nearest = np.empty(len(points), np.int64)
    for i in range(len(points)):
        best = np.inf
        for j in range(len(bank)):
            distance = (points[i, 0] - bank[j, 0]) ** 2 + (points[i, 1] - bank[j, 1]) ** 2
            if distance < best:
                best, nearest[i] = distance, j
    return nearest


def render_faces(config: FaceBankConfig, rng: np.random.Generator, world: WorldConfig | None = None) -> FaceBank:
    """Let the caregiver look at random locations of the table, and collect the face.

    Args:
        config: Size and noise of the bank.
        rng: For locations and noise.
        world: Scene; default as in a session.

    Raises:
        GLError: No image can be rendered here.
    """
    locations = draw_locations(TABLE, config.faces, rng)
    gaze = gaze_deg(locations)
    locations, gaze = locations[np.argsort(gaze[:, 0])], gaze[np.argsort(gaze[:, 0])]  # the head turns little by little
    config_of_world = world or WorldConfig()
    stage = World.build(config_of_world, np.random.SeedSequence(0))
    try:
        colours = np.array([item.rgb for item in config_of_world.scene.objects])
        sitter = Sitter(stage, config_of_world.behaviour.head_share, PixelPerception(PixelConfig(), colours))
        middle = len(gaze) // 2
        sitter.pattern(np.zeros(2), FACE_DIRECTION)  # a frontal face, which the detector needs to begin with
        for i in range(config.familiar):
            sitter.pattern(gaze[middle + round((middle - 1) * np.sin(i / 20))], FACE_DIRECTION)
        patches = [
            sitter.pattern(sight, FACE_DIRECTION + config.head_noise_deg * rng.standard_normal(2)) for sight in gaze
        ]
    finally:
        stage.close()
    detected = np.array([patch is not None for patch in patches])
    return FaceBank(np.array([patch for patch in patches if patch is not None], np.float32), gaze[detected])
