"""The caregiver's rules (sections 4.3.3 and 5.3.1), one by one and then all against a slow version of the text."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jointattn_mj.development.table.caregiver import (
    AFTER_JOINT_ATTENTION,
    CARELESS,
    IJA,
    IJA_BACK,
    NEUTRAL,
    NOWHERE,
    RJA,
    TableCaregiverConfig,
    rules,
    shift_gaze,
)
from jointattn_mj.errors import ConfigError

pytestmark = pytest.mark.integration

DRAWS = 3000
FACE = 3
"""With three spots."""


def shifts(config, full, robot, gaze, returns_to=NOWHERE, draws=DRAWS, seed=0):
    """How often each (gaze, returns_to, option) came."""
    compiled, spots, allowed = rules(config), np.array(full, bool), np.zeros(len(full), bool)
    random = np.random.default_rng(seed)
    return Counter(shift_gaze(compiled, spots, robot, gaze, returns_to, random, allowed) for _ in range(draws))


def close(counts, probabilities):
    """Frequencies within four standard errors, and nothing else than what may come."""
    assert set(counts) <= {outcome for outcome, p in probabilities.items() if p > 0}
    draws = sum(counts.values())
    for outcome, p in probabilities.items():
        assert abs(counts[outcome] / draws - p) <= 4.5 * np.sqrt(p * (1 - p) / draws), (outcome, counts, probabilities)


def test_following():
    """She sees the robot's face turned to an object: RJA with p_r, else another object."""
    close(
        shifts(TableCaregiverConfig(follow=0.3), [1, 0, 1], robot=2, gaze=FACE),
        {(2, NOWHERE, RJA): 0.3, (0, NOWHERE, NEUTRAL): 0.7},
    )


def test_following_to_an_empty_spot_ends_at_some_object():
    close(
        shifts(TableCaregiverConfig(follow=0.3), [1, 0, 1], robot=1, gaze=FACE),
        {(n, NOWHERE, option): p / 2 for n in (0, 2) for option, p in ((RJA, 0.3), (NEUTRAL, 0.7))},
    )


def test_neutral_may_end_where_the_robot_looks():
    config = TableCaregiverConfig(follow=0.0, neutral_follows=True)
    close(shifts(config, [1, 0, 1], robot=2, gaze=FACE), {(0, NOWHERE, NEUTRAL): 0.5, (2, NOWHERE, NEUTRAL): 0.5})


def test_nothing_else_to_look_at():
    """Neutral is not following: with the robot at the only object, she goes on looking at the robot."""
    close(shifts(TableCaregiverConfig(follow=0.0), [0, 1, 0], robot=1, gaze=FACE), {(FACE, NOWHERE, NEUTRAL): 1.0})
    close(shifts(TableCaregiverConfig(lead=0.0), [0, 1, 0], robot=FACE, gaze=1), {(1, NOWHERE, NEUTRAL): 1.0})


@pytest.mark.parametrize(
    ("eye_contact", "probabilities"),
    [
        ("stay", {FACE: 1.0}),
        ("leave", {0: 0.5, 2: 0.5}),
        ("any", {0: 1 / 3, 2: 1 / 3, FACE: 1 / 3}),
    ],
)
def test_eye_contact(eye_contact, probabilities):
    found = shifts(TableCaregiverConfig(eye_contact=eye_contact, follow=1.0), [1, 0, 1], robot=FACE, gaze=FACE)
    close(found, {(target, NOWHERE, NEUTRAL): p for target, p in probabilities.items()})


def test_chapter_4_follows_out_of_eye_contact():
    config = TableCaregiverConfig(follow=0.8, follows_eye_contact=True)
    close(
        shifts(config, [1, 0, 1], robot=FACE, gaze=FACE),
        {(0, NOWHERE, RJA): 0.4, (2, NOWHERE, RJA): 0.4, (FACE, NOWHERE, NEUTRAL): 0.2},
    )


def test_leading_takes_two_steps():
    close(
        shifts(TableCaregiverConfig(lead=0.3), [1, 0, 1], robot=FACE, gaze=0),
        {(FACE, 0, IJA): 0.3, (2, NOWHERE, NEUTRAL): 0.7},
    )
    for robot in (0, 1, 2, FACE):
        close(
            shifts(TableCaregiverConfig(follow=1.0), [1, 0, 1], robot, gaze=FACE, returns_to=0),
            {(0, NOWHERE, IJA_BACK): 1.0},
        )


def test_leading_to_an_object_that_is_gone():
    """She chooses as if there had been no first step."""
    config = TableCaregiverConfig(follow=0.3)
    for robot in (0, 1, 2, FACE):
        gone = shifts(config, [1, 0, 1], robot, gaze=FACE, returns_to=1)
        assert gone == shifts(config, [1, 0, 1], robot, gaze=FACE)
        assert all(option in (RJA, NEUTRAL) for _, _, option in gone)


