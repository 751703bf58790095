"""``jointattn develop realtime``: options of a run in which the caregiver does not wait for the robot."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, ClassVar, Literal, Self

from jointattn_mj.development.config import DevelopmentConfig, Every, UnfilmedOptions
from jointattn_mj.development.realtime.run import RealtimeConfig, RealtimeRun
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.options import Choice, Real, Whole

LIKE_FRONTAL = 0.6
"""Preset local: ``senses.frontal_likeness``. Without it three of twenty robots found gaze following only: a quarter to
two fifths of the frontal faces that each saw later fell into a category that the greeting had not shown."""


@dataclass(frozen=True)
class RealtimeDevelopmentConfig(DevelopmentConfig):
    """Options of a run at 30 frames a second at the same table, which the robot sees; a step is a fixation."""

    world: Literal["realtime"] = "realtime"
    preset: Annotated[str, Choice(PRESETS)] = "fast"
    """Reading of the text that gives --table.* and --agent.* their defaults, as at the table. An hour has some thousand
    steps, so the preset that needs the fewest is the default."""
    minutes: Annotated[float, Real("(0, 1e6]")] = 60.0
    """Length of the run in simulated minutes."""
    steps: Annotated[int, Whole("[1, 1e10]")] = 20_000
    """Largest number of steps; a step is a fixation."""
    realtime: RealtimeConfig = field(default_factory=RealtimeConfig)

    GONE: ClassVar[Sequence[str]] = ("mode",)
    OLD_CHOICES: ClassVar[Mapping[str, Mapping[str, str]]] = {"world": {"rendered": "realtime"}}
    steps_at_a_time: ClassVar[int] = 1
    checkpoint_every: ClassVar[int] = 500
    unit: ClassVar[str] = "min"

    @classmethod
    def defaults(cls, given: Mapping[str, Any]) -> Self:
        """See ``DevelopmentConfig``; preset local also says which categories of faces are frontal."""
        start = super().defaults(given)
        if start.preset != "local":
            return start
        senses = replace(start.realtime.senses, frontal_likeness=LIKE_FRONTAL)
        return replace(start, realtime=replace(start.realtime, senses=senses))

    @property
    def kind(self) -> type[RealtimeRun]:
        """See ``DevelopmentConfig``."""
        return RealtimeRun

    @property
    def length(self) -> float:
        """Length of the run, in ``unit``."""
        return self.minutes

    def new_run(self) -> RealtimeRun:
        """A run before its first fixation; the robot knows the caregiver's face."""
        initial = self.initial_modules()
        return RealtimeRun(self.table, self.realtime, self.agent, self.seed, self.steps, initial, self.sample_every)


@dataclass(frozen=True)
class RealtimeDevelopmentOptions(UnfilmedOptions):
    """Where a run leaves its results."""

    checkpoint_every: Every = RealtimeDevelopmentConfig.checkpoint_every
    """Steps between checkpoints; a kill loses no more than these."""
