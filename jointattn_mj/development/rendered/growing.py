"""A robot at the table that knows no places: it looks at her face, or in any direction where it has seen an object.

First it watches; then it babbles, while what it senses and does grows finer (``contingency.resolution``); then a mind
of chapter 5 develops with the values that were found.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, NamedTuple

import numpy as np

from jointattn_mj.contingency.online.detector import NOTHING
from jointattn_mj.contingency.online.events import Variable, Variables
from jointattn_mj.contingency.online.reactive import ReactiveModule
from jointattn_mj.contingency.online.resolution import (
    NOTHING_SENSED,
    Growth,
    Resolution,
    ResolutionConfig,
    Transitions,
    transitions,
)
from jointattn_mj.development.agent import Developer, DeveloperConfig
from jointattn_mj.development.loop import DevelopmentRun, think_and_note
from jointattn_mj.development.meaning import FACE, GAZE
from jointattn_mj.development.rendered.observer import confusion, faces_looked_at
from jointattn_mj.development.rendered.senses import ABRUPT, Gazed, SensesConfig, gazed, named_by_majority
from jointattn_mj.development.rendered.stage import Stage, StageConfig
from jointattn_mj.development.table.world import CAREGIVER, OPTION, TableConfig, step, table_variables, table_witnessed
from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Real, Whole
from jointattn_mj.perception.pixels import PixelPerception
from jointattn_mj.perception.som import SOM
from jointattn_mj.scene.camera import direction_of, directions_to, off_centre
from jointattn_mj.scene.looker import spot_positions


@dataclass(frozen=True)
class GrowingConfig(Checked):
    """A robot that does not know how many places there are."""

    stage: StageConfig = field(default_factory=StageConfig)
    """Bodies."""
    senses: SensesConfig = field(default_factory=lambda: SensesConfig(ABRUPT, centre_radius_deg=5.0))
    """From images to sensations. Gaze goes anywhere: what counts as looked at is a little wider than at places that
    are known."""
    resolution: ResolutionConfig = field(default_factory=ResolutionConfig)
    """When values split."""
    greeting: Annotated[int, Whole("[1, 1e6]")] = 15
    """Looks at the caregiver's face before all else, while she looks at the robot: so it learns what frontal is."""
    watching: Annotated[int, Whole("[1, 1e6]")] = 600
    """Turns in which it only watches: from her faces it makes its map, and it sees where objects are."""
    face_share: Annotated[float, Real("(0, 1)")] = 0.5
    """How often it looks at her face while it watches and babbles; else in a direction at random."""
    margin: Annotated[float, Real("[0, 0.5)")] = 0.02
    """Share of the directions of seen objects that is left out at each end of an axis: some are wrong."""


class Sensed(NamedTuple):
    """What is at the centre of view."""

    cell: int
    """The cell of the map that her face falls on; NOTHING_SENSED where there is no face."""
    object: bool


