"""The robot of the earlier work (reference [19] of the dissertation): a three-layered network, visual feedback, a gate.

It is told when to shift its gaze. It sees the caregiver's face once, then moves its head in several steps. In each step
the gate takes the command of the network or that of visual feedback. When an object, right or wrong, has come to the
centre of view, the network learns from the attempt. Directions are pairs (pan, tilt) in degrees.

The functions are compiled, since a run has 300,000 attempts; each can be called by itself.
"""

from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import numba
import numpy as np

from jointattn_mj.errors import ConfigError, ObservationError
from jointattn_mj.guards.border import checked_by, require_array
from jointattn_mj.options import Angle, Checked, Positive, Real, Whole

MOST = 1e6
"""Largest absolute value of faces, angles and movements."""
FEEDBACK = ("nearest", "kept", "interest")
"""Choices of ``TurnTakerConfig.feedback``."""
NEAREST, KEPT, INTEREST = range(3)
"""Their numbers in compiled code."""


@dataclass(frozen=True)
class TurnTakerConfig(Checked):
    """Settings of the robot; all are choices that the account of the earlier work leaves open."""

    hidden: Annotated[int, Whole("[1, 10000]")] = 30
    """Units of the hidden layer (tanh). 10 to 40 gave the same in trials."""
    rate: Annotated[float, Real("(0, 10]")] = 0.002
    """Learning rate of backpropagation, one step an attempt. A large rate follows the last object instead of the
    average over many; with ten objects .003 left some robots at chance."""
    face_length: Annotated[float, Real("(0, 1e6]")] = 10.0
    """Root mean square length of the face input after its mean is subtracted. It decides how fast the face's weights
    learn compared with those of the two head angles."""
    angle_scale_deg: Annotated[float, Real("[0.01, 360]")] = 30.0
    """Unit of head angles and movements in the network, degrees."""
    first_face_weight: Annotated[float, Real("[0, 100]")] = 0.02
    """Standard deviation of the face's initial weights."""
    first_weight: Annotated[float, Real("[0, 100]")] = 0.1
    """Standard deviation of all other initial weights."""
    gain: Annotated[float, Real("(0, 1]")] = 0.9
    """g, share of the commanded movement that one step makes. With .5 and ten objects three of eight robots lost
    everything when the gate opened, since they no longer came near any object."""
    steps: Annotated[int, Whole("[1, 10000]")] = 6
    """Movements in an attempt."""
    centre_radius_deg: Annotated[float, Real("(0, 180]")] = 3.5
    """d_th, degrees: an object so near to the centre of view is gazed at; as in chapter 6."""
    ends: Literal["last", "first"] = "last"
    """When an attempt ends. ``last``: after the last step. ``first``: as soon as an object is within d_th of the
    centre, which may be one on the way: with ten objects .30 right in the end instead of .88."""
    feedback: Literal["nearest", "kept", "interest"] = "nearest"
    """Object to which visual feedback moves the head. Interests are drawn for each attempt. ``nearest``: the most
    interesting one until the network has moved the head, then the one nearest to the centre of view. ``kept``: the
    first one as long as it is visible. ``interest``: in each step the most interesting one that is visible. All three
    learn, ``nearest`` fastest (see ``experiments/turn_taking``)."""
    reference: Literal["object", "executed"] = "object"
    """Movement that is learned. ``object``: the one that would have centred the object. ``executed``: the one that was
    made, which confirms whatever the network does and drifts until nothing is reached."""
    learns_from: Literal["every_step", "first_step"] = "every_step"
    """Pairs of an attempt: one for each head position, or only the first. With the first alone the network never learns
    what to do on the way, and nothing comes to the centre."""
    without_target: Literal["stay", "network"] = "stay"
    """What happens when visual feedback commands and no object is visible: the head stays, or the network commands."""
    gate: Literal["sigmoid", "shut", "open"] = "sigmoid"
    """``sigmoid``: the gate opens with learning time. ``shut``: visual feedback commands. ``open``: the network."""
    gate_midpoint: Annotated[float, Real("[-1e9, 1e9]")] = 60_000.0
    """Attempts after which the network's command is taken with probability 1/2."""
    gate_width: Positive = 20_000.0
    """Attempts over which the gate opens, as q in eq. 6.8."""
    gate_draws: Literal["step", "attempt"] = "step"
    """Whether the gate chooses in each step, or once for an attempt. Once an attempt, all robots lost everything when
    it opened: visual feedback never helps at the end of an attempt that the network began."""
    pan_limit_deg: Annotated[float, Real("[0, 180]")] = 60.0
    """Largest pan to either side, degrees."""
    tilt_limits_deg: tuple[Angle, Angle] = (-40.0, 20.0)
    """Lowest and highest tilt, degrees."""

    def __post_init__(self) -> None:
        super().__post_init__()
        low, high = self.tilt_limits_deg
        if not low < high:
            raise ConfigError(f"turn_taker.tilt_limits_deg must be a lower and a higher angle; got {low}, {high}")


