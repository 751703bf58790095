"""Reactive modules (section 5.2.3): behaviour that a robot has from the beginning.

Your own is a class with a method ``table``, as in ``ReactiveModule``.
"""

import math
from dataclasses import dataclass
from typing import Protocol, TypeGuard

import numpy as np

from jointattn_mj.contingency.online.events import Variable, Variables
from jointattn_mj.contingency.online.experience import PastSteps
from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Positive, Share

ROUNDING = 1e-5
"""By how much the probabilities of a row may miss 1."""


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
        if odds.ndim != 2 or (odds < 0).any() or not (np.abs(odds.sum(axis=1) - 1) <= ROUNDING).all():
            raise ConfigError(f"a reactive module of {self.joint!r} needs odds (values, commands), each row a sum of 1")
        if not 0 < self.trust < float("inf"):
            raise ConfigError(f"a reactive module of {self.joint!r} needs a trust above 0; got {self.trust}")


class ReactiveModule(Protocol):
    """What a reactive module must have."""

    def table(self, variables: Variables) -> ReactiveTable:
        """Its table for an agent with these variables."""


class LearningModule(ReactiveModule, Protocol):
    """What a reactive module that learns must have in addition."""

    def learned(self, variables: Variables, steps: PastSteps) -> ReactiveTable:
        """Its table after so many steps.

        Args:
            variables: Of the agent.
            steps: What was sensed, done and found.
        """


def learns(module: ReactiveModule) -> TypeGuard[LearningModule]:
    """Whether a reactive module learns; asked at every look, so by the name of its method."""
    return hasattr(module, "learned")


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
class CuriousModule(Checked):
    """A command is as frequent as what is sensed after it is manifold: in proportion to the perplexity of that.

    The perplexity exp H(s' | s, a), of all sensors of the world together after command a under value s of the first
    sensor, is the number of equally frequent values that would be as hard to foresee. A command after which the same is
    always sensed has 1.
    """

    joint: str
    """Name of the joint."""
    trust: Positive = 1.0
    """alpha (section 5.2.3), the reliability of the module."""
    concentration: Positive = 20.0
    """Steps that the prior is worth: what is sensed after command a whatever was sensed before it."""

    def table(self, variables: Variables) -> ReactiveTable:
        """See ``ReactiveModule``; before anything is known each command has the same probability."""
        return RandomModule(self.joint, self.trust).table(variables)

    def learned(self, variables: Variables, steps: PastSteps) -> ReactiveTable:
        """See ``LearningModule``."""
        joint = variables.joints.index(_named(variables.joints, self.joint))
        sensed, done, following, sizes = steps.sensed(joint)
        code = (sensed.astype(np.int64) * sizes[1] + done) * sizes[2] + following
        counts = np.bincount(code, minlength=math.prod(sizes)).reshape(sizes).astype(float)
        anyway = counts.sum(axis=0)
        total = anyway.sum(axis=1, keepdims=True)
        anyway = np.divide(anyway, total, out=np.zeros_like(anyway), where=total > 0)
        p = counts + self.concentration * anyway
        whole = p.sum(axis=2, keepdims=True)
        p = np.divide(p, whole, out=np.zeros_like(p), where=whole > 0)
        perplexity = np.exp(-(p * np.log(np.where(p > 0, p, 1.0))).sum(axis=2))
        name = variables.sensors[0].name
        return ReactiveTable(self.joint, name, perplexity / perplexity.sum(axis=1, keepdims=True), self.trust)


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
