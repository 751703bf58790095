"""The object-transfer task as a script: phases, durations, who is looked at and who is held. No physics."""

from itertools import pairwise

import mujoco
import numpy as np
import pytest

from jointattn_mj.errors import ConfigError
from jointattn_mj.scene.caregiver import FOLLOWING, FRAME_S, CaregiverConfig, Phase, TransferScript
from jointattn_mj.scene.layout import LayoutConfig
from jointattn_mj.scene.model import HEAD_POSITION, build_model
from jointattn_mj.scene.movement import Arm, gaze_angles

REST = 0.741
MODEL: mujoco.MjModel = build_model()
HOLDS = {Phase.LIFT, Phase.OBSERVE, Phase.PUT}


def caregiver(seed: int = 0, objects: int = 4, config: CaregiverConfig | None = None) -> TransferScript:
    config = config or CaregiverConfig()
    arm = Arm.from_model(MODEL, np.radians(config.hand_pitch_deg))
    rng = np.random.default_rng(seed)
    return TransferScript(config, LayoutConfig(), objects, REST, np.array(HEAD_POSITION), arm, rng)


def played(person: TransferScript, minutes: float = 5) -> list[tuple]:
    """(phase, target, held, objects, joints) of every frame."""
    frames = []
    for _ in range(round(minutes * 60 / FRAME_S)):
        frames.append((person.phase, person.target, person.held, person.objects.copy(), person.joints.copy()))
        person.advance()
    return frames


@pytest.fixture(scope="module")
def run() -> list[tuple]:
    return played(caregiver())


def phases_of(run: list[tuple]) -> list[tuple[Phase, int]]:
    """Phases with their lengths in frames; the last one, which was cut short, is left out."""
    begins = [0] + [i for i, (a, b) in enumerate(pairwise(run), 1) if a[0] != b[0]]
    return [(run[a][0], b - a) for a, b in pairwise(begins)]


def test_phases_follow_each_other(run):
    phases = [phase for phase, _ in phases_of(run)]
    assert phases[0] == Phase.GREET
    assert Phase.GREET not in phases[1:]
    assert all(FOLLOWING[a] == b for a, b in pairwise(phases))
    assert set(phases) == set(Phase)


def test_durations_stay_within_their_jitter(run):
    config = CaregiverConfig()
    drawn = {}
    for phase, frames in phases_of(run):
        usual = getattr(config, f"{phase}_s") / FRAME_S
        assert usual * (1 - config.duration_jitter) - 0.5 <= frames <= usual * (1 + config.duration_jitter) + 0.5
        drawn.setdefault(phase, set()).add(frames)
    assert len(drawn[Phase.OBSERVE]) > 10  # people are not clockwork


def test_without_jitter_every_phase_has_its_length():
    config = CaregiverConfig(duration_jitter=0)
    for phase, frames in phases_of(played(caregiver(config=config), 1)):
        assert frames == round(getattr(config, f"{phase}_s") / FRAME_S)


def test_another_object_every_time(run):
    targets = [b[1] for a, b in pairwise(run) if b[0] == Phase.TURN and a[0] != Phase.TURN]
    assert all(a != b for a, b in pairwise(targets))
    assert set(targets) == {0, 1, 2, 3}


def test_only_the_target_is_held_and_only_while_carried(run):
    for phase, target, held, *_ in run:
        assert held == (target if phase in HOLDS else None)
        assert (target is None) == (phase == Phase.GREET)


def test_objects_at_rest_stand_on_the_table_apart_from_each_other(run):
    for _, _, held, objects, _ in run:
        resting = np.delete(objects, held, axis=0) if held is not None else objects
        np.testing.assert_allclose(resting[:, 2], REST, atol=1e-12)
        apart = np.linalg.norm(resting[:, None] - resting[None], axis=2) + np.eye(len(resting))
        assert apart.min() >= LayoutConfig().spacing - 1e-12
        assert objects[:, 2].min() >= REST - 1e-12  # nor does the carried one dip below


