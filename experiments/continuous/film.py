"""The film of claim continuous: ``python -m experiments.continuous.film``. One life: gaze at random, gaze following by
its table, the same by its continuous map; of the latter two, moments in which the module moves the gaze."""

import pickle
from collections import deque
from collections.abc import Iterator
from itertools import islice

import tyro

from experiments.continuous.sweep import FILM, Trial
from jointattn_mj.contingency.online.reactive import RandomModule
from jointattn_mj.development.meaning import GAZE
from jointattn_mj.development.rendered.continuous import ContinuousLife
from jointattn_mj.development.rendered.film import LifeFilm
from jointattn_mj.development.table.presets import PRESETS

SEED = 7
LEAD = 2
"""Turns shown before the module moves the gaze."""


def moments(life: ContinuousLife, by_map: bool) -> Iterator[ContinuousLife]:
    """The life as it was a few turns before each of the next times in which the module moved the gaze."""
    before: deque[bytes] = deque(maxlen=LEAD)
    while life.lived < life.turns:
        before.append(pickle.dumps(life))
        known = len(life.landings)
        life.live(1)
        if len(life.landings) > known and life.landings[-1].by_map is by_map and len(before) == LEAD:
            yield pickle.loads(before[0])
            before.clear()


def main() -> None:
    """Live, and film."""
    preset, trial = PRESETS["fast"], Trial()
    life = ContinuousLife(
        preset.world, trial.world, preset.mind, SEED, trial.most + trial.after, trial.continuous, (RandomModule(GAZE),)
    )
    with LifeFilm(FILM) as film:
        life.live(100)
        film.scene(life, "Objects lie anywhere in the row; gaze at random", 5)
        while life.following is None:
            life.live(50)
        for moment in islice(moments(life, by_map=False), 3):
            film.scene(moment, "Gaze following is found: its table knows three directions", LEAD + 1)
            moment.close()
        life.live(4000)
        for moment in islice(moments(life, by_map=True), 5):
            pairs = sum(pair.informative for pair in moment.pairs)
            title = f"Its continuous map, learned from {pairs} informative pairs, moves the head"
            film.scene(moment, title, LEAD + 1)
            moment.close()
    life.close()


if __name__ == "__main__":
    tyro.cli(main)
