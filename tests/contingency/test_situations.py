"""Contingency situation by situation: slow sums, closed forms, the sum that is SAC, and what a posterior knows."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jointattn_mj.contingency import situation_contingency, state_action_contingency
from jointattn_mj.contingency.situations import PosteriorOptions
from jointattn_mj.errors import ConfigError, SeriesError


def series(seed: int, steps: int = 60, sizes=(3, 3, 2)) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [rng.integers(0, size, steps) for size in sizes]


def slow(s, a, r, policy: str) -> dict[tuple[int, int], float]:
    """The definition, loop by loop, in nats."""
    rows = list(zip(r[:-1], s[:-1], a[:-1], r[1:], strict=True))

    def p(after, **known) -> float:
        names = ("r", "s", "a")
        some = [row for row in rows if all(row[names.index(name)] == value for name, value in known.items())]
        return sum(row[3] == after for row in some) / len(some)

    values = {}
    for before, sensed in sorted({row[:2] for row in rows}):
        here = [row for row in rows if row[:2] == (before, sensed)]
        acted = sorted({row[2] for row in here})
        u = {
            act: sum(row[2] == act for row in here) / len(here) if policy == "actual" else 1 / len(acted)
            for act in acted
        }
        inner = mixed = 0.0
        for after in sorted(set(r)):
            known = {act: p(after, r=before, s=sensed, a=act) for act in acted}
            pooled = {act: p(after, r=before, a=act) for act in acted}
            inner += sum(u[act] * known[act] * np.log(known[act] / pooled[act]) for act in acted if known[act])
            both = sum(u[act] * known[act] for act in acted)
            base = p(after, r=before) if policy == "actual" else sum(u[act] * pooled[act] for act in acted)
            mixed += both * np.log(both / base) if both else 0.0
        values[before, sensed] = inner - mixed
    return values


@pytest.mark.parametrize("policy", ["actual", "reference"])
@pytest.mark.parametrize("seed", range(4))
def test_slow_sums(seed, policy):
    s, a, r = series(seed)
    found = situation_contingency(s, a, r, policy, base=np.e)
    expected = slow(s.tolist(), a.tolist(), r.tolist(), policy)
    assert list(zip(found.result.tolist(), found.sensor.tolist(), strict=True)) == list(expected)
    np.testing.assert_allclose(found.value, list(expected.values()), atol=1e-12)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**31), st.tuples(*[st.integers(1, 4)] * 3), st.integers(3, 40))
def test_the_weighed_sum_is_sac(seed, sizes, steps):
    s, a, r = series(seed, steps, sizes)
    found = situation_contingency(s, a, r)
    assert found.total() == pytest.approx(state_action_contingency(s, a, r), abs=1e-12)
    assert found.transitions.sum() == steps - 1


def test_exclusive_or_is_one_bit_in_every_situation():
    """r' = s xor a, all combinations equally often: neither says anything alone, both say everything."""
    grid = [(r, s, a) for r in (0, 1) for s in (0, 1) for a in (0, 1)]
    s, a, r = (list(part) for part in zip(*(([s, 0], [a, 0], [r, s ^ a]) for r, s, a in grid), strict=True))
    for policy in ("actual", "reference"):  # of recordings of one transition each
        np.testing.assert_allclose(situation_contingency(s, a, r, policy).value, 1, atol=1e-12)


def test_a_rare_situation_is_as_strong_as_a_frequent_one_by_the_reference_policy():
    """s = 2 comes in one step of fifty and makes the result follow the action; else the result is drawn."""
    rng = np.random.default_rng(1)
    steps = 60_000
    s = np.where(rng.random(steps) < 0.02, 2, rng.integers(0, 2, steps))
    a = np.where(rng.random(steps) < 0.1, 1, 0)
    r = np.append(0, np.where(s == 2, a, rng.integers(0, 2, steps)))[:-1]
    found = situation_contingency(s, a, r, "reference")
    strong = found.sensor == 2
    assert found.value[strong].min() > 0.5 > 0.02 > found.value[~strong].max()
    assert state_action_contingency(s, a, r) < 0.02


def test_codes_are_those_that_were_given():
    s, a, r = (part * 1_000_000 for part in series(5))
    found = situation_contingency(s, a, r)
    assert set(found.sensor) == {0, 1_000_000, 2_000_000}
    assert set(found.result) == {0, 1_000_000}


class TestPosterior:
    def test_draws_are_about_the_value_where_much_is_known(self):
        s, a, r = series(2, 200_000)
        r = np.append(0, np.where(s == a, 1, 0))[:-1]
        found = situation_contingency(s, a, r, posterior=PosteriorOptions(draws=50))
        assert found.draws.shape == (50, len(found.value))
        np.testing.assert_allclose(found.draws.mean(axis=0), found.value, atol=0.01)
        assert found.draws.std(axis=0).max() < 0.01

    def test_a_strong_prior_says_that_the_sensor_tells_nothing(self):
        s, a, r = series(3)
        found = situation_contingency(s, a, r, "reference", posterior=PosteriorOptions(40, concentration=1e7))
        np.testing.assert_allclose(found.draws, 0, atol=1e-3)

    def test_one_transition_is_not_believed(self):
        """Its plug-in value is high; its draws go from near 0 on."""
        s, a, r = series(4, 400)
        s, r = s.copy(), r.copy()
        s[100], r[101] = 3, 2
        found = situation_contingency(s, a, r, posterior=PosteriorOptions(200))
        once = found.sensor == 3
        assert np.quantile(found.draws[:, once], 0.1) < 0.5 * found.value[once]

    def test_the_same_seed_the_same_draws(self):
        given = series(6)
        first, same, other = (
            situation_contingency(*given, posterior=PosteriorOptions(5), seed=seed).draws for seed in (1, 1, 2)
        )
        assert np.array_equal(first, same)
        assert not np.array_equal(first, other)


def test_recordings_are_not_joined():
    s, a, r = series(7, 40)
    parts = [[part[:20], part[20:]] for part in (s, a, r)]
    found = situation_contingency(*parts)
    assert found.transitions.sum() == 38
    assert found.total() == pytest.approx(state_action_contingency(*parts), abs=1e-12)


def test_what_cannot_be_measured():
    with pytest.raises(SeriesError, match="policy must be one of actual, reference; got 'Actual'"):
        situation_contingency(*series(0), policy="Actual")
    with pytest.raises(SeriesError, match="equally long"):
        situation_contingency([0, 1, 1], [0, 1], [0, 1])
    with pytest.raises(ConfigError, match=r"draws: expected a whole number in \[0, 1e6\]"):
        PosteriorOptions(draws=-1)


def test_a_line_says_what_it_is():
    said = repr(situation_contingency(*series(0)))
    assert said.startswith("Situations(6, actual policy, total ")
    assert len(said) < 100
