"""The robot of the earlier work (reference [19] of the dissertation): a three-layered network, visual feedback, a gate.

It is told when to shift its gaze. It sees the caregiver's face once, then moves its head in several steps; at each
step the gate takes the command of the network or that of visual feedback. When some object has come to the centre of
view, right or wrong, the network learns what the attempt showed. Directions are pairs (pan, tilt) in degrees.

The functions are compiled, for a life is 300,000 attempts; they are plain enough to be called one by one.
"""

from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import numpy as np

from jointattn_mj.errors import ConfigError, ObservationError
from jointattn_mj.guards.border import checked_by, require_array
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Angle, Checked, Positive, Real, Whole

MOST = 1e6
"""Faces, angles and movements beyond this are none."""
FEEDBACK = ("nearest", "kept", "interest")


@dataclass(frozen=True)
class TurnTakerConfig(Checked):
    """Every place that our account of the earlier work leaves open, with what we chose."""

    hidden: Annotated[int, Whole("[1, 10000]")] = 30
    """Units of the one hidden layer (tanh). 10 to 40 were alike in trials."""
    rate: Annotated[float, Real("(0, 10]")] = 0.002
    """Learning rate of plain backpropagation, one step an attempt. A large one follows the last object instead of the
    average over many; with ten objects .003 already left some robots at chance."""
    face_length: Annotated[float, Real("(0, 1e6]")] = 10.0
    """Root mean square length of the face input, less its mean; sets how fast the face's weights learn compared with
    those of the two head angles."""
    angle_scale_deg: Annotated[float, Real("[0.01, 360]")] = 30.0
    """Head angles and movements pass the network in units of this."""
    first_face_weight: Annotated[float, Real("[0, 100]")] = 0.02
    """Standard deviation of the face's first weights."""
    first_weight: Annotated[float, Real("[0, 100]")] = 0.1
    """Standard deviation of all other first weights."""
    gain: Annotated[float, Real("(0, 1]")] = 0.9
    """g: share of the way that one step goes, for either command. With .5 and ten objects three of eight robots lost
    everything when the gate opened, for they no longer came near any object."""
    steps: Annotated[int, Whole("[1, 10000]")] = 6
    """Movements that make up an attempt."""
    centre_radius_deg: Annotated[float, Real("(0, 180]")] = 3.5
    """d_th: an object this near to the centre of view is being gazed at; as for the chapter 6 robot."""
    ends: Literal["last", "first"] = "last"
    """When an attempt is judged: after the last step, or as soon as an object is within d_th of the centre. The latter
    stops at whatever lies on the way: with ten objects .30 right in the end instead of .88."""
    feedback: Literal["nearest", "kept", "interest"] = "nearest"
    """Which of several equally interesting objects visual feedback moves to. As long as the network has not moved the
    head: a random one in view when the attempt began, but for the last reading. Afterwards: the one nearest to the
    centre of view; the first one as long as it stays in view; or, at each step, the most interesting in view, interests
    being drawn anew for each attempt. All three rise; the first does so soonest (see ``experiments/turn_taking``)."""
    reference: Literal["object", "executed"] = "object"
    """The movement that is learned: the one that would have centred the object, or the one that was made. The latter
    confirms whatever the network does, and drifts until nothing is reached."""
    learns_from: Literal["every_step", "first_step"] = "every_step"
    """Pairs of an attempt: one for each place of the head on the way, or only the first. With the first alone the
    network never learns what to do on the way, and nothing comes to the centre."""
    without_target: Literal["stay", "network"] = "stay"
    """What the head does when visual feedback is asked and no object is in view."""
    gate: Literal["sigmoid", "shut", "open"] = "sigmoid"
    """Who commands: by learning time, always visual feedback, or always the network."""
    gate_midpoint: Annotated[float, Real("[-1e9, 1e9]")] = 60_000.0
    """Attempts at which either is as likely."""
    gate_width: Positive = 20_000.0
    """Attempts over which that changes, as q in eq. 6.8."""
    gate_draws: Literal["step", "attempt"] = "step"
    """The gate chooses anew at each step, or once for an attempt. With the latter all robots lost everything when it
    opened: the network never gets visual feedback's help at the end of an attempt that it began."""
    pan_limit_deg: Annotated[float, Real("[0, 180]")] = 60.0
    """The head turns no further to either side."""
    tilt_limits_deg: tuple[Angle, Angle] = (-40.0, 20.0)
    """Nor further down and up."""

    def __post_init__(self) -> None:
        super().__post_init__()
        low, high = self.tilt_limits_deg
        if not low < high:
            raise ConfigError(f"turn_taker.tilt_limits_deg must be a lower and a higher angle; got {low}, {high}")


