"""The robot of chapter 4 acts at random and watches T^C of all events (section 4.5.2)."""

from typing import Any

import numpy as np

from experiments.tables import Run, live, run
from jointattn_mj.sweeps.claim import Setting

TARGET = "(S1, A1, R2)"
POINTS = 80
"""Turns, evenly spaced on a log axis, that are kept of a time course."""

FIRST_SEED = 30_000
SETTINGS = {
    "chapter4": Setting(run("chapter4"), runs=20),
    "chapter4_nats": Setting(run("chapter4", **{"detector.base": float(np.e)}), runs=20),
    "long": Setting(run("chapter4", turns=3_000_000), runs=5),
}


def cell(config: Run, seed: int) -> dict[str, Any]:
    """Time courses of all events, when the stopping rule held, and since when the right event has been the first."""
    life = live(config, seed, sample_every=100)
    turns, values = life.contingency()
    symbols = [life.mind.variables.symbol(event) for event in life.mind.events]
    wrong = np.flatnonzero(values.argmax(axis=1) != symbols.index(TARGET))
    kept = np.unique(np.geomspace(1, len(turns), POINTS).astype(int)) - 1
    return {
        "stop": life.found[0].turn if life.found else None,
        "first_at_stop": symbols[life.mind.events.index(life.found[0].event)] if life.found else None,
        "right_since": int(turns[wrong[-1] + 1])
        if len(wrong) and wrong[-1] + 1 < len(turns)
        else (None if len(wrong) else 100),
        "turns": turns[kept].tolist(),
        "values": {symbol: values[kept, number].tolist() for number, symbol in enumerate(symbols)},
    }
