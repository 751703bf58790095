"""Lead of the right event after 30,000 steps, for 1 to 9 objects and three values of p_r and p_i (section 4.5.2)."""

from typing import Any

from jointattn_mj.contingency.online.events import Event
from jointattn_mj.sweeps.claim import Setting

from ..tables import TableRunConfig, run_table, table_config, target_lead

CHANCES = (0.25, 0.5, 0.75)
OBJECTS = range(1, 10)
TARGET = Event(0, 0, 1)

FIRST_SEED = 30_000
SETTINGS = {
    f"follow {follow} lead {lead} objects {objects}": Setting(
        table_config(
            "chapter4", n_steps=30_000, **{"caregiver.follow": follow, "caregiver.lead": lead, "world.objects": objects}
        ),
        runs=20,
    )
    for follow in CHANCES
    for lead in CHANCES
    for objects in OBJECTS
}


def trial(config: TableRunConfig, seed: int) -> dict[str, Any]:
    """Difference of T^C in bits between (S1, A1, R2) and the highest other event."""
    return {"lead": target_lead(run_table(config, seed), TARGET)}