class Body:
    """Head and eyes at the table, turn after turn.

    Attributes:
        stage: The world.
        face: (2,) head angles for the caregiver's face, rad.
        som: The map of faces, there when it has watched.
        space: (2, 2) lowest and highest pan, and tilt, at which objects were seen, deg.
        greetings: Cells of the map on which the faces fell that greeted the robot.
    """

    def __init__(self, table: TableConfig, config: GrowingConfig, seed: np.random.SeedSequence):
        """The robot has watched when this returns."""
        of_stage, of_table, of_moves, of_map = seed.spawn(4)
        self.config, self.table_config = config, table
        self.stage = Stage(table, config.stage, of_stage)
        self.perception = PixelPerception(config.senses.pixels, np.array([item.rgb for item in self.stage.objects]))
        greeted = self._greeted()
        self.stage.begin(of_table)
        self._moves = np.random.default_rng(of_moves)
        faces = self._watched()
        rng = np.random.default_rng(of_map)
        self.som = SOM(self.perception.pattern_size, config.senses.som, rng)
        self.som.train(np.array(greeted + faces), rng)
        self.greetings = np.array([self.som.winner(pattern) for pattern in greeted])

    @property
    def spots(self) -> int:
        """Places on the table, of which the robot knows nothing."""
        return self.table_config.spots

    def step(self, direction: np.ndarray | None, gesture: int = 0) -> Sensed:
        """A turn in which the robot looks in a direction (2,), deg, or at her face; what it then senses.

        She takes it to look at the place that is nearest.
        """
        shown = self._step(direction, gesture)
        cell = NOTHING_SENSED if shown.pattern is None else self.som.winner(shown.pattern)
        return Sensed(cell, shown.object and not shown.face)

    def _step(self, direction: np.ndarray | None, gesture: int) -> Gazed:
        location = self._steps_done(direction, gesture)
        heads = np.vstack([self.stage.locations, self.face])
        if direction is not None:
            heads[location] = np.radians(direction)
        self.stage.show(gesture, heads)
        return self.look()

    def _steps_done(self, direction: np.ndarray | None, gesture: int) -> int:
        """Let the table live a turn; the place, or the face, at which the robot looks for her."""
        location = self.spots if direction is None else self.nearest(direction)
        step(self.stage.table, np.array([location, gesture]), self.stage.sensors, self.stage.results)
        return location

    def nearest(self, direction: np.ndarray) -> int:
        """The place nearest to a direction (2,), deg: the truth."""
        return int(np.argmin([off_centre(location, direction) for location in np.degrees(self.stage.locations)]))

    def look(self) -> Gazed:
        """What is gazed at now."""
        world = self.stage.world
        return gazed(self.perception, world.image(), world.head_angles(), self.config.senses.centre_radius_deg)

    def direction(self) -> np.ndarray | None:
        """Where to look next while moving at random: a direction (2,), deg, or at her face."""
        if self._moves.random() < self.config.face_share:
            return None
        return self._moves.uniform(self.space[:, 0], self.space[:, 1])

    def looks_at(self) -> int:
        """Where she looks, 0 to spots: the truth."""
        return int(self.stage.table.state[CAREGIVER])

    def _greeted(self) -> list[np.ndarray]:
        """Find her face, and bring it to the centre; returns the patterns (d,) seen there."""
        self.face, patterns, visible = np.zeros(2), list[np.ndarray](), 0
        for _ in range(100 * self.config.greeting):
            self.stage.greet(self.face)
            shown = self.look()
            if shown.pattern is not None:
                patterns.append(shown.pattern)
            if not np.isnan(shown.face_px).any():
                visible += 1
                location = np.radians(direction_of(shown.face_px, np.degrees(self.stage.world.head_angles())))
                self.face += (location - self.face) / visible
            if len(patterns) == self.config.greeting:
                return patterns
        raise ConfigError("the robot found no face to look at; change stage.variation, or the scene")

    def _watched(self) -> list[np.ndarray]:
        """Look at her, and where objects have been seen; returns the patterns (d,) of her faces."""
        faces, objects = list[np.ndarray](), list[np.ndarray]()
        for _ in range(self.config.watching):
            away = objects and self._moves.random() >= self.config.face_share
            shown = self._step(objects[self._moves.integers(len(objects))] if away else None, 0)
            if shown.pattern is not None:
                faces.append(shown.pattern)
            if not np.isnan(shown.object_px).any():
                objects.append(direction_of(shown.object_px, np.degrees(self.stage.world.head_angles())))
        self.space = np.quantile(objects, (self.config.margin, 1 - self.config.margin), axis=0).T
        return faces


class RecallingBody(Body):
    """The same without an image a turn, for many long lives: her faces are drawn from an album of images that were
    taken while she looked at each place, and an object is at the centre of view if it lies there."""

    pages = 40
    """Images at least of her for each place, and for the robot."""

    def __init__(self, table: TableConfig, config: GrowingConfig, seed: np.random.SeedSequence):
        super().__init__(table, config, seed)
        self._random = np.random.default_rng(seed.spawn(1)[0])
        self._spots = spot_positions(self.spots, self.stage.world.config.scene)
        self._album = [list[int]() for _ in range(self.spots + 1)]
        while min(len(page) for page in self._album) < self.pages:
            direction = self.direction()
            if direction is not None:
                self._steps_done(direction, 0)
            else:
                cell = super().step(None).cell
                self._album[self.looks_at()].append(cell)  # that no face was found is a page too
        self._full = np.zeros(self.spots, bool)

    def step(self, direction: np.ndarray | None, gesture: int = 0) -> Sensed:
        """See ``Body``."""
        self._steps_done(direction, gesture)
        table, config = self.stage.table, self.config
        if (table.full != self._full).any():
            self._full = table.full.copy()
            lie = self._spots[self._full].copy()
            lie[:, :2] += self._random.uniform(-1, 1, (len(lie), 2)) * config.stage.object_jitter_m
            self._objects = directions_to(lie)
        if direction is None:
            page = self._album[self.looks_at()]
            return Sensed(page[self._random.integers(len(page))], False)
        head = direction + self._random.normal(0, config.stage.motor_noise_deg, 2)
        off = [off_centre(location, head) for location in self._objects]
        return Sensed(NOTHING_SENSED, min(off) <= config.senses.centre_radius_deg)


