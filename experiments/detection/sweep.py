"""The robot of chapter 4 acts at random and measures T^C of all events (section 4.5.2)."""

from typing import Any

import numpy as np

from jointattn_mj.sweeps.claim import Setting

from ..tables import TableRunConfig, run_table, table_config

TARGET = "(S1, A1, R2)"
POINTS = 80
"""Number of steps, evenly spaced on a log axis, kept of a time course."""

FIRST_SEED = 30_000
SETTINGS = {
    "chapter4": Setting(table_config("chapter4"), runs=20),
    "chapter4_nats": Setting(table_config("chapter4", **{"detector.base": float(np.e)}), runs=20),
    "long": Setting(table_config("chapter4", n_steps=3_000_000), runs=5),
}


def trial(config: TableRunConfig, seed: int) -> dict[str, Any]:
    """Time courses of all events, when the stopping rule held, and since when the right event has been the first."""
    run = run_table(config, seed, sample_every=100)
    steps, values = run.contingency()
    symbols = [run.agent.variables.symbol(event) for event in run.agent.events]
    wrong = np.flatnonzero(values.argmax(axis=1) != symbols.index(TARGET))
    kept = np.unique(np.geomspace(1, len(steps), POINTS).astype(int)) - 1
    return {
        "stop": run.detections[0].step if run.detections else None,
        "first_at_stop": symbols[run.agent.events.index(run.detections[0].event)] if run.detections else None,
        "right_since": int(steps[wrong[-1] + 1])
        if len(wrong) and wrong[-1] + 1 < len(steps)
        else (None if len(wrong) else 100),
        "turns": steps[kept].tolist(),
        "values": {symbol: values[kept, number].tolist() for number, symbol in enumerate(symbols)},
    }
