"""What lives at a table that is seen have in common: an onlooker who knows what there was to be seen."""

from typing import Any

import numpy as np

from jointattn_mj.contingency.events import Variables
from jointattn_mj.rendered.senses import named_by_majority
from jointattn_mj.robots.developer import Developer
from jointattn_mj.robots.life import Life
from jointattn_mj.symbolic.meaning import FACE, GAZE, LOOKED_AT
from jointattn_mj.symbolic.table import LOOKS_AT, TableConfig, table_variables, table_witnessed

OBJECT_THERE = "object at the centre"
"""Column of the log that the robot does not know; the last one."""


class SeeingLife(Life):
    """A life whose first sensor is a category of faces; the last value of its gaze command is the caregiver's face.

    Attributes:
        table: What the table is like, and what she does there.
    """

    def __init__(self, mind: Developer, table: TableConfig, turns: int, sample_every: int):
        """See ``Life``; a turn's row of the log ends with where she looks, by which rule, and OBJECT_THERE."""
        super().__init__(mind, turns, sample_every, {**table_witnessed(table), OBJECT_THERE: ("no", "yes")})
        self.table, self.spots = table, table.spots
        self._truths = table_variables(table).sensors[0].values

    def faces(self) -> np.ndarray:
        """See ``Life``."""
        to_face = len(self.mind.variables.joints[0].values) - 1
        gaze = np.concatenate([[to_face], self.log(GAZE)[:-1]])[: self.lived]
        return np.where(gaze == to_face, self.log(LOOKS_AT), self.spots + 1)

    def named_variables(self) -> Variables:
        """See ``Life``: categories of faces by what she mostly looked at."""
        return named_by_majority(self.mind.variables, self.confusion(), self._truths)

    def more(self) -> dict[str, Any]:
        """See ``Life``: how well perception did."""
        values = self.mind.variables.sensors[0].values
        faces = [dict(zip(self._truths, row, strict=True)) for row in self.confusion().tolist()]
        objects = self.object_confusion().tolist()
        return {
            "sensed_face_by_truth": dict(zip(values, faces, strict=True)),
            "sensed_object_by_truth": {"object": objects[0], "none": objects[1]},
        }

    def confusion(self) -> np.ndarray:
        """(values of S1, spots + 2) how often each value was sensed under each truth; see ``faces``."""
        counts = np.zeros((len(self.mind.variables.sensors[0].values), self.spots + 2), np.int64)
        np.add.at(counts, (self.log(FACE), self.faces()), 1)
        return counts

    def object_confusion(self) -> np.ndarray:
        """(2, 2) how often an object, or none, was sensed (rows) when there was one, or none (columns)."""
        counts = np.zeros((2, 2), np.int64)
        np.add.at(counts, (self.log(LOOKED_AT), 1 - self.log(OBJECT_THERE)), 1)
        return counts
