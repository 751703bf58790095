"""Runs whose first sensor is a category of faces, and what an observer who knows the ground truth adds to their log.

Three worlds derive from ``ObservedRun``: images with known gaze targets (``run``), images with growing resolution
(``growing``) and real time (``realtime.run``). Each says what is sensed in a step; the loop over steps is here.
"""

from abc import abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np

from jointattn_mj.contingency.online.detector import NOTHING
from jointattn_mj.contingency.online.events import Variables
from jointattn_mj.development.agent import Developer
from jointattn_mj.development.loop import DevelopmentRun, hold, think_held
from jointattn_mj.development.meaning import FACE, GAZE, LOOKED_AT
from jointattn_mj.development.rendered.body import Witnessed
from jointattn_mj.development.rendered.senses import named_by_majority
from jointattn_mj.development.table.world import LOOKS_AT, TableConfig, table_variables, table_witnessed
from jointattn_mj.guards.border import require_array
from jointattn_mj.io.rows import spans

OBJECT_THERE = "object at the centre"
"""Last column of the log: whether there was an object in truth."""
PART_STEPS = 1 << 16
"""Steps that are counted at a time."""


class ObservedRun(DevelopmentRun):
    """A run whose first sensor is a category of faces; the last gaze command is the caregiver's face.

    Attributes:
        table: Rules of the table and of the caregiver.
    """

    def __init__(self, agent: Developer, table: TableConfig, n_steps: int, sample_every: int):
        """Make the log, whose rows end with the three values of ``Witnessed``.

        Args:
            agent: Agent of chapter 5 before its first step.
            table: Rules of the table and of the caregiver.
            n_steps: Longest possible run.
            sample_every: Steps from one note of every event's contingency to the next.
        """
        super().__init__(agent, n_steps, sample_every, {**table_witnessed(table), OBJECT_THERE: ("no", "yes")})
        self.table, self.spots = table, table.spots
        self._true_faces = table_variables(table).sensors[0].values

    @abstractmethod
    def sense(self, number: int) -> Witnessed:
        """Carry out the agent's last action, and write what is sensed then into ``_s`` and ``_r``.

        Args:
            number: Of the step; in step 0 the agent has not acted yet, and the robot looks at the caregiver's face.

        Returns:
            Ground truth at that moment.
        """

    def _advance(self, last: int, log: np.ndarray, samples: np.ndarray) -> tuple[int, int]:
        """See ``DevelopmentRun``."""
        first, base = self.steps_done, self.agent.variables.without_modules()
        most_s, most_r = (
            np.array([len(variable.values) - 1 for variable in group]) for group in (base.sensors, base.results)
        )
        held = hold(self.agent.state)
        for t in range(first, last):
            witnessed = self.sense(t)
            require_array("values of sensors", self._s, most_s.shape, "i", 0, most_s)
            require_array("values of results", self._r, most_r.shape, "i", 0, most_r)
            event, column = think_held(held, self._s, self._r, t, first, log, samples, self.sample_every)
            log[t - first, column:] = witnessed
            if event != NOTHING:
                return t + 1, event
        return last, NOTHING

    def faces(self, first: int = 0, last: int | None = None) -> np.ndarray:
        """See ``DevelopmentRun``."""
        to_face, last = len(self.agent.variables.joints[0].values) - 1, self.steps_done if last is None else last
        before = self.log(GAZE, max(first - 1, 0), max(last - 1, 0))
        gaze = np.concatenate([[to_face], before])[:last] if first == 0 else before
        return np.where(gaze == to_face, self.log(LOOKS_AT, first, last), self.spots + 1)

    def named_variables(self) -> Variables:
        """See ``DevelopmentRun``: categories of faces bear the name of the caregiver's usual gaze target."""
        return named_by_majority(self.agent.variables, self.confusion(), self._true_faces)

    def more(self) -> dict[str, Any]:
        """See ``DevelopmentRun``: how often perception was right."""
        values = self.agent.variables.sensors[0].values
        faces = [dict(zip(self._true_faces, row, strict=True)) for row in self.confusion().tolist()]
        objects = self.object_confusion().tolist()
        return {
            "sensed_face_by_truth": dict(zip(values, faces, strict=True)),
            "sensed_object_by_truth": {"object": objects[0], "none": objects[1]},
        }

    def confusion(self) -> np.ndarray:
        """(values of S1, spots + 2) steps by the category that was sensed and by the true face; see ``faces``."""
        return self._confusion(FACE, self.faces, (len(self.agent.variables.sensors[0].values), self.spots + 2))

    def object_confusion(self) -> np.ndarray:
        """(2, 2) steps by what was sensed (object, none) and by what was there (object, none)."""
        return self._confusion(LOOKED_AT, lambda first, last: 1 - self.log(OBJECT_THERE, first, last), (2, 2))

    def _confusion(self, sensed: str, truth: Callable[[int, int], np.ndarray], shape: tuple[int, int]) -> np.ndarray:
        """Count steps by what was sensed and by what was true.

        Args:
            sensed: Column of the log.
            truth: Gives the true values (last - first,) of the steps from ``first`` to before ``last``.
            shape: Of the result: number of sensed and of true values.
        """
        counts = np.zeros(shape, np.int64)
        for first, last in spans(self.steps_done, PART_STEPS):
            np.add.at(counts, (self.log(sensed, first, last), truth(first, last)), 1)
        return counts
