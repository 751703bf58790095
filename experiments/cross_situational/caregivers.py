"""Caregivers who do not look at what they handle, as in Fig. 4.6, who leave some objects alone, or whose objects hang
side by side and above each other."""

from typing import Any

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.scene.caregiver import FRAME_S, Phase, Plan, TransferScript
from jointattn_mj.scene.model import rest_height
from jointattn_mj.scene.movement import Arm, minimum_jerk
from jointattn_mj.scene.world import World

PLANE_X = 0.8
"""x of the upright plane, world frame, metres: before the caregiver's hand, above the table, below the face."""
SIDE, HEIGHT = 1, 2
"""Axes of the world in which places in the plane differ."""
LOOKS_BACK_RAD = 0.05
"""A gaze that begins a phase farther than this from where it was is led there as in the phase ``turn``."""


class CarelessScript(TransferScript):
    """Transfers objects, and looks elsewhere meanwhile; ``target`` is what the caregiver looks at, None for no object.

    Attributes:
        looks_away: Probability, in each phase after ``turn``, of looking at an empty position on the table.
        looks_at_others: Whether the gaze rests on an object that stays on the table, whatever is handled.
        handled: How many of the objects are transferred, the first ones; None for all.
    """

    looks_away = 0.0
    looks_at_others = False
    handled: int | None = None
    _transferred: int | None = None
    _other: int | None = None

    def next_target(self, rng: np.random.Generator) -> int:
        """See ``TransferScript``; among those that are handled."""
        count = len(self.objects) if self.handled is None else self.handled
        others = [i for i in range(count) if i != self.target or count == 1]
        return int(rng.choice(others))

    def _begin(self, phase: Phase) -> None:
        self.target = self._transferred
        super()._begin(phase)
        self._transferred = self.target
        if phase is Phase.GREET:
            return
        if phase is Phase.TURN:
            self._other = int(self._rng.choice([i for i in range(len(self.objects)) if i != self.target]))
        point = self.objects[self.target] if phase is Phase.GAZE else None
        if self.looks_at_others:
            self.target = self._other
            point = self.objects[self._other]
        elif phase is not Phase.TURN and self._rng.random() < self.looks_away:
            self.target = None
            point = self._anywhere()
        self._plan = self._looking_at(point)

    def _anywhere(self) -> np.ndarray:
        """A position (3,) on the table, m, where objects may lie."""
        layout = self._layout.config
        x, y = (self._rng.uniform(*span) for span in (layout.x_range, layout.y_range))
        return np.array([x, y, self._rest_height])

    def _looking_at(self, point: np.ndarray | None) -> Plan:
        """The plan of this phase with the gaze on a point (3,), m, or where it was planned, led there smoothly."""
        plan = self._plan
        gaze = plan.gaze if point is None else np.broadcast_to(self._sight(point), plan.gaze.shape)
        if point is None and np.abs(gaze[0] - self._gaze).max() < LOOKS_BACK_RAD:
            return plan
        turn = minimum_jerk(min(len(gaze), round(self.config.turn_s / FRAME_S)))
        share = np.ones(len(gaze))
        share[: len(turn)] = turn
        gaze = self._gaze + share[:, None] * (gaze - self._gaze)
        head = self.config.head_share * gaze
        joints = np.concatenate([head, gaze - head, gaze - head, plan.joints[:, 6:]], axis=1)
        return Plan(gaze=gaze, head=head, grasp=plan.grasp, joints=joints)


class UprightScript(TransferScript):
    """Transfers objects in an upright plane between robot and caregiver: the layout's x is their height.

    On the table objects differ far more in pan than in tilt. Here they can differ alike. The hand does not reach them:
    they hang in the air, and move as if it held them.
    """

    def __init__(self, *arguments: Any):
        """See ``TransferScript``."""
        super().__init__(*arguments)
        self.objects = _upright(self.objects)

    def _new_location(self) -> np.ndarray:
        others = self.objects[np.arange(len(self.objects)) != self.held]
        try:
            location: np.ndarray = _upright(self._layout.draw(others[:, [HEIGHT, SIDE]])[None])[0]
        except ConfigError:  # no room
            return self._taken_from
        return location


def _upright(points: np.ndarray) -> np.ndarray:
    """Points (n, 3), world frame, metres, of places (n, 2 or more): their height, and how far to the robot's left."""
    standing: np.ndarray = np.column_stack([np.full(len(points), PLANE_X), points[:, 1], points[:, 0]])
    return standing


class CarelessWorld(World):
    """A world with such a caregiver, or one of another class."""

    script: type[TransferScript] = CarelessScript

    def new_caregiver(self, head: np.ndarray, arm: Arm, rng: np.random.Generator) -> TransferScript:
        """See ``World``."""
        config, count = self.config, len(self.config.scene.objects)
        return self.script(config.behaviour, config.layout, count, rest_height(config.scene), head, arm, rng)


def world_with(looks_away: float, looks_at_others: bool, handled: int | None) -> type[World]:
    """A class of worlds, whose caregiver has these attributes of ``CarelessScript``; ``World`` itself for none.

    Args:
        looks_away: Share of looks at no object, 0 to 1.
        looks_at_others: Whether the gaze rests on an object that stays on the table, whatever is handled.
        handled: How many of the objects are transferred, the first ones; None for all.
    """
    if not looks_away and not looks_at_others and handled is None:
        return World
    attributes = {"looks_away": looks_away, "looks_at_others": looks_at_others, "handled": handled}
    script = type("Script", (CarelessScript,), attributes)
    return type("ScriptedWorld", (CarelessWorld,), {"script": script})


class UprightWorld(CarelessWorld):
    """A world whose objects hang in an upright plane."""

    script = UprightScript
