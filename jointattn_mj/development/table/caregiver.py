"""The caregiver's gaze shifts at the table (sections 4.3.3 and 5.3.1), as one compiled function."""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from jointattn_mj.errors import ObservationError
from jointattn_mj.guards.border import checked_by, require_array
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked, Share

NEUTRAL, RJA, IJA, IJA_BACK, AFTER_JOINT_ATTENTION, CARELESS = range(6)
OPTIONS = ("neutral", "RJA", "IJA", "IJA, second step", "joint attention reached", "not at objects")
NOWHERE = -1


@dataclass(frozen=True)
class TableCaregiverConfig(Checked):
    """How the caregiver shifts gaze."""

    follow: Share = 0.5
    """p_r, probability of following the robot's gaze (RJA) when it looks at a spot and the caregiver at the robot."""
    lead: Share = 0.5
    """p_i, probability of leading the robot (IJA) while looking at an object: look at the robot, then back there."""
    answer: Share = 1.0
    """p_e, probability of looking at the robot after both have looked at the same object (chapter 5)."""
    at_objects: Share = 1.0
    """p_c (section 4.5.3), probability of these rules; else the caregiver looks at the robot or an empty spot."""
    follows_eye_contact: bool = False
    """Whether RJA is also possible while robot and caregiver look at each other, as in chapter 4; it then ends at some
    object. In chapter 5 the robot must look at a spot."""
    eye_contact: Literal["stay", "leave", "any"] = "stay"
    """What the neutral option does during eye contact: ``stay``, ``leave`` for some object, or ``any`` of these."""
    neutral_follows: bool = False
    """Whether a neutral shift away from the robot may end where the robot looks, "identical to RJA" by chance."""


class Rules(NamedTuple):
    """A ``TableCaregiverConfig`` as numbers, for compiled code."""

    follow: float
    lead: float
    answer: float
    at_objects: float
    follows_eye_contact: bool
    stays: bool
    may_stay: bool
    neutral_follows: bool


def rules(config: TableCaregiverConfig) -> Rules:
    """The config as numbers."""
    return Rules(
        follow=float(config.follow),
        lead=float(config.lead),
        answer=float(config.answer),
        at_objects=float(config.at_objects),
        follows_eye_contact=config.follows_eye_contact,
        stays=config.eye_contact == "stay",
        may_stay=config.eye_contact == "any",
        neutral_follows=config.neutral_follows,
    )


@njit(cache=True, borrows=True, forceinline=True)
def _count(spots: np.ndarray) -> int:
    count = 0
    for spot in range(len(spots)):
        count += spots[spot]
    return count


@njit(cache=True, borrows=True, forceinline=True)
def _some(allowed: np.ndarray, random: np.random.Generator) -> int:
    """A random one of the allowed spots, or NOWHERE."""
    count = _count(allowed)
    if count == 0:
        return NOWHERE
    left = int(random.random() * count)
    for spot in range(len(allowed)):
        left -= allowed[spot]
        if left < 0:
            return spot
    return NOWHERE


def _check_shift(
    rules: Rules,
    full: np.ndarray,
    robot: int,
    gaze: int,
    returns_to: int,
    random: np.random.Generator,
    allowed: np.ndarray,
) -> None:
    require_array("whether an object lies on a spot", full, (-1,), "b")
    require_array("working space", allowed, full.shape, "b")
    looks = np.array([robot, gaze, returns_to])
    require_array(
        "gaze targets of robot and caregiver, and the spot to return to", looks, (3,), "iu", NOWHERE, len(full)
    )
    if min(robot, gaze) < 0 or returns_to == len(full):
        raise ObservationError(
            f"gaze targets are 0 to {len(full)}, and the caregiver returns to a spot; got {robot}, {gaze}, {returns_to}"
        )


@checked_by(_check_shift)
@njit(cache=True, borrows=True, forceinline=True)
def shift_gaze(
    rules: Rules,
    full: np.ndarray,
    robot: int,
    gaze: int,
    returns_to: int,
    random: np.random.Generator,
    allowed: np.ndarray,
) -> tuple[int, int, int]:
    """The caregiver's next gaze shift.

    Gaze targets are spots, 0 to N - 1, and N for the other's face.

    Args:
        rules: The caregiver's ``Rules``.
        full: (N,) bool, whether an object lies on a spot.
        robot: Gaze target of the robot.
        gaze: Gaze target of the caregiver.
        returns_to: Spot to which the second step of IJA leads, or NOWHERE. It is ignored if its object is gone.
        random: The caregiver's generator.
        allowed: (N,) bool, working space.

    Returns:
        The caregiver's new gaze target, the spot to return to or NOWHERE, and a position in OPTIONS.
    """
    face = len(full)
    if rules.at_objects < 1.0 and random.random() >= rules.at_objects:
        empty = face - _count(full)
        if random.random() * (empty + 1) < 1.0:
            return face, NOWHERE, CARELESS
        for spot in range(face):
            allowed[spot] = not full[spot]
        return _some(allowed, random), NOWHERE, CARELESS
    if gaze != face and gaze == robot and full[gaze] and random.random() < rules.answer:
        return face, NOWHERE, AFTER_JOINT_ATTENTION
    for spot in range(face):
        allowed[spot] = full[spot]
    if gaze == face:
        if returns_to != NOWHERE and full[returns_to]:
            return returns_to, NOWHERE, IJA_BACK
        if (robot != face or rules.follows_eye_contact) and random.random() < rules.follow:
            if robot != face and full[robot]:
                return robot, NOWHERE, RJA
            return _some(allowed, random), NOWHERE, RJA
        if robot == face:
            if rules.stays or (rules.may_stay and random.random() * (_count(full) + 1) < 1.0):
                return face, NOWHERE, NEUTRAL
        elif not rules.neutral_follows:
            allowed[robot] = False  # that would be following
    else:
        if full[gaze] and random.random() < rules.lead:
            return face, gaze, IJA
        allowed[gaze] = False
    target = _some(allowed, random)
    return (gaze if target == NOWHERE else target), NOWHERE, NEUTRAL
