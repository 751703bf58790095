"""Tables of 2 to 5 spots that the robot does not know: the values it comes to tell apart, and what an agent finds with
them."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from jointattn_mj.contingency.online.events import Variables
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING, Module
from jointattn_mj.contingency.online.reactive import RandomModule
from jointattn_mj.contingency.online.resolution import Growth, Step, contingency
from jointattn_mj.development.meaning import FACE, GAZE, OBJECT
from jointattn_mj.development.rendered.growing import Babbling, FreeGazeBody, GrowingConfig, GrowingRun, RecallingBody
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.options import Checked, Whole
from jointattn_mj.sweeps.claim import Setting


@dataclass(frozen=True)
class GrowingTrial(Checked):
    """Some steps of babbling, then an agent for some steps."""

    spots: Annotated[int, Whole("[2, 120]")]
    images: bool = False
    """Whether every step is rendered; else faces come from an album of images, and objects from geometry."""
    n_steps: Annotated[int, Whole("[1, 1e10]")] = 40_000
    agent_steps: Annotated[int, Whole("[0, 1e10]")] = 20_000
    growing: GrowingConfig = field(default_factory=GrowingConfig)


FIRST_SEED = 50_000
FILM = Path(__file__).with_name("resolution.mp4")
"""Made by ``python -m experiments.resolution.film``."""
SETTINGS = {
    **{f"{spots} spots": Setting(GrowingTrial(spots), runs=20) for spots in (2, 3, 4, 5)},
    "an image every step, 3 spots": Setting(GrowingTrial(3, images=True, n_steps=20_000, agent_steps=10_000), runs=4),
}


def trial(config: GrowingTrial, seed: int) -> dict[str, Any]:
    """The splits, what the values mean in the end, and what the preset ``fast`` found with them."""
    preset = PRESETS["fast"]
    table = replace(preset.world, spots=config.spots, objects=min(2, config.spots - 1))
    babbling = Babbling(table, config.growing, seed, FreeGazeBody if config.images else RecallingBody)
    babbling.advance(config.n_steps)
    growth, given = babbling.growth, babbling.experience()
    confusion = _confusion(babbling)
    truth = np.degrees(babbling.body.stage.locations)
    result = {
        "steps": [_step(step) for step in growth.steps],
        "confusion": confusion.tolist(),
        "regions": [box.tolist() for box in growth.resolution.boxes],
        "directions": babbling.commands().tolist(),
        "space": babbling.body.space.tolist(),
        "places": truth.tolist(),
        "contingency": contingency(given, growth.resolution),
        "shuffled": _shuffled(babbling, np.random.default_rng(seed)),
    }
    run = GrowingRun(babbling, preset.agent, seed, config.agent_steps, (RandomModule(GAZE),))
    following = None
    while run.steps_done < config.agent_steps and following is None:
        run.advance(100)
        following = next(
            (
                detection
                for detection in run.detections
                if detection.module and _follows(run.agent.variables, detection.module)
            ),
            None,
        )
    result["first"] = run.agent.variables.symbol(run.detections[0].event) if run.detections else None
    result["found"] = None if following is None else following.step
    result["right"] = (
        None if following is None or following.module is None else _right(following.module, confusion, run)
    )
    return result


def _step(step: Step) -> dict[str, Any]:
    split = step.split
    return {
        "turns": step.n_transitions, "kind": split.kind, "axis": split.axis, "at": split.at, "gain": split.gain,
        "error": split.error, "contingency": step.contingency, "faces": len(step.resolution.sensed),
        "regions": [box.tolist() for box in step.resolution.boxes],
    }  # fmt: skip


def _confusion(babbling: Babbling) -> np.ndarray:
    """(faces, spots + 1) how often each value of S, but the last, came with each target of the caregiver."""
    given = babbling.experience()
    value = babbling.growth.resolution.sensor(given.units)
    counts = np.zeros((len(babbling.growth.resolution.sensed) + 1, babbling.body.spots + 1), np.int64)
    np.add.at(counts, (value, np.array(babbling.looked_at)[:-1]), 1)
    return counts[:-1]


def _shuffled(babbling: Babbling, rng: np.random.Generator) -> int:
    """Number of splits made of the same experience with its faces shuffled."""
    given = babbling.experience()
    sensed, units = given.units >= 0, given.units.copy()
    units[sensed] = rng.permutation(units[sensed])
    growth = Growth(babbling.body.som.weights, babbling.body.space, babbling.body.config.resolution)
    shuffled = given._replace(units=units)
    for steps in range(500, len(units) + 1, 500):
        if growth.due(steps):
            growth.update(shuffled.some(slice(steps)))
    return len(growth.steps)


def _follows(variables: Variables, module: Module) -> bool:
    event = module.event
    names = variables.sensors[event.sensor].name, variables.actions[event.action].name
    return (*names, variables.results[event.result].name) == (FACE, GAZE, OBJECT)


def _right(module: Module, confusion: np.ndarray, run: GrowingRun) -> list[int]:
    """For each spot: 1 if most of the caregiver's faces that look there send the robot's gaze there, else 0."""
    spots, meant = confusion.shape[1] - 1, confusion.argmax(axis=1)
    right = []
    for spot in range(spots):
        values = np.flatnonzero(meant == spot)
        commands = module.command[0, values]
        hits = [
            command not in (OFFERS_NOTHING, len(run.directions)) and run.body.nearest(run.directions[command]) == spot
            for command in commands
        ]
        weights = confusion[values, spot]
        right.append(int(len(values) > 0 and weights @ np.array(hits, int) > weights.sum() / 2))
    return right
