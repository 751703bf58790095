"""A robot that knows no spots, and whose values of S and A grow finer (section 7.1).

It looks at the caregiver's face, or in any direction where it has seen an object. It calibrates and explores; then it
babbles while its resolution grows (``contingency.online.resolution``); then the agent of chapter 5 develops with the
values that were found.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

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
from jointattn_mj.development.rendered.body import Body, Witnessed
from jointattn_mj.development.rendered.observer import ObservedRun
from jointattn_mj.development.rendered.senses import (
    ABRUPT,
    CentralView,
    SensesConfig,
    frontal_categories,
    with_faces,
    write_values,
)
from jointattn_mj.development.rendered.stage import StageConfig
from jointattn_mj.development.table.world import CAREGIVER, TableConfig, check_table, table_variables
from jointattn_mj.guards.restored import check_array
from jointattn_mj.options import Checked, Real, Whole
from jointattn_mj.perception.som import SOM
from jointattn_mj.scene.camera import directions_to, off_centre
from jointattn_mj.scene.looker import spot_positions


@dataclass(frozen=True)
class GrowingConfig(Checked):
    """Settings of a robot that does not know how many spots there are."""

    stage: StageConfig = field(default_factory=StageConfig)
    """Looks and imprecision of bodies."""
    senses: SensesConfig = field(default_factory=lambda: SensesConfig(ABRUPT, centre_radius_deg=5.0))
    """From images to values of sensors. Gaze goes anywhere: the radius is a little larger than with known spots."""
    resolution: ResolutionConfig = field(default_factory=ResolutionConfig)
    """When values split."""
    calibration: Annotated[int, Whole("[1, 1e6]")] = 15
    """Frontal faces that the robot looks at before all else: they say which categories of faces are frontal."""
    exploration: Annotated[int, Whole("[1, 1e6]")] = 600
    """Steps in which the robot only looks: it makes its map of faces, and learns where objects are."""
    face_share: Annotated[float, Real("(0, 1)")] = 0.5
    """Share of looks at the caregiver's face while it explores and babbles; all others go in a random direction."""
    margin: Annotated[float, Real("[0, 0.5)")] = 0.02
    """Share of the directions of visible objects that is left out at each end of an axis; some are wrong."""

    RENAMED: ClassVar[Mapping[str, str]] = {"greeting": "calibration", "watching": "exploration"}


class Sensed(NamedTuple):
    """What is at the centre of view."""

    unit: int
    """Unit of the map of faces for the face that is there; NOTHING_SENSED where there is no face."""
    object: bool


class FreeGazeBody(Body):
    """A body that turns its gaze in any direction.

    Attributes:
        som: Map of faces.
        space: (2, 2) lowest and highest pan, and tilt, at which objects were seen, deg.
        frontal_units: Units of the map for the calibration's faces.
    """

    def __init__(self, table: TableConfig, config: GrowingConfig, seed: np.random.SeedSequence):
        """Calibrate, explore, and learn the map of faces.

        Args:
            table: Rules of the table.
            config: Bodies and perception.
            seed: Of scene, table, moves and map.
        """
        of_stage, of_table, of_moves, of_map = seed.spawn(4)
        super().__init__(table, config.stage, config.senses, of_stage)
        self.config, self.table_config = config, table
        frontal = self.calibrate(config.calibration)
        self.stage.begin(of_table)
        self._moves = np.random.default_rng(of_moves)
        faces = self._explored()
        rng = np.random.default_rng(of_map)
        self.som = SOM(self.perception.pattern_size, config.senses.som, rng)
        self.som.train(np.array(frontal + faces), rng)
        self.frontal_units = np.array([self.som.winner(pattern) for pattern in frontal])

    @property
    def spots(self) -> int:
        """Number of spots on the table, of which the robot knows nothing."""
        return self.table_config.spots

    def step(self, direction: np.ndarray | None, gesture: int = 0) -> Sensed:
        """Look in a direction for a step; the caregiver takes it for a look at the nearest spot.

        Args:
            direction: (2,) pan and tilt, deg; None for the caregiver's face.
            gesture: The robot's.

        Returns:
            What is at the centre of view then.
        """
        view = self._step(direction, gesture)
        unit = NOTHING_SENSED if view.pattern is None else self.som.winner(view.pattern)
        return Sensed(unit, view.object and not view.face)

    def _step(self, direction: np.ndarray | None, gesture: int) -> CentralView:
        spot = self._act_towards(direction, gesture)
        heads = np.vstack([self.stage.locations, self.face])
        if direction is not None:
            heads[spot] = np.radians(direction)
        return self.observe(gesture, heads)

    def _act_towards(self, direction: np.ndarray | None, gesture: int) -> int:
        """Advance the table by a step; returns the spot that is looked at, or ``spots`` for the face."""
        spot = self.spots if direction is None else self.nearest(direction)
        self.act(np.array([spot, gesture]))
        return spot

    def nearest(self, direction: np.ndarray) -> int:
        """The spot that is nearest to a direction (2,), deg, in truth."""
        return int(np.argmin([off_centre(location, direction) for location in np.degrees(self.stage.locations)]))

    def random_direction(self) -> np.ndarray | None:
        """Where to look next: a direction (2,), deg, or None for the caregiver's face."""
        if self._moves.random() < self.config.face_share:
            return None
        direction: np.ndarray = self._moves.uniform(self.space[:, 0], self.space[:, 1])
        return direction

    def looks_at(self) -> int:
        """Spot at which the caregiver looks, in truth; ``spots`` for the robot."""
        return int(self.stage.table.state[CAREGIVER])

    def _explored(self) -> list[np.ndarray]:
        """Look at the caregiver, and where objects have been seen; returns the patterns (d,) of the faces."""
        faces, objects = list[np.ndarray](), list[np.ndarray]()
        for _ in range(self.config.exploration):
            away = objects and self._moves.random() >= self.config.face_share
            view = self._step(objects[self._moves.integers(len(objects))] if away else None, 0)
            if view.pattern is not None:
                faces.append(view.pattern)
            if not np.isnan(view.object_px).any():
                objects.append(self.direction(view.object_px))
        self.space = np.quantile(objects, (self.config.margin, 1 - self.config.margin), axis=0).T
        return faces


