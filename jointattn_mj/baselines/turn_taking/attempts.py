"""The interaction of the earlier work, attempt by attempt.

The caregiver looks at one of the objects and tells the robot to shift its gaze. The robot, which has looked at the
caregiver's face, moves its head step by step. The attempt ends when an object is at the centre of view; it fails when
the steps are used up and the head points at nothing. Then all objects are placed anew.

Objects are perceived by the camera's geometry, with the noise and misses that were measured for images. Faces come from
a bank of rendered ones (``turn_taking.faces``).
"""

from dataclasses import dataclass

import numpy as np

from jointattn_mj.baselines.turn_taking.agent import (
    AttemptOptions,
    Network,
    TurnTaker,
    backpropagate,
    face_drive,
    feedback_target,
    network_command,
)
from jointattn_mj.baselines.turn_taking.faces import FACE_DIRECTION, FaceInputs
from jointattn_mj.errors import ObservationError
from jointattn_mj.guards.border import numbers, require_array
from jointattn_mj.io.compiled import njit
from jointattn_mj.perception.state import StateConfig
from jointattn_mj.scene import camera
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH, rest_height
from jointattn_mj.scene.world import WorldConfig

_pixel_of = njit(camera.pixel_of)
_direction_of = njit(camera.direction_of)
_off_centre = njit(camera.off_centre)
BESIDE_DEG = 80.0
"""Farther to the side, degrees, nothing is in the image and no pixel is defined."""


@dataclass(frozen=True)
class AttemptSituations:
    """T layouts of n objects each."""

    directions: np.ndarray  # (T, n, 2) of the objects from the robot, deg
    face: np.ndarray  # (T, n) index of the face pattern of a caregiver who looks at that object

    @classmethod
    def of_locations(
        cls, locations: np.ndarray, faces: FaceInputs, jitter_deg: float, rng: np.random.Generator
    ) -> "AttemptSituations":
        """Situations with the caregiver looking at each object in turn.

        Args:
            locations: (T, n, 2) of objects on the table, m.
            faces: Bank of faces.
            jitter_deg: Jitter of gaze before the nearest face is taken, degrees.
            rng: For the jitter.
        """
        height = np.full((*locations.shape[:-1], 1), rest_height(WorldConfig().scene))
        points = np.concatenate([locations, height], axis=-1)
        directions = camera.directions_to(points.reshape(-1, 3)).reshape(locations.shape)
        return cls(directions, faces.of_locations(locations, jitter_deg, rng))


@dataclass(frozen=True)
class Outcomes:
    """Results of n attempts, each array (n,)."""

    right: np.ndarray  # bool: the caregiver's object is at the centre of view
    reached: np.ndarray  # bool: some object is
    in_view: np.ndarray  # bool: the caregiver's object was in view when the attempt began
    movements: np.ndarray  # int: steps of the head


def run_attempts(
    robot: TurnTaker,
    situations: AttemptSituations,
    faces: FaceInputs,
    attempts: int,
    rng: np.random.Generator,
    learning: bool = True,
    senses: StateConfig | None = None,
) -> Outcomes:
    """Let a robot make some attempts, each with a random layout and a random object.

    Args:
        robot: Robot, which learns.
        situations: Layouts.
        faces: Bank of faces.
        attempts: How many.
        rng: For all choices and noise.
        learning: False to leave network and learning time as they are.
        senses: Noise and misses; default as measured.

    Raises:
        ObservationError: There is no table, or faces and directions do not fit each other and the robot.
    """
    senses = senses or StateConfig()
    tables = situations.face.shape
    require_array("faces of situations", situations.face, tables, "iu", 0, len(faces.patterns) - 1)
    require_array("directions of situations", situations.directions, (*tables, 2), "f", -360, 360)
    numbers("face patterns", faces.patterns, (-1, robot.network.face.shape[1]))
    if attempts < 0 or not situations.face.size:
        raise ObservationError(f"expected 0 attempts or more and a table with an object; got {attempts}, {tables}")
    results = np.zeros((attempts, 4), np.uint8)
    _run_attempts(
        robot.network, robot.options(), robot.gate(attempts), situations.directions, situations.face, faces.patterns,
        FACE_DIRECTION, senses.object_noise_px, senses.object_miss, learning, rng, results,
    )  # fmt: skip
    robot.time += attempts * learning
    right, reached, in_view = results[:, :3].T.astype(bool)
    return Outcomes(right, reached, in_view, results[:, 3])


