"""Reactive modules (section 5.2.3): behaviour that a robot has from the beginning.

Your own is a class with a method ``table``, as in ``ReactiveModule``.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from jointattn_mj.contingency.online.events import Variable, Variables
from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Positive, Share


@dataclass(frozen=True)
class ReactiveTable:
    """Probability of each command of a joint under each value of a sensor."""

    joint: str
    sensor: str
    odds: np.ndarray
    """(values, commands) probabilities; each row adds up to 1."""
    trust: float
    """alpha (section 5.2.3), the reliability of the module under all observables; above 0."""

    def __post_init__(self) -> None:
        odds = np.asarray(self.odds, float)
        if odds.ndim != 2 or (odds < 0).any() or not np.allclose(odds.sum(axis=1), 1):
            raise ConfigError(f"a reactive module of {self.joint!r} needs odds (values, commands), each row a sum of 1")
        if not 0 < self.trust < float("inf"):
            raise ConfigError(f"a reactive module of {self.joint!r} needs a trust above 0; got {self.trust}")


class ReactiveModule(Protocol):
    """What a reactive module must have."""

    def table(self, variables: Variables) -> ReactiveTable:
        """Its table for an agent with these variables."""


@dataclass(frozen=True)
class RandomModule(Checked):
    """Every command of a joint has the same probability (section 5.3)."""

    joint: str
    """Name of the joint."""
    trust: Positive = 1.0
    """alpha (section 5.2.3), the reliability of the module."""

    def table(self, variables: Variables) -> ReactiveTable:
        """See ``ReactiveModule``; the row is the same for every value of the first sensor."""
        sensor, joint = variables.sensors[0], _named(variables.joints, self.joint)
        count = len(joint.values)
        return ReactiveTable(self.joint, sensor.name, np.full((len(sensor.values), count), 1 / count), self.trust)


@dataclass(frozen=True)
class AvoidingModule(Checked):
    """One command is rarer than the others; for looks at the face this is the autism model of section 5.4."""

    joint: str
    """Name of the joint."""
    avoided: str
    """The rarer command, such as ``caregiver``."""
    share: Share = 0.1
    """Probability of the avoided command as a share of that of each other one, 0 to 1."""
    trust: Positive = 1.0
    """alpha (section 5.2.3), the reliability of the module."""

    def table(self, variables: Variables) -> ReactiveTable:
        """See ``ReactiveModule``; the row is the same for every value of the first sensor."""
        sensor, joint = variables.sensors[0], _named(variables.joints, self.joint)
        if self.avoided not in joint.values:
            raise ConfigError(f"{self.joint!r} has no value {self.avoided!r}; it has {joint.values}")
        odds = np.array([self.share if value == self.avoided else 1.0 for value in joint.values])
        return ReactiveTable(self.joint, sensor.name, np.tile(odds / odds.sum(), (len(sensor.values), 1)), self.trust)


def _named(variables: tuple[Variable, ...], name: str) -> Variable:
    for variable in variables:
        if variable.name == name:
            return variable
    raise ConfigError(f"no joint {name!r}; there are {[variable.name for variable in variables]}")
