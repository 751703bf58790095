"""Success at launch, at landing, or neither, on moments made by hand."""

import pickle

import numpy as np
import pytest

from jointattn_mj.gaze_following.scoring import Judgement, Moment, WorldMoment, judge
from jointattn_mj.scene.camera import directions_to
from jointattn_mj.scene.caregiver import Phase
from jointattn_mj.scene.world import World, WorldConfig

LEFT, MIDDLE, RIGHT = (15.0, -14.0), (0.0, -14.0), (-15.0, -14.0)


def moment(target: int | None, *directions: tuple[float, float]) -> Moment:
    return Moment(0, "gaze", target, np.array(directions))


def test_nothing_changes_on_the_way():
    scene = (LEFT, MIDDLE, RIGHT)
    at = np.array([14.0, -15.0])
    hit = judge(moment(0, *scene), moment(0, *scene), at)
    assert hit == Judgement(
        at_launch=True, at_landing=True, nearest=0, distance=pytest.approx(np.hypot(np.cos(np.radians(15)), 1))
    )
    miss = judge(moment(2, *scene), moment(2, *scene), at)
    assert (miss.at_launch, miss.at_landing, miss.nearest) == (False, False, 0)


def test_the_caregiver_turns_to_another_on_the_way():
    scene = (LEFT, MIDDLE, RIGHT)
    old, new = np.array(LEFT), np.array(RIGHT)
    for at, expected in ((old, (True, False)), (new, (False, True))):
        verdict = judge(moment(0, *scene), moment(2, *scene), at)
        assert (verdict.at_launch, verdict.at_landing) == expected


def test_the_target_is_carried_away_on_the_way():
    """Where the target was counts at launch; where it is, at landing."""
    launch, landing = moment(0, LEFT, MIDDLE), moment(0, RIGHT, MIDDLE)
    at_old_location = judge(launch, landing, np.array(LEFT))
    assert (at_old_location.at_launch, at_old_location.at_landing, at_old_location.nearest) == (True, False, 1)
    assert at_old_location.distance > 14
    at_new_location = judge(launch, landing, np.array(RIGHT))
    assert (at_new_location.at_launch, at_new_location.at_landing, at_new_location.nearest) == (False, True, 0)


def test_a_greeting_has_no_target():
    verdict = judge(moment(None, LEFT, RIGHT), moment(None, LEFT, RIGHT), np.array(LEFT))
    assert not verdict.at_launch
    assert not verdict.at_landing


def test_distance_shrinks_with_tilt():
    """A degree of pan is less than a degree of view when the head is tilted."""
    assert moment(0, (10.0, -60.0)).nearest(np.array([0.0, -60.0]))[1] == pytest.approx(5)


def test_the_present_of_a_world():
    world = World.build(WorldConfig(), np.random.SeedSequence(2))
    assert WorldMoment(world, 0).target is None
    while world.caregiver.phase != Phase.LIFT:
        world.step(np.zeros(2))
    now = WorldMoment(world, 7)
    assert (now.frame, now.phase, now.target) == (7, "lift", world.caregiver.held)
    kept = directions_to(world.caregiver.objects)
    for _ in range(10):
        world.step(np.zeros(2))
    again = pickle.loads(pickle.dumps(now))  # as a checkpoint keeps it, before anybody has asked for directions
    assert (again.frame, again.phase, again.target) == (now.frame, now.phase, now.target)
    np.testing.assert_array_equal(again.directions, kept)
    np.testing.assert_array_equal(now.directions, kept)  # does not move on with the world
    assert not np.array_equal(now.directions, directions_to(world.caregiver.objects))
    world.close()


def test_a_moment_of_a_world_is_restored_whole():
    with pytest.raises(ValueError, match=r"is made of .*objects.*; got .*frame"):
        object.__new__(WorldMoment).__setstate__({"frame": 7})
