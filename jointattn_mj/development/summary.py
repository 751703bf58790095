"""What became of a life, in words and a few numbers."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from jointattn_mj.development.behaviour import BEHAVIOURS, SHORT, BehaviourPhase
from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.meaning import Meaning

RANKED = 10
"""Events that the summary lists by their contingency at the end."""


def summarise(run: DevelopmentRun, known: Sequence[Meaning], parts: Sequence[BehaviourPhase]) -> dict[str, Any]:
    """Modules in their order, behaviour by phases and the ranking at the end, for JSON.

    Nothing in it depends on when or where the life was lived.
    """
    agent = run.agent
    made: list[dict[str, Any]] = []
    beyond: list[dict[str, Any]] = []
    for one in run.found:
        event = agent.variables.describe(one.event)
        if one.module is None:
            beyond.append({"step": one.step, "event": event})
            continue
        meaning, number = known[len(made)], len(made) + 1
        made.append(
            {
                "module": number,
                "step": one.step,
                "event": event,
                "symbol": agent.variables.symbol(one.event),
                "name": meaning.short,
                "means": meaning.words,
                "map": f"module_{number}.csv",
            }
        )
    contingency = agent.state.watch.values
    order = np.argsort(-contingency, kind="stable")[:RANKED]
    return {
        "steps": run.steps_done,
        "modules": made,
        "found_without_a_module": beyond,
        "behaviours": dict(zip(SHORT, BEHAVIOURS, strict=True)),
        "phases": [
            {
                "phase": f"P{number}",
                "first_step": part.first + 1,
                "last_step": part.last,
                "rates": {short: round(rate, 4) for short, rate in zip(SHORT, part.rates, strict=True)},
            }
            for number, part in enumerate(parts, 1)
        ],
        "measure": agent.config.detector.measure,
        "highest_at_the_end": [
            {"event": agent.variables.describe(agent.events[event]), "value": float(contingency[event])}
            for event in order.tolist()
        ],
    }
