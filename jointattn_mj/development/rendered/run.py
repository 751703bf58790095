"""The mind of chapter 5 in the rendered world, turn after turn: an image in, a gaze shift and a gesture out."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np

from jointattn_mj.contingency.online.detector import NOTHING
from jointattn_mj.contingency.online.reactive import ReactiveModule
from jointattn_mj.development.agent import Developer, DeveloperConfig
from jointattn_mj.development.loop import think_and_note
from jointattn_mj.development.rendered.observer import ObservedRun
from jointattn_mj.development.rendered.senses import NOTHING_LOOKED_AT, Gazed, Senses, SensesConfig, gazed
from jointattn_mj.development.rendered.stage import Stage, StageConfig
from jointattn_mj.development.table.world import CAREGIVER, OPTION, TableConfig, step
from jointattn_mj.errors import ConfigError
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked, Whole
from jointattn_mj.perception.pixels import PixelPerception
from jointattn_mj.scene.camera import direction_of

MOST_LOOKS = 1000
"""A robot that finds no face in so many looks straight ahead gives up."""


@dataclass(frozen=True)
class RenderedConfig(Checked):
    """What lies between the symbolic table and the mind."""

    stage: StageConfig = field(default_factory=StageConfig)
    """Bodies."""
    senses: SensesConfig = field(default_factory=SensesConfig)
    """From images to sensations."""
    greeting: Annotated[int, Whole("[1, 1e6]")] = 30
    """Looks at the caregiver's face before all else, while she looks at the robot: so it learns what frontal is."""
    watching: Annotated[int, Whole("[1, 1e6]")] = 1000
    """Turns of moving at random, after which the robot makes categories of the faces it has seen; then it begins to
    count. A quarter of these turns show the face: 250 patterns, in which none of twelve seeds lacked a category."""


class RenderedRun(ObservedRun):
    """A mind, and a table that it sees.

    Attributes:
        stage: The world.
        perception: Eyes.
        senses: What is made of their images.
        heads: (spots + 1, 2) the robot's gaze commands: head angles for each place and for the caregiver's face, rad.
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
        """The robot has been greeted, and has watched, when this returns. Table and mind have the seeds of a
        ``TableRun``."""
        if seed < 0:
            raise ConfigError(f"seed must be 0 or more; got {seed}")
        of_table, of_agent, of_bodies, of_watching, of_senses = np.random.SeedSequence(seed).spawn(5)
        self.config = config
        self.stage = Stage(table, config.stage, of_bodies)
        colours = np.array([item.rgb for item in self.stage.objects])
        self.perception = PixelPerception(config.senses.pixels, colours)
        patterns = self._greeted()
        self.heads = np.vstack([self.stage.locations, self._face])
        patterns += self._watched(table, of_watching)
        rng = np.random.default_rng(of_senses)
        self.senses = Senses(config.senses, table, np.array(patterns), config.greeting, rng)
        self.stage.begin(of_table)
        developer = Developer(self.senses.variables, agent, of_agent, reactive)
        super().__init__(developer, table, n_steps, sample_every)

    def check(self) -> None:
        """See ``DevelopmentRun``."""
        super().check()
        self.senses.check()
        self.stage.world.check()

    def more(self) -> dict[str, Any]:
        """See ``DevelopmentRun``: who she was, and how well perception did."""
        who = {"caregiver": self.stage.world.config.scene.caregiver, "turns_watched_before": self.config.watching}
        return {**who, **super().more()}

    def _advance(self, last: int, log: np.ndarray, samples: np.ndarray) -> tuple[int, int]:
        stage, first = self.stage, self.steps_done
        n_steps = _advance(
            stage.table, self.agent.state, first, last, stage.sensors, stage.results, self._s, self._r,
            log, samples, self.sample_every,
        )  # fmt: skip
        for t in range(first, last):
            next(n_steps)
            self.see()
            log[t - first, -3:] = stage.table.state[CAREGIVER], stage.table.state[OPTION], stage.sensors[1] == 0
            found = next(n_steps)
            if found != NOTHING:
                return t + 1, found
        return last, NOTHING

    def close(self) -> None:
        """Free the world's model, data and rendering context."""
        self.stage.world.close()

    def see(self) -> None:
        """Let bodies stand as the turn has left them, and take in what the image shows."""
        self.stage.show(int(self.agent.state.a[1]), self.heads)
        shown = self.look() if self.senses.looks else NOTHING_LOOKED_AT
        self.senses.read(shown, self.stage.sensors, self.stage.results, self._s, self._r)

    def look(self) -> Gazed:
        """What is gazed at now."""
        world = self.stage.world
        return gazed(self.perception, world.image(), world.head_angles(), self.config.senses.centre_radius_deg)

    def _greeted(self) -> list[np.ndarray]:
        """Find her face by looking straight ahead, and bring it to the centre; returns the patterns (d,) seen there."""
        self._face, patterns, visible = np.zeros(2), list[np.ndarray](), 0
        for _ in range(MOST_LOOKS):
            self.stage.greet(self._face)
            shown = self.look()
            if shown.pattern is not None:
                patterns.append(shown.pattern)
            if not np.isnan(shown.face_px).any():
                visible += 1
                location = np.radians(direction_of(shown.face_px, np.degrees(self.stage.world.head_angles())))
                self._face += (location - self._face) / visible
            if len(patterns) == self.config.greeting:
                return patterns
        raise ConfigError(
            f"the robot found no face to look at in {MOST_LOOKS} images; change stage.variation, or the scene"
        )

    def _watched(self, table: TableConfig, seed: np.random.SeedSequence) -> list[np.ndarray]:
        """Move at random for a while; returns the patterns (d,) of the faces that were gazed at."""
        of_table, of_moves = seed.spawn(2)
        rng, patterns = np.random.default_rng(of_moves), list[np.ndarray]()
        self.stage.begin(of_table)
        stage = self.stage
        for _ in range(self.config.watching):
            action = rng.integers((table.spots + 1, table.gestures))
            step(stage.table, action, stage.sensors, stage.results)
            stage.show(int(action[1]), self.heads)
            shown = self.look()
            if shown.pattern is not None:
                patterns.append(shown.pattern)
        return patterns


@njit(cache=True)
def _advance(table, agent, first, last, sensors, results, s, r, log, samples, every):
    """Turns from ``first`` to ``last`` as a coroutine, for the call of a compiled function with a mind takes longer
    than its turn: stops when the table has lived a turn, so that ``s`` and ``r`` can be sensed, and again when the
    mind has thought, with what it has found."""
    for t in range(first, last):
        step(table, agent.a, sensors, results)
        yield NOTHING
        yield think_and_note(agent, s, r, t, first, log, samples, every)[0]
