"""Learners of the map from the caregiver's face to a motor command, online (section 6.3.3, Fig. 6.4).

The dissertation has a two-layered perceptron on the activations of the self-organising map. It is trained after every
shift that ends at an object, with the robot's own motor command as reference. "Two-layered" leaves the output code
open; both readings are here. Every learner is told of all locations in view with a face (``Locations``); those of the
dissertation take notice of the object reached alone, ``cross_situational`` weighs all of them.
"""

import math
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Protocol

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.guards.border import numbers
from jointattn_mj.guards.restored import check_array
from jointattn_mj.options import Angle, Checked, Real, Whole


@dataclass(frozen=True)
class LearnerConfig(Checked):
    """Settings of the online contingency learning module."""

    code: Literal["population", "linear", "network", "cross_situational"] = "population"
    """Output code: units tuned to directions, two linear outputs, or a torch network before such units. With linear
    outputs right and wrong pairs average to the middle of the table. A population keeps them apart, and the right one
    wins for it is more frequent. ``network_learner`` also takes networks of your own. With cross_situational such units
    count how often something lies in their direction with each face; the next six options say what counts."""
    pairs: Literal["reached", "in_view"] = "reached"
    """With code cross_situational: pair a face with the object that the robot reached, as the text does, or with all
    objects in view at that moment."""
    base: Literal["none", "in_view"] = "none"
    """With code cross_situational: take a direction for the better the more often something lies there with this face
    (none), or the more often than with any face (in_view): contingency in place of co-occurrence."""
    competition: Annotated[float, Real("[0, 10]")] = 0.0
    """With code cross_situational: how sharply the objects in view compete for a face. Each counts by its share of
    exp(competition * evidence): 0 is alike, 1 by its probability. Above 1.3 the learner confirms its own errors."""
    compete_after: Annotated[int, Whole("[0, 1e6]")] = 10
    """With code cross_situational: looks at the face before objects compete. Evidence from none is noise."""
    forgetting: Annotated[float, Real("[0, 1)")] = 0.0
    """With code cross_situational: share of all counts that is forgotten at each look at the face. What was counted
    before objects competed well then goes."""
    smoothing: Annotated[float, Real("[1e-6, 1e3]")] = 0.05
    """With code cross_situational: added to shares before they are compared, in units of the mean share of a direction.
    It keeps what was seen once from being certain."""
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
        for name in ("pairs", "base", "competition", "compete_after", "forgetting", "smoothing"):
            if self.code != "cross_situational" and getattr(self, name) != getattr(LearnerConfig, name):
                raise ConfigError(
                    f"learner.{name} {getattr(self, name)} needs learner.code cross_situational; got {self.code}, "
                    f"which learns from the object reached alone (leave out learner.{name}, or set the code)"
                )

    @property
    def uses_all_looks(self) -> bool:
        """Whether something is learned from a look at the face after which, or before which, no object was reached."""
        return "in_view" in (self.pairs, self.base)


@dataclass(frozen=True)
class Locations:
    """Where objects lay when a face was seen, as turns of the head (pan, tilt) that lead from the face there, deg.

    Attributes:
        in_view: (n, 2) of all objects in view with the face, in the order of their numbers.
        reached: (2,) of the one object that the robot's own shift from the face reached, or from which it came to the
            face; None without such a shift.
    """

    in_view: np.ndarray
    reached: np.ndarray | None = None

    @classmethod
    def only(cls, command: np.ndarray) -> "Locations":
        """One object, the only one in view, that was reached by ``command`` (2,), deg."""
        there = np.asarray(command)
        return cls(np.reshape(there, (1, -1)), there)


class Learner(Protocol):
    """Interface of learners. A face is the robot's description of it, such as the activations (k,) of a map."""

    def predict(self, face: np.ndarray) -> np.ndarray:
        """Motor command (2,), deg, whatever is in view: the turn of the head from the face to what it looks at."""

    def score(self, face: np.ndarray, locations: Locations) -> np.ndarray:
        """How well each of the n objects in view goes with the face: (n,), the greatest being the best."""

    def learn(self, face: np.ndarray, locations: Locations) -> None:
        """Learn from a face and the locations of objects."""

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

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a code.

        Raises:
            ValueError: Its units lie beyond all directions.
        """
        self.__dict__.update(state)
        for units, number in zip((self._pans, self._tilts), self.shape, strict=True):
            check_array("the directions of units", units, (number,), float, -360, 360)

    def encode(self, command: np.ndarray) -> np.ndarray:
        """Activity (pan units, tilt units) for a command (2,), deg."""
        return np.outer(
            np.exp(-0.5 * ((self._pans - command[0]) / self._width) ** 2),
            np.exp(-0.5 * ((self._tilts - command[1]) / self._width) ** 2),
        )

    def shares(self, directions: np.ndarray) -> np.ndarray:
        """Share of each unit in the bumps of ``directions`` (n, 2), deg: (n, units), each row summing to 1.

        A direction beyond the units is taken for the nearest one that they cover.
        """
        pans, tilts = (
            _bumps(np.clip(given, units[0], units[-1]), units, self._width)
            for given, units in zip(directions.T, (self._pans, self._tilts), strict=True)
        )
        shares: np.ndarray = (pans[:, :, None] * tilts[:, None, :]).reshape(len(directions), math.prod(self.shape))
        return shares

    def at(self, activity: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Activity (n,) in each of ``directions`` (n, 2), deg, of an activity (pan units, tilt units)."""
        there: np.ndarray = self.shares(directions) @ activity.ravel()
        return there

    def decode(self, activity: np.ndarray) -> np.ndarray:
        """Command (2,), deg, for an activity (pan units, tilt units): the centre of mass about the most active unit."""
        pan, tilt = np.unravel_index(np.argmax(activity), activity.shape)
        pans = slice(max(pan - 1, 0), pan + 2)
        tilts = slice(max(tilt - 1, 0), tilt + 2)
        bump = np.maximum(activity[pans, tilts], 0) + 1e-12
        bump /= bump.sum()
        return np.array([bump.sum(1) @ self._pans[pans], bump.sum(0) @ self._tilts[tilts]])


