"""The agent of chapter 5 at the rendered table: in every step an image comes in, a gaze shift and a gesture go out."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from jointattn_mj.contingency.online.reactive import ReactiveModule
from jointattn_mj.development.agent import Developer, DeveloperConfig
from jointattn_mj.development.loop import streams
from jointattn_mj.development.rendered.body import Body, Witnessed
from jointattn_mj.development.rendered.observer import ObservedRun
from jointattn_mj.development.rendered.senses import CentralView, Senses, SensesConfig
from jointattn_mj.development.rendered.stage import Stage, StageConfig
from jointattn_mj.development.table.world import TableConfig, check_table
from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Whole

MOST_TIMES = 4
"""Length of the longest exploration, in lengths of the shortest."""


@dataclass(frozen=True)
class RenderedConfig(Checked):
    """What images and bodies add to the table: looks, imprecision, perception, and the steps before the agent's."""

    stage: StageConfig = field(default_factory=StageConfig)
    """Looks and imprecision of bodies."""
    senses: SensesConfig = field(default_factory=SensesConfig)
    """From images to values of sensors."""
    calibration: Annotated[int, Whole("[1, 1e6]")] = 30
    """Frontal faces that the robot looks at before all else: they say which categories of faces are frontal."""
    exploration: Annotated[int, Whole("[1, 1e6]")] = 1000
    """Steps of random movement, then the robot makes categories of the faces it has seen and starts to count. A quarter
    of these steps show the face: with 250 patterns, none of twelve seeds lacked a category."""
    least_turned: Annotated[int, Whole("[0, 1e6]")] = 0
    """Faces that are not frontal which the robot must have seen before exploration ends; as long as they are fewer, it
    goes on, up to four times its length. Under some lights the detector learns late what a turned face looks like."""
    draws: Literal["all", "centre"] = "all"
    """Part of each image that is drawn once the agent begins. all: the whole image. centre: what surrounds its centre;
    the rest is black, also in a film. A step takes half the time. The face detector then learns from faces at the
    centre alone, so that a run of the same seed may come out otherwise."""

    RENAMED: ClassVar[Mapping[str, str]] = {"greeting": "calibration", "watching": "exploration"}

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.draws == "centre" and self.stage.world.renderer == "warp":
            raise ConfigError("rendered.draws centre needs rendered.stage.world.renderer opengl; got warp")


class RenderedRun(ObservedRun):
    """An agent and a table that it sees.

    Attributes:
        body: Head, camera, and the table before them.
        senses: From images to values of sensors.
        heads: (spots + 1, 2) gaze commands: head angles for each spot and for the caregiver's face, rad.
        explored_steps: Steps of exploration before the run.
    """

    def __init__(
        self,
        table: TableConfig,
        config: RenderedConfig,
        agent: DeveloperConfig,
        seed: int,
        n_steps: int,
        reactive: Sequence[ReactiveModule] = (),
        sample_every: int = 100,
    ):
        """Calibrate and explore; table and agent get the same random streams as in a ``TableRun`` of this seed.

        Args:
            table: Rules of the table and of the caregiver.
            config: Bodies and perception.
            agent: Settings of detector, modules and selector.
            seed: 0 or more.
            n_steps: Longest possible run.
            reactive: Initial modules; a joint without any moves at random.
            sample_every: Steps from one note of every event's contingency to the next.

        Raises:
            ConfigError: The seed is negative, or the robot found no face.
        """
        of_table, of_agent, of_bodies, of_exploration, of_senses = streams(seed, 5)
        self.config, self.explored_steps = config, 0
        self.body = Body(table, config.stage, config.senses, of_bodies)
        patterns = self.body.calibrate(config.calibration)
        self.heads = np.vstack([self.stage.locations, self.body.face])
        needed = 0 if "category" in config.senses.state else config.least_turned
        for explored in self._explored(table, of_exploration):
            patterns += explored
            rng = np.random.default_rng(of_senses)
            self.senses = Senses(config.senses, table, np.array(patterns), config.calibration, rng)
            if not needed or self.senses.turned(patterns) >= needed:
                break
        self._narrow()
        self.stage.begin(of_table)
        developer = Developer(self.senses.variables, agent, of_agent, reactive)
        super().__init__(developer, table, n_steps, sample_every)

    @property
    def stage(self) -> Stage:
        """The table with bodies."""
        return self.body.stage

    def check(self) -> None:
        """See ``DevelopmentRun``."""
        super().check()
        self.senses.check()
        self.stage.world.check()

    def __setstate__(self, state: dict[str, Any]) -> None:
        """See ``DevelopmentRun``."""
        super().__setstate__(state)
        check_table(self.stage.table, self.table)
        self._narrow()

    def more(self) -> dict[str, Any]:
        """See ``ObservedRun``; and which caregiver it was."""
        who = {"caregiver": self.stage.world.config.scene.caregiver, "exploration_steps": self.explored_steps}
        return {**who, **super().more()}

    def sense(self, number: int) -> Witnessed:
        """See ``ObservedRun``."""
        self.body.act(self.agent.state.a[:2])
        self.read(self.body.observe(int(self.agent.state.a[1]), self.heads, self.senses.looks))
        return self.body.witnessed()

    def read(self, view: CentralView) -> None:
        """Turn what is at the centre of view into the values of this step."""
        self.senses.read(view, self.stage.sensors, self.stage.results, self._s, self._r)

    def _narrow(self) -> None:
        """Draw no more of images than asked from now on."""
        if self.config.draws == "centre" and not self.stage.world.closed:
            self.body.narrow()

    def close(self) -> None:
        """Free the world's model, data and rendering context."""
        self.body.close()

    def _explored(self, table: TableConfig, seed: np.random.SeedSequence) -> Iterator[list[np.ndarray]]:
        """Move at random, as often as asked; yields the patterns (d,) of the faces that were at the centre of view."""
        of_table, of_moves = seed.spawn(2)
        rng = np.random.default_rng(of_moves)
        self.stage.begin(of_table)
        for _ in range(MOST_TIMES):
            patterns = list[np.ndarray]()
            for _ in range(self.config.exploration):
                action = rng.integers((table.spots + 1, table.gestures))
                self.body.act(action)
                view = self.body.observe(int(action[1]), self.heads)
                if view.pattern is not None:
                    patterns.append(view.pattern)
            self.explored_steps += self.config.exploration
            yield patterns
