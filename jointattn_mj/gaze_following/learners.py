"""Learners of the map from the caregiver's face to a motor command, online (section 6.3.3, Fig. 6.4).

The dissertation has a two-layered perceptron on the activations of the self-organising map. It is trained after every
shift that ends at an object, with the robot's own motor command as reference. "Two-layered" leaves the output code
open; both readings are here.
"""

from dataclasses import dataclass
from typing import Annotated, Literal, Protocol

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.guards.border import numbers
from jointattn_mj.options import Angle, Checked, Real, Whole


@dataclass(frozen=True)
class LearnerConfig(Checked):
    """Settings of the online contingency learning module."""

    code: Literal["population", "linear", "network"] = "population"
    """Output code: units tuned to directions, two linear outputs, or a torch network before such units. With linear
    outputs right and wrong pairs average to the middle of the table. A population keeps them apart, and the right one
    wins for it is more frequent. ``network_learner`` also takes networks of your own."""
    rate: Annotated[float, Real("(0, 1]")] = 0.02
    """Learning rate of the delta rule, normalised by the squared length of the input."""
    context: Annotated[float, Real("[0, 1000]")] = 0.5
    """Activity of one more input, which is always on and takes no part in prediction (the context of Rescorla and
    Wagner's rule; the bias of a perceptron). It absorbs what is frequent whatever the face, such as an object that lies
    still for long. 0 is without; the difference is smaller than 8 sessions can show (``experiments/README.md``)."""
    hidden: Annotated[int, Whole("[1, 10000]")] = 60
    """Hidden units of the code network."""
    network_rate: Annotated[float, Real("(0, 10]")] = 0.02
    """Learning rate of the gradient descent of the code network."""
    directions: Literal["both", "face_to_object"] = "both"
    """Learn from shifts in both directions, or only from the face to an object; section 6.3.1 learns from both "to have
    double chances"."""
    counts: Literal["face_to_object", "both"] = "face_to_object"
    """Count learned pairs of these directions as learning iterations l of the gate (eq. 6.8)."""
    reference: Literal["object", "executed"] = "object"
    """Take as reference the command that would have centred the object, or the head's turn as executed."""
    pan_range_deg: tuple[Angle, Angle] = (-25.0, 25.0)
    """Least and greatest preferred pan of the output units, deg from the face; covers the table."""
    tilt_range_deg: tuple[Angle, Angle] = (-30.0, 0.0)
    """Least and greatest preferred tilt of the output units, deg from the face."""
    units: tuple[Annotated[int, Whole("[3, 128]")], Annotated[int, Whole("[3, 128]")]] = (21, 11)
    """Number of output units along pan and along tilt."""
    tuning_deg: Annotated[float, Real("[0.01, 180]")] = 1.5
    """Standard deviation of the reference pattern about the reference command, deg."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("pan_range_deg", "tilt_range_deg"):
            low, high = getattr(self, name)
            if not low < high:
                raise ConfigError(f"learner.{name} must be a lower and a higher angle; got {low}, {high}")


class Learner(Protocol):
    """Interface of learners; motor commands are turns of the head (pan, tilt) in degrees."""

    def predict(self, activations: np.ndarray) -> np.ndarray:
        """Motor command (2,) for SOM activations (k,)."""

    def learn(self, activations: np.ndarray, command: np.ndarray) -> None:
        """Strengthen the connection between SOM activations (k,) and a motor command (2,)."""

    def weights(self) -> np.ndarray:
        """All learned weights, as one array."""

    def load(self, weights: np.ndarray) -> None:
        """Take over what ``weights`` gave."""


class PopulationCode:
    """Code of directions by bumps of activity on a grid of units, each with a preferred direction."""

    def __init__(self, config: LearnerConfig):
        """Lay out the units by ranges, numbers and tuning of ``config``."""
        self.shape = config.units
        self._pans = np.linspace(*config.pan_range_deg, config.units[0])
        self._tilts = np.linspace(*config.tilt_range_deg, config.units[1])
        self._width = config.tuning_deg

    def encode(self, command: np.ndarray) -> np.ndarray:
        """Activity (pan units, tilt units) for a command (2,), deg."""
        return np.outer(
            np.exp(-0.5 * ((self._pans - command[0]) / self._width) ** 2),
            np.exp(-0.5 * ((self._tilts - command[1]) / self._width) ** 2),
        )

    def decode(self, activity: np.ndarray) -> np.ndarray:
        """Command (2,), deg, for an activity (pan units, tilt units): the centre of mass about the most active unit."""
        pan, tilt = np.unravel_index(np.argmax(activity), activity.shape)
        pans = slice(max(pan - 1, 0), pan + 2)
        tilts = slice(max(tilt - 1, 0), tilt + 2)
        bump = np.maximum(activity[pans, tilts], 0) + 1e-12
        bump /= bump.sum()
        return np.array([bump.sum(1) @ self._pans[pans], bump.sum(0) @ self._tilts[tilts]])


class PopulationLearner:
    """Perceptron with a population of output units; the delta rule moves them towards a bump at the reference.

    The last input is the context (see ``LearnerConfig.context``).
    """

    def __init__(self, config: LearnerConfig, inputs: int):
        """Make a learner of ``inputs`` SOM units whose weights are 0."""
        self._rate, self._context, self._code = config.rate, config.context, PopulationCode(config)
        self._weights = np.zeros((inputs + 1, *config.units))

    def predict(self, activations: np.ndarray) -> np.ndarray:
        """The command (2,), deg, whose units the activations (k,) make most active."""
        given = numbers("activations", activations, (len(self._weights) - 1,))
        return self._code.decode(np.tensordot(given, self._weights[:-1], 1))

    def learn(self, activations: np.ndarray, command: np.ndarray) -> None:
        """Make one step of the normalised delta rule towards ``command`` (2,), deg."""
        command = numbers("command", command, (2,))
        inputs = np.append(numbers("activations", activations, (len(self._weights) - 1,)), self._context)
        error = self._code.encode(command) - np.tensordot(inputs, self._weights, 1)
        gain = self._rate / (inputs @ inputs)
        self._weights += np.multiply.outer(gain * inputs, error)

    def weights(self) -> np.ndarray:
        """Weights (k + 1, pan units, tilt units); the last input is the context."""
        return self._weights.copy()

    def load(self, weights: np.ndarray) -> None:
        """Take over what ``weights`` gave; raises ConfigError where it does not fit."""
        self._weights = same_shape(weights, self._weights)


class LinearLearner:
    """Perceptron with two linear outputs, pan and tilt: the plainest reading of "two-layered", kept as a baseline."""

    def __init__(self, config: LearnerConfig, inputs: int):
        """Make a learner of ``inputs`` SOM units whose weights are 0."""
        self._config = config
        self._weights = np.zeros((inputs, 2))

    def predict(self, activations: np.ndarray) -> np.ndarray:
        """The command (2,), deg: the weighted sum of the activations (k,)."""
        return numbers("activations", activations, (len(self._weights),)) @ self._weights

    def learn(self, activations: np.ndarray, command: np.ndarray) -> None:
        """Make one step of the normalised delta rule towards ``command`` (2,), deg."""
        off = numbers("command", command, (2,)) - self.predict(activations)
        gain = self._config.rate / (activations @ activations)
        self._weights += np.outer(gain * activations, off)

    def weights(self) -> np.ndarray:
        """Weights (k, 2)."""
        return self._weights.copy()

    def load(self, weights: np.ndarray) -> None:
        """Take over what ``weights`` gave; raises ConfigError where it does not fit."""
        self._weights = same_shape(weights, self._weights)


def make_learner(config: LearnerConfig, inputs: int, rng: np.random.Generator) -> Learner:
    """The learner that ``config.code`` names.

    Args:
        config: Its settings.
        inputs: Number of SOM units, k.
        rng: Draws the first weights of a network.

    Raises:
        ExtraError: The code is "network", and torch is not installed.
    """
    if config.code == "network":
        from jointattn_mj.gaze_following.network_learner import (  # torch takes seconds to import
            NetworkLearner,
            hidden_layer,
        )

        return NetworkLearner(config, hidden_layer(config, inputs, rng))
    return PopulationLearner(config, inputs) if config.code == "population" else LinearLearner(config, inputs)


def same_shape(given: np.ndarray, own: np.ndarray) -> np.ndarray:
    """A copy of the array ``given``, if it fits in place of the weights ``own``.

    Raises:
        ConfigError: It has another shape, or numbers that are not finite.
    """
    if given.shape != own.shape:
        raise ConfigError(f"learned weights must have shape {own.shape} under this config; got {given.shape}")
    if given.dtype.kind not in "biuf":
        raise ConfigError(f"learned weights must be real numbers; got {given.dtype}")
    with np.errstate(over="ignore"):
        weights = np.array(given, own.dtype)
    if not np.isfinite(weights).all():
        raise ConfigError("learned weights must be finite numbers")
    return weights
