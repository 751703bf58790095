"""The detector against slow ones that look at the whole series at every step."""

import numpy as np
import pytest
from numba import njit
from worlds import counted, series, variables

import jointattn_mj.contingency as c
from jointattn_mj.contingency.online.counts import add, empty_counts
from jointattn_mj.contingency.online.detector import NOTHING, DetectorConfig, grown, new_watch, update
from jointattn_mj.errors import ConfigError

WORLD = variables([4, 3], [3, 2], [2, 3])
EVENTS = list(WORLD.events())
XOR = variables([2, 2], [2], [2])


@njit(cache=True)
def watch_all(watch, counts, s, a, r, values, found):
    """Measures (T - 1, E) and what was found (T - 1,) after each transition."""
    for t in range(len(found)):
        add(counts, s[t], a[t], r[t], r[t + 1], 1, len(counts.layout))
        found[t] = update(watch, counts)
        values[t] = watch.values


def watched(config, transitions, of=WORLD, watch=None):
    counts, steps = empty_counts(of, list(of.events())), len(transitions[0]) - 1
    watch = watch or new_watch(config, len(list(of.events())))
    values, found = np.zeros((steps, len(watch.values))), np.zeros(steps, np.int64)
    watch_all(watch, counts, *transitions, values, found)
    return watch, counts, values, found


def xor_run(length, seed=0, noise=0.0, other=0.5):
    """The result is s0 xor a, but for some noise; s1 differs from s0 with probability ``other``."""
    rng = np.random.default_rng(seed)
    s, a = rng.integers(0, 2, (length, 2)), rng.integers(0, 2, (length, 1))
    s[:, 1] = s[:, 0] ^ (rng.random(length) < other)
    r = np.zeros((length, 1), np.int64)
    r[1:] = (s[:-1, :1] ^ a[:-1]) ^ (rng.random((length - 1, 1)) < noise)
    return s, a, r


@pytest.mark.parametrize("base", [2.0, np.e])
@pytest.mark.parametrize("measure", ["sac", "tc"])
@pytest.mark.parametrize("correction", ["none", "miller_madow"])
def test_values_are_the_measures(measure, correction, base):
    transitions = series(WORLD, 400, np.random.default_rng(1))
    _, _, values, _ = watched(DetectorConfig(measure=measure, correction=correction, base=base), transitions)
    function = c.state_action_contingency if measure == "sac" else c.combined_transfer_entropy
    for t in (1, 2, 10, 100, 399):
        s, a, r = (part[: t + 1] for part in transitions)
        for number, event in enumerate(EVENTS):
            columns = s[:, event.sensor], a[:, event.action], r[:, event.result]
            expected = function(*columns, base, correction=correction)
            assert values[t - 1, number] == pytest.approx(expected, abs=1e-12)


def slow_convergence(values, config, modelled=()):
    """Stop rule convergence from measures (T, E) alone."""
    before, gap_before, first_before, held, found = np.zeros(values.shape[1]), 0.0, NOTHING, 0, []
    ranked = [e for e in range(values.shape[1]) if not (config.modelled == "drop" and e in modelled)]
    for t, now in enumerate(values, 1):
        order = sorted(ranked, key=lambda e: (-now[e], e))
        gap = now[order[0]] - now[order[1]]
        change = abs(gap - gap_before) if config.stability_of == "gap" else abs(now - before).max()
        held = held + 1 if order[0] == first_before and change < config.threshold else 0
        before, gap_before, first_before = now, gap, order[0]
        due = t > config.warm_up and held >= config.hold and order[0] not in modelled and now[order[0]] > 0
        found.append(order[0] if due else NOTHING)
        held = 0 if due else held
    return found


@pytest.mark.parametrize("of", ["all", "gap"])
@pytest.mark.parametrize("modelled", ["keep", "drop"])
@pytest.mark.parametrize("taken", [(), (0,), (0, 6)])
@pytest.mark.parametrize(("warm_up", "hold", "threshold"), [(100, 30, 4e-4), (0, 1, 2e-4), (2500, 5, 1e-3)])
def test_stop_rule_convergence(of, modelled, taken, warm_up, hold, threshold):
    config = DetectorConfig(stability_of=of, modelled=modelled, warm_up=warm_up, hold=hold, threshold=threshold)
    transitions = series(WORLD, 3000, np.random.default_rng(2))
    watch = new_watch(config, len(EVENTS))
    watch.modelled[list(taken)] = True
    _, _, values, found = watched(config, transitions, watch=watch)
    expected = slow_convergence(values, config, taken)
    assert found.tolist() == expected
    top = values[-1].argmax()
    assert (set(expected) != {NOTHING}) == (modelled == "drop" or top not in taken)


def test_of_next_to_nothing_nothing_changes():
    """Without a warm-up, the dissertation's condition holds after the first transition."""
    transitions = tuple(np.zeros((50, width), np.int64) for width in (2, 1, 1))
    assert set(watched(DetectorConfig(warm_up=0, hold=1), transitions, XOR)[3]) == {NOTHING}  # but 0 is not contingent
    first = []
    for warm_up in (0, 150):
        config = DetectorConfig(warm_up=warm_up, hold=1, threshold=0.1)
        first.append(np.flatnonzero(watched(config, xor_run(200), XOR)[3] >= 0)[0])
    assert first[0] < 20
    assert first[1] == 150


