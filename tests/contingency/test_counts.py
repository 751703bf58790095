"""Incremental counts: after every step they say what a recomputation from the whole series says."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from worlds import contingency, counted, joint_counts, series, variables

import jointattn_mj.contingency as c
from jointattn_mj.contingency import information
from jointattn_mj.contingency.online import counts as module
from jointattn_mj.contingency.online.counts import (
    ALONE,
    LISTED,
    OF_ACTION,
    OF_SENSOR,
    OWN,
    divide,
    empty_counts,
    joined,
    joint_table,
    local_variance,
    set_joint_table,
)
from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.table import steps


def measured(counts, field="sums"):
    """T^C and SAC of all events, times n: of sums, or of occupied cells."""
    parts = getattr(counts, field)[counts.of_event].astype(float)
    combined = parts[:, OWN] - parts[:, OF_ACTION]
    return combined, combined - (parts[:, OF_SENSOR] - parts[:, ALONE])


def same_counts(own, other):
    """Equal to the last count; sums up to rounding."""
    assert np.array_equal(own.entries, other.entries)
    for field in ("sums", "n", "occupied"):
        assert getattr(own, field) == pytest.approx(getattr(other, field), rel=1e-12, abs=1e-11), field
    assert np.array_equal(own.of_event, other.of_event)
    assert np.array_equal(own.layout, other.layout)


sizes = st.tuples(
    st.lists(st.integers(1, 4), min_size=1, max_size=2),
    st.lists(st.integers(1, 4), min_size=1, max_size=2),
    st.lists(st.integers(2, 3), min_size=1, max_size=2),
)


@settings(max_examples=25, deadline=None)
@given(sizes, st.integers(3, 25), st.integers(0, 2**32))
def test_every_step_equals_a_full_recomputation(sizes, length, seed):
    world = variables(*sizes)
    events = list(world.events())
    transitions = series(world, length, np.random.default_rng(seed))
    counts = empty_counts(world, events)
    for t in range(1, length):
        counted(counts, tuple(part[t - 1 : t + 1] for part in transitions))
        so_far = tuple(part[: t + 1] for part in transitions)
        combined, single = measured(counts)
        fewer, single_fewer = measured(counts, "occupied")
        for number, event in enumerate(events):
            s, a, r = so_far[0][:, event.sensor], so_far[1][:, event.action], so_far[2][:, event.result]
            entries = steps(s, r, a).entries()
            assert combined[number] / t == pytest.approx(information.COMBINED.value(entries), abs=1e-12)
            assert single[number] / t == pytest.approx(information.CONTINGENCY.value(entries), abs=1e-12)
            assert fewer[number] == pytest.approx(2 * t * information.COMBINED.bias(entries, "miller_madow"))
            assert single_fewer[number] == pytest.approx(2 * t * information.CONTINGENCY.bias(entries, "miller_madow"))
    for number, event in enumerate(events):
        assert np.array_equal(joint_table(counts, number), joint_counts(transitions, world, event))


@pytest.mark.parametrize("seed", range(3))
def test_the_public_measures_agree(seed):
    world = variables([4, 3], [3, 2], [2, 4])
    s, a, r = transitions = series(world, 800, np.random.default_rng(seed))
    counts = counted(empty_counts(world, list(world.events())), transitions)
    combined, single = measured(counts)
    for number, event in enumerate(world.events()):
        columns = s[:, event.sensor], a[:, event.action], r[:, event.result]
        assert combined[number] / 799 == pytest.approx(c.combined_transfer_entropy(*columns, np.e), abs=1e-12)
        assert single[number] / 799 == pytest.approx(c.state_action_contingency(*columns, np.e), abs=1e-12)
        assert contingency(joint_table(counts, number)) == pytest.approx(
            (combined[number] / 799, single[number] / 799), abs=1e-12
        )


@settings(max_examples=25, deadline=None)
@given(sizes, st.integers(3, 40), st.data())
def test_what_is_taken_out_again_was_never_there(sizes, length, data):
    world = variables(*sizes)
    transitions = series(world, length, np.random.default_rng(length))
    kept = data.draw(st.integers(0, length - 1))
    counts = counted(empty_counts(world, list(world.events())), transitions)
    counted(counts, tuple(part[: kept + 1] for part in transitions), -1)
    rest = counted(empty_counts(world, list(world.events())), tuple(part[kept:] for part in transitions))
    same_counts(counts, rest)


def test_contexts_are_shared_among_events():
    world = variables([3, 2], [2, 4], [2, 2, 3])
    counts = empty_counts(world, list(world.events()))
    assert len(counts.layout) == (2 * 2 + 2 + 2 + 1) * 3
    assert len(np.unique(counts.of_event[:, OWN])) == 12
    assert len(np.unique(counts.of_event[:, ALONE])) == 3


def test_events_that_join_later_start_empty_and_do_not_disturb_the_old_ones():
    first, both = variables([3], [2], [2, 3]), variables([3, 4], [2, 3], [2, 3])
    old = list(first.events())
    new = [event for event in both.events() if event not in set(old)]
    s, a, r = transitions = series(both, 60, np.random.default_rng(0))
    early = tuple(part[:31] for part in transitions)
    counts = counted(empty_counts(first, old), (early[0][:, :1], early[1][:, :1], early[2]))
    wider = joined(counts, empty_counts(both, new))
    late = (s[30:], a[30:], r[30:])
    counted(wider, late)
    for number, event in enumerate(old + new):
        since = transitions if event in set(old) else late
        assert np.array_equal(joint_table(wider, number), joint_counts(since, both, event)), event
        assert measured(wider)[1][number] == pytest.approx(
            contingency(joint_counts(since, both, event))[1] * (len(since[0]) - 1), abs=1e-10
        )
    assert counts.entries.sum() == pytest.approx(30 * 2 * len(counts.layout))  # its own tables, not the wider ones'


def test_fewer_contexts_take_part():
    first, both = variables([3], [2], [2]), variables([3, 2], [2], [2])
    old = list(first.events())
    new = [event for event in both.events() if event not in set(old)]
    counts = joined(empty_counts(first, old), empty_counts(both, new))
    s, a, r = series(both, 20, np.random.default_rng(1))
    module.add(counts, s[0], a[0], r[0], r[1], 1, 4)
    assert counts.n.tolist() == [1] * 4 + [0] * (len(counts.layout) - 4)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32), st.integers(1, 3), st.integers(1, 3), st.integers(2, 4))
def test_a_table_that_is_set_counts_on(seed, sensors, actions, results):
    world = variables([sensors], [actions], [results])
    rng = np.random.default_rng(seed)
    before, after = series(world, 30, rng), series(world, 10, rng)
    event = Event(0, 0, 0)
    table = joint_counts(before, world, event)
    counts = empty_counts(world, [event])
    set_joint_table(counts, 0, table)
    assert np.array_equal(joint_table(counts, 0), table)
    same_counts(counted(counts, after), counted(counted(empty_counts(world, [event]), before), after))


@pytest.mark.parametrize("seed", range(3))
def test_weights_that_fade(seed):
    """A transition k steps old weighs exp(-k / 25); making all weights smaller changes no measure."""
    world = variables([3, 2], [2], [2, 3])
    transitions = series(world, 300, np.random.default_rng(seed))
    counts = empty_counts(world, list(world.events()))
    weight = 1.0
    for t in range(1, 300):
        weight *= np.exp(1 / 25)
        counted(counts, tuple(part[t - 1 : t + 1] for part in transitions), weight)
        if weight > 100:
            divide(counts, weight)
            weight = 1.0
    ages = np.arange(298, -1, -1)
    for number, event in enumerate(world.events()):
        expected = joint_counts(transitions, world, event, np.exp(-ages / 25))
        assert joint_table(counts, number) / weight == pytest.approx(expected, abs=1e-12)
        n = counts.n[counts.of_event[number, OWN]]
        assert [values[number] / n for values in measured(counts)] == pytest.approx(contingency(expected), abs=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_local_variance(seed):
    world = variables([3, 1], [2, 4], [2, 3])
    s, a, r = transitions = series(world, 200, np.random.default_rng(seed))
    counts = counted(empty_counts(world, list(world.events())), transitions)
    for number, event in enumerate(world.events()):
        columns = s[:, event.sensor], a[:, event.action], r[:, event.result]
        for single, pointwise in (
            (0, c.pointwise_combined_transfer_entropy),
            (1, c.pointwise_state_action_contingency),
        ):
            expected = np.var(pointwise(*columns, np.e))
            assert local_variance(counts, number, single) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("c", [LISTED - 1, LISTED, LISTED + 1, 10**7, 10**12])
def test_logarithms_of_large_counts(c):
    exact = math.log(c + 1) + c * math.log1p(1 / c)
    assert module.one_more(float(c), module._gains()) == pytest.approx(exact, abs=1e-9 if c < LISTED else 2e-14)


def test_counts_pass_the_end_of_the_list():
    world = variables([2], [2], [2])
    table = np.full((2, 2, 2, 2), float(LISTED - 40))
    table[0, 1, 1, 0] += 5000
    transitions = series(world, 2000, np.random.default_rng(0))
    counts, after = empty_counts(world, [Event(0, 0, 0)]), empty_counts(world, [Event(0, 0, 0)])
    set_joint_table(counts, 0, table)
    counted(counts, transitions)
    set_joint_table(after, 0, table + joint_counts(transitions, world, Event(0, 0, 0)))
    assert np.array_equal(counts.entries, after.entries)
    assert counts.entries.max() > 2 * LISTED
    assert np.array(measured(counts)) / table.sum() == pytest.approx(np.array(measured(after)) / table.sum(), abs=1e-13)
    counted(counts, transitions, -1)
    assert np.array_equal(joint_table(counts, 0), table)


@pytest.mark.parametrize("million", [1, pytest.param(10, marks=pytest.mark.slow)])
def test_sums_do_not_drift(million):
    world = variables([5], [4], [2])
    transitions = series(world, million * 10**6 + 1, np.random.default_rng(0))
    counts = counted(empty_counts(world, [Event(0, 0, 0)]), transitions)
    exact = contingency(joint_counts(transitions, world, Event(0, 0, 0)))
    assert np.ravel(measured(counts)) / (million * 10**6) == pytest.approx(exact, abs=1e-12)
