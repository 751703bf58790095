"""Runs from images in which the module of gaze following gets a continuous map; other ways of learning from the same
data, for comparison."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING
from jointattn_mj.contingency.online.reactive import RandomModule
from jointattn_mj.development.meaning import FACE, GAZE, OBJECT
from jointattn_mj.development.rendered.continuous import FORWARD, SCATTERED, ContinuousConfig, ContinuousRun, Pair
from jointattn_mj.development.rendered.run import RenderedConfig
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.development.table.world import step
from jointattn_mj.gaze_following.learners import Learner, LearnerConfig, Locations, make_learner
from jointattn_mj.options import Checked, Whole
from jointattn_mj.scene.camera import directions_to, off_centre
from jointattn_mj.sweeps.claim import Setting

WITHIN_DEG = 3.5
"""As in chapter 6."""
CHECKPOINTS = (250, 500, 1000, 2000, 3500, 5000)
"""Steps after the event was found at which maps are examined."""
LINEAR = LearnerConfig(code="linear", rate=0.1)


@dataclass(frozen=True)
class ScatteredRun(Checked):
    """A run and the examination of its maps."""

    world: RenderedConfig = SCATTERED
    continuous: ContinuousConfig = field(default_factory=ContinuousConfig)
    most: Annotated[int, Whole("[1, 1e10]")] = 20_000
    """Most steps until gaze following is found."""
    after: Annotated[int, Whole("[1, 1e10]")] = CHECKPOINTS[-1]
    """Steps after it was found."""
    looks: Annotated[int, Whole("[1, 1e6]")] = 200
    """Held-out faces."""


FIRST_SEED = 50_000
FILM = Path(__file__).with_name("continuous.mp4")
"""Made by ``python -m experiments.continuous.film``."""
SETTINGS = {"scattered": Setting(ScatteredRun(), runs=20)}


@dataclass(frozen=True)
class Look:
    """A held-out face, with the directions (deg) of the caregiver's object and of all others."""

    activations: np.ndarray
    category: int
    target: np.ndarray
    others: np.ndarray


def trial(config: ScatteredRun, seed: int) -> dict[str, Any]:
    """Step of gaze following, landings by table and by map, and errors of every map at the checkpoints."""
    preset = PRESETS["fast"]
    run = ContinuousRun(
        preset.world, config.world, preset.agent, seed, config.most + config.after, config.continuous,
        (RandomModule(GAZE),),
    )  # fmt: skip
    following = None
    while run.steps_done < config.most and following is None:
        run.advance(100)
        following = next(
            (detection for detection in run.detections if detection.module and _follows(run, detection.module.event)),
            None,
        )
    categories = run.senses.categories.count
    if following is None:
        return {"found": None, "categories": categories}
    run.advance(config.after)
    by = {
        name: [(landing.off_deg, landing.nearest) for landing in run.landings if landing.by_map is by_map]
        for name, by_map in (("table", False), ("map", True))
    }
    looks = list(_looks(run, config.looks, np.random.SeedSequence(seed).spawn(7)[6]))
    return {
        "found": following.step,
        "categories": categories,
        "ready": next((landing.step for landing in run.landings if landing.by_map), None),
        "landings": {name: _landed(rows) for name, rows in by.items()},
        "pairs": _numbers(run.pairs, following.step),
        "maps": _maps(run, following.step, looks),
    }


def _follows(run: ContinuousRun, event: Event) -> bool:
    variables = run.agent.variables
    names = variables.sensors[event.sensor].name, variables.actions[event.action].name
    return (*names, variables.results[event.result].name) == (FACE, GAZE, OBJECT)


def _landed(rows: Sequence[tuple[float, bool]]) -> dict[str, Any]:
    off = [deg for deg, _ in rows]
    return {
        "n": len(rows),
        "median_deg": float(np.median(off)) if off else None,
        "within": float(np.mean(np.array(off) <= WITHIN_DEG)) if off else None,
        "nearest": float(np.mean([nearest for _, nearest in rows])) if off else None,
    }


def _numbers(pairs: Sequence[Pair], detected_at: int) -> dict[str, int]:
    since = [pair for pair in pairs if pair.step >= detected_at]
    forward = [pair for pair in since if pair.order == FORWARD]
    return {
        "face to object": len(forward),
        "informative": sum(pair.informative for pair in forward),
        "object to face": len(since) - len(forward),
    }


