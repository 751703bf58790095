"""One plain setting."""

from jointattn_mj.sweeps.claim import Setting

SETTINGS = {"only": Setting({"x": 1}, 2)}
FIRST_SEED = 5
VERSION = 3


def trial(config, seed):
    """Nothing much."""
    return {"sum": config["x"] + seed}
