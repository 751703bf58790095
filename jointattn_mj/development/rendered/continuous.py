"""Continuous maps (section 7.1): the gaze-following module learns head angles from face patterns.

The discrete module says which of a few spots to look at under which of a few categories of faces. From the step in
which its event is found, a learner of chapter 6 takes in pairs of the face pattern that was seen and the direction
where an object was. The contingent saliency of the event says which pairs count. After enough pairs the map says where
the head goes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from jointattn_mj.contingency.online.modules import Module
from jointattn_mj.contingency.online.reactive import ReactiveModule
from jointattn_mj.development.agent import DeveloperConfig
from jointattn_mj.development.contingency_log import ContingencyLog
from jointattn_mj.development.meaning import FACE, GAZE, OBJECT
from jointattn_mj.development.rendered.body import Witnessed
from jointattn_mj.development.rendered.run import RenderedConfig, RenderedRun
from jointattn_mj.development.rendered.senses import ABRUPT, CentralView, SensesConfig
from jointattn_mj.development.rendered.stage import StageConfig
from jointattn_mj.development.table.world import CAREGIVER, TableConfig
from jointattn_mj.gaze_following.learners import Learner, LearnerConfig, Locations, make_learner
from jointattn_mj.io.rows import RowStore
from jointattn_mj.options import Checked, Count
from jointattn_mj.scene.camera import directions_to, off_centre

FORWARD, BACKWARD = "face to object", "object to face"


@dataclass(frozen=True)
class ContinuousConfig(Checked):
    """How a module gets a continuous map."""

    learner: LearnerConfig = field(default_factory=LearnerConfig)
    """Learner of chapter 6, on the same activations of the map of faces."""
    enough: Count = 50
    """Pairs after which the map replaces the module's table."""


SCATTERED = RenderedConfig(
    stage=StageConfig(object_jitter_m=0.1, looks_at="object"),
    senses=SensesConfig(ABRUPT, centre_radius_deg=7.5),
)
"""Objects lie nearly anywhere along the row and up to 10 cm nearer or farther, and the caregiver looks at them there. A
look at a spot takes in what lies in its part of the row."""


class Pair(NamedTuple):
    """A face and the direction of an object, one step apart."""

    step: int
    activations: np.ndarray
    """(units,) of the map of faces."""
    direction: np.ndarray
    """(2,) head angles that would bring the object to the centre of view, deg."""
    order: str
    """FORWARD: the face was seen a step before the object; BACKWARD: a step after it."""
    informative: bool
    """Whether the module takes the transition for informative; False before its event was found."""


class Landing(NamedTuple):
    """Where a gaze shift by the module ended; the caregiver looked at an object when it began."""

    step: int
    by_map: bool
    """Whether the continuous map chose the direction; else the module's table."""
    off_deg: float
    """From the centre of view to the object that the caregiver had looked at, deg."""
    nearest: bool
    """Whether no other object was nearer to the centre."""


class ContinuousModule:
    """A module of the agent, and the continuous map that replaces its table.

    Attributes:
        module: The discrete module.
        learner: From activations of the map of faces to head angles, deg.
        pairs: Number of pairs that it has learned from.
    """

    def __init__(self, module: Module, config: ContinuousConfig, inputs: int, rng: np.random.Generator):
        """Make a map that has learned nothing.

        Args:
            module: The discrete module.
            config: Learner, and when its map replaces the table.
            inputs: Number of units of the map of faces.
            rng: For the learner.
        """
        self.module, self._enough = module, config.enough
        self.learner: Learner = make_learner(config.learner, inputs, rng)
        self.pairs = 0
        positive = module.saliency[module.saliency > 0]
        self._average = positive.mean() if len(positive) else np.inf

    @property
    def ready(self) -> bool:
        """Whether the map has learned from enough pairs to say where the head goes."""
        return self.pairs >= self._enough

    def is_informative(self, r: int, s: int, r_next: int, a: int) -> bool:
        """Whether e(r', a; r, s) of eq. 5.3 exceeds the mean of all positive ones (rule 1 of section 5.2.2).

        Args:
            r: Result before.
            s: Value of the sensor.
            r_next: Result after.
            a: Value of the action.
        """
        return bool(self.module.saliency[r, s, r_next, a] > self._average)

    def learn(self, pair: Pair) -> None:
        """Learn from an informative pair."""
        self.learner.learn(pair.activations, Locations.only(pair.direction))
        self.pairs += 1