def _looks(run: ContinuousRun, count: int, seed: np.random.SeedSequence) -> Iterable[Look]:
    """Held-out faces that look at objects, seen at another table while the gaze moves at random."""
    of_table, of_moves = seed.spawn(2)
    stage, rng = run.stage, np.random.default_rng(of_moves)
    stage.begin(of_table)
    while count:
        action = np.array([run.spots if rng.random() < 0.5 else rng.integers(run.spots), 0])
        step(stage.table, action, stage.sensors, stage.results)
        stage.show(0, run.heads)
        shown = run.body.perceive()
        target = run.target()
        if shown.pattern is None or target is None:
            continue
        directions = directions_to(np.vstack([target, stage.world.caregiver.objects]))
        others = directions[1:][np.abs(directions[1:] - directions[0]).max(axis=1) > 1e-9]
        categories = run.senses.categories
        yield Look(categories.som.activations(shown.pattern), categories.of(shown.pattern), directions[0], others)
        count -= 1


def _maps(run: ContinuousRun, detected_at: int, looks: Sequence[Look]) -> dict[str, list[dict[str, Any]]]:
    """Errors of each way of learning at the checkpoints. Before the event was found, gaze was random."""
    following = run.following
    if following is None:
        return {}
    since = [pair for pair in run.pairs if pair.step >= detected_at]
    before = [pair for pair in run.pairs if pair.step < detected_at]
    face, gaze, object_there = (run.log(name).astype(int) for name in (FACE, GAZE, OBJECT))
    informative = [
        pair
        for pair in before
        if pair.order == FORWARD
        and following.is_informative(
            object_there[pair.step - 1], face[pair.step - 1], object_there[pair.step], gaze[pair.step - 1]
        )
    ]  # fmt: skip
    population, units = LearnerConfig(), len(run.senses.categories.som.weights)
    chosen = [pair for pair in since if pair.informative]
    forward = [pair for pair in since if pair.order == FORWARD]
    ways = {
        "informative": (population, chosen, detected_at),
        "all": (population, forward, detected_at),
        "chapter 6": (population, since, detected_at),
        "informative, two linear outputs": (LINEAR, chosen, detected_at),
        "all, two linear outputs": (LINEAR, forward, detected_at),
        "gaze at random, informative": (population, informative, 0),
        "gaze at random, all": (population, [pair for pair in before if pair.order == FORWARD], 0),
        "gaze at random, chapter 6": (population, before, 0),
    }
    answers = [following.module.command[0, look.category] for look in looks]
    table = [None if a == OFFERS_NOTHING else np.degrees(run.heads[a]) for a in answers]
    known = {"table": [{"turns": 0, **_judged(table, looks)}]}
    for name, (config, pairs, start) in ways.items():
        learner = make_learner(config, units, np.random.default_rng(0))
        known[name] = list(_examined(learner, pairs, start, detected_at if start == 0 else np.inf, looks))
    return known


def _examined(
    learner: Learner, pairs: Sequence[Pair], start: int, end: float, looks: Sequence[Look]
) -> Iterable[dict[str, Any]]:
    """Errors of a learner on ``looks`` at each checkpoint after step ``start``, up to step ``end``."""
    left = list(pairs)
    for steps in CHECKPOINTS:
        if start + steps > end:
            return
        while left and left[0].step < start + steps:
            learner.learn(left[0].activations, Locations.only(left.pop(0).direction))
        yield {"turns": steps, "pairs": len(pairs) - len(left),
               **_judged([learner.predict(look.activations) for look in looks], looks)}  # fmt: skip


def _judged(directions: Sequence[np.ndarray | None], looks: Sequence[Look]) -> dict[str, Any]:
    """Errors over the looks for which there is a direction; success over all of them."""
    off, nearest = [], 0
    for direction, look in zip(directions, looks, strict=True):
        if direction is not None:
            off.append(off_centre(look.target, direction))
            nearest += all(off[-1] <= off_centre(other, direction) for other in look.others)
    return {
        "answered": len(off) / len(looks),
        "median_deg": float(np.median(off)) if off else None,
        "within": float(np.sum(np.array(off) <= WITHIN_DEG)) / len(looks),
        "nearest": nearest / len(looks),
    }
