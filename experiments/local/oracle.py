"""How many steps the three modules need at least: a test that knows the true probabilities, in Wald's sequence.

For each event in its order a sequential probability ratio test decides between p(r' | r, s, a) and p(r' | r, a), both
known, with errors of ``error``. The robot has the modules of the events before it, with the maps that many steps give.
No agent that has to learn these probabilities can be as quick, unless it chooses what to do better.
"""

from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np

from jointattn_mj.contingency.online.detector import DetectorConfig
from jointattn_mj.contingency.online.events import Event, Variables
from jointattn_mj.contingency.online.experience import EventSeries
from jointattn_mj.contingency.online.local import LocalConfig
from jointattn_mj.contingency.online.local_values import count
from jointattn_mj.contingency.online.reactive import RandomModule, ReactiveTable
from jointattn_mj.development.agent import DeveloperConfig
from jointattn_mj.development.meaning import CAREGIVER, GAZE
from jointattn_mj.development.table.run import TableRun
from jointattn_mj.development.table.world import TableConfig
from jointattn_mj.options import Checked, Real, Whole

EVENTS = (Event(0, 0, 2), Event(2, 0, 0), Event(2, 0, 1))
"""(S1, A1, R3), (Π1, A1, R1) and (Π1, A1, R2): gaze following, looking back, gaze alternation."""


@dataclass(frozen=True)
class SequentialTest(Checked):
    """A test that knows the ground truth."""

    table: TableConfig
    gaze: Literal["random", "face"] = "random"
    """How the robot looks about. ``face``: at the face in half of the steps, else at any spot."""
    known_from: Annotated[int, Whole("[1000, 1e8]")] = 100_000
    """Steps from which the true probabilities are taken, and maps of modules, before each test."""
    tested_in: Annotated[int, Whole("[1000, 1e8]")] = 20_000
    """Most steps of a test."""
    error: Annotated[float, Real("(0, 0.5)")] = 1e-3
    """Accepted errors of either kind."""


@dataclass(frozen=True)
class FaceModule:
    """Looks at the face in half of the steps, else at any spot."""

    joint: str = GAZE

    def table(self, variables: Variables) -> ReactiveTable:
        """See ``ReactiveModule``."""
        joint = next(event for event in variables.joints if event.name == self.joint)
        odds = np.array([0.5 if value == CAREGIVER else 0.5 / (len(joint.values) - 1) for value in joint.values])
        sensor = variables.sensors[0]
        return ReactiveTable(self.joint, sensor.name, np.tile(odds, (len(sensor.values), 1)), 1.0)


def needed(config: SequentialTest, seed: int) -> dict[str, Any]:
    """Steps that the test of each event needs, one after the other.

    Args:
        config: World, gaze and errors.
        seed: Of the world.

    Returns:
        ``each``: steps of each of the three tests; ``turns``: their sums; infinite where a test decides wrongly.
    """
    span = config.known_from + config.tested_in
    agent = DeveloperConfig(DetectorConfig(stop_rule="local"), LocalConfig(first_look=len(EVENTS) * span + 1))
    reactive = [RandomModule(GAZE)] if config.gaze == "random" else [FaceModule()]
    run = TableRun(config.table, agent, seed, len(EVENTS) * span, reactive, sample_every=span)
    each = []
    for event in EVENTS:
        begin = run.steps_done
        run.advance(span)
        series = run.agent.steps().of(event)
        each.append(_tested(series, begin, begin + config.known_from, config.error))
        run.take_in(run.agent.events.index(event))
    return {"turns": np.cumsum(each).tolist(), "each": each}


def _tested(series: EventSeries, begin: int, middle: int, error: float) -> float:
    """Steps after ``middle`` that the test needs, with the probabilities of those from ``begin`` to ``middle``."""
    table = np.zeros(series.sizes)
    count(*series.columns, (begin, middle), table)
    together = table.sum(axis=1, keepdims=True)
    s, a, before, after = (column[middle:] for column in series.columns)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.log(table / table.sum(axis=-1, keepdims=True)) - np.log(together / together.sum(-1, keepdims=True))
    gained = np.nan_to_num(ratio[before[:-1], s[:-1], a[:-1], after[1:]], nan=0.0)
    total = np.cumsum(gained)
    decided = np.flatnonzero(np.abs(total) >= np.log((1 - error) / error))
    return float(decided[0] + 1) if len(decided) and total[decided[0]] > 0 else np.inf
