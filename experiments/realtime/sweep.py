"""An hour in real time with a caregiver who does not wait, with and without motion cues; and the cost of each link."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.meaning import meanings
from jointattn_mj.development.realtime.run import RealtimeConfig, RealtimeRun
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.development.table.run import TableRun
from jointattn_mj.development.table.world import TableConfig
from jointattn_mj.options import Checked, Real, Whole
from jointattn_mj.sweeps.claim import Setting

MODULES = 3
"""Modules after which a run may stop: the third is gaze alternation, or the order is another."""
MOST_STEPS = 40_000
STEPS_AN_HOUR = 6_000
"""In real time it is some 5,400."""


@dataclass(frozen=True)
class Hour(Checked):
    """An agent of the preset ``fast`` and a caregiver, for a number of simulated minutes."""

    realtime: RealtimeConfig
    minutes: Annotated[float, Real("(0, 1e6]")] = 60.0


@dataclass(frozen=True)
class TableHour(Checked):
    """The same agent at the symbolic table, for about as many steps as an ``Hour`` has."""

    table: TableConfig
    steps: Annotated[int, Whole("[1, 1e10]")]


def _hour(perception: Literal["pixels", "state"], cues: bool, minutes: float = 60.0, **changes: Any) -> Hour:
    config = RealtimeConfig()
    config = replace(config, perception=perception, attention=replace(config.attention, motion_cues=cues), **changes)
    return Hour(config, minutes)


FIRST_SEED = 40_000
"""The caregiver's pace was chosen while looking at seeds below 150, with perception taken from the state. Three mends
of the robot's senses were made after some runs on these very seeds had been seen."""
SETTINGS = {
    "pixels/cues": Setting(_hour("pixels", True), runs=20),
    "pixels/no_cues": Setting(_hour("pixels", False), runs=20),
    "state/cues": Setting(_hour("state", True, 90.0), runs=20),
    "state/no_cues": Setting(_hour("state", False, 90.0), runs=20),
    "table": Setting(TableHour(PRESETS["fast"].world, STEPS_AN_HOUR), runs=100),
    "table, objects stay": Setting(
        TableHour(replace(PRESETS["fast"].world, replaced_every=40), STEPS_AN_HOUR), runs=100
    ),
}
"""Perception, a slash, and whether there are motion cues; then runs at the symbolic table."""


def trial(config: Hour | TableHour, seed: int) -> dict[str, Any]:
    """Modules, what they mean, when they were made, and how the robot saw and moved."""
    if isinstance(config, TableHour):
        preset = PRESETS["fast"]
        table = TableRun(config.table, preset.agent, seed, config.steps, sample_every=config.steps)
        while table.steps_done < table.n_steps and len(table.detections) < MODULES:
            table.advance(100)
        return _made(table)
    preset = PRESETS["fast"]
    run = RealtimeRun(preset.world, config.realtime, preset.agent, seed, MOST_STEPS, sample_every=MOST_STEPS)
    try:
        while run.minutes < config.minutes and run.steps_done < run.n_steps and len(run.detections) < MODULES:
            run.advance(1)
        return {
            **_made(run),
            "minutes": [run.minutes_at(step) for step in _made(run)["turns"]],
            "lived_minutes": run.minutes,
            "faces": run.confusion().tolist(),
            "directions": _directions(run),
            "after_following": _after_following(run),
            "caregiver": run.world.config.scene.caregiver,
        }
    finally:
        run.close()


def _made(run: DevelopmentRun) -> dict[str, Any]:
    made = [detection for detection in run.detections if detection.module is not None]
    variables = run.named_variables()
    return {
        "modules": [variables.symbol(detection.event) for detection in made],
        "means": [meaning.label for meaning in meanings(variables, run.agent.modules)],
        "turns": [detection.step for detection in made],
        "lived": run.steps_done,
    }


def _directions(run: RealtimeRun) -> list[int] | None:
    """Commands of gaze following's map, if it was found first: how many, and how many lead to where the caregiver then
    mostly looks."""
    first = next((detection.module for detection in run.detections if detection.module is not None), None)
    if first is None or run.agent.variables.symbol(first.event) != "(S1, A1, R3)":
        return None
    mostly, commands = run.confusion()[:-1].argmax(axis=1), first.command[:, :-1]
    offered = commands >= 0
    return [int(offered.sum()), int(np.sum(offered & (commands == mostly)))]


def _after_following(run: RealtimeRun) -> dict[str, list[int]] | None:
    """Looks at the caregiver's face, and those that showed it frontal, in the second step after gaze following was used
    and after it was not; until the second module."""
    if not run.detections or run.agent.variables.symbol(run.detections[0].event) != "(S1, A1, R3)":
        return None
    last = run.detections[1].step if len(run.detections) > 1 else run.steps_done
    steps = np.arange(run.detections[0].step, last - 2)
    used, to_face = run.log("driver of shift gaze")[steps] == 0, run.log("shift gaze")[steps + 1] == run.spots
    frontal = run.log("frontal face")[steps + 2] == 1
    return {
        name: [int(np.sum(part & to_face)), int(np.sum(part & to_face & frontal))]
        for name, part in (("used", used), ("not used", ~used))
    }


FILM = Path(__file__).with_name("realtime.mp4")
"""``python -m experiments.realtime.film``: the run of seed FILMED, in which all three are found."""
FILMED = FIRST_SEED + 5
