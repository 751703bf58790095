"""The caregiver of real time: what she does alone, and how she answers the robot."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from jointattn_mj.development.realtime.partner import PACE, Partner, PartnerConfig, PartnerWorld
from jointattn_mj.development.table.caregiver import (
    AFTER_JOINT_ATTENTION,
    IJA,
    IJA_BACK,
    NOWHERE,
    RJA,
    TableCaregiverConfig,
)
from jointattn_mj.development.table.world import TableConfig
from jointattn_mj.errors import ConfigError
from jointattn_mj.scene.caregiver import FRAME_S, Phase
from jointattn_mj.scene.looker import spot_positions
from jointattn_mj.scene.objects import OBJECTS
from jointattn_mj.scene.world import AS_USUAL, WorldConfig, build_physics

pytestmark = pytest.mark.integration

SPOTS = 3
PACE_OF_THE_CAREGIVER = PartnerConfig()
STILL = np.zeros(2)


def world_of(seed: int = 0, partner: PartnerConfig = PACE_OF_THE_CAREGIVER, **chances: float) -> PartnerWorld:
    """A world of three places and two objects."""
    config = WorldConfig(behaviour=PACE)
    config = replace(config, scene=replace(config.scene, objects=OBJECTS[:2]))
    table = TableConfig(caregiver=TableCaregiverConfig(**chances))
    return PartnerWorld(config, build_physics(config), np.random.SeedSequence(seed), AS_USUAL, partner, table)


def partner_of(seed: int = 0, partner: PartnerConfig = PACE_OF_THE_CAREGIVER, **chances: float) -> Partner:
    """Who sits there, without the robot looking at anything."""
    person = world_of(seed, partner, **chances).caregiver
    person.watch(NOWHERE)
    return person


def advance(person: Partner, until, frames: int = 3000) -> int:
    """Frames until something holds."""
    for frame in range(frames):
        if until():
            return frame
        person.advance()
    raise AssertionError(f"it has not come about in {frames} frames")


def looks_at_an_object(person: Partner) -> bool:
    return person.phase == Phase.GAZE and person.looks_at < SPOTS


def seconds(frames: int) -> float:
    return frames * FRAME_S


def test_objects_lie_at_locations_of_their_own_or_in_the_hand():
    person, spots = partner_of(1), spot_positions(SPOTS, WorldConfig().scene)
    before, carried = person.at.copy(), 0
    for _ in range(9000):
        person.advance()
        assert len(set(person.at)) == 2
        for number, location in enumerate(person.at):
            if number != person.held:
                assert np.abs(person.objects[number] - spots[location]).max() <= person.partner.jitter_m + 1e-9
        carried += not np.array_equal(before, person.at)
        before = person.at.copy()
    assert carried > 5


def test_the_caregiver_looks_at_what_is_said():
    person = partner_of(2)
    for _ in range(3000):
        person.advance()
        if person.phase == Phase.GAZE:
            yaw, pitch = person.joints[:2] + person.joints[2:4]
            if person.looks_at == SPOTS:
                assert abs(yaw) < 1e-9 and abs(pitch) < 1e-9
            else:
                off = person.objects[person.target] - np.append(person._origin[:2], person._eye[2])
                assert np.arctan2(-off[1], -off[0]) == pytest.approx(yaw, abs=1e-6)


def test_the_caregiver_answers_joint_attention_in_time_and_not_otherwise():
    lags = []
    for seed in range(8):
        person = partner_of(seed, lead=0.0)
        advance(person, lambda person=person: looks_at_an_object(person))
        person.watch(person.looks_at)
        lags.append(advance(person, lambda person=person: person.looks_at == SPOTS))
        assert person.option == AFTER_JOINT_ATTENTION
    low, high = PACE_OF_THE_CAREGIVER.latency_s
    assert all(low - 2 * FRAME_S <= seconds(lag) <= high + 2 * FRAME_S for lag in lags)
    assert len(set(lags)) > 3
    cold = partner_of(0, lead=0.0, answer=0.0)
    advance(cold, lambda: looks_at_an_object(cold))
    cold.watch(cold.looks_at)
    for _ in range(3000):
        cold.advance()
        assert cold.looks_at != SPOTS
    elsewhere = partner_of(0, lead=0.0)
    advance(elsewhere, lambda: looks_at_an_object(elsewhere))
    elsewhere.watch(SPOTS)
    for _ in range(3000):
        elsewhere.advance()
        assert elsewhere.option != AFTER_JOINT_ATTENTION


def test_the_caregiver_follows_the_robot_from_its_face_to_an_object():
    followed = 0
    for seed in range(8):
        person = partner_of(seed, lead=1.0, follow=1.0)
        advance(person, lambda person=person: person.phase == Phase.GAZE and person.looks_at == SPOTS)
        shown = int(person.at[0])
        person.watch(shown)
        advance(person, lambda person=person: person.looks_at != SPOTS)
        followed += person.option == RJA and person.looks_at == shown
    assert followed >= 6  # a glance may be over before she has answered
    never = partner_of(0, lead=1.0, follow=0.0)
    never.watch(int(never.at[0]))
    for _ in range(3000):
        never.advance()
        assert never.option != RJA


def test_the_caregiver_leads_and_comes_back():
    person = partner_of(4, lead=1.0)
    advance(person, lambda: person.option == IJA)
    shown = person._returns_to
    advance(person, lambda: person.option == IJA_BACK)
    assert person.looks_at == shown


def test_eye_contact_lasts_longer_than_waiting_alone_but_not_for_ever():
    waits = {}
    for robot in (NOWHERE, SPOTS):
        waits[robot] = []
        for seed in range(12):
            person = partner_of(seed, lead=0.0)
            advance(person, lambda person=person: looks_at_an_object(person))
            person.watch(person.looks_at)
            advance(person, lambda person=person: person.looks_at == SPOTS)
            person.watch(robot)
            waits[robot].append(advance(person, lambda person=person: person.looks_at != SPOTS))
    assert np.mean(waits[SPOTS]) > np.mean(waits[NOWHERE]) + 0.4 / FRAME_S


def test_the_caregiver_greets_before_all_else_and_when_asked_to():
    person = partner_of(6, PartnerConfig(greets=3))
    for _ in range(2):
        frames = advance(person, lambda: not person.greeting and person.looks_at != SPOTS)
        assert seconds(frames) > 2.0
        advance(person, lambda: person.held is not None)
        person.greet()
        assert person.greeting
        advance(person, lambda: person.phase == Phase.GREET)
        assert person.held is None and person.looks_at == SPOTS


def test_a_table_that_is_full_leaves_nothing_to_carry():
    config = WorldConfig(behaviour=PACE)
    config = replace(config, scene=replace(config.scene, objects=OBJECTS[:3]))
    table, physics = TableConfig(objects=3), build_physics(config)
    person = PartnerWorld(
        config, physics, np.random.SeedSequence(0), AS_USUAL, PartnerConfig(carries=1.0), table
    ).caregiver
    for _ in range(3000):
        person.advance()
        assert person.held is None


def test_a_world_goes_on_from_a_pickle_as_if_nothing_had_happened():
    world = world_of(5)
    for frame in range(400):
        world.caregiver.watch(frame // 50 % 4)
        world.step(STILL)
    again: PartnerWorld = pickle.loads(pickle.dumps(world))
    for frame in range(400):
        for each in (world, again):
            each.caregiver.watch(frame // 40 % 4)
            each.step(STILL)
        np.testing.assert_array_equal(world.data.qpos, again.data.qpos)
        np.testing.assert_array_equal(world.caregiver.objects, again.caregiver.objects)


@pytest.mark.parametrize(
    "wrong", [{"hold_s": (2.0, 1.0)}, {"latency_s": (0.0, 1.0)}, {"carries": 1.5}, {"jitter_m": 1}]
)
def test_a_pace_that_nobody_can_keep_is_refused(wrong):
    with pytest.raises(ConfigError, match=next(iter(wrong))):
        PartnerConfig(**wrong)
