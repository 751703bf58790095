"""Coins; ``TOY_TROUBLE`` makes them misbehave: error:3, exit:3, kill:3, kill_once:3:file, sleep:.1."""

import os
import random
import signal
import time
from dataclasses import dataclass
from pathlib import Path

from jointattn_mj.sweeps.claim import Setting


@dataclass(frozen=True)
class Coin:
    """How often it shows heads."""

    heads: float = 0.5
    throws: int = 50


SETTINGS = {"fair": Setting(Coin(), 8), "loaded": Setting(Coin(heads=0.8), 8)}


def trial(coin: Coin, seed: int) -> dict:
    """Share of heads."""
    misbehave(seed)
    rng = random.Random(seed)
    return {
        "heads": sum(rng.random() < coin.heads for _ in range(coin.throws)) / coin.throws,
        "threads": os.environ.get("OMP_NUM_THREADS"),
    }


def misbehave(seed: int) -> None:
    """What ``TOY_TROUBLE`` says."""
    kind, _, rest = os.environ.get("TOY_TROUBLE", "").partition(":")
    which, _, marker = rest.partition(":")
    if kind == "sleep":
        time.sleep(float(which))
    elif kind and seed == int(which):
        if kind == "error":
            raise ValueError("the coin stands on its edge")
        if kind == "exit":
            raise SystemExit(3)
        if kind == "kill" or not Path(marker).exists():
            Path(marker or os.devnull).touch()
            os.kill(os.getpid(), signal.SIGKILL)
