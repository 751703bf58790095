"""Each measure ranks the events of the same run, over growing lengths."""

from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np

from jointattn_mj.contingency import (
    combined_transfer_entropy,
    conditional_mutual_information,
    linear_granger,
    local_contingency,
    mutual_information,
    state_action_contingency,
    transfer_entropy,
)
from jointattn_mj.sweeps.claim import Setting

from ..tables import TableRunConfig, run_table, table_config

FIRST_SEED = 30_000
LENGTHS = tuple(int(n) for n in np.unique(np.geomspace(500, 40_000, 20).round(-2)))
SETTINGS = {"chapter4": Setting(table_config("chapter4", n_steps=LENGTHS[-1]), runs=20)}

Measured = Callable[[np.ndarray, np.ndarray, np.ndarray], float]


def _strongest_entry(s: np.ndarray, a: np.ndarray, r: np.ndarray) -> float:
    return max((entry.z for entry in local_contingency(s, a, r) if entry.contribution > 0), default=0.0)


OF_EVENTS: dict[str, Measured] = {
    "T^C": combined_transfer_entropy,
    "T^C, Miller-Madow": lambda s, a, r: combined_transfer_entropy(s, a, r, correction="miller_madow"),
    "T^C, degrees of freedom": lambda s, a, r: combined_transfer_entropy(s, a, r, correction="degrees_of_freedom"),
    "T^C, effective (shuffled)": lambda s, a, r: combined_transfer_entropy(
        s, a, r, correction="shuffle", surrogates=20
    ),
    "T^C, normalised": lambda s, a, r: combined_transfer_entropy(
        s, a, r, correction="miller_madow", normalise="smallest"
    ),
    "SAC": state_action_contingency,
    "SAC, Miller-Madow": lambda s, a, r: state_action_contingency(s, a, r, correction="miller_madow"),
    "local: the strongest cell": _strongest_entry,
}
OTHERS: dict[str, Measured] = {
    "I(S; R')": lambda s, a, r: mutual_information(s, r),
    "I(S; R' | A)": lambda s, a, r: conditional_mutual_information(s, r, a, correction="miller_madow"),
    "T(S -> R)": lambda s, a, r: transfer_entropy(s, r, correction="miller_madow"),
    "Granger, S -> R": lambda s, a, r: linear_granger(s, r),
    "Granger, S -> R given A": lambda s, a, r: linear_granger(s, r, a),
}
"""What the dissertation would be compared with; those with A in their name take each action in turn."""
MEASURES = OF_EVENTS | OTHERS
TARGET = (0, 0, 1)


def trial(config: TableRunConfig, seed: int) -> dict[str, Any]:
    """For each measure, whether (S1, A1, R2) is the first of all events, at each of LENGTHS.

    A measure without action counts as right where (S1, R2) is the first.
    """
    run = run_table(config, seed)
    variables = run.agent.variables
    s, a, r = (
        [run.log(variable.name) for variable in group]
        for group in (variables.sensors, variables.joints, variables.results)
    )
    events = list(product(range(len(s)), range(len(a)), range(len(r))))
    right: dict[str, list[bool]] = {name: [] for name in MEASURES}
    for length in LENGTHS:
        for name, measure in MEASURES.items():
            values = [measure(s[i][:length], a[j][:length], r[k][:length]) for i, j, k in events]
            best = events[int(np.argmax(values))]
            needs_action = name in OF_EVENTS or "A" in name
            right[name].append(best == TARGET if needs_action else (best[0], best[2]) == (TARGET[0], TARGET[2]))
    return {"lengths": list(LENGTHS), "right": right}
