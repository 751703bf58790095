"""The two-layered perceptron of Fig. 4.8, at every learning rate that its author may have used."""

from typing import Any

import numpy as np
from numba import njit

from jointattn_mj.sweeps.claim import Setting

from ..experience.sweep import shifts_to_objects
from ..tables import TableRunConfig, run_table, table_config

RATES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
EPOCHS = (1, 3, 10)

FIRST_SEED = 30_000
SETTINGS = {"chapter4": Setting(table_config("chapter4", n_steps=30_000), runs=20)}


@njit(cache=True)
def train(weights, bias, inputs, outputs, rate):
    """One pass of backpropagation (squared error, sigmoid outputs) over pairs of active input and wanted output.

    Args:
        weights: (inputs, outputs), changed in place.
        bias: (outputs,), changed in place.
        inputs: (pairs,) number of the input that is 1.
        outputs: (pairs,) number of the output that should be 1.
        rate: Learning rate.
    """
    for pair in range(len(inputs)):
        row = weights[inputs[pair]]
        for output in range(len(bias)):
            out = 1.0 / (1.0 + np.exp(-(row[output] + bias[output])))
            step = rate * ((outputs[pair] == output) - out) * out * (1.0 - out)
            row[output] += step
            bias[output] += step


def trial(config: TableRunConfig, seed: int) -> dict[str, Any]:
    """Share of the caregiver's directions that the perceptron answers with the same direction."""
    run = run_table(config, seed)
    face, gaze = shifts_to_objects(run)
    spots = config.world.spots
    values = [len(variable.values) for variable in (run.agent.variables.sensors[0], run.agent.variables.joints[0])]
    success: dict[str, dict[str, float]] = {}
    start = np.random.default_rng(np.random.SeedSequence(seed).spawn(3)[2]).normal(0, 0.1, (values[0], values[1]))
    for epochs in EPOCHS:
        success[str(epochs)] = {}
        for rate in RATES:
            weights, bias = start.copy(), np.zeros(values[1])
            for _ in range(epochs):
                train(weights, bias, face.astype(np.int64), gaze.astype(np.int64), rate)
            answers = (weights + bias)[:spots].argmax(axis=1)
            success[str(epochs)][str(rate)] = float((answers == np.arange(spots)).mean())
    return {"success": success, "pairs": len(face)}
