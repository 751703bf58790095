"""How often the robot found an object, by where it looked and where the caregiver had looked (section 4.5.4)."""

from typing import Any

import numpy as np

from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.sweeps.claim import Setting

from ..tables import TableRunConfig, run_table, table_config

FIRST_SEED = 30_000
SETTINGS = {"chapter4": Setting(table_config("chapter4", n_steps=30_000), runs=20)}


def shifts_to_objects(run: DevelopmentRun) -> tuple[np.ndarray, np.ndarray]:
    """Caregiver's face (S1) and gaze shift (A1) of every step after which the robot saw an object."""
    at_object = run.log("object")[1:] == 1
    return run.log("caregiver's face")[:-1][at_object], run.log("shift gaze")[:-1][at_object]


def trial(config: TableRunConfig, seed: int) -> dict[str, Any]:
    """Counts (spots, spots): the caregiver looked at spot i, the robot looked at spot j and found an object."""
    spots = config.world.spots
    face, gaze = shifts_to_objects(run_table(config, seed))
    counts = np.zeros((spots, spots), int)
    both = (face < spots) & (gaze < spots)
    np.add.at(counts, (face[both], gaze[both]), 1)
    return {"counts": counts.tolist()}
