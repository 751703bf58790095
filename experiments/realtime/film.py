"""``python -m experiments.realtime.film``: one run from images, before and after each of its first three modules."""

from pathlib import Path

import tyro

from jointattn_mj.development.meaning import meanings
from jointattn_mj.development.realtime.film import RealtimeFilm
from jointattn_mj.development.realtime.run import RealtimeConfig, RealtimeRun
from jointattn_mj.development.table.presets import PRESETS

from .sweep import FILM, FILMED, MODULES, MOST_STEPS

BEFORE_MINUTES = 1.0
"""The robot has to move at random for a while, for there to be anything to see."""
SECONDS = 10.0


def film(path: Path = FILM, seed: int = FILMED, minutes: float = 90.0) -> None:
    """Run the setting pixels/cues and film some of its moments.

    Args:
        path: Of the video.
        seed: Of the run.
        minutes: Simulated minutes of the run.
    """
    preset = PRESETS["fast"]
    run = RealtimeRun(preset.world, RealtimeConfig(), preset.agent, seed, MOST_STEPS, sample_every=MOST_STEPS)
    filmed(run, path, minutes)


def filmed(run: RealtimeRun, path: Path, minutes: float) -> None:
    """Advance a run until it has its modules, and film it before the first and after each.

    Args:
        run: Before its first step; it is closed.
        path: Of the film.
        minutes: Simulated minutes after which it stops anyway.
    """
    run.run_until(BEFORE_MINUTES)
    with RealtimeFilm(path) as reel:
        reel.watch(run, "Before anything was found", SECONDS)
        while run.minutes < minutes and len(run.detections) < MODULES:
            if run.advance(1) and run.agent.modules:
                known = meanings(run.named_variables(), run.agent.modules)
                reel.watch(run, f"After {known[-1].label}", SECONDS)
    run.close()


if __name__ == "__main__":
    tyro.cli(film)
