"""Reproducing contingency in continuous space (section 7.1): a module's map from face patterns to head angles.

The discrete module says which of a few places to look at under which of a few faces. From the turn in which its event
is found, a learner of chapter 6 takes in pairs of what was really seen and where an object really was; which of them
count, the contingent saliency of the event says. When it knows enough pairs, it says where the head goes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from jointattn_mj.contingency.online.modules import Module
from jointattn_mj.contingency.online.reactive import ReactiveModule
from jointattn_mj.development.agent import DeveloperConfig
from jointattn_mj.development.meaning import FACE, GAZE, OBJECT
from jointattn_mj.development.rendered.run import RenderedConfig, RenderedRun
from jointattn_mj.development.rendered.senses import ABRUPT, Gazed, SensesConfig
from jointattn_mj.development.rendered.stage import StageConfig
from jointattn_mj.development.table.world import CAREGIVER, ROBOT, TableConfig
from jointattn_mj.gaze_following.learners import Learner, LearnerConfig, make_learner
from jointattn_mj.options import Checked, Count
from jointattn_mj.scene.camera import direction_of, directions_to, off_centre

FORWARD, BACKWARD = "face to object", "object to face"


@dataclass(frozen=True)
class ContinuousConfig(Checked):
    """How a module gets a map of its own."""

    learner: LearnerConfig = field(default_factory=LearnerConfig)
    """As in chapter 6, on the same activations of the map of faces."""
    enough: Count = 50
    """Pairs that a map must have learned from before it replaces the table; never, if this is more than come."""


SCATTERED = RenderedConfig(
    stage=StageConfig(object_jitter_m=0.1, looks_at="object"),
    senses=SensesConfig(ABRUPT, centre_radius_deg=7.5),
)
"""Objects lie nearly anywhere along the row and up to 10 cm nearer or farther, and she looks at them there. A look at a
place takes in what lies in its part of the row."""


class Pair(NamedTuple):
    """A face and the direction of an object, one turn apart."""

    step: int
    activations: np.ndarray
    """(cells,) of the map of faces."""
    direction: np.ndarray
    """(2,) head angles that would bring the object to the centre of view, deg."""
    order: str
    """FORWARD: the face was seen a turn before the object; BACKWARD: a turn after it."""
    informative: bool
    """Whether the transition was one that the module holds for informative; only after its event was found."""


class Landing(NamedTuple):
    """Where a gaze shift that reproduced the event ended, with the caregiver's eyes on an object when it began."""

    step: int
    by_map: bool
    """Whether the continuous map said where."""
    off_deg: float
    """From the centre of view to the object that she had looked at."""
    nearest: bool
    """Whether no other object was nearer to the centre."""


class ContinuousModule:
    """A module of the mind, and the continuous map that takes its place.

    Attributes:
        module: As it was made.
        learner: From activations to head angles, deg.
        pairs: How many it has learned from.
    """

    def __init__(self, module: Module, config: ContinuousConfig, inputs: int, rng: np.random.Generator):
        self.module, self._enough = module, config.enough
        self.learner: Learner = make_learner(config.learner, inputs, rng)
        self.pairs = 0
        positive = module.saliency[module.saliency > 0]
        self._average = positive.mean() if len(positive) else np.inf

    @property
    def ready(self) -> bool:
        """Whether it says where the head goes."""
        return self.pairs >= self._enough

    def is_informative(self, r: int, s: int, r_next: int, a: int) -> bool:
        """Whether e(r', a; r, s) of eq. 5.3 exceeds the mean of all positive ones, as rule 1 of section 5.2.2 asks."""
        return bool(self.module.saliency[r, s, r_next, a] > self._average)

    def learn(self, pair: Pair) -> None:
        """Take in an informative pair."""
        self.learner.learn(pair.activations, pair.direction)
        self.pairs += 1


