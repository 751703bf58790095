"""The table: where objects lie, and what the robot senses in both orders of a turn."""

from collections import Counter
from itertools import combinations, permutations, product

import numpy as np
import pytest

from jointattn_mj.development.table.caregiver import NOWHERE, TableCaregiverConfig, shift_gaze
from jointattn_mj.development.table.world import (
    CAREGIVER,
    CHAPTER_4,
    CHAPTER_5,
    OPTION,
    RETURNS_TO,
    ROBOT,
    TableConfig,
    new_table,
    step,
    table_variables,
)
from jointattn_mj.errors import ConfigError

WORLDS = {
    "chapter 4": CHAPTER_4,
    "chapter 5": CHAPTER_5,
    "robot first": TableConfig(order="robot_first"),
    "chapter 4, robot first": TableConfig(spots=4, objects=2, kinds=3, profile=False, order="robot_first"),
    "full, quick": TableConfig(spots=3, objects=3, kinds=3, replaced_every=1),
    "careless": TableConfig(spots=5, objects=1, caregiver=TableCaregiverConfig(at_objects=0.3)),
}


def n_steps(config, count, seed=0):
    """A robot that acts at random: tables, actions, sensors and results turn by turn."""
    rng, variables = np.random.default_rng(seed), table_variables(config)
    table = new_table(config, np.random.SeedSequence(seed))
    s, r = np.zeros(len(variables.sensors), np.int64), np.zeros(len(variables.results), np.int64)
    a = np.zeros(2, np.int64)
    for _ in range(count):
        step(table, a, s, r)
        yield table, a, s, r
        a = np.array([rng.integers(0, len(action.values)) for action in variables.actions])


def named(variable, code):
    return variable.values[code]


@pytest.mark.parametrize("name", WORLDS)
def test_what_is_sensed(name):
    """Against the words of Tables 4.1 and 5.1; the caregiver's side is replayed from her own generator."""
    config = WORLDS[name]
    variables = table_variables(config)
    seed = np.random.SeedSequence(3)
    world = new_table(config, seed)
    caregivers = np.random.default_rng(np.random.SeedSequence(3).spawn(2)[1])
    rng = np.random.default_rng(1)
    s, r, a = np.zeros(2, np.int64), np.zeros(len(variables.results), np.int64), np.zeros(2, np.int64)
    robot = gaze = config.spots
    returns_to, full, kind = NOWHERE, np.zeros(config.spots, bool), np.zeros(config.spots, int)

    def results():
        face, objects = robot == config.spots, robot != config.spots and full[robot]
        frontal = face and gaze == config.spots
        return [frontal, face and not frontal, objects] if config.profile else [frontal, objects]

    for t in range(300):
        step(world, a, s, r)
        robot = a[0] if t > 0 else robot
        early = results()
        if t % config.replaced_every == 0:
            full, kind = world.full.copy(), world.kind.copy()
        assert np.array_equal(full, world.full)
        assert np.array_equal(kind, world.kind)
        gaze, returns_to, option = shift_gaze(
            world.rules, full, robot, gaze, returns_to, caregivers, np.zeros(config.spots, bool)
        )
        assert world.state[[ROBOT, CAREGIVER, RETURNS_TO, OPTION]].tolist() == [robot, gaze, returns_to, option]
        assert r.tolist() == (early if config.order == "robot_first" else results())
        sees = "not seen" if robot != config.spots else "at robot" if gaze == config.spots else f"at spot {gaze + 1}"
        assert named(variables.sensors[0], s[0]) == sees
        what = "none"
        if robot != config.spots and full[robot]:
            what = "object" if config.kinds == 1 else f"object {kind[robot] + 1}"
        assert named(variables.sensors[1], s[1]) == what
        a = np.array([rng.integers(0, len(action.values)) for action in variables.actions])


@pytest.mark.parametrize("every", [1, 3, 10])
def test_objects_are_replaced_every_so_many_turns(every):
    config = TableConfig(spots=6, objects=3, kinds=5, replaced_every=every)
    lay = [(table.full.tolist(), table.kind[table.full].tolist()) for table, *_ in n_steps(config, 60)]
    changes = [t for t in range(1, 60) if lay[t] != lay[t - 1]]
    assert set(changes) <= set(range(every, 60, every))
    assert len(changes) >= len(range(every, 60, every)) - 3  # now and then they come to lie as before


def test_every_layout_is_as_likely_as_every_other():
    config = TableConfig(spots=4, objects=2, kinds=3, replaced_every=1)
    visible = Counter(
        tuple((spot, int(table.kind[spot])) for spot in np.flatnonzero(table.full))
        for table, *_ in n_steps(config, 3600)
    )
    possible = [
        tuple(zip(spots, kinds, strict=True))
        for spots, kinds in product(combinations(range(4), 2), permutations(range(3), 2))
    ]
    assert set(visible) == set(possible)
    share = 1 / len(possible)
    squares = sum((visible[pair] - 3600 * share) ** 2 / (3600 * share) for pair in possible)
    assert squares < 35 + 4 * np.sqrt(2 * 35)  # chi squared with 35 degrees of freedom


def test_one_kind_needs_no_name():
    for table, *_ in n_steps(TableConfig(spots=5, objects=5), 30):
        assert table.full.all()
        assert (table.kind == 0).all()


def test_variables_of_the_chapters():
    five, four = table_variables(CHAPTER_5), table_variables(CHAPTER_4)
    sizes = [[len(variable.values) for variable in group] for group in (five.sensors, five.actions, five.results)]
    assert sizes == [[5, 2], [4, 4], [2, 2, 2]]
    sizes = [[len(variable.values) for variable in group] for group in (four.sensors, four.actions, four.results)]
    assert sizes == [[11, 11], [10, 10], [2, 2]]
    assert [result.name for result in five.results] == ["frontal face", "profile", "object"]
    assert five.sensors[0].values == ("at spot 1", "at spot 2", "at spot 3", "at robot", "not seen")
    assert five.actions[0].values == ("spot 1", "spot 2", "spot 3", "caregiver")


def test_the_same_seed_is_the_same_world():
    runs = [[(s.tolist(), r.tolist()) for _, _, s, r in n_steps(CHAPTER_5, 200, seed)] for seed in (5, 5, 6)]
    assert runs[0] == runs[1] != runs[2]


def test_where_objects_lie_does_not_depend_on_what_the_caregiver_does():
    """The world and the caregiver draw from streams of their own."""
    others = TableConfig(caregiver=TableCaregiverConfig(follow=0.0, lead=0.0, at_objects=0.5))
    laid = [[table.full.tolist() for table, *_ in n_steps(config, 100)] for config in (CHAPTER_5, others)]
    assert laid[0] == laid[1]


BAD = [
    ({"spots": 1, "objects": 1}, ("spots", "1")),
    ({"objects": 0}, ("objects", "0")),
    ({"objects": 4}, ("objects", "4")),
    ({"objects": 3, "kinds": 2}, ("kinds", "2", "3")),
    ({"kinds": 0}, ("kinds", "0")),
    ({"gestures": 0}, ("gestures", "0")),
    ({"replaced_every": 0}, ("replaced_every", "0")),
    ({"order": "both"}, ("order", "both")),
]


@pytest.mark.parametrize(("options", "words"), BAD, ids=str)
def test_impossible_options(options, words):
    with pytest.raises(ConfigError) as refused:
        TableConfig(**options)
    for word in words:
        assert word in str(refused.value)
