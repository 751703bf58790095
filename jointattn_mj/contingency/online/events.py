"""Variables with finitely many values, and events (S, A, R) made of them (section 5.2.1)."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

from jointattn_mj.errors import ConfigError


@dataclass(frozen=True)
class Variable:
    """A variable with a name and finitely many values; in series a value is its position in ``values``."""

    name: str
    values: tuple[str, ...]

    def __post_init__(self) -> None:
        if not self.values or len(set(self.values)) != len(self.values):
            raise ConfigError(f"variable {self.name!r} needs at least one value, and no value twice; got {self.values}")


class Event(NamedTuple):
    """An action under a sensation, and its result: (S_i, A_j, R_k), as positions in ``Variables``, counted from 0."""

    sensor: int
    action: int
    result: int


@dataclass(frozen=True)
class Variables:
    """All that an agent senses and does (Table 4.1, Table 5.1).

    Among ``sensors`` those of the world come first, among ``actions`` the joints. Each module adds one of each (S_Pi,
    A_Pi): whether it drove its joint in the step before, and whether it drives it in this one.
    """

    sensors: tuple[Variable, ...]
    actions: tuple[Variable, ...]
    results: tuple[Variable, ...]
    modules: int = 0
    """Number of modules; the last so many sensors and actions are theirs."""

    def __post_init__(self) -> None:
        if not (self.sensors and self.actions and self.results):
            raise ConfigError("at least one sensor, one action and one result are needed")

    @property
    def joints(self) -> tuple[Variable, ...]:
        """Actions that are motor commands."""
        return self.actions[: len(self.actions) - self.modules]

    def with_module(self, name: str) -> "Variables":
        """These variables, and the two of a further module called ``name`` (section 5.2.1)."""
        used = ("not used", "used")
        return replace(
            self,
            sensors=(*self.sensors, Variable(f"{name} before", used)),
            actions=(*self.actions, Variable(f"{name} now", used)),
            modules=self.modules + 1,
        )

    def without_modules(self) -> "Variables":
        """These variables without those of modules."""
        sensors, actions = self.sensors[: len(self.sensors) - self.modules], self.joints
        return replace(self, sensors=sensors, actions=actions, modules=0)

    def events(self, of_joints: bool = False) -> Iterator[Event]:
        """Every (sensor, action, result); results change fastest.

        Args:
            of_joints: Only those whose action is a motor command.
        """
        for sensor in range(len(self.sensors)):
            for action in range(len(self.joints if of_joints else self.actions)):
                for result in range(len(self.results)):
                    yield Event(sensor, action, result)

    def symbol(self, event: Event) -> str:
        """An event as the dissertation writes it: ``(S1, A1, R3)``, with ``Π1`` for the variables of module 1."""
        letters = []
        for letter, number, count in (("S", event.sensor, len(self.sensors)), ("A", event.action, len(self.actions))):
            module = number - (count - self.modules)
            letters.append(f"{letter}{number + 1}" if module < 0 else f"Π{module + 1}")
        return f"({letters[0]}, {letters[1]}, R{event.result + 1})"

    def describe(self, event: Event) -> str:
        """An event in words, such as ``caregiver's face, shift gaze -> object``."""
        sensor, action = self.sensors[event.sensor], self.actions[event.action]
        return f"{sensor.name}, {action.name} -> {self.results[event.result].name}"
