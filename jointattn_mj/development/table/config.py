"""``jointattn develop table``: options of a run at the table of chapters 4 and 5."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from jointattn_mj.development.config import DevelopmentConfig, Every, UnfilmedOptions
from jointattn_mj.development.table.run import TableRun


@dataclass(frozen=True)
class TableDevelopmentConfig(DevelopmentConfig):
    """Options of a run at a table with spots, objects and a caregiver, whose state the robot is told in symbols."""

    world: Literal["table"] = "table"

    steps_at_a_time: ClassVar[int] = 20_000
    checkpoint_every: ClassVar[int] = 2_000_000

    @property
    def kind(self) -> type[TableRun]:
        """See ``DevelopmentConfig``."""
        return TableRun

    def new_run(self) -> TableRun:
        """A run before its first step."""
        return TableRun(self.table, self.agent, self.seed, self.steps, self.initial_modules(), self.sample_every)


@dataclass(frozen=True)
class TableDevelopmentOptions(UnfilmedOptions):
    """Where a run leaves its results."""

    checkpoint_every: Every = TableDevelopmentConfig.checkpoint_every
    """Steps between checkpoints; a kill loses no more than these."""
