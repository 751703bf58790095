"""What the caregiver does, and how fast: the object-transfer task of section 6.4.2.

The caregiver picks an object at random and turns to it, reaches, lifts it before the face, observes it, puts it
elsewhere on the table, and looks at it for a while. Each phase is planned as a whole when it begins (a ``Plan`` of one
row per frame) and then played. Nothing of this depends on the robot.
"""

from dataclasses import dataclass, replace
from enum import StrEnum
from math import radians
from typing import Annotated, ClassVar

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Angle, Checked, Metres, Real, Seconds, Share
from jointattn_mj.scene.layout import Layout, LayoutConfig
from jointattn_mj.scene.movement import Arm, gaze_angles, minimum_jerk, path_between

FRAME_S = 1 / 30
"""One step of caregiver, robot and camera: 30 images a second (section 6.4.1)."""


class Phase(StrEnum):
    """The phases of the object-transfer task; GREET comes once, before it."""

    GREET = "greet"
    TURN = "turn"
    REACH = "reach"
    LIFT = "lift"
    OBSERVE = "observe"
    PUT = "put"
    GAZE = "gaze"


PHASES = tuple(Phase)
_NUMBERS = {phase: number for number, phase in enumerate(PHASES)}
_ABOUT = np.array([-1.0, -1.0, 1.0])
DURATIONS = ("greet_s", "turn_s", "reach_s", "lift_s", "observe_s", "put_s", "gaze_s", "withdraw_s")
"""The fields of ``CaregiverConfig`` that make up the caregiver's pace."""
FOLLOWING = {
    Phase.GREET: Phase.TURN,
    Phase.TURN: Phase.REACH,
    Phase.REACH: Phase.LIFT,
    Phase.LIFT: Phase.OBSERVE,
    Phase.OBSERVE: Phase.PUT,
    Phase.PUT: Phase.GAZE,
    Phase.GAZE: Phase.TURN,
}
"""The phase after each phase."""


@dataclass(frozen=True)
class CaregiverConfig(Checked):
    """The caregiver's pace and ways of moving.

    The fields that end in ``_s`` are the pace, in seconds. Section 6.4.2 fixes "about two seconds" for observing and
    for gazing; all else is a choice.
    """

    greet_s: Seconds = 1.0
    """Looking at the robot, once, before anything else: the robot's first sight of a frontal face."""
    turn_s: Seconds = 0.7
    """Turning the head to an object; with minimum jerk, 40 degrees peak at about 107 degrees/s."""
    reach_s: Seconds = 0.6
    """Moving the hand from its resting position to the object."""
    lift_s: Seconds = 0.7
    """Lifting the object from the table to ``holding_location``."""
    observe_s: Seconds = 2.3
    """Observing the object: "observes it for about two seconds" (6.4.2)."""
    put_s: Seconds = 1.5
    """Putting the object down elsewhere on the table."""
    gaze_s: Seconds = 2.0
    """Looking at the object on the table: "gazes at it for about two seconds" (6.4.2); meanwhile the hand goes back."""
    duration_jitter: Annotated[float, Real("[0, 1)")] = 0.2
    """Each duration is multiplied by a uniform draw from 1 +- this, since people are not clockwork."""
    withdraw_s: Seconds = 0.8
    """Moving the hand back to its resting position, during ``gaze_s``."""
    holding_location: tuple[Metres, Metres, Metres] = (1.20, 0.0, 0.895)
    """Where an object is held to be observed, x, y, z in the world frame, metres: before and below the face."""
    wobble_m: Annotated[float, Real("[0, 1]")] = 0.015
    """Amplitude, metres, by which the observed object is moved to and fro. A still object gives the robot no motion cue
    and cost trial runs a third of their successes."""
    wobble_hz: Annotated[float, Real("[0, 100]")] = 2.0
    """Frequency of that movement, hertz: fast and small, so that the learned direction is not smeared."""
    reach_arch_m: Annotated[float, Real("[0, 1]")] = 0.12
    """How far the empty hand rises above the straight path, metres, so that it comes down on an object from above."""
    carry_arch_m: Annotated[float, Real("[0, 1]")] = 0.06
    """The same for a hand with an object, which has to pass over the others, metres."""
    head_share: Share = 0.85
    """Share of a gaze angle that the head turns; the eyes turn the rest."""
    hand_pitch_deg: Angle = 27.0
    """How far down the hand points, degrees; steeper, it would hide the chin while an object is observed."""
    elbow_at_table_deg: Angle = 25.0
    """How far the elbow is raised with the hand at the table, degrees: the forearm passes over other objects."""
    elbow_at_holding_deg: Angle = -10.0
    """The same with the hand at ``holding_location``: the elbow hangs, and the forearm leaves the face free."""
    rest_location: tuple[Metres, Metres, Metres] = (1.21, 0.36, 0.752)
    """Where the hand rests, on the table beside the objects; x, y, z in the world frame, metres."""

    def at_pace(self, factor: float) -> "CaregiverConfig":
        """The same caregiver, who takes ``factor`` times as long for everything."""
        return replace(self, **{name: getattr(self, name) * factor for name in DURATIONS})

    RENAMED: ClassVar = {"holding_place": "holding_location", "rest_place": "rest_location"}
    ADVANCED: ClassVar = ("wobble_hz", "reach_arch_m", "carry_arch_m", "elbow_at_table_deg", "elbow_at_holding_deg")


