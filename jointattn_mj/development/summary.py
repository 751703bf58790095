"""Summary of a finished run: modules, behaviour rates by phase, final ranking of events."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from jointattn_mj.development.behaviour import BEHAVIOURS, SHORT, BehaviourPhase
from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.meaning import Meaning
from jointattn_mj.io.provenance import plain
from jointattn_mj.options import warn_renamed

OLD_KEYS = {
    "turns_watched_before": "exploration_steps",
    "found_without_a_module": "detected_without_a_module",
    "minutes_when_found": "minutes_when_detected",
}
"""Keys of ``summary.json`` by their names in the last version."""
RANKED = 10
"""Events in the final ranking."""


@dataclass(frozen=True, repr=False)
class LearnedModule:
    """A module, in words."""

    number: int
    """Counted from 1, in the order in which modules were made."""
    step: int
    """Steps done when it was made."""
    event: str
    """Its event, such as ``caregiver's face, shift gaze -> object``."""
    symbol: str
    """The event in the dissertation's symbols, such as ``(S1, A1, R3)``."""
    name: str
    """The dissertation's name (section 5.3.2), such as ``FG-m``; else its number, such as ``module 4``."""
    means: str
    """What it does, such as ``gaze following``."""

    def __repr__(self) -> str:
        name = f" ({self.name})" if self.name.endswith("-m") else ""
        return f"<module {self.number}: {self.means}{name}, step {self.step:,}>"


@dataclass(frozen=True)
class UnmodelledEvent:
    """An event that was found when there were as many modules as there can be."""

    step: int
    """Steps done when it was found."""
    event: str


@dataclass(frozen=True, repr=False)
class PhaseSummary:
    """Behaviour between two modules."""

    phase: str
    """P1 before the first module, P2 after it, and so on (Fig. 5.5)."""
    first_step: int
    last_step: int
    rates: Mapping[str, float]
    """Rate of each behaviour at the end of the phase, by the names of Fig. 5.5, such as ``FG``."""

    def __repr__(self) -> str:
        rates = ", ".join(f"{name} {rate:.0%}" for name, rate in self.rates.items())
        return f"<{self.phase}, steps {self.first_step:,} to {self.last_step:,}: {rates}>"


@dataclass(frozen=True)
class RankedEvent:
    """An event and its contingency at the end."""

    event: str
    value: float


@dataclass(frozen=True, repr=False)
class DevelopmentSummary:
    """What a run came to. Nothing in it depends on when or on which machine it ran."""

    world: str
    preset: str
    seed: int
    steps: int
    """Steps done."""
    modules: tuple[LearnedModule, ...]
    detected_without_a_module: tuple[UnmodelledEvent, ...]
    phases: tuple[PhaseSummary, ...]
    measure: str
    """Measure of contingency that ranks the events: ``sac``, ``tc`` or ``local``, SAC where an event is surest to be
    contingent."""
    highest_at_the_end: tuple[RankedEvent, ...]
    """The most contingent events, the highest first."""
    more: Mapping[str, Any] = field(default_factory=dict)
    """What only one world has: who the caregiver was, how well perception did, minutes."""

    def __repr__(self) -> str:
        names = ", ".join(module.means for module in self.modules) or "none"
        return f"<{self.world}, preset {self.preset}, seed {self.seed}, {self.steps:,} steps; modules: {names}>"

    def to_json(self) -> dict[str, Any]:
        """The same as ``summary.json`` has it."""
        return {
            "world": self.world,
            "preset": self.preset,
            "seed": self.seed,
            "steps": self.steps,
            "modules": [
                {
                    "module": module.number,
                    "step": module.step,
                    "event": module.event,
                    "symbol": module.symbol,
                    "name": module.name,
                    "means": module.means,
                    "map": map_name(module.number),
                }
                for module in self.modules
            ],
            "detected_without_a_module": [vars(event) for event in self.detected_without_a_module],
            "behaviours": dict(zip(SHORT, BEHAVIOURS, strict=True)),
            "phases": [vars(part) | {"rates": dict(part.rates)} for part in self.phases],
            "measure": self.measure,
            "highest_at_the_end": [vars(event) for event in self.highest_at_the_end],
            **self.more,
        }

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> "DevelopmentSummary":
        """What ``to_json`` gave; keys of the last version are taken with a warning.

        Raises:
            KeyError: Something is missing.
            TypeError: Something is of another kind.
        """
        for old, name in OLD_KEYS.items():
            if old in document:
                warn_renamed(f"{old} in a summary of development", name)
        more = {OLD_KEYS.get(key, key): value for key, value in document.items()}
        modules = [
            LearnedModule(
                module["module"], module["step"], module["event"], module["symbol"], module["name"], module["means"]
            )
            for module in more.pop("modules")
        ]
        del more["behaviours"]
        return cls(
            world=more.pop("world"),
            preset=more.pop("preset"),
            seed=more.pop("seed"),
            steps=more.pop("steps"),
            modules=tuple(modules),
            detected_without_a_module=tuple(
                UnmodelledEvent(**event) for event in more.pop("detected_without_a_module")
            ),
            phases=tuple(PhaseSummary(**part) for part in more.pop("phases")),
            measure=more.pop("measure"),
            highest_at_the_end=tuple(RankedEvent(**event) for event in more.pop("highest_at_the_end")),
            more=more,
        )


def map_name(number: int) -> str:
    """Name of the file with the map of a module, which are counted from 1."""
    return f"module_{number}.csv"


def summarise(
    run: DevelopmentRun, names: Mapping[str, Any], known: Sequence[Meaning], parts: Sequence[BehaviourPhase]
) -> DevelopmentSummary:
    """The summary of a run that has ended.

    Args:
        run: The run.
        names: World, preset and seed.
        known: What each module means.
        parts: Behaviour by phases.
    """
    agent = run.agent
    made: list[LearnedModule] = []
    beyond: list[UnmodelledEvent] = []
    for detection in run.detections:
        event = agent.variables.describe(detection.event)
        if detection.module is None:
            beyond.append(UnmodelledEvent(detection.step, event))
            continue
        meaning, symbol = known[len(made)], agent.variables.symbol(detection.event)
        made.append(LearnedModule(len(made) + 1, detection.step, event, symbol, meaning.short, meaning.words))
    contingency = agent.state.watch.values
    order = np.argsort(-contingency, kind="stable")[:RANKED].tolist()
    return DevelopmentSummary(
        **names,
        steps=run.steps_done,
        modules=tuple(made),
        detected_without_a_module=tuple(beyond),
        phases=tuple(
            PhaseSummary(
                f"P{number}",
                part.first + 1,
                part.last,
                {short: round(rate, 4) for short, rate in zip(SHORT, part.rates, strict=True)},
            )
            for number, part in enumerate(parts, 1)
        ),
        measure=agent.config.detector.ranks_by,
        highest_at_the_end=tuple(
            RankedEvent(agent.variables.describe(agent.events[event]), float(contingency[event])) for event in order
        ),
        more=plain(run.more()),
    )
