"""The caregiver of real time: sections 4.3.3 and 5.3.1 without steps, at the caregiver's own pace.

The caregiver looks at an object for a while, glances at the robot and back (IJA), carries an object to a free spot, or
turns to another object. After both have looked at the same object, the caregiver looks at the robot. While the
caregiver looks at the robot and it turns to an object, the caregiver follows (RJA). Each answer comes after a latency.
``watch`` tells the caregiver where the robot looks; it is not measured in images.
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
"""Faster than in chapter 6, where the caregiver shows objects to the robot; here objects are only moved. People turn
their heads by 30 degrees in a third of a second."""


@dataclass(frozen=True)
class PartnerConfig(Checked):
    """Pace of the caregiver; probabilities are in ``TableConfig.caregiver``.

    Times are ranges in seconds, from which each is drawn uniformly.
    """

    latency_s: tuple[Seconds, Seconds] = (0.3, 0.6)
    """From the robot's gaze shift to the beginning of the answer. An answer that comes after two more shifts answers
    nothing: with up to 1 s the event of looking back was not found in four hours (``perception state``)."""
    hold_s: tuple[Seconds, Seconds] = (3.0, 5.0)
    """How long the caregiver looks at an object before the next action: some five of the robot's fixations. The robot
    needs two of them to see where the caregiver looks and to look there too."""
    glance_s: tuple[Seconds, Seconds] = (0.4, 0.8)
    """How long the caregiver looks at the robot in IJA."""
    wait_s: tuple[Seconds, Seconds] = (1.2, 2.2)
    """How long the caregiver looks at the robot after both have looked at the same object."""
    eye_contact_s: tuple[Seconds, Seconds] = (0.5, 1.5)
    """How much longer the caregiver looks at the robot during eye contact; then at an object again."""
    carries: Share = 0.5
    """Probability of carrying the object to another spot, rather than turning to the next one. Where nothing is moved,
    maps are made of one arrangement; where all is moved all the time, objects are in the hand. With 0.15 the maps of
    gaze following led elsewhere in 4 of 11 runs. With 1 it was found in 1 of 10 runs of 50 minutes (``perception
    state``, seeds 0 to 30)."""
    jitter_m: Annotated[float, Real("[0, 0.1]")] = 0.02
    """Largest distance of an object from its spot along x and y, m; a third of its size, as a hand puts it."""
    greets: Annotated[int, Whole("[1, 10000]")] = 10
    """Seconds for which the caregiver greets the robot, in each with another turn of the head. They say which
    categories of faces are frontal."""
    head_jitter_deg: Annotated[float, Real("[0, 15]")] = 2.0
    """Standard deviation, yaw and pitch, of where the caregiver's head comes to rest, degrees; the eyes make up for it.
    Heads turn most of the way to what is looked at, but never the same part of it. Without jitter, faces that look at
    one object are all alike, and each place where an object ever lay would be a category of faces."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("latency_s", "hold_s", "glance_s", "wait_s", "eye_contact_s"):
            low, high = getattr(self, name)
            if low > high:
                raise ConfigError(f"partner.{name} must be a shorter and a longer time; got {low} and {high}")