@njit
def _run_attempts(
    network: Network, options: AttemptOptions, gate: np.ndarray, directions: np.ndarray, face_index: np.ndarray,
    patterns: np.ndarray, start: np.ndarray, noise: float, miss: float, learning: bool, rng: np.random.Generator,
    results: np.ndarray,
) -> None:  # fmt: skip
    tables, objects = face_index.shape
    for k in range(len(gate)):
        table, target = int(rng.random() * tables), int(rng.random() * objects)
        face = patterns[face_index[table, target]]
        results[k] = _attempt(
            network, options, gate[k], directions[table], target, face, start, noise, miss, learning, rng
        )


@njit
def _attempt(
    network: Network,
    options: AttemptOptions,
    gate: float,
    directions: np.ndarray,
    target: int,
    face: np.ndarray,
    start: np.ndarray,
    noise: float,
    miss: float,
    learning: bool,
    rng: np.random.Generator,
) -> np.ndarray:
    """One attempt: (4,) right, reached, in view at first, number of movements."""
    heads = np.empty((options.steps + 1, 2))
    heads[0] = start
    interest = rng.random(len(directions))
    by_network = rng.random() < gate
    drive = face_drive(network, face)
    visible, locations, off = _look(directions, heads[0], noise, miss, rng)
    result = np.zeros(4, np.uint8)
    result[2] = visible[target]
    last, chosen, moved = 0, -1, False
    while last < options.steps:
        head = heads[last]
        if options.draws_each_step:
            by_network = rng.random() < gate
        chosen = feedback_target(options.feedback, visible, off, interest, chosen, moved)
        if by_network or (chosen < 0 and options.network_searches):
            pan, tilt = network_command(network, drive, head, options.scale)
            moved = True
        elif chosen >= 0:
            pan, tilt = locations[chosen, 0] - head[0], locations[chosen, 1] - head[1]
        else:
            pan, tilt = 0.0, 0.0
        last += 1
        heads[last, 0] = min(max(head[0] + options.gain * pan, -options.pan_limit), options.pan_limit)
        heads[last, 1] = min(max(head[1] + options.gain * tilt, options.tilt_low), options.tilt_high)
        visible, locations, off = _look(directions, heads[last], noise, miss, rng)
        if options.ends_first and off.min() <= options.centre_radius_deg:
            break
    nearest = int(off.argmin())
    result[3] = last
    if off[nearest] <= options.centre_radius_deg:
        result[0], result[1] = nearest == target, True
        if learning:
            end = locations[nearest] if options.object_reference else heads[last]
            pairs = last if options.every_step else 1
            backpropagate(network, face, drive, heads[:pairs], end - heads[:pairs], options.scale, options.rate)
    return result


@njit
def _look(
    directions: np.ndarray, head: np.ndarray, noise: float, miss: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Visible objects (n,), their directions (n, 2), deg, and distances from the centre of view (n,), deg or inf."""
    count = len(directions)
    visible, locations, off = np.zeros(count, np.bool_), np.zeros((count, 2)), np.full(count, np.inf)
    for i in range(count):
        if abs(directions[i, 0] - head[0]) > BESIDE_DEG:
            continue
        pixel = _pixel_of(directions[i], head)
        inside = -0.5 <= pixel[0] <= IMAGE_WIDTH - 0.5 and -0.5 <= pixel[1] <= IMAGE_HEIGHT - 0.5
        if inside and rng.random() >= miss:
            pixel[0] += noise * rng.standard_normal()
            pixel[1] += noise * rng.standard_normal()
            visible[i] = True
            locations[i] = _direction_of(pixel, head)
            off[i] = _off_centre(locations[i], head)
    return visible, locations, off
