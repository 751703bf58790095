"""The table of chapter 5 with bodies, whose movements are imprecise: nobody looks or puts things exactly anywhere.

The table without bodies (``development.table``) decides what happens in a step, by its own random streams. Here the
caregiver's head and eyes, the objects, and the robot's head and hand are moved accordingly.
"""

from dataclasses import dataclass, field, replace
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from jointattn_mj.development.table.world import (
    CAREGIVER,
    ROBOT,
    TableConfig,
    TableState,
    check_step,
    hold,
    new_table,
    step_held,
)
from jointattn_mj.errors import ConfigError
from jointattn_mj.io.held import Held
from jointattn_mj.options import Checked, Real
from jointattn_mj.scene.camera import directions_to
from jointattn_mj.scene.looker import AWAY, TableWorld, spot_positions
from jointattn_mj.scene.objects import OBJECTS
from jointattn_mj.scene.variation import Variation, drawn, variation_of
from jointattn_mj.scene.world import WorldConfig


@dataclass(frozen=True)
class StageConfig(Checked):
    """Looks and imprecision of bodies, which the table without bodies leaves open."""

    world: WorldConfig = field(default_factory=WorldConfig)
    """Looks of the scene. Its objects are replaced by as many as lie on the table, each of its own colour."""
    variation: Variation = "people+lights"
    """What differs between seeds, by names of ``scene.variation``; by default the caregiver and the light."""
    object_jitter_m: Annotated[float, Real("[0, 0.1]")] = 0.02
    """Largest distance of an object from its spot along x and y, m; a third of its size, as a hand puts it."""
    head_jitter_deg: Annotated[float, Real("[0, 15]")] = 2.0
    """Standard deviation, yaw and pitch, of where the caregiver's head comes to rest, degrees; the eyes make up for it.
    Heads turn most of the way to what is looked at, but never the same part of it."""
    motor_noise_deg: Annotated[float, Real("[0, 15]")] = 0.5
    """Standard deviation, pan and tilt, of where the robot's head comes to rest, degrees."""
    looks_at: Literal["location", "object"] = "location"
    """What the caregiver's eyes rest on when an object lies at the spot. ``location``: the middle of the spot, so that
    the jitter of objects is one more imprecision. ``object``: the object, wherever it lies; for large jitter."""

    OLD_CHOICES: ClassVar = {"looks_at": {"place": "location"}}


class Stage:
    """Robot and caregiver at the table, an image a step.

    Attributes:
        table: The table without bodies, which decides; there from ``begin`` on.
        world: The bodies.
        objects: What the robot expects to see on the table; lights and variation may make it look otherwise.
        locations: (spots, 2) head angles that bring each spot to the centre of view, rad.
        sensors: (2,) true values of the sensors, written by ``table.world.step``.
        results: (results,) true values of the results, likewise.
    """

    table: TableState
    _held: Held | None

    def __init__(self, table: TableConfig, config: StageConfig, seed: np.random.SeedSequence):
        """Build the scene.

        Args:
            table: Rules of the table.
            config: Looks and imprecision.
            seed: Of both.

        Raises:
            ConfigError: The table cannot be rendered.
        """
        if table.objects > len(OBJECTS):
            raise ConfigError(f"the scene knows {len(OBJECTS)} objects; the table has {table.objects}")
        if table.kinds > 1 or table.order != "caregiver_first":
            raise ConfigError(
                "the rendered table takes one image a step and has objects of one kind: it needs kinds 1 and "
                f"order caregiver_first; got {table.kinds}, {table.order}"
            )
        self.config = config
        of_look, of_bodies = seed.spawn(2)
        self.objects = OBJECTS[: table.objects]
        scene = replace(config.world.scene, objects=self.objects)
        world, conditions = drawn(replace(config.world, scene=scene), variation_of(config.variation), of_look)
        self.world = TableWorld.build(world, np.random.SeedSequence(0), conditions)
        self._random = np.random.default_rng(of_bodies)
        self._spots = spot_positions(table.spots, world.scene)
        self.locations = np.radians(directions_to(self._spots))
        self._table_config = table
        self._noise = np.radians([[config.head_jitter_deg], [config.motor_noise_deg]])
        self.sensors = np.zeros(2, np.int64)
        self.results = np.zeros(3 if table.profile else 2, np.int64)

    def face_to_face(self, head: np.ndarray) -> None:
        """Let the caregiver look at the robot, whose head points to ``head`` (2,), rad; for the calibration."""
        self._pose(None, head)

    def begin(self, seed: np.random.SeedSequence) -> None:
        """Begin at a table before its first step; ``seed`` is that of ``table.world.new_table``."""
        self.table = new_table(self._table_config, seed)
        self._held = None
        self._full, self._gesture = self.table.full.copy(), -1
        self._lie = self._spots.copy()

    def step(self, action: np.ndarray) -> None:
        """Advance the table, without bodies, by a step; ``action`` (2,) as for ``table.world.step``.

        Raises:
            ObservationError: It is no such action.
        """
        check_step(self.table, action, self.sensors, self.results)
        if self._held is None:
            self._held = hold(self.table)
        step_held(self._held, action, self.sensors, self.results)

    def __getstate__(self) -> dict[str, Any]:
        """What is held is held anew."""
        return {**vars(self), "_held": None}

    def looked_at(self) -> np.ndarray | None:
        """The point (3,) at which the caregiver looks, world frame, m; None for the robot."""
        location = self.table.state[CAREGIVER]
        if location == len(self._spots):
            return None
        point: np.ndarray = (self._lie if self.config.looks_at == "object" else self._spots)[location]
        return point

    def show(self, gesture: int, heads: np.ndarray) -> None:
        """Move all bodies to where the table's last step has put them.

        Args:
            gesture: The robot's.
            heads: (spots + 1, 2) head angles for each spot and for the caregiver's face, rad.
        """
        if (self.table.full != self._full).any():
            self._lay()
        if gesture != self._gesture:
            self._gesture = gesture
            self.world.gesture(gesture, self._table_config.gestures)
        self._pose(self.looked_at(), heads[self.table.state[ROBOT]])

    def _lay(self) -> None:
        """Put the objects on the table's occupied spots, in random order and imprecisely."""
        full = np.flatnonzero(self.table.full)
        off = self._random.uniform(-self.config.object_jitter_m, self.config.object_jitter_m, (len(full), 2))
        which = self._random.permutation(len(full))
        objects = self.world.caregiver.objects
        objects[:] = AWAY
        self._lie = self._spots.copy()
        self._lie[full, :2] += off
        objects[which] = self._lie[full]
        self._full = self.table.full.copy()

    def _pose(self, point: np.ndarray | None, head: np.ndarray) -> None:
        off = self._noise * self._random.standard_normal((2, 2))
        self.world.caregiver.look_at(point, off[0])
        self.world.arrive(head + off[1])