class Babbling:
    """A robot that moves its gaze at random, and whose resolution grows.

    Attributes:
        body: Its own.
        growth: What it has become able to tell apart.
        looked_at: Where she looked in each turn: the truth.
    """

    def __init__(self, table: TableConfig, config: GrowingConfig, seed: int, kind: type[Body] = Body):
        of_body, of_table = np.random.SeedSequence(seed).spawn(2)
        self.body = kind(table, config, of_body)
        self.body.stage.begin(of_table)
        self.growth = Growth(self.body.som.weights, self.body.space, config.resolution)
        self.looked_at: list[int] = []
        self._cells: list[int] = []
        self._commands: list[np.ndarray] = []
        self._results: list[int] = []
        self._direction: np.ndarray | None = None

    @property
    def steps_done(self) -> int:
        """Turns so far."""
        return len(self._cells)

    def advance(self, n_steps: int) -> None:
        """Babble so many turns more, and look for splits now and then."""
        for _ in range(n_steps):
            cell, there = self.body.step(self._direction)
            self._cells.append(cell)
            self._results.append(int(there))
            self.looked_at.append(self.body.looks_at())
            self._direction = self.body.direction()
            self._commands.append(np.full(2, np.nan) if self._direction is None else self._direction)
            if self.growth.due(self.steps_done - 1):
                self.growth.look(self.experience())

    def experience(self) -> Transitions:
        """All of it."""
        return transitions(np.array(self._cells), np.array(self._commands), np.array(self._results))

    def commands(self) -> np.ndarray:
        """(boxes, 2) for each value of A the direction, deg, that stands for it: the mean of those that led to objects,
        or its middle."""
        given, resolution = self.experience(), self.growth.resolution
        action = resolution.action(given.commands)
        found = [given.commands[(action == box) & (given.after == 1)] for box in range(len(resolution.boxes))]
        return np.array([
            led.mean(axis=0) if len(led) else box.mean(axis=1)
            for led, box in zip(found, resolution.boxes, strict=True)
        ])  # fmt: skip


class GrowingRun(DevelopmentRun):
    """A mind of chapter 5 whose faces and gaze commands are the values that were found."""

    def __init__(
        self,
        babbling: Babbling,
        agent: DeveloperConfig,
        seed: int,
        n_steps: int,
        reactive: Sequence[ReactiveModule] = (),
        sample_every: int = 100,
    ):
        """Goes on in the world of ``babbling``, which lives no more."""
        self.body, self.spots = babbling.body, babbling.body.spots
        self.resolution: Resolution = babbling.growth.resolution
        self.directions = babbling.commands()
        values = self.resolution.sensor(self.body.greetings)
        greeted = np.bincount(values, minlength=len(self.resolution.sensed) + 1)
        self.frontal = greeted > self.body.config.senses.frontal_share * len(values)
        of_table = table_variables(self.body.table_config)
        faces = (*(f"face {number}" for number in range(1, len(self.resolution.sensed) + 1)), "not seen")
        looks = (*(f"region {number}" for number in range(1, len(self.directions) + 1)), "caregiver")
        variables = Variables(
            (Variable(FACE, faces), *of_table.sensors[1:]), (Variable(GAZE, looks), *of_table.actions[1:]),
            of_table.results,
        )  # fmt: skip
        developer = Developer(variables, agent, np.random.SeedSequence(seed), reactive)
        super().__init__(developer, n_steps, sample_every, table_witnessed(self.body.table_config))

    def faces(self, first: int = 0, last: int | None = None) -> np.ndarray:
        """See ``DevelopmentRun``."""
        return faces_looked_at(self, len(self.directions), first, last)

    def named_variables(self) -> Variables:
        """See ``DevelopmentRun``: values of faces by what she mostly looked at, and regions by the place in them."""
        counts = confusion(self, FACE, self.faces, (len(self.resolution.sensed) + 1, self.spots + 2))
        truth = table_variables(self.body.table_config)
        variables, gaze = self.agent.variables, self.agent.variables.actions[0]
        names = list(gaze.values)
        for location, name in zip(np.degrees(self.body.stage.locations), truth.actions[0].values, strict=False):
            off = [off_centre(location, direction) for direction in self.directions]
            if min(off) <= self.body.config.senses.centre_radius_deg:
                names[int(np.argmin(off))] = name
        variables = replace(variables, actions=(Variable(gaze.name, tuple(names)), *variables.actions[1:]))
        return named_by_majority(variables, counts, truth.sensors[0].values)

    def _advance(self, last: int, log: np.ndarray, samples: np.ndarray) -> tuple[int, int]:
        s, r, first = self._s, self._r, self.steps_done
        for t in range(first, last):
            gaze, gesture = (int(value) for value in self.agent.state.a[:2]) if t else (len(self.directions), 0)
            cell, there = self.body.step(None if gaze == len(self.directions) else self.directions[gaze], gesture)
            s[0] = self.resolution.sensor(np.array([cell]))[0]
            s[1] = 0 if there else 1
            r[0] = self.frontal[s[0]]
            r[1:-1] = cell != NOTHING_SENSED and not r[0]
            r[-1] = there
            found, _ = think_and_note(self.agent.state, s, r, t, first, log, samples, self.sample_every)
            log[t - first, -2:] = self.body.looks_at(), self.body.stage.table.state[OPTION]
            if found != NOTHING:
                return t + 1, found
        return last, NOTHING
