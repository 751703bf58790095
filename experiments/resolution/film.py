"""The film of claim resolution: ``python -m experiments.resolution.film``. Every turn of this life is seen: values are
few, split where contingency rises, and with them a mind finds gaze following."""

import pickle
from collections import deque
from dataclasses import replace

import tyro

from experiments.resolution.sweep import FILM, Trial
from jointattn_mj.contingency.online.reactive import RandomModule
from jointattn_mj.development.meaning import GAZE, meanings
from jointattn_mj.development.rendered.growing import Babbling, ResolvedLife
from jointattn_mj.development.rendered.growth_film import GrowthFilm
from jointattn_mj.development.table.presets import PRESETS

SEED, SPOTS, MOST = 7, 3, 20_000
AFTER = 5
"""Moments of gaze following that are shown."""
NATS_PER_BIT = 0.6931


def _babbling(life: Babbling) -> list[str]:
    steps = life.growth.steps
    now = f"contingency of face, gaze and object: {steps[-1].contingency / NATS_PER_BIT:.4f} bit" if steps else ""
    return ["Moves its gaze: at random", f"It was told of no places. Splits so far: {len(steps)}", now]


def _mover(life: ResolvedLife) -> str:
    """What moved the gaze to where it is now."""
    drivers = life.log(f"driver of {GAZE}")
    made = meanings(life.named_variables(), life.mind.modules)
    return made[drivers[-2]].label if len(drivers) > 1 and drivers[-2] < len(made) else "at random"


def _driven(life: ResolvedLife) -> list[str]:
    names = [meaning.label for meaning in meanings(life.named_variables(), life.mind.modules)]
    return [f"Moves its gaze: {_mover(life)}", "Modules: " + (", ".join(names) or "none yet")]


def main() -> None:
    """Live, and film."""
    preset = PRESETS["fast"]
    life = Babbling(replace(preset.world, spots=SPOTS), Trial(SPOTS).growing, SEED)
    with GrowthFilm(FILM) as film:
        life.live(50)
        film.scene(life, life.growth.resolution, "Born: a face or none, somewhere or at her", _babbling, 4)
        while life.lived < MOST:
            known = len(life.growth.steps)
            life.live(1)
            for number, step in enumerate(life.growth.steps[known:], known + 1):
                what = {"S": "Faces split", "A": "Gaze splits"}.get(step.split.kind, "Faces and gaze split together")
                film.scene(life, step.resolution, f"{what}: split {number}, after {step.turns:,} turns", _babbling, 2)
        mind = ResolvedLife(life, preset.mind, SEED, MOST, (RandomModule(GAZE),))
        mind.live(1)
        film.scene(mind, mind.resolution, "A mind with these values, before gaze following", _driven, 4)
        while not mind.found and mind.lived < MOST:
            mind.live(50)
        before: deque[bytes] = deque(maxlen=2)
        shown = 0
        while shown < AFTER and mind.lived < MOST:
            before.append(pickle.dumps(mind))
            mind.live(1)
            if _mover(mind) != "at random" and len(before) == 2:
                moment = pickle.loads(before[0])
                film.scene(moment, mind.resolution, "Gaze following with the values it has found", _driven, 3)
                moment.body.stage.world.close()
                before.clear()
                shown += 1
    life.body.stage.world.close()


if __name__ == "__main__":
    tyro.cli(main)
