"""The film of claim continuous: ``python -m experiments.continuous.film``. One run: gaze at random, gaze following
by its table, then by its continuous map; of the latter two, moments in which the module moves the gaze."""

import pickle
from collections import deque
from collections.abc import Iterator
from itertools import islice

import tyro

from jointattn_mj.contingency.online.reactive import RandomModule
from jointattn_mj.development.meaning import GAZE
from jointattn_mj.development.rendered.continuous import ContinuousRun
from jointattn_mj.development.rendered.film import RunFilm
from jointattn_mj.development.table.presets import PRESETS

from .sweep import FILM, ScatteredRun

SEED = 7
LEAD = 2
"""Steps shown before the module moves the gaze."""


def moments(run: ContinuousRun, by_map: bool) -> Iterator[ContinuousRun]:
    """The run as it was a few steps before each of the next times at which the module moved the gaze."""
    before: deque[bytes] = deque(maxlen=LEAD)
    while run.steps_done < run.n_steps:
        before.append(pickle.dumps(run))
        known = len(run.landings)
        run.advance(1)
        if len(run.landings) > known and run.landings[-1].by_map is by_map and len(before) == LEAD:
            yield pickle.loads(before[0])
            before.clear()


def main() -> None:
    """Run and film."""
    preset, trial = PRESETS["fast"], ScatteredRun()
    run = ContinuousRun(
        preset.world, trial.world, preset.agent, SEED, trial.most + trial.after, trial.continuous, (RandomModule(GAZE),)
    )
    with RunFilm(FILM) as film:
        run.advance(100)
        film.scene(run, "Objects lie anywhere in the row; gaze at random", 5)
        while run.following is None:
            run.advance(50)
        for moment in islice(moments(run, by_map=False), 3):
            film.scene(moment, "Gaze following is found: its table knows three directions", LEAD + 1)
            moment.close()
        run.advance(4000)
        for moment in islice(moments(run, by_map=True), 5):
            pairs = sum(pair.informative for pair in moment.pairs)
            title = f"Its continuous map, learned from {pairs} informative pairs, moves the head"
            film.scene(moment, title, LEAD + 1)
            moment.close()
    run.close()


if __name__ == "__main__":
    tyro.cli(main)
