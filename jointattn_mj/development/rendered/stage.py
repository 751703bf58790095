"""The table of chapter 5 with bodies, and as imprecise as bodies are: nobody looks or puts things exactly anywhere.

The symbolic table (``symbolic.table``) decides what happens in a turn, by its own random streams; here it is acted out
by the caregiver's head and eyes, objects, and the robot's head and hand.
"""

from dataclasses import dataclass, field, replace
from typing import Annotated, Literal

import numpy as np

from jointattn_mj.development.table.world import CAREGIVER, ROBOT, Table, TableConfig, new_table
from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Real
from jointattn_mj.scene.camera import directions_to
from jointattn_mj.scene.looker import AWAY, TableWorld, spot_positions
from jointattn_mj.scene.objects import OBJECTS
from jointattn_mj.scene.variation import Variation, drawn, variation_of
from jointattn_mj.scene.world import WorldConfig


@dataclass(frozen=True)
class StageConfig(Checked):
    """What the symbolic table leaves open about bodies."""

    world: WorldConfig = field(default_factory=WorldConfig)
    """What things look like; its objects are replaced by as many as lie on the table, each of its own colour."""
    variation: Variation = "people+lights"
    """How each seed's world differs, by names of ``scene.variation``: she is one of six people, in her own light."""
    object_jitter_m: Annotated[float, Real("[0, 0.1]")] = 0.02
    """Objects lie up to so far beside their place, either way; a third of their size, as a hand puts them."""
    head_jitter_deg: Annotated[float, Real("[0, 15]")] = 2.0
    """Standard deviation, yaw and pitch, of where the caregiver's head comes to rest; her eyes make up for it. Heads
    turn most of the way to what is looked at, but never the same part of it."""
    motor_noise_deg: Annotated[float, Real("[0, 15]")] = 0.5
    """Standard deviation, pan and tilt, of where the robot's head comes to rest."""
    looks_at: Literal["place", "object"] = "place"
    """What her eyes rest on when an object lies at the place she looks at: the middle of the ``location``, so that the
    jitter of objects is one more imprecision, or the ``object``, wherever it lies: so where jitter is large."""


class Stage:
    """Robot and caregiver at the table, an image a turn.

    Attributes:
        table: The symbolic table, which decides; there from ``begin`` on.
        world: The bodies.
        objects: What the robot expects to see on the table; lights and variation may make it look otherwise.
        places: (spots, 2) head angles that bring each place to the centre of view, rad.
        sensors: (2,) what the robot of the symbolic table senses in a turn: the truth, for ``table.step`` to write.
        results: (results,) likewise.
    """

    table: Table

    def __init__(self, table: TableConfig, config: StageConfig, seed: np.random.SeedSequence):
        if table.objects > len(OBJECTS):
            raise ConfigError(f"the scene knows {len(OBJECTS)} objects; the table has {table.objects}")
        if table.kinds > 1 or table.order != "caregiver_first":
            raise ConfigError(
                "images are taken once a turn, and objects are of one kind: the rendered world needs kinds 1 and "
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

    def greet(self, head: np.ndarray) -> None:
        """Before the first turn: she looks at the robot, whose head is told to be at ``head`` (2,), rad."""
        self._pose(None, head)

    def begin(self, seed: np.random.SeedSequence) -> None:
        """Sit down at a table before its first turn; ``seed`` is that of ``symbolic.table.new_table``."""
        self.table = new_table(self._table_config, seed)
        self._full, self._gesture = self.table.full.copy(), -1
        self._lie = self._spots.copy()

    def looked_at(self) -> np.ndarray | None:
        """The point (3,) that she looks at, world frame, metres; None where she looks at the robot."""
        location = self.table.state[CAREGIVER]
        if location == len(self._spots):
            return None
        return self._lie[location] if self.config.looks_at == "object" else self._spots[location]

    def show(self, gesture: int, heads: np.ndarray) -> None:
        """Let bodies stand as the table's last turn has left them.

        Args:
            gesture: The robot's.
            heads: (spots + 1, 2) angles to which it turns its head to look at each place, and at her face, rad.
        """
        if (self.table.full != self._full).any():
            self._lay()
        if gesture != self._gesture:
            self._gesture = gesture
            self.world.gesture(gesture, self._table_config.gestures)
        self._pose(self.looked_at(), heads[self.table.state[ROBOT]])

    def _lay(self) -> None:
        """Put the objects where the table has them, whichever where, and none exactly."""
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
