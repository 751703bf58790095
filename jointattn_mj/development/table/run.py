"""A mind at a table, turn after turn: the compiled loop of chapters 4 and 5."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import njit

from jointattn_mj.contingency.online.detector import NOTHING
from jointattn_mj.contingency.online.events import Variables
from jointattn_mj.contingency.online.reactive import ReactiveModule
from jointattn_mj.development.agent import Developer, DeveloperConfig
from jointattn_mj.development.loop import Life, think_and_note
from jointattn_mj.development.meaning import FACE
from jointattn_mj.development.table.world import (
    CAREGIVER,
    OPTION,
    TableConfig,
    check_table,
    new_table,
    table_variables,
    table_witnessed,
    turn,
)
from jointattn_mj.errors import ConfigError


class TableLife(Life):
    """A mind and its table."""

    def __init__(
        self,
        world: TableConfig,
        mind: DeveloperConfig,
        seed: int,
        turns: int,
        reactive: Sequence[ReactiveModule] = (),
        sample_every: int = 100,
    ):
        """See ``Life``."""
        if seed < 0:
            raise ConfigError(f"seed must be 0 or more; got {seed}")
        of_world, of_mind = np.random.SeedSequence(seed).spawn(2)
        self.world, self.spots = world, world.spots
        self.table = new_table(world, of_world)
        developer = Developer(table_variables(world), mind, of_mind, reactive)
        super().__init__(developer, turns, sample_every, table_witnessed(world))

    def _advance(self, last: int, log: np.ndarray, samples: np.ndarray) -> tuple[int, int]:
        return _live(self.table, self.mind.mind, self.lived, last, self._s, self._r, log, samples, self.sample_every)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """See ``Life``."""
        super().__setstate__(state)
        check_table(self.table, self.world)
        if self.witnessed != table_witnessed(self.world):
            raise ValueError("what is witnessed is another than at this table")

    def _sensed(self) -> Variables:
        """See ``Life``."""
        return table_variables(self.world)

    def faces(self, first: int = 0, last: int | None = None) -> np.ndarray:
        """See ``Life``; here that is what the robot senses."""
        return self.log(FACE, first, last)


@njit(cache=True)
def _live(table, mind, first, last, s, r, log, samples, every):
    """Turns from ``first`` to ``last``, or until something is found; returns how far it came, and which event."""
    for t in range(first, last):
        turn(table, mind.a, s, r)
        found, place = think_and_note(mind, s, r, t, first, log, samples, every)
        log[t - first, place] = table.state[CAREGIVER]
        log[t - first, place + 1] = table.state[OPTION]
        if found != NOTHING:
            return t + 1, found
    return last, NOTHING
