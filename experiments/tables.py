"""Shared by the experiments of chapters 4 and 5: a run at the symbolic table, and the result kept of it."""

from dataclasses import dataclass, field, replace
from typing import Annotated, Any

import numpy as np

from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.online.reactive import AvoidingModule
from jointattn_mj.development.agent import DeveloperConfig
from jointattn_mj.development.behaviour import behaviours, phases
from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.development.table.run import TableRun
from jointattn_mj.development.table.world import TableConfig
from jointattn_mj.options import Checked, Share, Whole

STAGES = ("(S1, A1, R3)", "(Π1, A1, R1)", "(Π1, A1, R2)")
"""FG-m, SCf-m and SC-m of section 5.3.2: following a gaze, looking back after it, alternating."""


@dataclass(frozen=True)
class TableRunConfig(Checked):
    """An agent at a table for a number of steps."""

    world: TableConfig
    agent: DeveloperConfig
    n_steps: Annotated[int, Whole("[1, 1e10]")] = 100_000
    """Steps of the run."""
    stop_after: Annotated[int, Whole("[0, 1e10]")] = 100
    """Number of modules after which the run may stop."""
    avoids_faces: Share | None = field(default=None)
    """Share of gaze shifts to the face that a face-avoiding reactive module keeps; None: the random module."""


def table_config(preset: str, **changes: Any) -> TableRunConfig:
    """A preset with some fields changed.

    Args:
        preset: Name of a preset.
        changes: New values of fields such as ``world.spots``, ``caregiver.lead``, ``detector.base`` or ``n_steps``.
    """
    chosen = TableRunConfig(PRESETS[preset].world, PRESETS[preset].agent)
    for name, value in changes.items():
        part, _, last = name.partition(".")
        if not last:
            chosen = replace(chosen, **{name: value})
        elif part == "world":
            chosen = replace(chosen, world=replace(chosen.world, **{last: value}))
        elif part == "caregiver":
            caregiver = replace(chosen.world.caregiver, **{last: value})
            chosen = replace(chosen, world=replace(chosen.world, caregiver=caregiver))
        elif part == "agent":
            chosen = replace(chosen, agent=replace(chosen.agent, **{last: value}))
        else:
            inner = replace(getattr(chosen.agent, part), **{last: value})
            chosen = replace(chosen, agent=replace(chosen.agent, **{part: inner}))
    return chosen


def run_table(config: TableRunConfig, seed: int, sample_every: int = 0) -> TableRun:
    """Run an agent at the symbolic table to the end.

    Args:
        config: World, agent and length.
        seed: Seed of the run.
        sample_every: Steps between two logs of contingency; 0 for none.
    """
    avoiding = () if config.avoids_faces is None else (AvoidingModule("shift gaze", "caregiver", config.avoids_faces),)
    run = TableRun(config.world, config.agent, seed, config.n_steps, avoiding, sample_every or config.n_steps)
    while run.steps_done < config.n_steps and len(run.detections) < config.stop_after:
        run.advance(1000)
    return run


def develop(config: TableRunConfig, seed: int) -> dict[str, Any]:
    """Trial: modules and their steps, whether gaze following is right, and rates of behaviour in each phase."""
    run = run_table(config, seed)
    variables, spots = run.agent.variables, config.world.spots
    made = [detection for detection in run.detections if detection.module is not None]
    following = [
        detection.module.command[0] for detection in made[:1] if variables.symbol(detection.event) == STAGES[0]
    ]
    done = behaviours(run.log("caregiver's face"), run.log("shift gaze"), spots)
    return {
        "modules": [variables.symbol(detection.event) for detection in made],
        "turns": [detection.step for detection in made],
        "directions_right": int((following[0][:spots] == np.arange(spots)).sum()) if following else None,
        "phases": [list(phase.rates) for phase in phases(done, [detection.step for detection in made])],
    }


def in_order(result: dict[str, Any]) -> bool:
    """Whether the first three modules are gaze following, looking back, alternating."""
    return tuple(result["modules"][:3]) == STAGES


def time_of(result: dict[str, Any], stage: int) -> float:
    """Step at which module number ``stage`` (from 0) was made; infinite if it never was."""
    return result["turns"][stage] if len(result["turns"]) > stage else np.inf


def target_lead(run: DevelopmentRun, event: Event) -> float:
    """How much higher the measure of an event is than that of any other; below 0 where another is higher."""
    values = run.agent.state.watch.values
    number = run.agent.events.index(event)
    return float(values[number] - np.delete(values, number).max())