def _bumps(given: np.ndarray, units: np.ndarray, width: float) -> np.ndarray:
    """Bumps (n, units) about ``given`` (n,), each summing to 1."""
    exponents = -0.5 * ((units - given[:, None]) / width) ** 2
    bumps: np.ndarray = np.exp(exponents - exponents.max(axis=1, keepdims=True))  # of narrow ones the highest stays
    bumps /= bumps.sum(axis=1, keepdims=True)
    return bumps


class PopulationLearner:
    """Perceptron with a population of output units; the delta rule moves them towards a bump at the reference.

    The last input is the context (see ``LearnerConfig.context``).
    """

    def __init__(self, config: LearnerConfig, inputs: int):
        """Make a learner of ``inputs`` SOM units whose weights are 0."""
        self._rate, self._context, self._code = config.rate, config.context, PopulationCode(config)
        self._weights = np.zeros((inputs + 1, *config.units))

    def predict(self, face: np.ndarray) -> np.ndarray:
        """The command (2,), deg, whose units the activations (k,) make most active."""
        return self._code.decode(self._activity(face))

    def score(self, face: np.ndarray, locations: Locations) -> np.ndarray:
        """Activity (n,) of the units about each of the n objects in view."""
        return self._code.at(self._activity(face), locations_in_view(locations))

    def _activity(self, face: np.ndarray) -> np.ndarray:
        given = numbers("activations of the face", face, (len(self._weights) - 1,))
        return self._of(given, self._weights[:-1])

    @staticmethod
    def _of(inputs: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Activity (pan units, tilt units) of ``inputs`` (k,) through ``weights`` (k, pan units, tilt units)."""
        activity: np.ndarray = np.dot(inputs[None], weights.reshape(len(weights), -1)).reshape(weights.shape[1:])
        return activity

    def learn(self, face: np.ndarray, locations: Locations) -> None:
        """Make one step of the normalised delta rule towards the location reached, if one was."""
        if locations.reached is None:
            return
        command = numbers("locations.reached", locations.reached, (2,))
        inputs = np.append(numbers("activations of the face", face, (len(self._weights) - 1,)), self._context)
        error = self._code.encode(command) - self._of(inputs, self._weights)
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

    def predict(self, face: np.ndarray) -> np.ndarray:
        """The command (2,), deg: the weighted sum of the activations (k,)."""
        return numbers("activations of the face", face, (len(self._weights),)) @ self._weights

    def score(self, face: np.ndarray, locations: Locations) -> np.ndarray:
        """How near each of the n objects in view is to the command: (n,) distances, negative, deg."""
        nearness: np.ndarray = -np.linalg.norm(locations_in_view(locations) - self.predict(face), axis=1)
        return nearness

    def learn(self, face: np.ndarray, locations: Locations) -> None:
        """Make one step of the normalised delta rule towards the location reached, if one was."""
        if locations.reached is None:
            return
        off = numbers("locations.reached", locations.reached, (2,)) - self.predict(face)
        gain = self._config.rate / (face @ face)
        self._weights += np.outer(gain * face, off)

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
    if config.code == "cross_situational":
        from jointattn_mj.gaze_following.cross_situational import CrossSituationalLearner  # it is built on this module

        return CrossSituationalLearner(config, inputs)
    return PopulationLearner(config, inputs) if config.code == "population" else LinearLearner(config, inputs)


def locations_in_view(locations: Locations) -> np.ndarray:
    """The directions (n, 2), deg, of all objects in view.

    Raises:
        ObservationError: They are no finite numbers of this shape.
    """
    return numbers("locations.in_view", locations.in_view, (-1, 2))


def same_shape(given: np.ndarray, own: np.ndarray) -> np.ndarray:
    """A copy of the array ``given``, if it fits in place of the weights ``own``.

    Raises:
        ConfigError: It has another shape, or numbers that are not finite.
    """
    if given.shape != own.shape:
        raise ConfigError(
            f"learned weights must have shape {own.shape} under this config; got {given.shape}, those of another "
            "learner.code or of other numbers of units"
        )
    if given.dtype.kind not in "biuf":
        raise ConfigError(f"learned weights must be real numbers; got {given.dtype}")
    with np.errstate(over="ignore"):
        weights = np.array(given, own.dtype)
    if not np.isfinite(weights).all():
        raise ConfigError("learned weights must be finite numbers")
    return weights