class RecallingBody(FreeGazeBody):
    """The same without an image a step, for many long runs.

    Faces are drawn from an album of images that were taken while the caregiver looked at each spot. An object is at the
    centre of view if it lies there.
    """

    pages = 40
    """Fewest images for each of the caregiver's gaze targets."""

    def __init__(self, table: TableConfig, config: GrowingConfig, seed: np.random.SeedSequence):
        """See ``FreeGazeBody``; then fill the album."""
        super().__init__(table, config, seed)
        self._random = np.random.default_rng(seed.spawn(1)[0])
        self._spots = spot_positions(self.spots, self.stage.world.config.scene)
        self._album = [list[int]() for _ in range(self.spots + 1)]
        while min(len(page) for page in self._album) < self.pages:
            direction = self.random_direction()
            if direction is not None:
                self._act_towards(direction, 0)
            else:
                unit = super().step(None).unit
                self._album[self.looks_at()].append(unit)  # that no face was detected is a page too
        self._full = np.zeros(self.spots, bool)

    def step(self, direction: np.ndarray | None, gesture: int = 0) -> Sensed:
        """See ``FreeGazeBody``."""
        self._act_towards(direction, gesture)
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
    """A robot that moves its gaze at random while its resolution grows.

    Attributes:
        body: Its head and camera.
        growth: The values that it can tell apart, and how they came about.
        looked_at: Spot at which the caregiver looked in each step, in truth.
    """

    def __init__(self, table: TableConfig, config: GrowingConfig, seed: int, kind: type[FreeGazeBody] = FreeGazeBody):
        """Calibrate and explore.

        Args:
            table: Rules of the table.
            config: Bodies, perception and resolution.
            seed: 0 or more.
            kind: ``FreeGazeBody`` with an image a step, or ``RecallingBody`` with none.
        """
        of_body, of_table = np.random.SeedSequence(seed).spawn(2)
        self.body = kind(table, config, of_body)
        self.body.stage.begin(of_table)
        self.growth = Growth(self.body.som.weights, self.body.space, config.resolution)
        self.looked_at: list[int] = []
        self._units: list[int] = []
        self._commands: list[np.ndarray] = []
        self._results: list[int] = []
        self._direction: np.ndarray | None = None

    @property
    def steps_done(self) -> int:
        """Steps so far."""
        return len(self._units)

    def advance(self, n_steps: int) -> None:
        """Babble for so many steps more, and split values now and then."""
        for _ in range(n_steps):
            unit, there = self.body.step(self._direction)
            self._units.append(unit)
            self._results.append(int(there))
            self.looked_at.append(self.body.looks_at())
            self._direction = self.body.random_direction()
            self._commands.append(np.full(2, np.nan) if self._direction is None else self._direction)
            if self.growth.due(self.steps_done - 1):
                self.growth.update(self.experience())

    def experience(self) -> Transitions:
        """All transitions so far."""
        return transitions(np.array(self._units), np.array(self._commands), np.array(self._results))

    def commands(self) -> np.ndarray:
        """(boxes, 2) the direction, deg, that stands for each value of A: the mean of those that led to objects, or
        the middle of its box."""
        given, resolution = self.experience(), self.growth.resolution
        action = resolution.action(given.commands)
        successes = [given.commands[(action == box) & (given.after == 1)] for box in range(len(resolution.boxes))]
        return np.array([
            led.mean(axis=0) if len(led) else box.mean(axis=1)
            for led, box in zip(successes, resolution.boxes, strict=True)
        ])  # fmt: skip