class Network(NamedTuple):
    """Weights of the three-layered network, float32. Inputs: a face (d,) and two head angles; output: a movement."""

    face: np.ndarray  # (hidden, d)
    head: np.ndarray  # (hidden, 2)
    threshold: np.ndarray  # (hidden,)
    out: np.ndarray  # (2, hidden)
    out_threshold: np.ndarray  # (2,)


class AttemptOptions(NamedTuple):
    """A ``TurnTakerConfig`` as numbers, for compiled code."""

    gain: float
    steps: int
    centre_radius_deg: float
    ends_first: bool
    feedback: int
    object_reference: bool
    every_step: bool
    network_searches: bool
    draws_each_step: bool
    scale: float
    rate: float
    pan_limit: float
    tilt_low: float
    tilt_high: float


class TurnTaker:
    """Network and learning time of one robot.

    Attributes:
        network: Its weights.
        time: Attempts so far, on which the gate depends.
    """

    def __init__(self, config: TurnTakerConfig, inputs: int, rng: np.random.Generator):
        """Draw the initial weights.

        Args:
            config: Settings.
            inputs: Size of a face.
            rng: For the weights.
        """
        self.config, self.time = config, 0

        def draw(sd: float, *shape: int) -> np.ndarray:
            return (sd * rng.standard_normal(shape)).astype(np.float32)

        self.network = Network(
            draw(config.first_face_weight, config.hidden, inputs),
            draw(config.first_weight, config.hidden, 2),
            draw(config.first_weight, config.hidden),
            draw(config.first_weight, 2, config.hidden),
            np.zeros(2, np.float32),
        )

    def options(self) -> AttemptOptions:
        """The config as numbers."""
        config = self.config
        return AttemptOptions(
            config.gain, config.steps, config.centre_radius_deg, config.ends == "first",
            FEEDBACK.index(config.feedback), config.reference == "object", config.learns_from == "every_step",
            config.without_target == "network", config.gate_draws == "step", config.angle_scale_deg, config.rate,
            config.pan_limit_deg, *config.tilt_limits_deg,
        )  # fmt: skip

    def gate(self, attempts: int) -> np.ndarray:
        """(attempts,) probability that the network's command is taken in each of the next attempts."""
        config = self.config
        if config.gate != "sigmoid":
            return np.full(attempts, float(config.gate == "open"))
        time = self.time + np.arange(attempts)
        chance: np.ndarray = 1 / (1 + np.exp((config.gate_midpoint - time) / config.gate_width))
        return chance

    def movement(self, face: np.ndarray, head: np.ndarray) -> np.ndarray:
        """The network's command (2,), deg, for a ``face`` (d,) and a head at ``head`` (2,), deg."""
        drive = face_drive(self.network, face)
        return np.array(network_command(self.network, drive, head, self.config.angle_scale_deg))

    def learn(self, face: np.ndarray, heads: np.ndarray, movements: np.ndarray) -> None:
        """One step of backpropagation.

        Args:
            face: (d,) the same in all pairs.
            heads: (k, 2) head angles, deg.
            movements: (k, 2) movements that they should lead to, deg.
        """
        drive = face_drive(self.network, face)
        backpropagate(self.network, face, drive, heads, movements, self.config.angle_scale_deg, self.config.rate)


def _check_face(network: Network, face: np.ndarray) -> None:
    require_array("face", face, network.face.shape[1:], "f", -MOST, MOST)


@checked_by(_check_face)
@numba.njit(fastmath=True, cache=True)
def face_drive(network: Network, face: np.ndarray) -> np.ndarray:
    """Input of each hidden unit from the face, (hidden,); it is the same in all steps of an attempt."""
    drive = network.threshold.copy()
    for unit in range(drive.size):
        total = np.float32(0)
        for i in range(face.size):
            total += network.face[unit, i] * face[i]
        drive[unit] += total
    return drive


def _check_command(network: Network, drive: np.ndarray, head: np.ndarray, scale: float) -> None:
    require_array("drive", drive, network.threshold.shape, "f")
    require_array("head", head, (2,), "f", -MOST, MOST)


