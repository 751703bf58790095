"""What became of a life, in words and a few numbers."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from jointattn_mj.development.behaviour import BEHAVIOURS, SHORT, Phase
from jointattn_mj.development.loop import Life
from jointattn_mj.development.meaning import Meaning

RANKED = 10
"""Events that the summary lists by their contingency at the end."""


def summarise(life: Life, known: Sequence[Meaning], parts: Sequence[Phase]) -> dict[str, Any]:
    """Modules in their order, behaviour by phases and the ranking at the end, for JSON.

    Nothing in it depends on when or where the life was lived.
    """
    mind = life.mind
    made: list[dict[str, Any]] = []
    beyond: list[dict[str, Any]] = []
    for one in life.found:
        event = mind.variables.describe(one.event)
        if one.module is None:
            beyond.append({"step": one.turn, "event": event})
            continue
        meaning, number = known[len(made)], len(made) + 1
        made.append(
            {
                "module": number,
                "step": one.turn,
                "event": event,
                "symbol": mind.variables.symbol(one.event),
                "name": meaning.short,
                "means": meaning.words,
                "map": f"module_{number}.csv",
            }
        )
    contingency = mind.mind.watch.values
    order = np.argsort(-contingency, kind="stable")[:RANKED]
    return {
        "steps": life.lived,
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
        "measure": mind.config.detector.measure,
        "highest_at_the_end": [
            {"event": mind.variables.describe(mind.events[event]), "value": float(contingency[event])}
            for event in order.tolist()
        ],
    }
