"""Rates of six behaviours in the last 1000 steps of each phase between modules (Fig. 5.5)."""

from jointattn_mj.sweeps.claim import Setting

from ..tables import develop, table_config

FIRST_SEED = 30_000
SETTINGS = {
    "caregiver first": Setting(table_config("thesis"), runs=100),
    "robot first": Setting(table_config("thesis_robot_first"), runs=100),
}
trial = develop
