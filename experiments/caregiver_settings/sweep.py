"""Modules under all p_r, p_i of Fig. 5.4, for p_e of 1 and 0 and the values between (section 5.3.3)."""

from jointattn_mj.sweeps.claim import Setting

from ..tables import develop, table_config

CHANCES = (0.0, 0.25, 0.5, 0.75, 1.0)

FIRST_SEED = 30_000
SETTINGS = {
    f"answer {answer} follow {follow} lead {lead}": Setting(
        table_config("thesis", **{"caregiver.answer": answer, "caregiver.follow": follow, "caregiver.lead": lead}),
        runs=10,
    )
    for answer in (1.0, 0.0, 0.75, 0.5, 0.25)
    for follow in CHANCES
    for lead in CHANCES
}
trial = develop