class Network(NamedTuple):
    """Weights of the three-layered network, float32. Inputs: a face (d,) and the head's angles; output: a movement."""

    face: np.ndarray  # (hidden, d)
    head: np.ndarray  # (hidden, 2)
    threshold: np.ndarray  # (hidden,)
    out: np.ndarray  # (2, hidden)
    out_threshold: np.ndarray  # (2,)


class Options(NamedTuple):
    """The config as numbers, for compiled code."""

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
        network: What it has learned.
        time: Attempts so far, on which the gate depends.
    """

    def __init__(self, config: TurnTakerConfig, inputs: int, rng: np.random.Generator):
        """``inputs`` is the size of a face; ``rng`` draws the first weights."""
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

    def options(self) -> Options:
        """The config as numbers."""
        config = self.config
        return Options(
            config.gain, config.steps, config.centre_radius_deg, config.ends == "first",
            FEEDBACK.index(config.feedback), config.reference == "object", config.learns_from == "every_step",
            config.without_target == "network", config.gate_draws == "step", config.angle_scale_deg, config.rate,
            config.pan_limit_deg, *config.tilt_limits_deg,
        )  # fmt: skip

    def gate(self, attempts: int) -> np.ndarray:
        """(attempts,) chances that the network's command is taken, over the coming attempts."""
        config = self.config
        if config.gate != "sigmoid":
            return np.full(attempts, float(config.gate == "open"))
        time = self.time + np.arange(attempts)
        return 1 / (1 + np.exp((config.gate_midpoint - time) / config.gate_width))

    def movement(self, face: np.ndarray, head: np.ndarray) -> np.ndarray:
        """The way (2,) that the network thinks lies between a head at ``head`` and what this face looks at."""
        drive = face_drive(self.network, face)
        return np.array(network_command(self.network, drive, head, self.config.angle_scale_deg))

    def learn(self, face: np.ndarray, heads: np.ndarray, movements: np.ndarray) -> None:
        """One step of backpropagation on the pairs (face, ``heads`` (k, 2)) -> ``movements`` (k, 2)."""
        drive = face_drive(self.network, face)
        backpropagate(self.network, face, drive, heads, movements, self.config.angle_scale_deg, self.config.rate)


def _check_face(network: Network, face: np.ndarray) -> None:
    require_array("face", face, network.face.shape[1:], "f", -MOST, MOST)


@checked_by(_check_face)
@njit(fastmath=True, cache=True)
def face_drive(network: Network, face: np.ndarray) -> np.ndarray:
    """What a face adds to the input of each hidden unit: (hidden,). It is the same all through an attempt."""
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
@njit(cache=True)
def network_command(network: Network, drive: np.ndarray, head: np.ndarray, scale: float) -> tuple[float, float]:
    """The network's output: pan and tilt still to go, deg."""
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
@njit(fastmath=True, cache=True)
def backpropagate(
    network: Network,
    face: np.ndarray,
    drive: np.ndarray,
    heads: np.ndarray,
    movements: np.ndarray,
    scale: float,
    rate: float,
) -> None:
    """One gradient step, in place, on half the squared error summed over the pairs of an attempt."""
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
    require_array("seen", visible, (-1,), "b")
    require_array("off", off, visible.shape, "f")
    require_array("interest", interest, visible.shape, "f")
    if not -1 <= kept < len(visible):
        raise ObservationError(f"kept: expected one of {len(visible)} objects, or -1; got {kept}")


@checked_by(_check_target)
@njit(cache=True)
def feedback_target(
    feedback: int, visible: np.ndarray, off: np.ndarray, interest: np.ndarray, kept: int, by_network: bool
) -> int:
    """The object that visual feedback moves to, or -1 when none is in view.

    ``off`` (n,) are distances from the centre of view, deg; ``interest`` (n,) this attempt's draws; ``kept`` the last
    target or -1; ``by_network`` whether the network has moved the head in this attempt.
    """
    keeps = feedback == 1 or (feedback == 0 and not by_network)
    if keeps and kept >= 0 and visible[kept]:
        return kept
    best = -1
    for i in range(visible.size):
        if not visible[i]:
            continue
        if feedback == 0 and by_network:
            better = best < 0 or off[i] < off[best]
        else:
            better = best < 0 or interest[i] > interest[best]
        if better:
            best = i
    return best
