"""A caregiver who lives at her own pace and notices where the robot looks: sections 4.3.3 and 5.3.1 without turns.

She looks at an object for a while, glances at the robot and back (IJA), carries an object to a free place, or turns to
another; nobody tells her when. When both look at the same object she looks at the robot; when she looks at the robot
and it turns to an object she follows (RJA): each after a latency, as people do. She has eyes: where the robot looks is
told to her by ``watch`` and not measured in images.
"""

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from dm_control.mujoco import Physics

from jointattn_mj.development.table.caregiver import AFTER_JOINT_ATTENTION, IJA, IJA_BACK, NEUTRAL, NOWHERE, RJA
from jointattn_mj.development.table.world import TableConfig
from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Real, Seconds, Share, Whole
from jointattn_mj.scene.caregiver import FRAME_S, CaregiverConfig, Phase, Plan, TransferScript
from jointattn_mj.scene.dressing import Conditions
from jointattn_mj.scene.layout import LayoutConfig
from jointattn_mj.scene.looker import spot_positions
from jointattn_mj.scene.model import rest_height
from jointattn_mj.scene.movement import Arm, path_between
from jointattn_mj.scene.world import World, WorldConfig

AT_REST_M = 1e-6
"""A hand that is so near to its resting place has nothing to withdraw."""
PACE = CaregiverConfig(greet_s=1.0, turn_s=0.35, reach_s=0.5, lift_s=0.5, put_s=1.0)
"""Quicker than in chapter 6, where she shows objects to the robot: here she moves them and goes on. People turn their
heads by 30 degrees in a third of a second."""