def test_an_object_that_is_gone_cannot_be_led_to():
    close(
        shifts(TableCaregiverConfig(lead=1.0), [1, 0, 1], robot=FACE, gaze=1),
        {(0, NOWHERE, NEUTRAL): 0.5, (2, NOWHERE, NEUTRAL): 0.5},
    )


@pytest.mark.parametrize("answer", [0.0, 0.6, 1.0])
def test_joint_attention_is_answered(answer):
    """p_e, whatever she would have chosen otherwise."""
    close(
        shifts(TableCaregiverConfig(answer=answer, lead=0.5), [1, 0, 1], robot=2, gaze=2),
        {
            (FACE, NOWHERE, AFTER_JOINT_ATTENTION): answer,
            (FACE, 2, IJA): (1 - answer) / 2,
            (0, NOWHERE, NEUTRAL): (1 - answer) / 2,
        },
    )


def test_only_an_object_can_be_attended_to_jointly():
    assert all(
        option != AFTER_JOINT_ATTENTION for *_, option in shifts(TableCaregiverConfig(), [1, 0, 1], robot=1, gaze=1)
    )
    assert all(
        option != AFTER_JOINT_ATTENTION for *_, option in shifts(TableCaregiverConfig(), [1, 0, 1], FACE, gaze=FACE)
    )


def test_careless():
    """Section 4.5.3: with 1 - p_c the robot or an empty spot, one as likely as the other."""
    close(
        shifts(TableCaregiverConfig(at_objects=0.4), [1, 0, 0], robot=FACE, gaze=FACE),
        {(FACE, NOWHERE, NEUTRAL): 0.4, **{(n, NOWHERE, CARELESS): 0.2 for n in (1, 2, FACE)}},
    )
    close(shifts(TableCaregiverConfig(at_objects=0.0), [1, 1, 1], robot=0, gaze=1), {(FACE, NOWHERE, CARELESS): 1.0})


def slow(config, full, robot, gaze, returns_to):
    """Probabilities of what may come, read off sections 4.3.3 and 5.3.1."""
    face, objects = len(full), [spot for spot, there in enumerate(full) if there]
    found = Counter()

    def choose(probability, targets, option, then=NOWHERE):
        for target in targets:
            found[target, then, option] += probability / len(targets)

    choose(1 - config.at_objects, [face] + [n for n in range(face) if not full[n]], CARELESS)
    left = config.at_objects
    on_object = gaze != face and full[gaze]
    if on_object and robot == gaze:
        choose(left * config.answer, [face], AFTER_JOINT_ATTENTION)
        left *= 1 - config.answer
    if gaze != face:
        leads = config.lead if on_object else 0.0
        choose(left * leads, [face], IJA, gaze)
        choose(left * (1 - leads), [n for n in objects if n != gaze] or [gaze], NEUTRAL)
    elif returns_to in objects:
        choose(left, [returns_to], IJA_BACK)
    else:
        follows = config.follow if robot != face or config.follows_eye_contact else 0.0
        choose(left * follows, [robot] if robot in objects else objects, RJA)
        others = objects if config.neutral_follows else [n for n in objects if n != robot]
        if robot == face:
            others = {"stay": [face], "leave": objects, "any": [*objects, face]}[config.eye_contact]
        choose(left * (1 - follows), others or [face], NEUTRAL)
    return found


chances = st.sampled_from([0.0, 0.25, 0.5, 0.75, 1.0])


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.data())
def test_all_rules_together(data):
    config = TableCaregiverConfig(
        follow=data.draw(chances),
        lead=data.draw(chances),
        answer=data.draw(chances),
        at_objects=data.draw(st.sampled_from([1.0, 1.0, 0.5, 0.0])),
        follows_eye_contact=data.draw(st.booleans()),
        eye_contact=data.draw(st.sampled_from(["stay", "leave", "any"])),
        neutral_follows=data.draw(st.booleans()),
    )
    spots = data.draw(st.integers(2, 5))
    full = data.draw(st.lists(st.booleans(), min_size=spots, max_size=spots).filter(any))
    robot, gaze = data.draw(st.integers(0, spots)), data.draw(st.integers(0, spots))
    returns_to = data.draw(st.integers(NOWHERE, spots - 1))
    found = shifts(config, full, robot, gaze, returns_to, draws=1000)
    close(found, slow(config, full, robot, gaze, returns_to))
    if config.at_objects == 1:
        assert all(target == spots or full[target] for target, _, _ in found)


BAD = [{name: value} for name in ("follow", "lead", "answer", "at_objects") for value in (-0.1, 1.5, float("nan"))]


@pytest.mark.parametrize("options", [*BAD, {"eye_contact": "wink"}], ids=str)
def test_impossible_options(options):
    ((name, value),) = options.items()
    with pytest.raises(ConfigError, match=name) as refused:
        TableCaregiverConfig(**options)
    assert str(value) in str(refused.value)
