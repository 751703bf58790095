"""Whether what was found is true: evidence from other steps, in which no module acts.

What a robot has found it also does, and hardly anything else; its own steps then say little of what would be otherwise.
Here another robot looks about at random in the same world. What the modules of the first say of its steps, by
hindsight, is held against the results. How often the face is frontal, after gaze was followed and else, is counted as
well.
"""

from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np

from jointattn_mj.contingency.online.detector import DetectorConfig
from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.online.experience import PastSteps, beyond_last
from jointattn_mj.contingency.online.local import LocalConfig
from jointattn_mj.contingency.online.local_values import count, log_evidence
from jointattn_mj.development.agent import DeveloperConfig
from jointattn_mj.development.config import DevelopmentConfig
from jointattn_mj.development.table.run import TableRun
from jointattn_mj.options import Checked, Whole

OTHER = 10_000_000
"""Added to the seed of a run: that of the other robot."""


@dataclass(frozen=True)
class Later(Checked):
    """A run at the table, and how long another robot looks about at random."""

    development: DevelopmentConfig
    random_steps: Annotated[int, Whole("[1000, 1e8]")] = 300_000


def later(config: Later, seed: int) -> dict[str, Any]:
    """What was found, and the evidence of it from steps of another robot.

    Args:
        config: What to run.
        seed: Of the run; the other robot has one of its own.

    Returns:
        ``modules`` and ``turns`` of what was found; ``evidence`` of each, nats, and ``beyond``, the same with results
        conditioned on what came of the same action last time; ``looks``: looks from an object at the face, and how
        many found it frontal, after gaze was followed and else.
    """
    run = replace(config.development, seed=seed).new_run()
    run.advance(run.n_steps)
    made = [detection for detection in run.detections if detection.module is not None]
    agent, n = run.agent, config.random_steps
    looks_never = DeveloperConfig(DetectorConfig(stop_rule="local"), LocalConfig(first_look=n + 1))
    other = TableRun(config.development.table, looks_never, seed + OTHER, n, sample_every=n)
    other.advance(n)
    steps = other.agent.steps(agent.variables, agent.modules)
    events = [detection.event for detection in made]
    evidence, beyond = [], []
    for number, event in enumerate(events):
        alike = [steps.of_world + earlier for earlier in range(number) if events[earlier].result == event.result]
        series = steps.columns([event], True, {event.result: alike}).of(0)
        for columns, logs in ((series, evidence), (beyond_last(series), beyond)):
            table = np.zeros(columns.sizes)
            count(*columns.columns, (0, n), table)
            logs.append(log_evidence(table))
    return {
        "modules": [agent.variables.symbol(event) for event in events],
        "turns": [detection.step for detection in made],
        "evidence": evidence,
        "beyond": beyond,
        "looks": _looks(steps, other.spots) if made else [],
    }


def _looks(steps: PastSteps, face: int) -> list[list[int]]:
    """(2, 2) looks from an object at the face, and how many found it frontal, after module 1 was used and else."""
    used, gaze, frontal, next_frontal = steps.of(Event(steps.of_world, 0, 0)).columns
    profile = steps.of(Event(steps.of_world, 0, 1)).columns[2]
    seen = steps.of(Event(steps.of_world, 0, 2)).columns[2]
    looked = (gaze == face) & (frontal == 0) & (profile == 0) & (seen == 1)
    looked[-1] = False
    counted = []
    for value in (1, 0):
        at = np.flatnonzero(looked & (used == value))
        counted.append([len(at), int(next_frontal[at + 1].sum())])
    return counted
