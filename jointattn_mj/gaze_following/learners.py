"""From the caregiver's face to a motor command, learned online (section 6.3.3, Fig. 6.4).

A two-layered perceptron on the activations of the SOM, trained after every shift that ends at an object with the
robot's own motor command as reference. "Two-layered" leaves the output's code open; both readings are here.
"""

from dataclasses import dataclass
from typing import Annotated, Literal, Protocol

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.guards.border import numbers
from jointattn_mj.options import Angle, Checked, Real, Whole


@dataclass(frozen=True)
class LearnerConfig(Checked):
    """The online contingency learning module."""

    code: Literal["population", "linear", "network"] = "population"
    """Output code. With two linear outputs right and wrong pairs average to the middle of the table; a population of
    output units tuned to directions keeps them apart and lets the more frequent, the right one, win. "network" puts a
    hidden layer before the population, in torch (see ``network_learner``, also for networks of your own)."""
    rate: Annotated[float, Real("(0, 1]")] = 0.02
    """Learning rate of the delta rule, normalised by the squared length of the input."""
    context: Annotated[float, Real("[0, 1000]")] = 0.5
    """Activity of one more input that is always on and takes no part in prediction (the context of Rescorla and
    Wagner's rule; the bias of a perceptron). What comes often whatever the face, such as an object that lies still for
    long, is put down to it, and a face keeps what it tells beyond that. 0 is without; the difference over a session is
    smaller than 8 sessions can show (``experiments/README.md``)."""
    hidden: Annotated[int, Whole("[1, 10000]")] = 60
    """Hidden units of the "network" code."""
    network_rate: Annotated[float, Real("(0, 10]")] = 0.02
    """Learning rate of its gradient descent."""
    directions: Literal["both", "face_to_object"] = "both"
    """Which shifts are learned from: section 6.3.1 learns from object-to-face shifts too "to have double chances"."""
    counts: Literal["face_to_object", "both"] = "face_to_object"
    """Which learned pairs advance l of the gate, eq. 6.8."""
    reference: Literal["object", "executed"] = "object"
    """Reference signal: the command that would have centred the object, or the head's turn as carried out."""
    pan_range_deg: tuple[Angle, Angle] = (-25.0, 25.0)
    """Preferred directions of the output units, pan; covers the table as seen from the face."""
    tilt_range_deg: tuple[Angle, Angle] = (-30.0, 0.0)
    """The same for tilt."""
    units: tuple[Annotated[int, Whole("[3, 128]")], Annotated[int, Whole("[3, 128]")]] = (21, 11)
    """Output units along pan and tilt."""
    tuning_deg: Annotated[float, Real("[0.01, 180]")] = 1.5
    """Standard deviation of the reference pattern about the reference command."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("pan_range_deg", "tilt_range_deg"):
            low, high = getattr(self, name)
            if not low < high:
                raise ConfigError(f"learner.{name} must be a lower and a higher angle; got {low}, {high}")


class Learner(Protocol):
    """What any learner of the map must offer; directions are motor commands (pan, tilt) in degrees."""

    def predict(self, activations: np.ndarray) -> np.ndarray:
        """Motor command (2,) for SOM activations (k,)."""

    def learn(self, activations: np.ndarray, command: np.ndarray) -> None:
        """Strengthen the connection between the two."""

    def weights(self) -> np.ndarray:
        """All that was learned, as one array."""

    def load(self, weights: np.ndarray) -> None:
        """Take over what ``weights`` gave."""


class PopulationCode:
    """Directions as bumps of activity on a grid of units, each with a preferred direction."""

    def __init__(self, config: LearnerConfig):
        self.shape = config.units
        self._pans = np.linspace(*config.pan_range_deg, config.units[0])
        self._tilts = np.linspace(*config.tilt_range_deg, config.units[1])
        self._width = config.tuning_deg

    def encode(self, command: np.ndarray) -> np.ndarray:
        """Activity (pan units, tilt units) for a command (2,)."""
        return np.outer(
            np.exp(-0.5 * ((self._pans - command[0]) / self._width) ** 2),
            np.exp(-0.5 * ((self._tilts - command[1]) / self._width) ** 2),
        )

    def decode(self, activity: np.ndarray) -> np.ndarray:
        """Centre of mass (2,) of the most active unit and its neighbours."""
        pan, tilt = np.unravel_index(np.argmax(activity), activity.shape)
        pans = slice(max(pan - 1, 0), pan + 2)
        tilts = slice(max(tilt - 1, 0), tilt + 2)
        bump = np.maximum(activity[pans, tilts], 0) + 1e-12
        bump /= bump.sum()
        return np.array([bump.sum(1) @ self._pans[pans], bump.sum(0) @ self._tilts[tilts]])


class PopulationLearner:
    """Outputs are units with preferred directions; the delta rule moves them towards a bump at the reference.

    The last input is the context (see ``LearnerConfig.context``).
    """

    def __init__(self, config: LearnerConfig, inputs: int):
        self._rate, self._context, self._code = config.rate, config.context, PopulationCode(config)
        self._weights = np.zeros((inputs + 1, *config.units))

    def predict(self, activations: np.ndarray) -> np.ndarray:
        """The direction whose units this face makes most active."""
        given = numbers("activations", activations, (len(self._weights) - 1,))
        return self._code.decode(np.tensordot(given, self._weights[:-1], 1))

    def learn(self, activations: np.ndarray, command: np.ndarray) -> None:
        """One step of the normalised delta rule."""
        command = numbers("command", command, (2,))
        inputs = np.append(numbers("activations", activations, (len(self._weights) - 1,)), self._context)
        error = self._code.encode(command) - np.tensordot(inputs, self._weights, 1)
        gain = self._rate / (inputs @ inputs)
        self._weights += np.multiply.outer(gain * inputs, error)

    def weights(self) -> np.ndarray:
        """(k + 1, pan units, tilt units)."""
        return self._weights.copy()

    def load(self, weights: np.ndarray) -> None:
        """The inverse of ``weights``."""
        self._weights = same_shape(weights, self._weights)


class LinearLearner:
    """Two linear outputs, pan and tilt: the nearest reading of "two-layered perceptron", kept as a baseline."""

    def __init__(self, config: LearnerConfig, inputs: int):
        self._config = config
        self._weights = np.zeros((inputs, 2))

    def predict(self, activations: np.ndarray) -> np.ndarray:
        """Weighted sum."""
        return numbers("activations", activations, (len(self._weights),)) @ self._weights

    def learn(self, activations: np.ndarray, command: np.ndarray) -> None:
        """One step of the normalised delta rule."""
        off = numbers("command", command, (2,)) - self.predict(activations)
        gain = self._config.rate / (activations @ activations)
        self._weights += np.outer(gain * activations, off)

    def weights(self) -> np.ndarray:
        """(k, 2)."""
        return self._weights.copy()

    def load(self, weights: np.ndarray) -> None:
        """The inverse of ``weights``."""
        self._weights = same_shape(weights, self._weights)


def make_learner(config: LearnerConfig, inputs: int, rng: np.random.Generator) -> Learner:
    """The learner that ``config.code`` names, for ``inputs`` SOM cells; ``rng`` draws first weights where needed."""
    if config.code == "network":
        from jointattn_mj.gaze_following.network_learner import (  # torch takes seconds to import
            NetworkLearner,
            hidden_layer,
        )

        return NetworkLearner(config, hidden_layer(config, inputs, rng))
    return PopulationLearner(config, inputs) if config.code == "population" else LinearLearner(config, inputs)


def same_shape(given: np.ndarray, own: np.ndarray) -> np.ndarray:
    """A copy of ``given`` if it can replace the weights ``own``.

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
