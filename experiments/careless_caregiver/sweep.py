"""Lead of the right event after 30,000 steps with a caregiver who behaves as described with probability p_c only
(section 4.5.3)."""

from typing import Any

from jointattn_mj.contingency.online.events import Event
from jointattn_mj.sweeps.claim import Setting

from ..tables import TableRunConfig, run_table, table_config, target_lead

CARE = tuple(round(0.1 * step, 1) for step in range(11))
TARGET = Event(0, 0, 1)

FIRST_SEED = 30_000
SETTINGS = {
    f"at objects {care}": Setting(table_config("chapter4", n_steps=30_000, **{"caregiver.at_objects": care}), runs=20)
    for care in CARE
}


def trial(config: TableRunConfig, seed: int) -> dict[str, Any]:
    """Difference of T^C in bits between (S1, A1, R2) and the highest other event."""
    return {"lead": target_lead(run_table(config, seed), TARGET)}