@dataclass
class Plan:
    """A phase of T frames, frame by frame.

    Attributes:
        gaze: (T, 2) yaw and pitch of the line of sight, the caregiver's frame, rad.
        head: (T, 2) the head's part of it, rad.
        grasp: (T, 3) where the hand's grasp is, world frame, metres.
        joints: (T, 13) neck yaw and pitch, yaw and pitch of either eye, the seven arm joints, rad.
    """

    gaze: np.ndarray
    head: np.ndarray
    grasp: np.ndarray
    joints: np.ndarray

    def __post_init__(self) -> None:
        if len({len(part) for part in (self.gaze, self.head, self.grasp, self.joints)}) != 1:
            raise ValueError("all parts of a plan must have as many frames")

    def __repr__(self) -> str:
        return f"Plan({len(self.joints)} frames)"


class TransferScript:
    """The caregiver's state machine. Attributes hold for the end of the last frame.

    Attributes:
        phase: What the caregiver does.
        target: Index of the object that the caregiver looks at; None for the robot.
        held: Index of the object in the caregiver's hand, or None.
        joints: (13,) neck yaw and pitch, yaw and pitch of either eye, and the seven arm joints, rad.
        objects: (n, 3) centres of the objects, world frame, metres.
    """

    following: ClassVar[dict[Phase, Phase]] = FOLLOWING
    """The phase after each phase."""

    def __init__(
        self,
        config: CaregiverConfig,
        layout: LayoutConfig,
        object_count: int,
        rest_height: float,
        head: np.ndarray,
        arm: Arm,
        rng: np.random.Generator,
    ):
        """Lay out the objects, and begin to greet.

        Args:
            config: Pace and ways of moving.
            layout: Where objects may lie.
            object_count: How many objects there are.
            rest_height: Height of an object's centre on the table, metres.
            head: (3,) centre of the caregiver's head, world frame, metres.
            arm: The caregiver's arm.
            rng: Draws targets, positions and durations.

        Raises:
            ConfigError: Objects do not fit on the table, or would be held below it.
        """
        if not config.holding_location[2] > rest_height:
            raise ConfigError(
                f"caregiver.holding_location must lie above the objects on the table, z > {rest_height:.3f} m; "
                f"got {config.holding_location}"
            )
        self.config = config
        self._rng = rng
        self._layout = Layout(layout, rng)
        self._rest_height = rest_height
        self._origin = np.array([head[0], head[1], 0.0])
        self._eye = np.array([0.0, 0.0, head[2]])
        self._arm = arm
        self.objects = np.column_stack([self._layout.fill(object_count), np.full(object_count, rest_height)])
        self.target: int | None = None
        self.held: int | None = None
        self._taken_from = self.objects[0]
        self._gaze = np.zeros(2)
        self._hand = np.array(config.rest_location)
        self._begin(Phase.GREET)
        self._play(0)

    def advance(self) -> None:
        """Advance by one frame."""
        if self._ends:
            self._begin(self.following[self.phase])
            self._play(0)
        else:
            self._play(self._frame + 1)

    def advance_all(self, doing: np.ndarray, joints: np.ndarray, objects: np.ndarray) -> None:
        """Advance by k frames as ``advance`` does it frame by frame, and write what the caregiver does.

        Args:
            doing: (k, 3) int, takes what ``doing`` says before each of these frames.
            joints: (k, 13) takes the joints at the end of each, rad.
            objects: (k, n, 3) takes the objects at the end of each, world frame, metres.
        """
        done, frames = 0, len(joints)
        doing[:1] = self.doing()
        while done < frames:
            if self._ends:
                self._begin(self.following[self.phase])
                self._frame = -1
            first, plan = self._frame + 1, self._plan
            last = min(len(plan.joints), first + frames - done)
            span = slice(done, done + last - first)
            joints[span], objects[span] = plan.joints[first:last], self.objects
            if self.held is not None:
                objects[span, self.held] = plan.grasp[first:last]
            self._play(last - 1)
            done = span.stop
            doing[span.start + 1 : done + 1] = self.doing()

    def doing(self) -> tuple[int, int, int]:
        """Number of the phase in ``PHASES``, target, and held object; -1 for none."""
        target, held = self.target, self.held
        return _NUMBERS[self.phase], -1 if target is None else target, -1 if held is None else held

    def next_target(self, rng: np.random.Generator) -> int:
        """Index of the next target: any other object ("picks an object at random", 6.4.2)."""
        others = [i for i in range(len(self.objects)) if i != self.target or len(self.objects) == 1]
        return others[rng.integers(len(others))]  # as ``rng.choice`` draws, in a third of the time

    @property
    def _ends(self) -> bool:
        """Whether this is the phase's last frame."""
        return self._frame + 1 == len(self._plan.joints)

    def _play(self, frame: int) -> None:
        self._frame = frame
        plan = self._plan
        self.joints = plan.joints[frame]
        self._gaze, self._hand = plan.gaze[frame], plan.grasp[frame]
        if self.held is not None:
            self.objects[self.held] = self._hand

    def _begin(self, phase: Phase) -> None:
        config, hand = self.config, self._hand
        self.phase = phase
        frames = self._frames(getattr(config, f"{phase}_s"))
        match phase:
            case Phase.GREET:
                self._plan = self._planned(np.zeros((frames, 2)), hand[None])
            case Phase.TURN:
                self.target = self.next_target(self._rng)
                aim = self._sight(self.objects[self.target])
                self._plan = self._planned(path_between(self._gaze, aim, frames), hand[None])
            case Phase.REACH:
                target = self.objects[self.target]
                gaze = np.broadcast_to(self._sight(target), (frames, 2))
                self._plan = self._planned(gaze, path_between(hand, target, frames, config.reach_arch_m))
            case Phase.LIFT:
                self.held, self._taken_from = self.target, self.objects[self.target].copy()
                path = path_between(hand, np.array(config.holding_location), frames, config.carry_arch_m)
                self._plan = self._planned(self._sight(path), path)
            case Phase.OBSERVE:
                path = np.array(config.holding_location) + self._wobble(frames)
                steady = np.broadcast_to(self._sight(np.array(config.holding_location)), (frames, 2))
                self._plan = self._planned(self._sight(path), path, head_towards=steady)
            case Phase.PUT:
                path = path_between(hand, self._new_location(), frames, config.carry_arch_m)
                self._plan = self._planned(self._sight(path), path)
            case Phase.GAZE:
                self.held = None
                gaze = np.broadcast_to(self._gaze, (frames, 2))
                back = max(1, min(frames, round(config.withdraw_s / FRAME_S)))
                path = path_between(hand, np.array(config.rest_location), back, config.reach_arch_m)
                self._plan = self._planned(gaze, path)

    def _new_location(self) -> np.ndarray:
        """Where to put the held object, (3,), metres: elsewhere, or back where it was if the table has no room."""
        others = self.objects[np.arange(len(self.objects)) != self.held, :2]
        try:
            return np.append(self._layout.draw(others), self._rest_height)
        except ConfigError:
            taken_from: np.ndarray = self._taken_from
            return taken_from

    def _frames(self, seconds: float) -> int:
        jitter = self.config.duration_jitter
        return max(2, round(seconds * self._rng.uniform(1 - jitter, 1 + jitter) / FRAME_S))

    def _sight(self, points: np.ndarray) -> np.ndarray:
        """Gaze angles (..., 2), rad, towards points (..., 3), world frame, metres."""
        return gaze_angles(self._eye, self._own(points))

    def _own(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) of the world in the caregiver's frame, which faces the other way."""
        own: np.ndarray = (points - self._origin) * _ABOUT
        return own

    def _elbow(self, height: np.ndarray) -> np.ndarray:
        """Swing of the elbow (T,), rad, for a hand at ``height`` (T,), metres, between those of the config."""
        table, holding = radians(self.config.elbow_at_table_deg), radians(self.config.elbow_at_holding_deg)
        risen = (height - self._rest_height) / (self.config.holding_location[2] - self._rest_height)
        swing: np.ndarray = table + risen * (holding - table)
        return swing

    def _wobble(self, frames: int) -> np.ndarray:
        """A small movement to and fro, (frames, 3), metres, that begins and ends at rest."""
        config, time = self.config, np.arange(1, frames + 1) * FRAME_S
        ramp = minimum_jerk(max(1, frames // 4))
        swell = np.ones(frames)
        swell[: len(ramp)], swell[frames - len(ramp) :] = ramp, 1 - ramp
        phase = 2 * np.pi * config.wobble_hz * time
        to_and_fro = np.column_stack([0 * time, np.sin(phase), 0.5 * np.sin(2 * phase)])
        offsets: np.ndarray = config.wobble_m * swell[:, None] * to_and_fro
        return offsets

    def _planned(self, gaze: np.ndarray, grasp: np.ndarray, head_towards: np.ndarray | None = None) -> Plan:
        """The plan for a gaze (T, 2), rad, and a path of the hand (up to T, 3), metres, at whose end the hand stays."""
        on_path = np.minimum(np.arange(len(gaze)), len(grasp) - 1)
        head = self.config.head_share * (gaze if head_towards is None else head_towards)
        arm = self._arm.reach(self._own(grasp), self._elbow(grasp[:, 2]))
        eyes = gaze - head
        joints = np.concatenate([head, eyes, eyes, arm[on_path]], axis=1)
        return Plan(gaze=gaze, head=head, grasp=grasp[on_path], joints=joints)