@checked_by(_check_command)
@numba.njit(cache=True)
def network_command(network: Network, drive: np.ndarray, head: np.ndarray, scale: float) -> tuple[float, float]:
    """The network's output.

    Args:
        network: Weights.
        drive: (hidden,) of ``face_drive``.
        head: (2,) head angles, deg.
        scale: Unit of angles in the network, deg.

    Returns:
        Pan and tilt by which to move, deg.
    """
    pan, tilt = float(network.out_threshold[0]), float(network.out_threshold[1])
    for unit in range(drive.size):
        active = np.tanh(drive[unit] + (network.head[unit, 0] * head[0] + network.head[unit, 1] * head[1]) / scale)
        pan += network.out[0, unit] * active
        tilt += network.out[1, unit] * active
    return pan * scale, tilt * scale


def _check_pairs(
    network: Network, face: np.ndarray, drive: np.ndarray, heads: np.ndarray, movements: np.ndarray, *rates: float
) -> None:
    _check_face(network, face)
    require_array("drive", drive, network.threshold.shape, "f")
    require_array("heads", heads, (-1, 2), "f", -MOST, MOST)
    require_array("movements", movements, heads.shape, "f", -MOST, MOST)


@checked_by(_check_pairs)
@numba.njit(fastmath=True, cache=True)
def backpropagate(
    network: Network,
    face: np.ndarray,
    drive: np.ndarray,
    heads: np.ndarray,
    movements: np.ndarray,
    scale: float,
    rate: float,
) -> None:
    """One gradient step on half the squared error, summed over the pairs of an attempt.

    Args:
        network: Weights, changed in place.
        face: (d,) the same in all pairs.
        drive: (hidden,) of ``face_drive``.
        heads: (k, 2) head angles, deg.
        movements: (k, 2) movements that they should lead to, deg.
        scale: Unit of angles in the network, deg.
        rate: Learning rate.
    """
    hidden = drive.size
    to_face = np.zeros(hidden)
    to_head, to_out, to_out_threshold = np.zeros((hidden, 2)), np.zeros((2, hidden)), np.zeros(2)
    active = np.zeros(hidden)
    for k in range(len(heads)):
        error = np.array([movements[k, 0] / scale, movements[k, 1] / scale])
        error[0] -= network.out_threshold[0]
        error[1] -= network.out_threshold[1]
        for unit in range(hidden):
            way = network.head[unit, 0] * heads[k, 0] + network.head[unit, 1] * heads[k, 1]
            active[unit] = np.tanh(drive[unit] + way / scale)
            error[0] -= network.out[0, unit] * active[unit]
            error[1] -= network.out[1, unit] * active[unit]
        to_out_threshold += error
        for unit in range(hidden):
            back = (error[0] * network.out[0, unit] + error[1] * network.out[1, unit]) * (1 - active[unit] ** 2)
            to_face[unit] += back
            for axis in range(2):
                to_out[axis, unit] += error[axis] * active[unit]
                to_head[unit, axis] += back * heads[k, axis] / scale
    for axis in range(2):
        network.out_threshold[axis] += rate * to_out_threshold[axis]
    for unit in range(hidden):
        step = np.float32(rate * to_face[unit])
        network.threshold[unit] += step
        for axis in range(2):
            network.out[axis, unit] += rate * to_out[axis, unit]
            network.head[unit, axis] += rate * to_head[unit, axis]
        for i in range(face.size):
            network.face[unit, i] += step * face[i]


def _check_target(
    feedback: int, visible: np.ndarray, off: np.ndarray, interest: np.ndarray, kept: int, by_network: bool
) -> None:
    require_array("visible", visible, (-1,), "b")
    require_array("off", off, visible.shape, "f")
    require_array("interest", interest, visible.shape, "f")
    if not -1 <= kept < len(visible):
        raise ObservationError(f"kept: expected one of {len(visible)} objects, or -1; got {kept}")


@checked_by(_check_target)
@numba.njit(cache=True)
def feedback_target(
    feedback: int, visible: np.ndarray, off: np.ndarray, interest: np.ndarray, kept: int, by_network: bool
) -> int:
    """The object to which visual feedback moves the head.

    Args:
        feedback: Position in FEEDBACK.
        visible: (n,) bool.
        off: (n,) distances from the centre of view, deg.
        interest: (n,) interests in this attempt.
        kept: Target of the step before, or -1.
        by_network: Whether the network has moved the head in this attempt.

    Returns:
        Number of the object; -1 when none is visible.
    """
    keeps = feedback == KEPT or (feedback == NEAREST and not by_network)
    if keeps and kept >= 0 and visible[kept]:
        return kept
    best = -1
    for i in range(visible.size):
        if not visible[i]:
            continue
        if feedback == NEAREST and by_network:
            better = best < 0 or off[i] < off[best]
        else:
            better = best < 0 or interest[i] > interest[best]
        if better:
            best = i
    return best