@dataclass(frozen=True)
class PartnerConfig(Checked):
    """What turns leave open: how long everything takes her; how likely it is is said by ``TableConfig.caregiver``.

    All times are ranges in seconds, from which each is drawn evenly.
    """

    latency_s: tuple[Seconds, Seconds] = (0.3, 0.6)
    """From what the robot does to the beginning of her answer. An answer that comes when the robot has gone on twice is
    an answer to nothing: with up to 1 s the event of looking back was not to be seen in four hours (from the state)."""
    hold_s: tuple[Seconds, Seconds] = (3.0, 5.0)
    """How long she looks at an object before she does anything else of her own accord: some five of the robot's
    fixations, of which it needs two to see where she looks and to look there too."""
    glance_s: tuple[Seconds, Seconds] = (0.4, 0.8)
    """How long she looks up at the robot in IJA."""
    wait_s: tuple[Seconds, Seconds] = (1.2, 2.2)
    """How long she looks at the robot after both have looked at the same object: until it looks back, if it does."""
    eye_contact_s: tuple[Seconds, Seconds] = (0.5, 1.5)
    """How much longer she looks at the robot if it looks at her; then she looks at an object again."""
    carries: Share = 0.5
    """How likely she carries the object that she has looked at to another place, rather than turn to the next one.
    Where nothing is moved, one arrangement of objects lasts so long that maps are made of it; where they are moved all
    the time, they are in her hand: with 0.15 the maps of gaze following led elsewhere in 4 of 11 lives, with 1 it was
    found in 1 of 10 lives of 50 minutes (from the state, seeds 0 to 30)."""
    jitter_m: Annotated[float, Real("[0, 0.1]")] = 0.02
    """Objects lie up to so far beside their place, either way; a third of their size, as a hand puts them."""
    greets: Annotated[int, Whole("[1, 10000]")] = 10
    """For so many seconds she looks at the robot when she greets it, in each a little otherwise: so it learns what
    frontal is."""
    head_jitter_deg: Annotated[float, Real("[0, 15]")] = 2.0
    """Standard deviation, yaw and pitch, of where her head comes to rest; her eyes make up for it. As in turns: heads
    turn most of the way to what is looked at, but never the same part of it. Without it faces that look at one object
    are all alike, and each place where an object ever lay would be a category of faces."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("latency_s", "hold_s", "glance_s", "wait_s", "eye_contact_s"):
            low, high = getattr(self, name)
            if low > high:
                raise ConfigError(f"partner.{name} must be a shorter and a longer time; got {low}, {high}")


class Partner(TransferScript):
    """Who sits at the table. Places are 0 to N - 1; N stands for the other's face.

    Attributes:
        at: (n,) place of each object; a carried one's is that where it was taken from.
        looks_at: Where she looks, or turns to.
        option: What she chose last (``symbolic.caregiver.OPTIONS``).
    """

    def __init__(
        self,
        config: PartnerConfig,
        table: TableConfig,
        spots: np.ndarray,
        behaviour: CaregiverConfig,
        height: float,
        head: np.ndarray,
        arm: Arm,
        rng: np.random.Generator,
    ):
        """``spots`` (N, 3): the places, world frame, m; ``height``: of an object's centre on the table."""
        self.partner, self._chance, self._spots = config, table.caregiver, spots
        self.looks_at = self._robot = len(spots)
        self._met = self._shown = False
        self._head_off = self._head_will_be_off = np.zeros(2)
        self._greeted = 0
        self.option = NEUTRAL
        self._returns_to = self._to = NOWHERE
        self._noticed: tuple[int, int] | None = None
        self._answer, self._due = NOWHERE, 0
        anywhere = LayoutConfig(spacing=1e-6, evenness=1)
        super().__init__(behaviour, anywhere, table.objects, height, head, arm, rng)
        self.at = rng.permutation(len(spots))[: table.objects]
        self.objects[:] = [self._beside(location) for location in self.at]

    def watch(self, robot: int) -> None:
        """She sees the robot look at a place, at her face (N), or turn its head (NOWHERE)."""
        self._robot = robot
        self._shown = self.looks_at == self._face

    def greet(self) -> None:
        """Greet the robot once more, as soon as she has nothing else to do."""
        self._greeted = 0

    @property
    def greeting(self) -> bool:
        """Whether she greets it, or will."""
        return self._greeted < self.partner.greets

    def advance(self) -> None:
        """Live through one frame."""
        if self.phase in (Phase.GAZE, Phase.REACH):
            self._notice()
        if self._due == 1:
            self._due = 0
            self._turn_to(self._answer, RJA if self.looks_at == self._face else AFTER_JOINT_ATTENTION)
            self._play(0)
            return
        self._due = max(0, self._due - 1)
        if self._frame + 1 < len(self._plan.joints):
            self._play(self._frame + 1)
        elif self._due == 0:
            self._go_on()
            self._play(0)

    @property
    def _face(self) -> int:
        """The number that stands for the robot's face."""
        return len(self._spots)

    def full(self, location: int) -> bool:
        """Whether an object lies at a place; one in her hand lies nowhere."""
        return any(at == location and number != self.held for number, at in enumerate(self.at))

    def _notice(self) -> None:
        """Whether what the robot does is worth an answer; each such thing is considered once. She follows a gaze that
        she has seen turn, and not back to the object from which she has just looked up."""
        robot, following = self._robot, self.looks_at == self._face
        concerns_her = self._shown if following else self.looks_at == robot
        visible = (self.looks_at, robot) if concerns_her and robot != self._face and self.full(robot) else None
        chance = self._chance.follow if following else self._chance.answer
        if visible is not None and visible != self._noticed and self._due == 0 and self._rng.random() < chance:
            self._due = self._frames_of(self.partner.latency_s)
            self._answer = robot if following else self._face
        self._noticed = visible

    def _go_on(self) -> None:
        """What comes after a phase that has run its course."""
        match self.phase:
            case Phase.GREET if self.greeting:
                self._greeted += 1
                self._head_will_be_off = self._beside_the_way()
                self._begin(Phase.GREET)
            case Phase.GREET:
                self._turn_to(self._some_object(NOWHERE), NEUTRAL)
            case Phase.TURN if self.greeting and self.looks_at == self._face:
                self._begin(Phase.GREET)
            case Phase.TURN:
                self._look_on()
            case Phase.REACH:
                self._begin(Phase.LIFT)
            case Phase.LIFT:
                self._begin(Phase.PUT)
            case Phase.PUT:
                self.at[self.target], self.looks_at = self._to, self._to
                self._look_on()
            case _:
                self._choose()

    def _choose(self) -> None:
        """Nothing has called for an answer, and she has looked there long enough."""
        chance, rng = self._chance, self._rng
        if self.greeting:
            self._turn_to(self._face, NEUTRAL)
        elif self.looks_at == self._face:
            if self._returns_to != NOWHERE:
                self._turn_to(self._returns_to, IJA_BACK)
            elif self._robot == self._face and not self._met and chance.eye_contact == "stay":
                self.option, self._met = NEUTRAL, True
                self._look_on()
            else:
                self._turn_to(self._some_object(self._robot), NEUTRAL)  # that would be following
        elif rng.random() < chance.lead:
            returns_to = self.looks_at
            self._turn_to(self._face, IJA)
            self._returns_to = returns_to
        elif len(self.at) < len(self._spots) and rng.random() < self.partner.carries:
            self.option = NEUTRAL
            self._begin(Phase.REACH)
        else:
            self._turn_to(self._some_object(self.looks_at), NEUTRAL)

    def _some_object(self, but: int) -> int:
        """Place of any object but one; of that one where there is no other."""
        others = [int(location) for location in self.at if location != but]
        return int(self._rng.choice(others)) if others else but

    def _turn_to(self, location: int, option: int) -> None:
        """Turn to a place or, with N, to the robot; the hand goes home meanwhile."""
        self.looks_at, self.option, self._returns_to = location, option, NOWHERE
        self._due, self._noticed, self._met, self._shown = 0, None, False, False
        self.target = None if location == self._face else int(np.flatnonzero(self.at == location)[0])
        self.phase = Phase.TURN
        self._head_will_be_off = self._beside_the_way()
        aim = np.zeros(2) if self.target is None else self._sight(self.objects[self.target])
        frames = self._frames(self.config.turn_s)
        self._plan = self._planned(path_between(self._gaze, aim, frames), self._home(frames))

    def _look_on(self) -> None:
        """Look where she looks for as long as that lasts."""
        config, self.held, self.phase = self.partner, None, Phase.GAZE
        if self.target is not None:
            frames = self._frames_of(config.hold_s)
        elif self._met:
            frames = self._frames_of(config.eye_contact_s)
        else:
            frames = self._frames_of(config.wait_s if self.option == AFTER_JOINT_ATTENTION else config.glance_s)
        self._plan = self._planned(np.broadcast_to(self._gaze, (frames, 2)), self._home(frames))

    def _beside_the_way(self) -> np.ndarray:
        """How far beside its share of the way her head will come to rest, yaw and pitch (2,), rad."""
        return np.radians(self._rng.normal(0.0, self.partner.head_jitter_deg, 2))

    def _planned(self, gaze: np.ndarray, grasp: np.ndarray, head_towards: np.ndarray | None = None) -> Plan:
        """See ``TransferScript``; the head comes to rest a little beside its share of the way."""
        plan = super()._planned(gaze, grasp, head_towards)
        off = path_between(self._head_off, self._head_will_be_off, len(gaze))
        self._head_off = self._head_will_be_off
        plan.head += off
        plan.joints[:, :2] += off
        plan.joints[:, 2:4] -= off
        plan.joints[:, 4:6] -= off
        return plan

    def _home(self, frames: int) -> np.ndarray:
        """The hand's way (up to ``frames``, 3) to its resting place."""
        rest = np.array(self.config.rest_location)
        if np.linalg.norm(self._hand - rest) < AT_REST_M:
            return self._hand[None]
        back = min(frames, round(self.config.withdraw_s / FRAME_S))
        return path_between(self._hand, rest, back, self.config.reach_arch_m)

    def _new_location(self) -> np.ndarray:
        """See ``TransferScript``: beside one of the free places."""
        free = np.setdiff1d(np.arange(len(self._spots)), self.at)
        self._to = int(self._rng.choice(free))
        return self._beside(self._to)

    def _beside(self, location: int) -> np.ndarray:
        """Where a hand puts an object that belongs at a place, (3,)."""
        off = self._rng.uniform(-self.partner.jitter_m, self.partner.jitter_m, 2)
        return self._spots[location] + np.append(off, 0.0)

    def _frames_of(self, seconds: tuple[float, float]) -> int:
        return max(2, round(self._rng.uniform(*seconds) / FRAME_S))


class PartnerWorld(World):
    """A world with a partner in it, a frame of 1/30 s a step."""

    caregiver: Partner

    def __init__(
        self,
        config: WorldConfig,
        physics: Physics,
        seed: np.random.SeedSequence,
        conditions: Conditions,
        partner: PartnerConfig,
        table: TableConfig,
    ):
        """``config.scene.objects`` are as many as the table's."""
        self._partner, self._table = partner, table
        super().__init__(config, physics, seed, conditions)

    def new_caregiver(self, head: np.ndarray, arm: Arm, rng: np.random.Generator) -> Partner:
        """See ``World``."""
        config, spots = self.config, spot_positions(self._table.spots, self.config.scene)
        height = rest_height(config.scene)
        return Partner(self._partner, self._table, spots, config.behaviour, height, head, arm, rng)

    def __getstate__(self) -> dict[str, Any]:
        """See ``World``."""
        return {**super().__getstate__(), "_partner": self._partner, "_table": self._table}
