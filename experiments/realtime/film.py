"""``python -m experiments.realtime.film``: one life from pictures, before and after each of its first three modules."""

from pathlib import Path

import tyro

from experiments.realtime.sweep import FILM, FILMED, MODULES, MOST_STEPS
from jointattn_mj.development.meaning import meanings
from jointattn_mj.development.realtime.film import RealtimeFilm
from jointattn_mj.development.realtime.run import RealtimeConfig, RealtimeLife
from jointattn_mj.development.table.presets import PRESETS

BEFORE_MINUTES = 1.0
"""The robot has to move at random for a while, for there to be anything to see."""
SECONDS = 10.0


def film(path: Path = FILM, seed: int = FILMED, minutes: float = 90.0) -> None:
    """Live a life of the setting pixels/cues and film some of its moments."""
    preset = PRESETS["fast"]
    life = RealtimeLife(preset.world, RealtimeConfig(), preset.mind, seed, MOST_STEPS, sample_every=MOST_STEPS)
    life.live_until(BEFORE_MINUTES)
    with RealtimeFilm(path) as reel:
        reel.watch(life, "Before anything was found", SECONDS)
        while life.minutes < minutes and len(life.found) < MODULES:
            if life.live(1) and life.mind.modules:
                known = meanings(life.named_variables(), life.mind.modules)
                reel.watch(life, f"After {known[-1].label}", SECONDS)
    life.close()


if __name__ == "__main__":
    tyro.cli(film)
