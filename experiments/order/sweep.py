"""Modules of a robot in 100,000 steps, under two orders of acting within a step (section 5.3.2)."""

from jointattn_mj.sweeps.claim import Setting

from ..tables import develop, table_config

FIRST_SEED = 30_000
SETTINGS = {
    "caregiver first": Setting(table_config("thesis"), runs=100),
    "robot first": Setting(table_config("thesis_robot_first"), runs=100),
}
trial = develop