def slow_confidence(values, config, transitions, of):
    """Stop rule confidence, with standard errors from the pointwise values of the series so far."""
    function = (
        c.pointwise_state_action_contingency if config.measure == "sac" else c.pointwise_combined_transfer_entropy
    )
    next_look, found = config.warm_up, []
    for t, now in enumerate(values, 1):
        found.append(NOTHING)
        if t <= next_look:
            continue
        next_look = int(t * (1 + config.look_again))
        first = int(now.argmax())
        if now[first] <= 0:
            continue
        s, a, r = (part[: t + 1] for part in transitions)
        squared = [
            np.var(function(s[:, e.sensor], a[:, e.action], r[:, e.result], config.base)) / t for e in of.events()
        ]
        known = config.deviations * np.sqrt(squared[first]) <= config.precision * now[first]
        ahead = all(
            now[first] * (1 + config.tolerance) - now[e] >= config.deviations * np.sqrt(squared[first] + squared[e])
            for e in range(len(now))
            if e != first
        )
        if known and ahead:
            found[-1] = first
    return found


@pytest.mark.parametrize("measure", ["sac", "tc"])
@pytest.mark.parametrize("options", [{}, {"deviations": 2.0, "tolerance": 0.0}, {"precision": 0.2, "warm_up": 20}])
def test_stop_rule_confidence(measure, options):
    config = DetectorConfig(stop_rule="confidence", measure=measure, **options)
    transitions = xor_run(3000, noise=0.2)
    _, _, values, found = watched(config, transitions, XOR)
    assert found.tolist() == slow_confidence(values, config, transitions, XOR)
    assert set(found) == {NOTHING, 0}


@pytest.mark.parametrize(("tolerance", "found"), [(0.0, False), (0.25, False), (0.5, True)])
def test_a_rival_that_is_nearly_as_contingent(tolerance, found):
    """It may come second within the tolerance; two that cannot be told apart otherwise leave all open."""
    config = DetectorConfig(stop_rule="confidence", tolerance=tolerance)
    transitions = xor_run(300, noise=0.1, other=0.02)
    _, _, values, what = watched(config, transitions, XOR)
    assert what.tolist() == slow_confidence(values, config, transitions, XOR)
    assert (0 in what) == found


def test_certainty_has_no_unit():
    transitions = xor_run(2000, noise=0.3)
    in_bits, in_nats = (
        watched(DetectorConfig(stop_rule="confidence", base=base), transitions, XOR)[3].tolist() for base in (2.0, np.e)
    )
    assert in_bits == in_nats


def test_of_noise_nothing_is_certain():
    rng = np.random.default_rng(5)
    noise = rng.integers(0, 2, (20000, 2)), rng.integers(0, 2, (20000, 1)), rng.integers(0, 2, (20000, 1))
    config = DetectorConfig(stop_rule="confidence", correction="miller_madow")
    assert set(watched(config, noise, XOR)[3]) == {NOTHING}


def test_a_modelled_event_blocks_certainty_or_steps_aside():
    transitions = xor_run(3000, noise=0.1)
    for modelled in ("keep", "drop"):
        config = DetectorConfig(stop_rule="confidence", modelled=modelled)
        watch = new_watch(config, 2)
        watch.modelled[0] = True
        assert 0 not in watched(config, transitions, XOR, watch)[3]
    config = DetectorConfig(modelled="drop")
    watch = new_watch(config, 2)
    watch.modelled[:] = True
    assert set(watched(config, transitions, XOR, watch)[3]) == {NOTHING}


@pytest.mark.parametrize("anew", [False, True])
def test_grown(anew):
    watch, counts, values, _ = watched(DetectorConfig(), series(WORLD, 500, np.random.default_rng(3)))
    wider = grown(watch, len(EVENTS) + 5, 3, anew)
    assert wider.values.tolist() == [*values[-1], 0, 0, 0, 0, 0]
    assert np.flatnonzero(wider.modelled).tolist() == [3]
    assert not watch.modelled.any()
    assert wider.first.tolist() == [watch.first[0], 0]
    assert wider.time.tolist() == ([0, 100] if anew else watch.time.tolist())
    assert counts.n.max() == 499


BAD = [
    {"measure": "te"},
    {"correction": "shuffle"},
    {"stop_rule": "moving"},
    {"stability_of": "some"},
    {"modelled": "block it"},
    {"base": 1.0},
    {"base": float("inf")},
    {"threshold": 0.0},
    {"threshold": float("nan")},
    {"hold": 0},
    {"warm_up": -1},
    {"deviations": -2.0},
    {"precision": 0.0},
    {"tolerance": -0.1},
    {"look_again": 0.0},
]


@pytest.mark.parametrize("options", BAD, ids=str)
def test_impossible_options(options):
    ((name, value),) = options.items()
    with pytest.raises(ConfigError, match=name) as refused:
        DetectorConfig(**options)
    assert str(value) in str(refused.value)


def test_counts_are_not_touched():
    transitions = series(WORLD, 300, np.random.default_rng(4))
    _, counts, _, _ = watched(DetectorConfig(), transitions)
    assert np.array_equal(counts.entries, counted(empty_counts(WORLD, EVENTS), transitions).entries)
