"""``python -m experiments.local.film``: an hour from images, before and after each of its first three modules."""

from dataclasses import replace
from pathlib import Path

import tyro

from jointattn_mj.development.realtime.run import RealtimeRun

from ..realtime.film import filmed
from .sweep import FILM, FILMED, SETTINGS


def film(path: Path = FILM, seed: int = FILMED) -> None:
    """Run the setting realtime/pixels and film some of its moments."""
    run = replace(SETTINGS["realtime/pixels"].config.development, seed=seed).new_run()
    assert isinstance(run, RealtimeRun)
    filmed(run, path, minutes=60.0)


if __name__ == "__main__":
    tyro.cli(film)
