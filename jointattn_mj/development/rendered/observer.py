"""What lives at a table that is seen have in common: an onlooker who knows what there was to be seen."""

from collections.abc import Callable
from typing import Any

import numpy as np

from jointattn_mj.contingency.online.events import Variables
from jointattn_mj.development.agent import Developer
from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.meaning import FACE, GAZE, LOOKED_AT
from jointattn_mj.development.rendered.senses import named_by_majority
from jointattn_mj.development.table.world import LOOKS_AT, TableConfig, table_variables, table_witnessed
from jointattn_mj.io.rows import spans

OBJECT_THERE = "object at the centre"
"""Column of the log that the robot does not know; the last one."""
PART_TURNS = 1 << 16
"""Turns that are counted at a time."""


class ObservedRun(DevelopmentRun):
    """A life whose first sensor is a category of faces; the last value of its gaze command is the caregiver's face.

    Attributes:
        table: What the table is like, and what she does there.
    """

    def __init__(self, agent: Developer, table: TableConfig, n_steps: int, sample_every: int):
        """See ``DevelopmentRun``; a row of the log ends with where she looks, by which rule, and OBJECT_THERE."""
        super().__init__(agent, n_steps, sample_every, {**table_witnessed(table), OBJECT_THERE: ("no", "yes")})
        self.table, self.spots = table, table.spots
        self._truths = table_variables(table).sensors[0].values

    def faces(self, first: int = 0, last: int | None = None) -> np.ndarray:
        """See ``DevelopmentRun``."""
        return faces_looked_at(self, len(self.agent.variables.joints[0].values) - 1, first, last)

    def named_variables(self) -> Variables:
        """See ``DevelopmentRun``: categories of faces by what she mostly looked at."""
        return named_by_majority(self.agent.variables, self.confusion(), self._truths)

    def more(self) -> dict[str, Any]:
        """See ``DevelopmentRun``: how well perception did."""
        values = self.agent.variables.sensors[0].values
        faces = [dict(zip(self._truths, row, strict=True)) for row in self.confusion().tolist()]
        objects = self.object_confusion().tolist()
        return {
            "sensed_face_by_truth": dict(zip(values, faces, strict=True)),
            "sensed_object_by_truth": {"object": objects[0], "none": objects[1]},
        }

    def confusion(self) -> np.ndarray:
        """(values of S1, spots + 2) how often each value was sensed under each truth; see ``faces``."""
        return confusion(self, FACE, self.faces, (len(self.agent.variables.sensors[0].values), self.spots + 2))

    def object_confusion(self) -> np.ndarray:
        """(2, 2) how often an object, or none, was sensed (rows) when there was one, or none (columns)."""
        return confusion(self, LOOKED_AT, lambda first, last: 1 - self.log(OBJECT_THERE, first, last), (2, 2))


def faces_looked_at(run: DevelopmentRun, to_face: int, first: int, last: int | None) -> np.ndarray:
    """``DevelopmentRun.faces`` where the gaze command ``to_face`` turns to the caregiver's face, as at first."""
    last = run.steps_done if last is None else last
    before = run.log(GAZE, max(first - 1, 0), max(last - 1, 0))
    gaze = np.concatenate([[to_face], before])[:last] if first == 0 else before
    return np.where(gaze == to_face, run.log(LOOKS_AT, first, last), run.spots + 1)


def confusion(
    run: DevelopmentRun, sensed: str, truth: Callable[[int, int], np.ndarray], shape: tuple[int, int]
) -> np.ndarray:
    """Counts (``shape``) of turns by what was sensed, a column of the log, and by ``truth`` of some turns."""
    counts = np.zeros(shape, np.int64)
    for first, last in spans(run.steps_done, PART_TURNS):
        np.add.at(counts, (run.log(sensed, first, last), truth(first, last)), 1)
    return counts
