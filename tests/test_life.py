"""A life at a table: the log says what happened, and however it is interrupted, it goes on the same."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import jointattn_mj.contingency as c
from jointattn_mj.contingency.online.detector import DetectorConfig
from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.online.reactive import AvoidingModule
from jointattn_mj.development.agent import Developer, DeveloperConfig
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.development.table.run import TableLife
from jointattn_mj.development.table.world import CAREGIVER, OPTION, TableConfig, new_table, table_variables, turn
from jointattn_mj.errors import ConfigError
from jointattn_mj.io import rows

HASTY = DeveloperConfig(detector=DetectorConfig(threshold=2e-3), most_modules=3)
"""Finds something every few hundred turns."""
WORLD = TableConfig()
MINDS = {
    "whole": HASTY,
    "reset": replace(HASTY, memory="reset"),
    "window": replace(HASTY, memory="window", horizon=500),
    "fading": replace(HASTY, memory="fading", horizon=500),
    "ever": replace(HASTY, history="ever"),
    "refresh": replace(HASTY, refresh_every=150),
}
TURNS = 1200


def lived(mind=HASTY, turns=TURNS, seed=4, world=WORLD, reactive=(), **options):
    life = TableLife(world, mind, seed, turns, reactive, **options)
    life.live(turns)
    return life


def same(one, other):
    assert one.lived == other.lived
    for column in one.columns:
        assert np.array_equal(one.log(column), other.log(column)), column
    assert [(f.turn, f.event) for f in one.found] == [(f.turn, f.event) for f in other.found]
    for first, second in zip(one.mind.modules, other.mind.modules, strict=True):
        assert np.array_equal(first.command, second.command)
        assert np.array_equal(first.reliability, second.reliability)
    assert all(
        np.array_equal(*pair, equal_nan=True) for pair in zip(one.contingency(), other.contingency(), strict=True)
    )
    assert np.array_equal(one.mind.mind.counts.cells, other.mind.mind.counts.cells)
    assert np.array_equal(one.mind.mind.counts.contexts, other.mind.mind.counts.contexts)


@pytest.fixture(scope="module", params=MINDS)
def undisturbed(request):
    life = lived(MINDS[request.param])
    assert life.found, "else nothing grows in these tests"
    return life


def test_the_log_says_what_happened(undisturbed):
    """The same life once more in plain Python, through ``Developer.act``."""
    life = undisturbed
    of_world, of_mind = np.random.SeedSequence(4).spawn(2)
    table, mind = new_table(WORLD, of_world), Developer(table_variables(WORLD), life.mind.config, of_mind)
    s, r, a = np.zeros(2, np.int64), np.zeros(3, np.int64), np.zeros(2, np.int64)
    rows = []
    for _ in range(TURNS):
        turn(table, a, s, r)
        before = len(mind.modules)
        a = mind.act(s, r)
        driver = mind.mind.driver - (mind.mind.driver >= before) * (len(mind.modules) - before)  # as numbered before
        rows.append([*s, *r, *a, *driver, table.state[CAREGIVER], table.state[OPTION]])
    for number, column in enumerate(life.columns):
        assert life.log(column).tolist() == [row[number] for row in rows], column
    assert [module.event for module in mind.modules] == [module.event for module in life.mind.modules]
    assert np.array_equal(mind.mind.counts.cells, life.mind.mind.counts.cells)


def test_the_same_seed_is_the_same_life(undisturbed):
    same(undisturbed, lived(undisturbed.mind.config))
    other = lived(undisturbed.mind.config, seed=5)
    assert not np.array_equal(undisturbed.log("gesture"), other.log("gesture"))


@settings(max_examples=6, deadline=None, derandomize=True)
@given(st.lists(st.integers(1, 400), min_size=1, max_size=6))
def test_interrupted_and_stored(undisturbed, pieces):
    life, found = TableLife(WORLD, undisturbed.mind.config, 4, TURNS), []
    for piece in [*pieces, TURNS]:
        found += life.live(piece)
        life = pickle.loads(pickle.dumps(life))
    same(life, undisturbed)
    assert [one.turn for one in found] == [one.turn for one in undisturbed.found]


@settings(max_examples=6, deadline=None, derandomize=True)
@given(st.lists(st.integers(1, 400), min_size=1, max_size=6))
def test_kept_in_a_folder(undisturbed, tmp_path_factory, pieces):
    """With small buffers; killed after every piece but some turns later, and resumed."""
    folder = tmp_path_factory.mktemp("log")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rows, "BUFFER_BYTES", 1000)
        life = TableLife(WORLD, undisturbed.mind.config, 4, TURNS)
        life.attach(folder)
        for piece in [*pieces, TURNS]:
            life.live(piece)
            checkpoint = pickle.dumps(life)
            life.live(300)
            life = pickle.loads(checkpoint)
            life.attach(folder)
            if piece == pieces[0]:
                kept = pickle.loads(checkpoint)
        same(life, undisturbed)
        kept.recall(folder)
        kept.live(TURNS)
        same(kept, undisturbed)
        same(life, undisturbed)


def test_stopped_exactly_where_something_is_found(undisturbed):
    moment = undisturbed.found[0].turn
    for pause in (moment - 1, moment, moment + 1):
        life = TableLife(WORLD, undisturbed.mind.config, 4, TURNS)
        assert len(life.live(pause)) == (pause >= moment)
        life = pickle.loads(pickle.dumps(life))
        life.live(TURNS)
        same(life, undisturbed)


def test_it_ends():
    life = TableLife(WORLD, HASTY, 0, 50)
    life.live(80)
    assert life.lived == 50
    assert life.live(10) == []
    assert life.lived == 50
    assert len(life.log("shift gaze")) == 50


@pytest.mark.parametrize("correction", ["none", "miller_madow"])
def test_contingency_is_that_of_the_log(correction):
    life = lived(replace(HASTY, detector=replace(HASTY.detector, correction=correction)), sample_every=100)
    turns, values = life.contingency()
    variables = life.mind.variables
    assert turns.tolist() == list(range(100, TURNS + 1, 100))
    assert values.shape == (12, len(life.mind.events))
    first = table_variables(WORLD)
    for number, event in enumerate(first.events()):
        assert life.mind.events[number] == event
        columns = [life.log(one.name) for one in (variables.sensors[event.sensor], variables.actions[event.action])]
        columns.append(life.log(variables.results[event.result].name))
        for turn_, row in zip(turns, values, strict=True):
            expected = c.state_action_contingency(*(column[:turn_] for column in columns), correction=correction)
            assert row[number] == pytest.approx(expected, abs=1e-12)
    born = [0] * 12 + [life.found[0].turn] * (len(life.mind.events) - 12)
    for number in range(len(list(first.with_module("module 1").events()))):
        assert np.isnan(values[:, number]).tolist() == (turns < born[number]).tolist()


def test_samples_do_not_change_the_life():
    one, other = lived(sample_every=1), lived(sample_every=TURNS + 1)
    assert all(np.array_equal(one.log(column), other.log(column)) for column in one.columns)
    assert len(one.contingency()[0]) == TURNS
    assert len(other.contingency()[0]) == 0


def test_what_is_left_when_no_more_modules_are_made():
    life = lived(replace(HASTY, most_modules=1), turns=2000)
    assert [found.module is None for found in life.found] == [False] + [True] * (len(life.found) - 1)
    assert len(life.found) > 1
    assert len({found.event for found in life.found}) == len(life.found)
    assert len(life.mind.modules) == 1
    nothing = lived(replace(HASTY, most_modules=0))
    assert nothing.mind.modules == []
    assert nothing.found[0].module is None
    assert set(nothing.log("driver of shift gaze")) == {0}


def test_a_robot_that_avoids_faces():
    avoiding = lived(turns=1000, reactive=[AvoidingModule("shift gaze", "caregiver", share=0.0)])
    assert (avoiding.log("shift gaze") != 3).all()
    assert set(avoiding.log("gesture")) == {0, 1, 2, 3}


def test_following_the_gaze_is_found_first():
    """Section 5.3.2, one seed; how often is for the experiments."""
    preset = PRESETS["thesis"]
    life = TableLife(preset.world, preset.mind, 1, 10000)
    while not life.found and life.lived < 10000:
        life.live(1000)
    (found,) = life.found
    assert found.event == Event(0, 0, 2)
    assert life.mind.variables.describe(found.event) == "caregiver's face, shift gaze -> object"
    for spot in range(3):
        assert found.module.command[0, spot] == spot
        assert found.module.expected[0, spot] == 1


@pytest.mark.parametrize("name", PRESETS)
def test_presets_live(name):
    preset = PRESETS[name]
    assert preset.why
    assert lived(preset.mind, turns=200, world=preset.world).lived == 200


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"seed": -1}, "-1"),
        ({"turns": 0}, "0"),
        ({"sample_every": 0}, "0"),
        ({"mind": replace(HASTY, most_modules=127)}, "129"),
    ],
)
def test_impossible_lives(arguments, word):
    with pytest.raises(ConfigError, match=word):
        TableLife(**({"world": WORLD, "mind": HASTY, "seed": 0, "turns": 10} | arguments))