class ContinuousRun(RenderedRun):
    """A run at the rendered table in which gaze following, once found, becomes continuous.

    Attributes:
        following: The module of (S1, A1, R3) with its map; None before it is found.
    """

    def __init__(
        self,
        table: TableConfig,
        config: RenderedConfig,
        agent: DeveloperConfig,
        seed: int,
        n_steps: int,
        continuous: ContinuousConfig = ContinuousConfig(),
        reactive: Sequence[ReactiveModule] = (),
        sample_every: int = 100,
    ):
        """See ``RenderedRun``.

        Args:
            table: Rules of the table and of the caregiver.
            config: Bodies and perception, such as ``SCATTERED``.
            agent: Settings of detector, modules and selector.
            seed: 0 or more.
            n_steps: Longest possible run.
            continuous: Learner of the continuous map.
            reactive: Initial modules; a joint without any moves at random.
            sample_every: Steps from one note of every event's contingency to the next.
        """
        super().__init__(table, config, agent, seed, n_steps, reactive, sample_every)
        self.continuous = continuous
        self.following: ContinuousModule | None = None
        units = len(self.senses.categories.som.weights)
        self._pairs, self._landings = RowStore("pairs", np.float64, units + 5), RowStore("landings", np.float64, 4)
        self._face_visible: np.ndarray | None = None  # activations for the face at the centre of view, a step ago
        self._object_at: np.ndarray | None = None  # direction of the object at the centre of view, a step ago
        self._target: np.ndarray | None = None  # object (3,) that the caregiver looked at a step ago
        self._rng = np.random.default_rng(np.random.SeedSequence(seed).spawn(6)[5])

    @property
    def pairs(self) -> list[Pair]:
        """All pairs so far, informative or not."""
        return [
            Pair(int(row[0]), activations, row[3:5], FORWARD if row[1] else BACKWARD, bool(row[2]))
            for row in self._pairs.read()
            for activations in (row[5:].astype(np.float32),)  # as the map of faces gave them
        ]

    @property
    def landings(self) -> list[Landing]:
        """Where the module's gaze shifts ended, in truth."""
        return [
            Landing(int(step), bool(by_map), off_deg, bool(nearest))
            for step, by_map, off_deg, nearest in self._landings.read().tolist()
        ]

    def more(self) -> dict[str, Any]:
        """See ``ObservedRun``; and how near the module's gaze shifts came, by its table and by its map."""
        landings = {"table": [landing for landing in self.landings if not landing.by_map]}
        landings["map"] = [landing for landing in self.landings if landing.by_map]
        return {
            **super().more(),
            "pairs_learned_from": 0 if self.following is None else self.following.pairs,
            "landings": {
                name: {
                    "gaze_shifts": len(rows),
                    "median_off_deg": float(np.median([row.off_deg for row in rows])) if rows else None,
                    "nearest_to_the_right_object": float(np.mean([row.nearest for row in rows])) if rows else None,
                }
                for name, rows in landings.items()
            },
        }

    def sense(self, number: int) -> Witnessed:
        """See ``RenderedRun``; the head goes where the map says while its module is used, and the map learns."""
        if self.following is None:
            self._adopt()
        s, r, a = (values.copy() for values in (self.agent.state.s, self.agent.state.r, self.agent.state.a))
        used = self.following is not None and bool(a[len(self.agent.variables.joints) + self._number])
        suggestion = self.suggestion() if used else None
        heads = self.heads
        if suggestion is not None:
            heads = heads.copy()
            heads[a[0]] = np.radians(suggestion)
        objects, target = self.stage.world.caregiver.objects.copy(), self._target
        self.body.act(a[:2])
        view = self.body.observe(int(a[1]), heads)
        self.read(view)
        if used and self._face_visible is not None and target is not None:
            self._judge(number, target, objects, suggestion is not None)
        self._learn(number, view, s, a, r)
        return self.body.witnessed()

    def suggestion(self) -> np.ndarray | None:
        """Head angles (2,), deg, for the face of the last step; None without one, or while the table decides."""
        if self.following is None or not self.following.ready or self._face_visible is None:
            return None
        return self.following.learner.predict(self._face_visible)

    def target(self) -> np.ndarray | None:
        """Position (3,), m, of the object that the caregiver looks at, in truth; None if it is no object."""
        point, table = self.stage.looked_at(), self.stage.table
        return point.copy() if point is not None and table.full[table.state[CAREGIVER]] else None

    def _adopt(self) -> None:
        """Give the first module that follows gazes a continuous map."""
        variables = self.agent.variables
        for number, module in enumerate(self.agent.modules):
            event = module.event
            names = variables.sensors[event.sensor].name, variables.actions[event.action].name
            if (*names, variables.results[event.result].name) == (FACE, GAZE, OBJECT):
                units = len(self.senses.categories.som.weights)
                self.following = ContinuousModule(module, self.continuous, units, self._rng)
                self._number = number
                return

    def _learn(self, number: int, view: CentralView, s: np.ndarray, a: np.ndarray, r: np.ndarray) -> None:
        """Keep the pair that this step makes with the one before, and learn from it if it is informative.

        Args:
            number: Of the step.
            view: What is at the centre of view.
            s: (sensors,) values of the step before.
            a: (actions,) likewise.
            r: (results,) likewise.
        """
        face = None if view.pattern is None else self.senses.categories.som.activations(view.pattern)
        location = None
        if view.object and not view.face:
            location = self.body.direction(view.object_px)
        if location is not None and self._face_visible is not None:
            module, informative = self.following, False
            if module is not None:
                event = module.module.event
                next_r = int(self._r[event.result])
                informative = module.is_informative(r[event.result], s[event.sensor], next_r, a[event.action])
            pair = Pair(number, self._face_visible, location, FORWARD, informative)
            self._keep(pair)
            if module is not None and informative:
                module.learn(pair)
        elif face is not None and self._object_at is not None:
            self._keep(Pair(number, face, self._object_at, BACKWARD, False))
        self._face_visible, self._object_at = face, location
        self._target = self.target()

    def _keep(self, pair: Pair) -> None:
        self._pairs.append([pair.step, pair.order == FORWARD, pair.informative, *pair.direction, *pair.activations])

    def _written_down(self) -> tuple[RowStore | ContingencyLog, ...]:
        return *super()._written_down(), self._pairs, self._landings

    def _judge(self, number: int, target: np.ndarray, before: np.ndarray, by_map: bool) -> None:
        """Note how near the gaze has come to the caregiver's object, unless objects were moved meanwhile.

        Args:
            number: Of the step.
            target: (3,) object that the caregiver looked at before the shift, m.
            before: (objects, 3) where objects were before the shift, m.
            by_map: Whether the continuous map chose the direction.
        """
        objects = self.stage.world.caregiver.objects
        if not np.array_equal(before, objects):
            return
        head = np.degrees(self.stage.world.head_angles())
        off = [off_centre(direction, head) for direction in directions_to(objects)]
        own = off_centre(directions_to(target[None])[0], head)
        self._landings.append(Landing(number, by_map, own, bool(own <= min(off) + 1e-9)))