class Partner(TransferScript):
    """The caregiver at the table. Gaze targets are spots, 0 to N - 1, and N for the other's face.

    Attributes:
        at: (n,) spot of each object; for a carried one, the spot from which it was taken.
        looks_at: Gaze target, during a turn the new one.
        option: Rule that was followed last, a position in ``table.caregiver.OPTIONS``.
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
        """A caregiver who looks at the robot.

        Args:
            config: Pace.
            table: Rules of the caregiver.
            spots: (N, 3) spots, world frame, m.
            behaviour: Duration of movements.
            height: Height of the centre of an object on the table, m.
            head: (3,) position of the head, world frame, m.
            arm: Kinematics of the arm.
            rng: For choices, times and jitter.
        """
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
        """Tell the caregiver where the robot looks: at a spot, at the face (N), or nowhere yet (NOWHERE)."""
        self._robot = robot
        self._shown = self.looks_at == self._face

    def greet(self) -> None:
        """Greet the robot once more, after the present action."""
        self._greeted = 0

    @property
    def greeting(self) -> bool:
        """Whether the caregiver greets the robot, or is about to."""
        return self._greeted < self.partner.greets

    def advance(self) -> None:
        """Advance by one frame."""
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
        """Number of the robot's face as a gaze target."""
        return len(self._spots)

    def full(self, location: int) -> bool:
        """Whether an object lies at a spot; one in the hand lies nowhere."""
        return any(at == location and number != self.held for number, at in enumerate(self.at))

    def _notice(self) -> None:
        """Decide whether to answer the robot's gaze; each gaze is considered once. A gaze is followed only if its shift
        was visible, and not back to the object from which the caregiver has just looked up."""
        robot, following = self._robot, self.looks_at == self._face
        concerns = self._shown if following else self.looks_at == robot
        visible = (self.looks_at, robot) if concerns and robot != self._face and self.full(robot) else None
        chance = self._chance.follow if following else self._chance.answer
        if visible is not None and visible != self._noticed and self._due == 0 and self._rng.random() < chance:
            self._due = self._frames_of(self.partner.latency_s)
            self._answer = robot if following else self._face
        self._noticed = visible

    def _go_on(self) -> None:
        """Begin what follows a finished phase."""
        match self.phase:
            case Phase.GREET if self.greeting:
                self._greeted += 1
                self._head_will_be_off = self._head_jitter()
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
        """Choose the next action after a look that nothing has interrupted."""
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
        """Spot of a random object, other than the one at ``but`` if there is another."""
        others = [int(location) for location in self.at if location != but]
        return int(self._rng.choice(others)) if others else but

    def _turn_to(self, location: int, option: int) -> None:
        """Turn to a gaze target by some rule; the hand goes to rest meanwhile."""
        self.looks_at, self.option, self._returns_to = location, option, NOWHERE
        self._due, self._noticed, self._met, self._shown = 0, None, False, False
        self.target = None if location == self._face else int(np.flatnonzero(self.at == location)[0])
        self.phase = Phase.TURN
        self._head_will_be_off = self._head_jitter()
        aim = np.zeros(2) if self.target is None else self._sight(self.objects[self.target])
        frames = self._frames(self.config.turn_s)
        self._plan = self._planned(path_between(self._gaze, aim, frames), self._home(frames))

    def _look_on(self) -> None:
        """Keep the gaze where it is, for a random time."""
        config, self.held, self.phase = self.partner, None, Phase.GAZE
        if self.target is not None:
            frames = self._frames_of(config.hold_s)
        elif self._met:
            frames = self._frames_of(config.eye_contact_s)
        else:
            frames = self._frames_of(config.wait_s if self.option == AFTER_JOINT_ATTENTION else config.glance_s)
        self._plan = self._planned(np.broadcast_to(self._gaze, (frames, 2)), self._home(frames))

    def _head_jitter(self) -> np.ndarray:
        """Jitter of the head where it will come to rest, yaw and pitch (2,), rad."""
        return np.radians(self._rng.normal(0.0, self.partner.head_jitter_deg, 2))

    def _planned(self, gaze: np.ndarray, grasp: np.ndarray, head_towards: np.ndarray | None = None) -> Plan:
        """See ``TransferScript``; the head comes to rest with some jitter."""
        plan = super()._planned(gaze, grasp, head_towards)
        off = path_between(self._head_off, self._head_will_be_off, len(gaze))
        self._head_off = self._head_will_be_off
        plan.head += off
        plan.joints[:, :2] += off
        plan.joints[:, 2:4] -= off
        plan.joints[:, 4:6] -= off
        return plan

    def _home(self, frames: int) -> np.ndarray:
        """Path of the hand (up to ``frames``, 3), m, to where it rests."""
        rest = np.array(self.config.rest_location)
        if np.linalg.norm(self._hand - rest) < AT_REST_M:
            return self._hand[None]
        back = min(frames, round(self.config.withdraw_s / FRAME_S))
        return path_between(self._hand, rest, back, self.config.reach_arch_m)

    def _new_location(self) -> np.ndarray:
        """See ``TransferScript``: near one of the free spots."""
        free = np.setdiff1d(np.arange(len(self._spots)), self.at)
        self._to = int(self._rng.choice(free))
        return self._beside(self._to)

    def _beside(self, location: int) -> np.ndarray:
        """Where a hand puts an object that belongs at a spot, (3,), m."""
        off = self._rng.uniform(-self.partner.jitter_m, self.partner.jitter_m, 2)
        point: np.ndarray = self._spots[location] + np.append(off, 0.0)
        return point

    def _frames_of(self, seconds: tuple[float, float]) -> int:
        """A random time from a range, in frames."""
        return max(2, round(self._rng.uniform(*seconds) / FRAME_S))


class PartnerWorld(World):
    """A world with such a caregiver; a step is a frame of 1/30 s."""

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
        """See ``World``.

        Args:
            config: Looks and movements; the scene has as many objects as the table.
            physics: Of the scene.
            seed: Of the caregiver.
            conditions: Light and camera.
            partner: Pace of the caregiver.
            table: Rules of the caregiver.
        """
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
