"""The task ``turn_taking``: the table of chapters 4 and 5 as a 3D scene.

A step is one step of ``development.table``, by its rules: objects are placed anew now and then, the robot looks at a
spot or at the caregiver's face, the caregiver shifts gaze. Heads turn for a second; the image shows the end of it.
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
from jointattn_mj.scene.looker import AWAY, TableWorld, spot_positions
from jointattn_mj.scene.objects import OBJECTS, ObjectConfig
from jointattn_mj.scene.variation import VariationConfig
from jointattn_mj.scene.world import WorldConfig
from jointattn_mj.tasks.arguments import require
from jointattn_mj.tasks.environment import JointAttentionTask, SeedLike
from jointattn_mj.tasks.physics import Physics

TIME_LIMIT = 1000.0
"""Seconds in an episode, of one step each."""

_KEPT = ("table", "joint_attention", "_sensors", "_results")
"""Attributes of the task that change from step to step."""


def objects_for(table: TableConfig) -> tuple[ObjectConfig, ...]:
    """Objects of the scene for a table: one for each kind, or with a single kind as many alike as lie on the table.

    Raises:
        ConfigError: The table has more kinds than the scene can show.
    """
    if table.kinds > len(OBJECTS):
        raise ConfigError(f"the scene knows {len(OBJECTS)} kinds of objects; the table has {table.kinds}")
    if table.kinds > 1:
        return OBJECTS[: table.kinds]
    return tuple(replace(OBJECTS[0], name=f"object {number}") for number in range(1, table.objects + 1))


class TurnTaking(JointAttentionTask):
    """A table with spots, some with an object. Robot and caregiver look at each other or at a spot.

    A gesture moves the robot's hand, outside of its own view. The caregiver does not answer gestures, as in section
    5.3.1.

    Attributes:
        table: The table of the episode.
        joint_attention: Whether in the last step both have looked at the same object.
    """

    kind = TableWorld
    world: TableWorld
    joint_attention = False

    def __init__(
        self, config: WorldConfig, random: SeedLike = None, camera: bool = True, truth: bool = False,
        people: tuple[str, ...] = (), table: TableConfig = CHAPTER_5, variation: VariationConfig | str = "none",
        face_patch: bool = False,
    ):  # fmt: skip
        """Make a task.

        Args:
            config: The world; its objects are replaced by the table's.
            random: See ``JointAttentionTask``, as for ``camera``, ``truth``, ``people`` and ``variation``.
            camera: See there.
            truth: See there.
            people: See there.
            table: Spots, objects and the caregiver's rules.
            variation: See there.
            face_patch: See there.
        """
        require("world", config, WorldConfig)
        require("table", table, TableConfig)
        self.table_config, self.variables = table, table_variables(table)
        scene = replace(config.scene, objects=objects_for(table))
        super().__init__(replace(config, scene=scene), random, camera, truth, people, variation, face_patch)
        self.table = new_table(table, np.random.SeedSequence(0))
        self._sensors = np.zeros(len(self.variables.sensors), np.int64)
        self._results = np.zeros(len(self.variables.results), np.int64)

    def begin(self, seed: np.random.SeedSequence) -> None:
        """The first step: objects are placed, the caregiver shifts gaze or not, the robot looks at the caregiver."""
        self.table = new_table(self.table_config, seed)
        self._survey()
        self._advance(np.array([self.table_config.spots, 0]))
        self.joint_attention = False
        self.world.arrive(self._directions[-1])

    def _survey(self) -> None:
        """Work out where spots are, and in which directions, rad, they and the caregiver's face lie."""
        self._spots = spot_positions(self.table_config.spots, self.world.config.scene)
        face = np.radians(directions_to(self.world.candidate_points())[-1])
        self._directions = np.vstack([np.radians(directions_to(self._spots)), face])

    def act(self, action: np.ndarray) -> None:
        """One step.

        Args:
            action: (2,) the spot that the robot looks at, or the number of spots for the caregiver's face; and its
                gesture. Fractions are rounded, so that noise may be added to actions.
        """
        self._advance(np.rint(action).astype(np.int64))
        self.world.before_step(self._directions[self.table.state[ROBOT]])

    def _advance(self, action: np.ndarray) -> None:
        """Advance the table by one step, and direct the caregiver's gaze accordingly."""
        state, full, looked_at = self.table.state, self.table.full.copy(), int(self.table.state[CAREGIVER])
        step(self.table, action, self._sensors, self._results)
        self.world.gesture(int(action[1]), self.table_config.gestures)
        robot, looks_at, face = int(state[ROBOT]), int(state[CAREGIVER]), len(full)
        followed = robot == looked_at < face and full[robot]
        was_followed = robot == looks_at < face and self.table.full[robot]
        self.joint_attention = bool(followed or was_followed)
        self._lay()
        self.world.caregiver.look_at(None if looks_at == face else self._spots[looks_at])

    def _lay(self) -> None:
        """Put the objects on their spots."""
        objects, kinds = self.world.caregiver.objects, self.table_config.kinds
        objects[:] = AWAY
        for number, spot in enumerate(np.flatnonzero(self.table.full)):
            objects[self.table.kind[spot] if kinds > 1 else number] = self._spots[spot]

    def actions(self) -> specs.BoundedArray:
        """Shape and bounds of an action: the spot to look at (their number: the caregiver's face), and the gesture."""
        most = [self.table_config.spots, self.table_config.gestures - 1]
        return specs.BoundedArray((2,), np.int64, [0, 0], most, name="shift gaze\tgesture")

    @property
    def built(self) -> tuple[Any, ...]:
        """See ``JointAttentionTask``."""
        return *super().built, self.table_config

    def get_state(self) -> dict[str, Any]:
        """See ``JointAttentionTask``."""
        table_state = {name: snapshot.take(getattr(self, name)) for name in _KEPT}
        return {**super().get_state(), "table": table_state}

    def set_state(self, state: dict[str, Any]) -> None:
        """See ``JointAttentionTask``."""
        for name in _KEPT:
            setattr(self, name, snapshot.put(getattr(self, name), state["table"][name]))
        super().set_state(state)
        self._survey()

    def truth_spec(self) -> dict[str, specs.Array]:
        """Shapes and bounds of what ``truth`` returns."""
        spec: OrderedDict[str, specs.Array] = OrderedDict()
        for name, group in (("sensors", self.variables.sensors), ("results", self.variables.results)):
            most = [len(variable.values) - 1 for variable in group]
            spec[name] = specs.BoundedArray((len(group),), np.int64, 0, most, name=name)
        return spec

    def truth(self) -> dict[str, np.ndarray]:
        """Ground truth: values of the sensory and resultant variables (Table 5.1), (2,) and (2,) or (3,) int."""
        return {"sensors": self._sensors.copy(), "results": self._results.copy()}

    def get_reward(self, physics: Physics) -> float:
        """1 where the robot looked at the caregiver's object in this step, or the caregiver at the robot's; else 0.

        Eye contact earns nothing, or a robot that only looks at the caregiver would get all of it.
        """
        return float(self.joint_attention)

    def best_action(self, physics: Physics) -> np.ndarray:
        """Look at the caregiver's object; while the caregiver looks at the robot, at any object, to be followed."""
        state, full = self.table.state, self.table.full
        for spot in (int(state[CAREGIVER]), int(state[ROBOT]), int(np.argmax(full))):
            if spot < len(full) and full[spot]:
                return np.array([spot, 0])
        raise AssertionError("a table has at least one object")
