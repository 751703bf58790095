"""The film of claim resolution: ``python -m experiments.resolution.film``. Every step is rendered: values
are few, split where contingency rises, and with them an agent finds gaze following."""

import pickle
from collections import deque
from dataclasses import replace

import tyro

from jointattn_mj.contingency.online.reactive import RandomModule
from jointattn_mj.development.meaning import GAZE, meanings
from jointattn_mj.development.rendered.growing import Babbling, GrowingRun
from jointattn_mj.development.rendered.growth_film import GrowthFilm
from jointattn_mj.development.table.presets import PRESETS

from .sweep import FILM, GrowingTrial

SEED, SPOTS, MOST = 7, 3, 20_000
AFTER = 5
"""Moments of gaze following that are shown."""
NATS_PER_BIT = 0.6931


def _babbling(run: Babbling) -> list[str]:
    steps = run.growth.steps
    now = f"contingency of face, gaze and object: {steps[-1].contingency / NATS_PER_BIT:.4f} bit" if steps else ""
    return ["Moves its gaze: at random", f"It was told of no spots. Splits so far: {len(steps)}", now]


def _mover(run: GrowingRun) -> str:
    """What moved the gaze to where it is now."""
    drivers = run.log(f"driver of {GAZE}")
    made = meanings(run.named_variables(), run.agent.modules)
    return made[drivers[-2]].label if len(drivers) > 1 and drivers[-2] < len(made) else "at random"


def _driven(run: GrowingRun) -> list[str]:
    names = [meaning.label for meaning in meanings(run.named_variables(), run.agent.modules)]
    return [f"Moves its gaze: {_mover(run)}", "Modules: " + (", ".join(names) or "none yet")]


def main() -> None:
    """Run and film."""
    preset = PRESETS["fast"]
    run = Babbling(replace(preset.world, spots=SPOTS), GrowingTrial(SPOTS).growing, SEED)
    with GrowthFilm(FILM) as film:
        run.advance(50)
        film.growth(run, run.growth.resolution, "At first: a face or none, somewhere or at the caregiver", _babbling, 4)
        while run.steps_done < MOST:
            known = len(run.growth.steps)
            run.advance(1)
            for number, step in enumerate(run.growth.steps[known:], known + 1):
                what = {"S": "Faces split", "A": "Gaze splits"}.get(step.split.kind, "Faces and gaze split together")
                film.growth(
                    run, step.resolution, f"{what}: split {number}, after {step.n_transitions:,} steps", _babbling, 2
                )
        agent = GrowingRun(run, preset.agent, SEED, MOST, (RandomModule(GAZE),))
        agent.advance(1)
        film.growth(agent, agent.resolution, "An agent with these values, before gaze following", _driven, 4)
        while not agent.detections and agent.steps_done < MOST:
            agent.advance(50)
        before: deque[bytes] = deque(maxlen=2)
        shown = 0
        while shown < AFTER and agent.steps_done < MOST:
            before.append(pickle.dumps(agent))
            agent.advance(1)
            if _mover(agent) != "at random" and len(before) == 2:
                moment = pickle.loads(before[0])
                film.growth(moment, agent.resolution, "Gaze following with the values it has found", _driven, 3)
                moment.body.stage.world.close()
                before.clear()
                shown += 1
    run.body.stage.world.close()


if __name__ == "__main__":
    tyro.cli(main)
