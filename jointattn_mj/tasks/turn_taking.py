"""Face-to-face interaction in turns (chapters 4 and 5) with bodies: what the symbolic table does can be seen.

One step is one turn of ``symbolic.table``, with its rules and nothing added: objects are placed anew now and then, the
robot looks somewhere, the caregiver shifts her gaze. Heads turn for a second; the image shows how things stand then.
"""

from collections import OrderedDict
from dataclasses import replace
from typing import Any

import numpy as np
from dm_env import specs

from jointattn_mj.development.table.world import (
    CAREGIVER,
    CHAPTER_5,
    ROBOT,
    TableConfig,
    new_table,
    step,
    table_variables,
)
from jointattn_mj.errors import ConfigError
from jointattn_mj.scene import snapshot
from jointattn_mj.scene.camera import directions_to
from jointattn_mj.scene.looker import AWAY, TurnWorld, locations
from jointattn_mj.scene.model import OBJECTS, ObjectConfig
from jointattn_mj.scene.variation import VariationConfig
from jointattn_mj.scene.world import WorldConfig
from jointattn_mj.tasks.arguments import require
from jointattn_mj.tasks.environment import JointAttentionTask, Random
from jointattn_mj.tasks.physics import Physics

TIME_LIMIT = 1000.0
"""Seconds, and turns, in an episode."""


_KEPT = ("table", "joint_attention", "_sensors", "_results")
"""Attributes of the task that change from turn to turn."""


def visible_objects(table: TableConfig) -> tuple[ObjectConfig, ...]:
    """Objects that look as many different ways as the table has kinds; all that lie on it look alike if that is 1.

    Raises:
        ConfigError: More kinds than the scene can show.
    """
    if table.kinds > len(OBJECTS):
        raise ConfigError(f"the scene knows {len(OBJECTS)} kinds of objects; the table has {table.kinds}")
    if table.kinds > 1:
        return OBJECTS[: table.kinds]
    return tuple(replace(OBJECTS[0], name=f"object {number}") for number in range(1, table.objects + 1))


class TurnTaking(JointAttentionTask):
    """A table with places, some of them full, at which robot and caregiver look at each other, or at a place.

    The robot's gesture moves its hand, which others see and it does not, and changes nothing in what the caregiver
    does: she answers none, as in section 5.3.1.

    Attributes:
        table: The symbolic table of the episode.
        joint_attention: Whether in the last turn both have looked at the same object.
    """

    kind = TurnWorld
    world: TurnWorld
    joint_attention = False

    def __init__(
        self, config: WorldConfig, random: Random = None, camera: bool = True, truth: bool = False,
        people: tuple[str, ...] = (), table: TableConfig = CHAPTER_5, variation: VariationConfig | str = "none",
    ):  # fmt: skip
        """``config.scene.objects`` are those of the table, whatever they were."""
        require("world", config, WorldConfig)
        require("table", table, TableConfig)
        self.table_config, self.variables = table, table_variables(table)
        scene = replace(config.scene, objects=visible_objects(table))
        super().__init__(replace(config, scene=scene), random, camera, truth, people, variation)
        self.table = new_table(table, np.random.SeedSequence(0))
        self._sensors = np.zeros(len(self.variables.sensors), np.int64)
        self._results = np.zeros(len(self.variables.results), np.int64)

    def begin(self, seed: np.random.SeedSequence) -> None:
        """The first turn: objects are placed, the caregiver shifts her gaze or not; the robot looks at her."""
        self.table = new_table(self.table_config, seed)
        self._survey()
        self._advance(np.array([self.table_config.spots, 0]))
        self.joint_attention = False
        self.world.arrive(self._directions[-1])

    def _survey(self) -> None:
        """Where places are, and in which directions they and her face lie."""
        self._locations = locations(self.table_config.spots, self.world.config.scene)
        face = np.radians(directions_to(self.world.candidate_points())[-1])
        self._directions = np.vstack([np.radians(directions_to(self._locations)), face])

    def act(self, action: np.ndarray) -> None:
        """A turn; ``action`` (2,) is where the robot looks (a place, or their number for her face) and its gesture.

        Numbers that are not whole are rounded, as noise on actions needs.
        """
        self._advance(np.rint(action).astype(np.int64))
        self.world.before_step(self._directions[self.table.state[ROBOT]])

    def _advance(self, action: np.ndarray) -> None:
        """Let the table live through a turn, and the caregiver know where she looks at its end."""
        state, full, looked_at = self.table.state, self.table.full.copy(), int(self.table.state[CAREGIVER])
        step(self.table, action, self._sensors, self._results)
        self.world.gesture(int(action[1]), self.table_config.gestures)
        robot, looks_at, face = int(state[ROBOT]), int(state[CAREGIVER]), len(full)
        followed = robot == looked_at < face and full[robot]
        was_followed = robot == looks_at < face and self.table.full[robot]
        self.joint_attention = bool(followed or was_followed)
        self._lay()
        self.world.caregiver.look_at(None if looks_at == face else self._locations[looks_at])

    def _lay(self) -> None:
        """Put the objects where the table has them."""
        objects, kinds = self.world.caregiver.objects, self.table_config.kinds
        objects[:] = AWAY
        for number, location in enumerate(np.flatnonzero(self.table.full)):
            objects[self.table.kind[location] if kinds > 1 else number] = self._locations[location]

    def actions(self) -> specs.BoundedArray:
        """Where the robot looks, 0 to the number of places, which stands for her face; and its gesture."""
        most = [self.table_config.spots, self.table_config.gestures - 1]
        return specs.BoundedArray((2,), np.int64, [0, 0], most, name="shift gaze\tgesture")

    @property
    def built(self) -> tuple[Any, ...]:
        """See ``JointAttentionTask``."""
        return *super().built, self.table_config

    def get_state(self) -> dict[str, Any]:
        """See ``JointAttentionTask``."""
        turn_state = {name: snapshot.take(getattr(self, name)) for name in _KEPT}
        return {**super().get_state(), "turn": turn_state}

    def set_state(self, state: dict[str, Any]) -> None:
        """See ``JointAttentionTask``."""
        for name in _KEPT:
            setattr(self, name, snapshot.put(getattr(self, name), state["turn"][name]))
        super().set_state(state)
        self._survey()

    def truth_spec(self) -> dict[str, specs.Array]:
        """What ``truth`` returns."""
        spec: OrderedDict[str, specs.Array] = OrderedDict()
        for name, group in (("sensors", self.variables.sensors), ("results", self.variables.results)):
            most = [len(variable.values) - 1 for variable in group]
            spec[name] = specs.BoundedArray((len(group),), np.int64, 0, most, name=name)
        return spec

    def truth(self) -> dict[str, np.ndarray]:
        """What the robot of chapter 5 is given: values of its ``sensors`` and ``results`` (Table 5.1)."""
        return {"sensors": self._sensors.copy(), "results": self._results.copy()}

    def get_reward(self, physics: Physics) -> float:
        """1 in a turn in which the robot has looked at the object that she looks at, or she at the robot's; else 0.

        Not for eye contact: a robot that does nothing but look at her would get all of that.
        """
        return float(self.joint_attention)

    def best_action(self, physics: Physics) -> np.ndarray:
        """To the object that she looks at; while she looks at the robot, to any, that she may follow."""
        state, full = self.table.state, self.table.full
        for location in (int(state[CAREGIVER]), int(state[ROBOT]), int(np.argmax(full))):
            if location < len(full) and full[location]:
                return np.array([location, 0])
        raise AssertionError("a table has at least one object")