class ContinuousRun(RenderedRun):
    """A rendered life in which gaze following, once found, becomes continuous.

    Attributes:
        following: The module of (S1, A1, R3) with its map; None before it is found.
        pairs: All that could be learned from, informative or not.
        landings: How well the module has followed; the robot does not know.
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
        super().__init__(table, config, agent, seed, n_steps, reactive, sample_every)
        self.continuous = continuous
        self.following: ContinuousModule | None = None
        self.pairs: list[Pair] = []
        self.landings: list[Landing] = []
        self._face_visible: np.ndarray | None = None  # activations of the face at the centre a turn ago
        self._object_at: np.ndarray | None = None  # direction of the object at the centre a turn ago
        self._hers: np.ndarray | None = None  # point (3,) that she looked at a turn ago
        self._step = 0
        self._rng = np.random.default_rng(np.random.SeedSequence(seed).spawn(6)[5])

    def see(self) -> None:
        """See ``RenderedRun``; the head goes where the map says while its module is used, and the map learns."""
        if self.following is None:
            self._notice()
        s, r, a = (values.copy() for values in (self.agent.state.s, self.agent.state.r, self.agent.state.a))
        used = self.following is not None and bool(a[len(self.agent.variables.joints) + self._number])
        suggestion = self.suggestion() if used else None
        heads = self.heads
        if suggestion is not None:
            heads = heads.copy()
            heads[self.stage.table.state[ROBOT]] = np.radians(suggestion)
        objects, hers = self.stage.world.caregiver.objects.copy(), self._hers
        self.stage.show(int(a[1]), heads)
        shown = self.look()
        self.senses.read(shown, self.stage.sensors, self.stage.results, self._s, self._r)
        if used and self._face_visible is not None and hers is not None:
            self._judge(hers, objects, suggestion is not None)
        self._learn(shown, s, a, r)
        self._step += 1

    def suggestion(self) -> np.ndarray | None:
        """Head angles (2,), deg, for the face that was seen last; None without one, or while the table decides."""
        if self.following is None or not self.following.ready or self._face_visible is None:
            return None
        return self.following.learner.predict(self._face_visible)

    def target(self) -> np.ndarray | None:
        """The object (3,) that she looks at now, if it is one: the truth."""
        point, table = self.stage.looked_at(), self.stage.table
        return point.copy() if point is not None and table.full[table.state[CAREGIVER]] else None

    def _notice(self) -> None:
        """Give the first module that follows gazes a map."""
        variables = self.agent.variables
        for number, module in enumerate(self.agent.modules):
            event = module.event
            names = variables.sensors[event.sensor].name, variables.actions[event.action].name
            if (*names, variables.results[event.result].name) == (FACE, GAZE, OBJECT):
                cells = len(self.senses.categories.som.weights)
                self.following = ContinuousModule(module, self.continuous, cells, self._rng)
                self._number = number
                return

    def _learn(self, shown: Gazed, s: np.ndarray, a: np.ndarray, r: np.ndarray) -> None:
        """Keep the pairs that this turn makes with the one before, and learn from them what is informative."""
        face = None if shown.pattern is None else self.senses.categories.som.activations(shown.pattern)
        location = None
        if shown.object and not shown.face:
            location = direction_of(shown.object_px, np.degrees(self.stage.world.head_angles()))
        if location is not None and self._face_visible is not None:
            one, informative = self.following, False
            if one is not None:
                event = one.module.event
                next_r = int(self._r[event.result])
                informative = one.is_informative(r[event.result], s[event.sensor], next_r, a[event.action])
            pair = Pair(self._step, self._face_visible, location, FORWARD, informative)
            self.pairs.append(pair)
            if one is not None and informative:
                one.learn(pair)
        elif face is not None and self._object_at is not None:
            self.pairs.append(Pair(self._step, face, self._object_at, BACKWARD, False))
        self._face_visible, self._object_at = face, location
        self._hers = self.target()

    def _judge(self, hers: np.ndarray, before: np.ndarray, by_map: bool) -> None:
        """Note how near the gaze has come to the object that she looked at before the shift, unless all was moved."""
        objects = self.stage.world.caregiver.objects
        if not np.array_equal(before, objects):
            return
        head = np.degrees(self.stage.world.head_angles())
        off = [off_centre(direction, head) for direction in directions_to(objects)]
        own = off_centre(directions_to(hers[None])[0], head)
        self.landings.append(Landing(self._step, by_map, own, bool(own <= min(off) + 1e-9)))
