"""State-action contingency of all events every 200 steps (Fig. 5.3)."""

from typing import Any

import numpy as np

from jointattn_mj.sweeps.claim import Setting

from ..tables import TableRunConfig, run_table, table_config

FIRST_SEED = 30_000
SETTINGS = {"caregiver first": Setting(table_config("thesis", n_steps=80_000), runs=20)}


def trial(config: TableRunConfig, seed: int) -> dict[str, Any]:
    """Time courses of the events that were ever among the two highest, and when modules were made."""
    run = run_table(config, seed, sample_every=200)
    steps, values = run.contingency()
    known = np.nan_to_num(values, nan=-np.inf)
    ever = sorted(set(np.argsort(known, axis=1)[:, -2:].ravel()))
    symbol = run.agent.variables.symbol
    return {
        "turns": steps.tolist(),
        "values": {
            symbol(run.agent.events[number]): [None if np.isnan(v) else float(v) for v in values[:, number]]
            for number in ever
        },
        "modules": [symbol(detection.event) for detection in run.detections],
        "made": [detection.step for detection in run.detections],
    }