def test_only_the_held_object_moves(run):
    for before, after in pairwise(run):
        moved = np.flatnonzero((before[3] != after[3]).any(axis=1))
        assert set(moved) <= {after[2], before[2]}


def test_the_object_is_brought_to_the_holding_location_and_stays_about_it(run):
    config = CaregiverConfig()
    for phase, _, held, objects, _ in run:
        if phase == Phase.OBSERVE:
            assert np.linalg.norm(objects[held] - config.holding_location) <= 1.25 * config.wobble_m


def test_eyes_and_head_together_look_at_the_target(run):
    eye = np.array([0, 0, HEAD_POSITION[2]])
    for phase, target, _, objects, joints in run:
        gaze = joints[:2] + joints[2:4]
        if phase == Phase.GREET:
            np.testing.assert_allclose(gaze, 0, atol=1e-12)
        elif phase != Phase.TURN:
            own = (objects[target] - [HEAD_POSITION[0], 0, 0]) * [-1, -1, 1]
            np.testing.assert_allclose(gaze, gaze_angles(eye, own), atol=1e-9)


def test_many_frames_are_those_one_by_one():
    one_by_one, at_once = caregiver(seed=4), caregiver(seed=4)
    for frames in (1, 2, 40, 333, 1, 900):
        doing, joints, objects = np.empty((frames, 3), int), np.empty((frames, 13)), np.empty((frames, 4, 3))
        at_once.advance_all(doing, joints, objects)
        for frame in range(frames):
            assert tuple(doing[frame]) == one_by_one.doing()
            one_by_one.advance()
            np.testing.assert_array_equal(joints[frame], one_by_one.joints)
            np.testing.assert_array_equal(objects[frame], one_by_one.objects)
        assert at_once.doing() == one_by_one.doing()
        np.testing.assert_array_equal(at_once.objects, one_by_one.objects)
    assert {phase for phase, *_ in played(one_by_one, 0.5)} > {Phase.LIFT, Phase.PUT}


def test_places_spread_evenly_over_the_table():
    """Section 6.4.2: "positions as even as possible". Chi-square over 3 x 8 cells; uniform draws give about 23."""
    config, used, low = LayoutConfig(), np.zeros((3, 8)), np.array([0.90, -0.36])
    for before, after in pairwise(played(caregiver(seed=2), 26)):  # as long as a session
        if before[0] == Phase.PUT and after[0] == Phase.GAZE:
            location = after[3][after[1], :2]
            used[tuple(((location - low) / [0.22, 0.72] * used.shape).astype(int))] += 1
    assert config.cells == used.shape
    expected = used.sum() / used.size
    assert used.sum() > 100
    assert ((used - expected) ** 2 / expected).sum() < 8


def test_same_seed_same_run():
    first, second, other = (played(caregiver(seed=seed), 0.5) for seed in (3, 3, 4))
    assert all(np.array_equal(a[3], b[3]) and np.array_equal(a[4], b[4]) for a, b in zip(first, second, strict=True))
    assert not np.array_equal(first[0][3], other[0][3])


@pytest.mark.parametrize("objects", [1, 2, 8])
def test_other_numbers_of_objects(objects):
    for _, _, _, locations, joints in played(caregiver(objects=objects), 0.5):
        assert locations.shape == (objects, 3)
        assert np.isfinite(joints).all()


@pytest.mark.parametrize("wrong", [{"turn_s": 0}, {"gaze_s": -1}, {"duration_jitter": 1}, {"duration_jitter": -0.1}])
def test_impossible_settings_are_errors(wrong):
    with pytest.raises(ConfigError, match=next(iter(wrong))):
        CaregiverConfig(**wrong)


def test_a_hand_that_is_back_within_a_frame():
    config = CaregiverConfig(withdraw_s=0.001)
    person = caregiver(config=config)
    played(person, 0.5)
    while person.phase is not Phase.GAZE:
        person.advance()
    assert person._hand == pytest.approx(config.rest_location)


def test_a_holding_location_on_the_table_is_an_error():
    with pytest.raises(ConfigError, match="holding_location"):
        caregiver(config=CaregiverConfig(holding_location=(1.2, 0.0, REST)))
