"""``jointattn develop --world rendered --mode realtime``: what differs from a life in turns."""

from dataclasses import dataclass, field
from typing import Annotated, ClassVar, Literal

from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.realtime.run import RealtimeConfig, RealtimeRun
from jointattn_mj.development.run import DevelopConfig
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.options import Choice, Real, Whole


@dataclass(frozen=True)
class RealtimeDevelopConfig(DevelopConfig):
    """An hour at the same table, in which nobody waits for anybody."""

    world: Literal["table", "rendered"] = "rendered"
    """Where the robot lives: at a table that it sees in images."""
    mode: Literal["turns", "realtime"] = "realtime"
    """How time goes on: 30 frames a second, whatever the robot does."""
    preset: Annotated[str, Choice(PRESETS)] = "fast"
    """As at the symbolic table. An hour has some thousand steps: the preset that needs fewest is the default."""
    minutes: Annotated[float, Real("(0, 1e6]")] = 60.0
    """Simulated minutes to live."""
    steps: Annotated[int, Whole("[1, 1e10]")] = 20_000
    """Fixations that it can have at most."""
    realtime: RealtimeConfig = field(default_factory=RealtimeConfig)

    kind: ClassVar[type[DevelopmentRun]] = RealtimeRun
    at_a_time: ClassVar[int] = 1
    checkpoint_every: ClassVar[int] = 500
    unit: ClassVar[str] = "min"

    @property
    def length(self) -> float:
        """See ``DevelopConfig``."""
        return self.minutes

    def new_run(self) -> RealtimeRun:
        """A life before its first fixation; the robot knows the caregiver's face."""
        initial_modules = self.initial_modules()
        return RealtimeRun(
            self.table, self.realtime, self.agent, self.seed, self.steps, initial_modules, self.sample_every
        )
