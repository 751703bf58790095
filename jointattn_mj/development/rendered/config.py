"""``jointattn develop --world rendered``: what differs from a life at the symbolic table."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.meaning import meanings
from jointattn_mj.development.rendered.film import RunFilm
from jointattn_mj.development.rendered.run import RenderedConfig, RenderedRun
from jointattn_mj.development.run import DevelopConfig
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.options import Choice, Whole


@dataclass(frozen=True)
class RenderedDevelopConfig(DevelopConfig):
    """A life at the same table, which the robot sees."""

    world: Literal["table", "rendered"] = "rendered"
    """Where the robot lives: at a table that it sees in images, one a turn, and at which bodies are imprecise."""
    mode: Literal["turns", "realtime"] = "turns"
    """How time goes on: in turns, or at 30 frames a second (realtime; with it --help lists other options)."""
    preset: Annotated[str, Choice(PRESETS)] = "fast"
    """As at the symbolic table. A turn takes an image's time, so the one that needs fewest turns is the default."""
    steps: Annotated[int, Whole("[1, 1e10]")] = 20_000
    """Turns to live; half a minute without a GPU."""
    rendered: RenderedConfig = field(default_factory=RenderedConfig)

    kind: ClassVar[type[DevelopmentRun]] = RenderedRun
    at_a_time: ClassVar[int] = 500
    checkpoint_every: ClassVar[int] = 10_000
    films: ClassVar[bool] = True

    def new_run(self) -> RenderedRun:
        """A life before its first turn; the robot has been greeted, and has watched."""
        initial_modules = self.initial_modules()
        return RenderedRun(
            self.table, self.rendered, self.agent, self.seed, self.steps, initial_modules, self.sample_every
        )

    def film(self, path: Path, moments: Iterable[DevelopmentRun]) -> None:
        """Film some turns from each of a life's moments on."""
        with RunFilm(path) as film:
            for run in moments:
                assert isinstance(run, RenderedRun)
                known = meanings(run.named_variables(), run.agent.modules)
                film.scene(run, f"After {known[-1].label}" if known else "Before anything was found")
                run.close()
