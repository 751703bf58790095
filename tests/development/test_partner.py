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
PACE_OF_HERS = PartnerConfig()
STILL = np.zeros(2)


def world_of(seed: int = 0, partner: PartnerConfig = PACE_OF_HERS, **chances: float) -> PartnerWorld:
    """A world of three places and two objects."""
    config = WorldConfig(behaviour=PACE)
    config = replace(config, scene=replace(config.scene, objects=OBJECTS[:2]))
    table = TableConfig(caregiver=TableCaregiverConfig(**chances))
    return PartnerWorld(config, build_physics(config), np.random.SeedSequence(seed), AS_USUAL, partner, table)


def partner_of(seed: int = 0, partner: PartnerConfig = PACE_OF_HERS, **chances: float) -> Partner:
    """Who sits there, without the robot looking at anything."""
    her = world_of(seed, partner, **chances).caregiver
    her.watch(NOWHERE)
    return her


def advance(her: Partner, until, frames: int = 3000) -> int:
    """Frames until something holds."""
    for frame in range(frames):
        if until():
            return frame
        her.advance()
    raise AssertionError(f"it has not come about in {frames} frames")


def looks_at_an_object(her: Partner) -> bool:
    return her.phase == Phase.GAZE and her.looks_at < SPOTS


def seconds(frames: int) -> float:
    return frames * FRAME_S


def test_objects_lie_at_places_of_their_own_or_in_her_hand():
    her, spots = partner_of(1), spot_positions(SPOTS, WorldConfig().scene)
    before, carried = her.at.copy(), 0
    for _ in range(9000):
        her.advance()
        assert len(set(her.at)) == 2
        for number, location in enumerate(her.at):
            if number != her.held:
                assert np.abs(her.objects[number] - spots[location]).max() <= her.partner.jitter_m + 1e-9
        carried += not np.array_equal(before, her.at)
        before = her.at.copy()
    assert carried > 5


def test_she_looks_at_what_she_is_said_to_look_at():
    her = partner_of(2)
    for _ in range(3000):
        her.advance()
        if her.phase == Phase.GAZE:
            yaw, pitch = her.joints[:2] + her.joints[2:4]
            if her.looks_at == SPOTS:
                assert abs(yaw) < 1e-9 and abs(pitch) < 1e-9
            else:
                off = her.objects[her.target] - np.append(her._origin[:2], her._eye[2])
                assert np.arctan2(-off[1], -off[0]) == pytest.approx(yaw, abs=1e-6)


def test_she_answers_joint_attention_in_time_and_not_otherwise():
    lags = []
    for seed in range(8):
        her = partner_of(seed, lead=0.0)
        advance(her, lambda her=her: looks_at_an_object(her))
        her.watch(her.looks_at)
        lags.append(advance(her, lambda her=her: her.looks_at == SPOTS))
        assert her.option == AFTER_JOINT_ATTENTION
    low, high = PACE_OF_HERS.latency_s
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


def test_she_follows_the_robot_from_its_face_to_an_object():
    followed = 0
    for seed in range(8):
        her = partner_of(seed, lead=1.0, follow=1.0)
        advance(her, lambda her=her: her.phase == Phase.GAZE and her.looks_at == SPOTS)
        shown = int(her.at[0])
        her.watch(shown)
        advance(her, lambda her=her: her.looks_at != SPOTS)
        followed += her.option == RJA and her.looks_at == shown
    assert followed >= 6  # a glance may be over before she has answered
    never = partner_of(0, lead=1.0, follow=0.0)
    never.watch(int(never.at[0]))
    for _ in range(3000):
        never.advance()
        assert never.option != RJA


def test_she_leads_and_comes_back():
    her = partner_of(4, lead=1.0)
    advance(her, lambda: her.option == IJA)
    shown = her._returns_to
    advance(her, lambda: her.option == IJA_BACK)
    assert her.looks_at == shown


def test_eye_contact_lasts_longer_than_waiting_alone_but_not_for_ever():
    waits = {}
    for robot in (NOWHERE, SPOTS):
        waits[robot] = []
        for seed in range(12):
            her = partner_of(seed, lead=0.0)
            advance(her, lambda her=her: looks_at_an_object(her))
            her.watch(her.looks_at)
            advance(her, lambda her=her: her.looks_at == SPOTS)
            her.watch(robot)
            waits[robot].append(advance(her, lambda her=her: her.looks_at != SPOTS))
    assert np.mean(waits[SPOTS]) > np.mean(waits[NOWHERE]) + 0.4 / FRAME_S


def test_she_greets_before_all_else_and_when_she_is_asked_to():
    her = partner_of(6, PartnerConfig(greets=3))
    for _ in range(2):
        frames = advance(her, lambda: not her.greeting and her.looks_at != SPOTS)
        assert seconds(frames) > 2.0
        advance(her, lambda: her.held is not None)
        her.greet()
        assert her.greeting
        advance(her, lambda: her.phase == Phase.GREET)
        assert her.held is None and her.looks_at == SPOTS


def test_a_table_that_is_full_leaves_nothing_to_carry():
    config = WorldConfig(behaviour=PACE)
    config = replace(config, scene=replace(config.scene, objects=OBJECTS[:3]))
    table, physics = TableConfig(objects=3), build_physics(config)
    her = PartnerWorld(
        config, physics, np.random.SeedSequence(0), AS_USUAL, PartnerConfig(carries=1.0), table
    ).caregiver
    for _ in range(3000):
        her.advance()
        assert her.held is None


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
