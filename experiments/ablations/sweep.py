"""The default reading of chapter 5 with one choice changed."""

import numpy as np

from jointattn_mj.sweeps.claim import Setting

from ..tables import develop, table_config

CHANGES = {
    "default": {},
    "log base e": {"detector.base": float(np.e)},
    "log base 10": {"detector.base": 10.0},
    "stability of the gap of the two highest": {"detector.stability_of": "gap"},
    "no warm-up": {"detector.warm_up": 0},
    "measure T^C": {"detector.measure": "tc"},
    "Miller-Madow": {"detector.correction": "miller_madow"},
    "modelled events drop out": {"detector.modelled": "drop"},
    "full history": {"agent.history": "full"},
    "memory reset": {"agent.memory": "reset"},
    "memory window 20,000": {"agent.memory": "window"},
    "memory fading 20,000": {"agent.memory": "fading"},
    "maps follow the counts": {"agent.refresh_every": 1000},
    "habituation as observed": {"selector.habituates": "observed"},
    "no habituation": {"selector.habituation": 0.0},
    "rule 1 over all not negative": {"reproduction.mean_over": "not_negative"},
    "Z_theta 0": {"reproduction.reliability_gap": 0.0},
    "eye contact: leave": {"caregiver.eye_contact": "leave"},
    "eye contact: any": {"caregiver.eye_contact": "any"},
    "following in eye contact": {"caregiver.follows_eye_contact": True},
    "neutral may follow": {"caregiver.neutral_follows": True},
    "robot first": {"world.order": "robot_first"},
    "avoids faces, a tenth": {"avoids_faces": 0.1},
    "avoids faces, a third": {"avoids_faces": 0.33},
}
FIRST_SEED = 30_000
AVOIDING = {
    f"fast, avoids faces, {words}": share for words, share in (("not", None), ("a third", 0.33), ("a tenth", 0.1))
}
"""The model of autism that section 5.4 proposes, under a rule that does not mistake waiting for certainty."""
SETTINGS = {name: Setting(table_config("thesis", **changes), runs=50) for name, changes in CHANGES.items()} | {
    name: Setting(table_config("fast", avoids_faces=share), runs=50) for name, share in AVOIDING.items()
}
trial = develop
