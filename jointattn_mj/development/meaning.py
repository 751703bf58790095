"""Meaning of a module in words: the dissertation's name of a behaviour, or a description of the module's map.

A name needs the event and the map. A module of the event of gaze following whose map leads elsewhere is described, not
named.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jointattn_mj.contingency.online.events import Variables
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING, Module

FACE, LOOKED_AT, GAZE, CAREGIVER = "caregiver's face", "object looked at", "shift gaze", "caregiver"
FRONTAL, PROFILE, OBJECT = "frontal face", "profile", "object"
GAZE_FOLLOWING = "gaze following"
"""Names in ``table_variables``, and of the behaviour that comes first."""


@dataclass(frozen=True)
class Meaning:
    """What a module does, in words."""

    short: str
    """The dissertation's name (section 5.3.2), such as FG-m; else its number, such as module 4."""
    name: str
    """Name of the behaviour, such as ``gaze following``; else a description of the map."""
    partly: str = ""
    """Reservation: which share of the map does what the name says. Empty where all of it does."""

    @property
    def words(self) -> str:
        """The name with its reservation."""
        return self.name + self.partly

    @property
    def label(self) -> str:
        """The words, and the dissertation's name in brackets."""
        return f"{self.words} ({self.short})" if self.short.endswith("-m") else self.words


def meanings(variables: Variables, modules: Sequence[Module]) -> list[Meaning]:
    """The meaning of each module; later modules may build on earlier ones.

    Args:
        variables: Of the agent, with the variables of its modules.
        modules: In the order in which they were made.
    """
    known: list[Meaning] = []
    for module in modules:
        known.append(
            _named(variables, module, known) or Meaning(f"module {len(known) + 1}", in_words(variables, module))
        )
    return known


def in_words(variables: Variables, module: Module, most: int = 2) -> str:
    """Describe a map: ``shift gaze: caregiver after module 1 was used, expecting frontal face``.

    Args:
        variables: Of the agent, with the variables of its modules.
        module: The module.
        most: Number of commands that are described, the most reliable first.
    """
    names = _Names(variables, module)
    offers: dict[tuple[int, int], dict[int, float]] = {}
    for r, s in np.argwhere(module.command != OFFERS_NOTHING):
        sensed = offers.setdefault((int(module.command[r, s]), int(module.expected[r, s])), {})
        sensed[int(s)] = max(sensed.get(int(s), 0.0), float(module.reliability[r, s]))
    ranked = sorted(offers.items(), key=lambda item: -max(item[1].values()))
    said = []
    for (command, expected), sensed in ranked[:most]:
        when = " or ".join(names.sensed(s) for s in sorted(sensed))
        said.append(f"{names.command(command)} {when}, expecting {names.outcome(expected)}")
    if len(ranked) > most:
        said.append(f"{len(ranked) - most} more")
    return "; ".join(said) or "offers nothing under any observables"


def _named(variables: Variables, module: Module, known: Sequence[Meaning]) -> Meaning | None:
    """The behaviour of section 5.3 that the module shows; None for any other."""
    sensor, action = variables.sensors[module.event.sensor], variables.actions[module.event.action]
    result = variables.results[module.event.result].name
    before = module.event.sensor - (len(variables.sensors) - variables.modules)
    if action.name != GAZE:
        return None
    offers = [(int(s), int(module.command[r, s])) for r, s in np.argwhere(module.command != OFFERS_NOTHING)]
    to_caregiver = [action.values[command] == CAREGIVER for s, command in offers]
    if sensor.name == FACE and result == OBJECT:
        where = [(sensor.values[s], action.values[command]) for s, command in offers]
        follows = [face.partition(" (")[0] == f"at {spot}" for face, spot in where]
        if _most(follows):
            return Meaning("FG-m", GAZE_FOLLOWING, _share(follows))
    if not _most(to_caregiver):
        return None
    if before >= 0 and result == FRONTAL:
        after = known[before].name if known[before].short.endswith("-m") else f"module {before + 1}"
        short = "SCf-m" if after == GAZE_FOLLOWING else f"module {len(known) + 1}"
        return Meaning(short, f"looking back to the caregiver after {after}", _share(to_caregiver))
    if before >= 0 and result == PROFILE:
        return Meaning("SC-m", "gaze alternation", _share(to_caregiver))
    if sensor.name == FACE and result in (FRONTAL, PROFILE):
        return Meaning(f"module {len(known) + 1}", "keeping eye contact", _share(to_caregiver))
    if sensor.name == LOOKED_AT and result in (FRONTAL, PROFILE):
        return Meaning(f"module {len(known) + 1}", "shifting to the caregiver", _share(to_caregiver))
    return None


def _most(right: Sequence[bool]) -> bool:
    return 2 * sum(right) > len(right)


def _share(right: Sequence[bool]) -> str:
    return "" if all(right) else f", in {sum(right)} of its map's {len(right)} commands"


class _Names:
    """Values of a module's variables in words."""

    def __init__(self, variables: Variables, module: Module):
        self._sensor = variables.sensors[module.event.sensor]
        self._action = variables.actions[module.event.action]
        self._result = variables.results[module.event.result]
        self._of_module = module.event.sensor >= len(variables.sensors) - variables.modules
        self._uses_module = module.event.action >= len(variables.joints)

    def sensed(self, value: int) -> str:
        label = self._sensor.values[value]
        if self._of_module:
            return f"after {self._sensor.name.removesuffix(' before')} was {label}"
        return f"when {self._sensor.name} is {label}"

    def command(self, value: int) -> str:
        label = self._action.values[value]
        if self._uses_module:
            return f"{'using' if label == 'used' else 'not using'} {self._action.name.removesuffix(' now')}"
        return f"{self._action.name}: {label}"

    def outcome(self, value: int) -> str:
        label = self._result.values[value]
        return {"yes": self._result.name, "no": f"no {self._result.name}"}.get(label, f"{self._result.name} {label}")
