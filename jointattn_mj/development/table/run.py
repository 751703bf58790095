"""The agent at the table without images: the compiled loop of chapters 4 and 5."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from jointattn_mj.contingency.online.blocks import LONGEST, Block, new_block, patience, put, take_in
from jointattn_mj.contingency.online.detector import NOTHING
from jointattn_mj.contingency.online.events import Variables
from jointattn_mj.contingency.online.reactive import ReactiveModule
from jointattn_mj.development.agent import AgentState, Developer, DeveloperConfig, choose, count
from jointattn_mj.development.loop import DevelopmentRun, note, sample, streams
from jointattn_mj.development.meaning import FACE
from jointattn_mj.development.table.world import (
    CAREGIVER,
    OPTION,
    TableConfig,
    TableState,
    check_table,
    new_table,
    step,
    table_variables,
    table_witnessed,
)
from jointattn_mj.io.compiled import njit


class TableRun(DevelopmentRun):
    """An agent and its table.

    Attributes:
        world: Rules of the table and of the caregiver.
        table: State of the table.
    """

    def __init__(
        self,
        world: TableConfig,
        agent: DeveloperConfig,
        seed: int,
        n_steps: int,
        reactive: Sequence[ReactiveModule] = (),
        sample_every: int = 100,
    ):
        """Begin a run.

        Args:
            world: Rules of the table and of the caregiver.
            agent: Settings of detector, modules and selector.
            seed: 0 or more.
            n_steps: Longest possible run.
            reactive: Initial modules; a joint without any moves at random.
            sample_every: Steps from one note of every event's contingency to the next.

        Raises:
            ConfigError: A number is out of range.
        """
        of_world, of_agent = streams(seed, 2)
        self.world, self.spots = world, world.spots
        self.table = new_table(world, of_world)
        developer = Developer(table_variables(world), agent, of_agent, reactive)
        super().__init__(developer, n_steps, sample_every, table_witnessed(world))

    def _advance(self, last: int, log: np.ndarray, samples: np.ndarray) -> tuple[int, int]:
        agent = self.agent.state
        block = new_block(len(agent.s), len(agent.a), len(agent.r), len(agent.counts.n))
        steps_done, event = _advance(
            self.table, agent, block, self.steps_done, last, self._s, self._r, log, samples, self.sample_every
        )
        return steps_done, event

    def __setstate__(self, state: dict[str, Any]) -> None:
        """See ``DevelopmentRun``."""
        super().__setstate__(state)
        check_table(self.table, self.world)
        if self.witnessed != table_witnessed(self.world):
            raise ValueError("the columns that the robot does not know are others than at this table")

    def _sensed(self) -> Variables:
        """See ``DevelopmentRun``."""
        return table_variables(self.world)

    def faces(self, first: int = 0, last: int | None = None) -> np.ndarray:
        """See ``DevelopmentRun``; at this table the robot senses it."""
        return self.log(FACE, first, last)


@njit(cache=True, borrows=True)
def _advance(
    table: TableState, agent: AgentState, block: Block, first: int, last: int, s: np.ndarray, r: np.ndarray,
    log: np.ndarray, samples: np.ndarray, every: int,
) -> tuple[int, int]:  # fmt: skip
    """See ``DevelopmentRun._advance``.

    Transitions are counted in blocks that end where an event may be found, and where the contingency is noted.
    """
    t, event, in_blocks = first, NOTHING, agent.counting and not agent.forgets
    while t < last and event == NOTHING:
        n = min(patience(agent.watch), LONGEST, every - t % every, last - t) if in_blocks and t > 0 else 1
        for i in range(n):
            step(table, agent.a, s, r)
            if in_blocks:
                put(block, i, agent.s, agent.a, agent.r, r)
            else:
                event = count(agent, r)
            choose(agent, s, r)
            row = log[t - first + i]
            column = note(agent.a, agent.driver, s, r, row)
            row[column] = table.state[CAREGIVER]
            row[column + 1] = table.state[OPTION]
        if in_blocks and t > 0:
            event = take_in(agent.watch, agent.counts, block, n)
        t += n
        if t % every == 0:
            sample(agent.watch.values, samples[t // every - 1 - first // every])
    return t, event
