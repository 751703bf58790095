"""The presets ``fast`` and ``thesis`` in the world of chapter 5, and in others for which nothing was tuned."""

from jointattn_mj.sweeps.claim import Setting

from ..tables import develop, table_config

SPOTS = (2, 3, 4, 5, 6)
CHANCES = (0.25, 0.5, 0.75)


def _other_world(preset: str, spots: int, follow: float, lead: float, n_steps: int) -> Setting:
    changes = {
        "world.spots": spots, "world.objects": min(2, spots - 1), "caregiver.follow": follow, "caregiver.lead": lead,
        "n_steps": n_steps, "stop_after": 3,
    }  # fmt: skip
    return Setting(table_config(preset, **changes), runs=20)


FIRST_SEED = 30_000
SETTINGS = {
    "fast": Setting(table_config("fast"), runs=100),
    "thesis": Setting(table_config("thesis"), runs=100),
    **{
        f"{preset} spots {spots} follow {follow} lead {lead}": _other_world(preset, spots, follow, lead, n_steps)
        for preset, n_steps in (("fast", 60_000), ("thesis", 100_000))
        for spots in SPOTS
        for follow in CHANCES
        for lead in CHANCES
    },
    **{
        f"fast {option} {value}": Setting(
            table_config("fast", **{f"detector.{option}": value, "stop_after": 3}), runs=50
        )
        for option, values in (
            ("deviations", (1.5, 2.0, 4.0)),
            ("precision", (0.25, 0.7, 1.0)),
            ("tolerance", (0.0, 0.5)),
            ("correction", ("none",)),
        )
        for value in values
    },
}
trial = develop