class GrowingRun(ObservedRun):
    """An agent of chapter 5 whose faces and gaze commands are the values that babbling found.

    Attributes:
        body: That of the babbling robot.
        resolution: Values of S and A.
        directions: (values of A - 1, 2) head angles of the gaze commands, deg; the last command is the face.
        frontal: (values of S1,) whether a category of faces is frontal.
    """

    def __init__(
        self,
        babbling: Babbling,
        agent: DeveloperConfig,
        seed: int,
        n_steps: int,
        reactive: Sequence[ReactiveModule] = (),
        sample_every: int = 100,
    ):
        """Go on in the world of ``babbling``, which must not advance any more.

        Args:
            babbling: Robot whose resolution has grown.
            agent: Settings of detector, modules and selector.
            seed: Of the agent; 0 or more.
            n_steps: Longest possible run.
            reactive: Initial modules; a joint without any moves at random.
            sample_every: Steps from one note of every event's contingency to the next.
        """
        self.body = babbling.body
        self.resolution: Resolution = babbling.growth.resolution
        self.directions = babbling.commands()
        self._splits = [
            (step.n_transitions, step.split.kind, float(step.contingency)) for step in babbling.growth.steps
        ]
        senses, faces = self.body.config.senses, len(self.resolution.sensed)
        frontal = self.resolution.sensor(self.body.frontal_units)
        self.frontal = frontal_categories(frontal, faces, senses.frontal_share)
        variables = with_faces(table_variables(self.body.table_config), faces)
        gaze = (*(f"region {number}" for number in range(1, len(self.directions) + 1)), "caregiver")
        developer = Developer(_with_gaze(variables, gaze), agent, np.random.SeedSequence(seed), reactive)
        super().__init__(developer, self.body.table_config, n_steps, sample_every)

    def named_variables(self) -> Variables:
        """See ``ObservedRun``; regions bear the name of the spot in them."""
        spots = table_variables(self.table).actions[0].values
        variables = super().named_variables()
        names = list(variables.actions[0].values)
        for location, name in zip(np.degrees(self.body.stage.locations), spots, strict=False):
            off = [off_centre(location, direction) for direction in self.directions]
            if min(off) <= self.body.config.senses.centre_radius_deg:
                names[int(np.argmin(off))] = name
        return _with_gaze(variables, tuple(names))

    def more(self) -> dict[str, Any]:
        """See ``ObservedRun``; and what babbling came to tell apart, by which splits of the values of S and A."""
        return {
            "caregiver": self.body.stage.world.config.scene.caregiver,
            **super().more(),
            "faces_told_apart": len(self.resolution.sensed),
            "regions_of_gaze_deg": [box.tolist() for box in self.resolution.boxes],
            "splits": [
                {"step": step, "values": kind, "contingency_nats": contingency}
                for step, kind, contingency in self._splits
            ],
        }

    def check(self) -> None:
        """See ``DevelopmentRun``."""
        super().check()
        self.body.stage.world.check()

    def __setstate__(self, state: dict[str, Any]) -> None:
        """See ``DevelopmentRun``."""
        super().__setstate__(state)
        check_table(self.body.stage.table, self.table)
        units, (faces, *_) = len(self.body.som.weights), self.agent.variables.sensors
        if sorted(chain(*self.resolution.sensed)) != list(range(units)):
            raise ValueError(f"the values of faces must share the {units} units of the map among them")
        check_array("which faces are frontal", self.frontal, (len(self.resolution.sensed) + 1,), bool)
        check_array("directions of gaze", self.directions, (len(self.resolution.boxes), 2), float, -360, 360)
        if (
            len(faces.values) != len(self.frontal)
            or len(self.agent.variables.joints[0].values) != len(self.directions) + 1
        ):
            raise ValueError("the agent's variables are others than the values that babbling found")

    def sense(self, number: int) -> Witnessed:
        """See ``ObservedRun``."""
        gaze, gesture = (int(value) for value in self.agent.state.a[:2]) if number else (len(self.directions), 0)
        unit, there = self.body.step(None if gaze == len(self.directions) else self.directions[gaze], gesture)
        face = int(self.resolution.sensor(np.array([unit]))[0])
        write_values(face, there, self.frontal, self._s, self._r)
        return self.body.witnessed()

    def close(self) -> None:
        """Free the world's model, data and rendering context."""
        self.body.close()


def _with_gaze(variables: Variables, values: tuple[str, ...]) -> Variables:
    """``variables`` with other values of the gaze command."""
    gaze = variables.actions[0]
    return replace(variables, actions=(Variable(gaze.name, values), *variables.actions[1:]))
