"""What modules mean: a name where event and map agree with it, else what the map says."""

import numpy as np
import pytest

from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.online.modules import Module
from jointattn_mj.development.meaning import in_words, meanings
from jointattn_mj.development.table.world import TableConfig, table_variables

FRONTAL, PROFILE, OBJECT = range(3)


def module(variables, event, commands, expected=1):
    """One that offers ``commands`` (r, s) -> command, with a reliability that falls from one to the next."""
    event = Event(*event)
    shape = (len(variables.results[event.result].values), len(variables.sensors[event.sensor].values))
    command, outcome, reliability = np.full(shape, -1), np.full(shape, -1), np.zeros(shape)
    for rank, (pair, value) in enumerate(commands.items()):
        command[pair], outcome[pair], reliability[pair] = value, expected, 3 - 0.1 * rank
    return Module(event, command, reliability, outcome, np.zeros((*shape, 2, 4)))


@pytest.fixture(params=[3, 5])
def table(request):
    """Variables with two modules, and the number of spots."""
    variables = table_variables(TableConfig(spots=request.param))
    return variables.with_module("module 1").with_module("module 2"), request.param


def follow(variables, spots, wrong=0):
    """A map of gaze following, some commands of which lead elsewhere."""
    return module(variables, (0, 0, OBJECT), {(0, s): (s + (s < wrong)) % spots for s in range(spots)})


def to_caregiver(variables, spots, event, pair=(0, 1)):
    return module(variables, event, {pair: spots})


def test_the_three_of_chapter_5(table):
    variables, spots = table
    modules = [
        follow(variables, spots),
        to_caregiver(variables, spots, (2, 0, FRONTAL)),
        to_caregiver(variables, spots, (3, 0, PROFILE)),
    ]
    found = meanings(variables, modules)
    assert [meaning.short for meaning in found] == ["FG-m", "SCf-m", "SC-m"]
    assert [meaning.words for meaning in found] == [
        "gaze following",
        "looking back to the caregiver after gaze following",
        "gaze alternation",
    ]
    assert found[0].label == "gaze following (FG-m)"


def test_a_map_that_follows_in_part(table):
    variables, spots = table
    words = meanings(variables, [follow(variables, spots, wrong=1)])[0].words
    assert words == f"gaze following, in {spots - 1} of its map's {spots} commands"


def test_a_map_that_leads_elsewhere(table):
    """The event of gaze following alone makes no gaze following."""
    variables, spots = table
    found = meanings(variables, [follow(variables, spots, wrong=spots)])[0]
    assert found.short == "module 1"
    assert "gaze following" not in found.words
    assert "shift gaze: spot 2 when caregiver's face is at spot 1, expecting object" in found.words


def test_looking_back_after_something_else(table):
    variables, spots = table
    first = to_caregiver(variables, spots, (0, 0, PROFILE), pair=(0, spots))
    found = meanings(variables, [first, to_caregiver(variables, spots, (2, 0, FRONTAL))])
    assert [meaning.short for meaning in found] == ["module 1", "module 2"]
    words = [meaning.words for meaning in found]
    assert words == ["keeping eye contact", "looking back to the caregiver after module 1"]


def test_from_the_table_to_the_caregiver(table):
    variables, spots = table
    found = meanings(variables, [to_caregiver(variables, spots, (1, 0, PROFILE))])
    assert found[0].label == "shifting to the caregiver"


def test_without_profile():
    """Results are told by name, wherever they stand."""
    variables = table_variables(TableConfig(profile=False))
    assert meanings(variables, [module(variables, (0, 0, 1), {(0, 0): 0})])[0].short == "FG-m"


def test_modules_that_use_others(table):
    variables, _ = table
    assert in_words(variables, module(variables, (1, 2, FRONTAL), {(0, 1): 1})) == (
        "using module 1 when object looked at is none, expecting frontal face"
    )
    assert in_words(variables, module(variables, (2, 3, OBJECT), {(0, 0): 0}, expected=0)) == (
        "not using module 2 after module 1 was not used, expecting no object"
    )


def test_long_maps(table):
    """The most reliable first; the same command under several sensations is one."""
    variables, _ = table
    map_of = module(variables, (1, 1, OBJECT), {(0, 0): 2, (0, 1): 2, (1, 0): 1, (1, 1): 0})
    assert in_words(variables, map_of) == (
        "gesture: gesture 3 when object looked at is object or when object looked at is none, expecting object; "
        "gesture: gesture 2 when object looked at is object, expecting object; 1 more"
    )


@pytest.mark.parametrize("event", [(0, 0, OBJECT), (2, 0, FRONTAL), (2, 0, PROFILE), (0, 1, OBJECT)])
def test_a_map_that_offers_nothing(table, event):
    variables, _ = table
    known = meanings(variables, [module(variables, event, {})])
    assert known[0].words == "offers nothing under any observables"
