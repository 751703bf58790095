"""Stop rule local: values against the measure for whole series, evidence against slow sums, and what is found."""

import itertools
import math

import numpy as np
import pytest
from scipy import special

from jointattn_mj.contingency import state_action_contingency
from jointattn_mj.contingency.online.detector import NOTHING
from jointattn_mj.contingency.online.events import Event, Variable, Variables
from jointattn_mj.contingency.online.experience import (
    Experience,
    PastSteps,
    beyond_last,
    empty_experience,
    joint_code,
    keep,
    ranks,
)
from jointattn_mj.contingency.online.followed_maps import followed_map, gains
from jointattn_mj.contingency.online.local import LocalConfig, search
from jointattn_mj.contingency.online.local_values import (
    AFFECTED,
    QUANTILES,
    STRENGTHS,
    Weighing,
    count,
    digamma,
    evidence_of,
    exceeding,
    log_evidence,
    predictive_evidence,
    trigamma,
    value_of,
)
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING, Module
from jointattn_mj.contingency.online.reactive import CuriousModule
from jointattn_mj.contingency.situations import PosteriorOptions, situation_contingency

ALL = Weighing(concentration=2.0, smallest_share=1.0, deviations=3.0, actual=True, reference=True)
YES = ("no", "yes")


def variables(sensors=(3,), actions=(3,), results=2) -> Variables:
    return Variables(
        tuple(Variable(f"s{i}", tuple(map(str, range(size)))) for i, size in enumerate(sensors)),
        tuple(Variable(f"a{i}", tuple(map(str, range(size)))) for i, size in enumerate(actions)),
        tuple(Variable(f"r{i}", YES) for i in range(results)),
    )


def steps_of(world: Variables, s, a, r) -> PastSteps:
    columns = (np.atleast_2d(np.asarray(part).T).T.astype(np.int8) for part in (s, a, r))
    return PastSteps(Experience(*columns), len(s), world)


def looking_pays(seed: int, n: int = 3000, sensors: int = 3):
    """The second action brings the first result about where it equals the sensor; the second result is chance."""
    rng = np.random.default_rng(seed)
    s, a, noise = rng.integers(0, sensors, n), rng.integers(0, sensors, (n, 2)), rng.random((n, 2))
    r = np.zeros((n, 2), int)
    r[1:, 0] = noise[1:, 0] < np.where(a[:-1, 1] == s[:-1], 0.9, 0.4)
    r[:, 1] = noise[:, 1] < 0.5
    return variables((sensors,), (sensors, sensors)), s[:, None], a, r


@pytest.mark.parametrize("policy", ["actual", "reference"])
@pytest.mark.parametrize(("usual", "strength"), [(0.2, 0.0), (0.2, 0.6), (0.01, 0.0)])
def test_moments_are_those_of_posterior_draws(policy, usual, strength):
    rng = np.random.default_rng(3)
    s, a = rng.integers(0, 3, (2, 600))
    r = np.r_[0, rng.random(599) < usual + strength * (s == a)[:-1]].astype(int)
    lead, hoped = np.zeros((2, 2))
    table = np.zeros((2, 3, 3, 2))
    count(s, a, r, r, (0, len(s)), table)
    value_of(table, policy == "reference", ALL, lead, hoped)
    found = situation_contingency(
        s, a, r, policy, base=np.e, posterior=PosteriorOptions(draws=4000, concentration=2.0), seed=1
    )
    drawn = found.draws @ found.share
    assert lead == pytest.approx([drawn.mean(), drawn.std()], rel=0.16)
    assert lead[0] == pytest.approx(drawn.mean(), rel=0.04)
    assert hoped == pytest.approx(lead), "with all situations there is one set"


@pytest.mark.parametrize("policy", ["actual", "reference"])
def test_of_many_steps_all_situations_together_are_sac(policy):
    """Counts a hundred million times as large leave no doubt; what is left is the measure for whole series."""
    rng = np.random.default_rng(7)
    s, a, r = (rng.integers(0, size, 400) for size in (3, 4, 3))
    lead, hoped = np.zeros((2, 2))
    table = np.zeros((3, 3, 4, 3))
    count(s, a, r, r, (0, len(s)), table)
    value_of(1e8 * table, policy == "reference", ALL, lead, hoped)
    assert lead[0] == pytest.approx(situation_contingency(s, a, r, policy, base=np.e).total(), rel=1e-6)
    if policy == "actual":
        assert lead[0] == pytest.approx(state_action_contingency(s, a, r, base=np.e), rel=1e-6)


def test_the_posterior_mean_is_exact_where_each_situation_has_one_action():
    """The divergence from what is usual is then a difference of logarithms, and linear in what is not known."""
    table = np.array([[[[3.0, 1, 2], [0, 0, 0]], [[1, 4, 0], [0, 0, 0]], [[0, 0, 0], [2, 0, 5]]]])
    lead, hoped = np.zeros((2, 2))
    value_of(table, False, ALL, lead, hoped)
    n, first, base = table.sum((0, 2, 3)), table[0, :2, 0].sum(0) / 11, table.sum((0, 1, 2)) / 18
    expected = sum((table[0, s, 0] + 2 * first) / (n[s] + 2) @ np.log(base / first) * n[s] / 18 for s in (0, 1))
    other = table[0, 2, 1] / 7
    expected += other[[0, 2]] @ np.log(base[[0, 2]] / other[[0, 2]]) * 7 / 18
    assert lead[0] == pytest.approx(expected, abs=1e-9)


def test_digamma_and_trigamma():
    x = np.array([1.0, 1.5, 2, 5.99, 6, 50, 1e6])
    assert [digamma(one) for one in x] == pytest.approx(special.digamma(x), abs=1e-9)
    assert [trigamma(one) for one in x] == pytest.approx(special.polygamma(1, x), abs=1e-9)


def test_a_rival_exceeds_as_often_as_draws_say():
    first, rivals = np.array([0.1, 0.02]), np.array([[0.12, 0.03], [0.02, 0.0], [0.5, 0.0]])
    higher = np.zeros((3, len(QUANTILES)))
    for rival, row in zip(rivals, higher, strict=True):
        exceeding(first, rival, 0.25, row)
    rng = np.random.default_rng(0)
    drawn = (rng.normal(*rivals[0], 200_000) > 1.25 * rng.normal(*first, 200_000)).mean()
    assert higher.mean(axis=1) == pytest.approx([drawn, 0, 1], abs=0.01)


def slow_evidence(table: np.ndarray) -> float:
    """Dirichlet-multinomial against multinomial, entry by entry."""
    totals = []
    for alone in (table.sum(1, keepdims=True), table.sum(2, keepdims=True)):
        q = np.broadcast_to(alone / np.maximum(alone.sum(-1, keepdims=True), 1), table.shape)
        logs = []
        for k0, share in itertools.product(STRENGTHS, AFFECTED):
            total = 0.0
            for index in np.ndindex(table.shape[:3]):
                n, p = table[index], q[index]
                if n.sum():
                    factor = math.lgamma(k0) - math.lgamma(n.sum() + k0)
                    factor += sum(
                        math.lgamma(c + k0 * x) - math.lgamma(k0 * x) - c * math.log(x)
                        for c, x in zip(n, p, strict=True)
                        if c
                    )
                    total += math.log(1 - share + share * math.exp(factor))
            logs.append(total)
        totals.append(math.log(np.mean(np.exp(np.array(logs) - max(logs)))) + max(logs))
    return min(totals)


@pytest.mark.parametrize("seed", range(3))
def test_evidence_is_the_slow_sum(seed):
    table = np.random.default_rng(seed).poisson(1.5, (2, 3, 2, 2)).astype(float)
    assert log_evidence(table) == pytest.approx(slow_evidence(table), abs=1e-10)


def test_evidence_of_an_event_is_that_of_its_table():
    world, s, a, r = looking_pays(1)
    columns = steps_of(world, s, a, r).columns(list(world.events()), joint=True, given={})
    tables = [np.zeros(size) for size in columns.sizes]
    for number, table in enumerate(tables):
        count(*columns.of(number).columns, (0, len(s)), table)
    assert [evidence_of(columns, number) for number in range(len(tables))] == [log_evidence(table) for table in tables]


def test_predictive_evidence_is_for_what_is_there_and_against_chance():
    world, s, a, r = looking_pays(1)
    steps = steps_of(world, s, a, r)
    right, gesture, chance = (steps.of(event) for event in (Event(0, 1, 0), Event(0, 0, 0), Event(0, 1, 1)))
    assert predictive_evidence(*right.columns, 0, right.sizes) > 100
    assert predictive_evidence(*gesture.columns, 0, gesture.sizes) < 0
    assert predictive_evidence(*chance.columns, 0, chance.sizes) < 0


DEFAULT = LocalConfig()


def found_in(world, s, a, r, config=DEFAULT, served=()):
    steps, events = steps_of(world, s, a, r), list(world.events(of_joints=True))

    def offers(event):
        return bool((followed_map(event, steps.of(event), 0, config).command != OFFERS_NOTHING).any())

    known = np.array([event in served for event in events])
    number, values = search(steps, events, served, known, 0, config, offers)
    return (None if number == NOTHING else events[number]), dict(zip(events, values, strict=True))


def test_the_contingent_event_is_found_and_nothing_in_chance():
    world, s, a, r = looking_pays(2)
    event, values = found_in(world, s, a, r)
    assert event == Event(0, 1, 0)
    assert max(values, key=values.get) == event
    rng = np.random.default_rng(0)
    assert found_in(world, s, a, rng.permutation(r))[0] is None


def test_what_a_module_explains_is_not_found_again():
    world, s, a, r = looking_pays(3)
    wider = world.with_module("following")
    again = np.column_stack([s, np.r_[0, (a[:-1, 1] == s[:-1, 0]).astype(int)]])
    assert found_in(wider, again, np.column_stack([a, a[:, 1] == s[:, 0]]), r, served=[Event(0, 1, 0)])[0] is None


def test_rare_and_strong_comes_before_frequent_and_weak():
    rng = np.random.default_rng(5)
    n = 6000
    s = np.column_stack([rng.random(n) < 0.08, rng.integers(0, 2, n)]).astype(int)
    a, r = rng.integers(0, 2, (n, 1)), np.zeros((n, 1), int)
    p = (
        0.5
        + 0.12 * np.where(a[:, 0] == s[:, 1], 1, -1)
        + np.where(s[:, 0] == 1, np.where(a[:, 0] == 1, 0.35, -0.35), 0)
    )
    r[1:, 0] = rng.random(n - 1) < p[:-1]
    world = variables((2, 2), (2,), 1)
    assert found_in(world, s, a, r)[0] == Event(0, 0, 0)
    whole = found_in(world, s, a, r, LocalConfig(smallest_share=1.0))[1]
    assert whole[Event(1, 0, 0)] > whole[Event(0, 0, 0)], "else the share makes no difference here"


def test_an_event_whose_sign_is_chance_seldom_waits():
    """Of two spots, looking at one finds what looking at the other misses; a second result is chance."""
    found = {0.0: 0, 1.0: 0, 3.0: 0}
    for seed in range(12):
        rng = np.random.default_rng(seed)
        s, a = rng.integers(0, 2, (2, 1500, 1))
        r = rng.integers(0, 2, (1500, 2))
        r[1:, 0] = rng.random(1499) < np.where(s[:-1, 0] == a[:-1, 0], 0.9, 0.1)
        for least in found:
            config = LocalConfig(waits_deviations=least)
            found[least] += found_in(variables((2,), (2,)), s, a, r, config)[0] == Event(0, 0, 0)
    assert found[0.0] <= found[1.0] < found[3.0] == 12, "at 0 the sign, a coin, decides whether it waits for ever"


def test_map_offers_what_a_situation_adds():
    world, s, a, r = looking_pays(4)
    steps, event = steps_of(world, s, a, r), Event(0, 1, 0)
    module = followed_map(event, steps.of(event), 0, LocalConfig())
    assert (module.command == np.arange(3)).all()
    assert (module.expected == 1).all() and (module.reliability > 1).all()


def test_map_offers_nothing_that_merely_lasts():
    """An object that stays or is away for long; the sensor says whether it was there at the last look, no more."""
    rng = np.random.default_rng(6)
    n = 4000
    there, look = np.cumsum(rng.random(n) < 0.02) % 2, rng.integers(0, 2, n)
    r = np.r_[0, (there & look)[:-1]]
    looked = np.flatnonzero(look[:-1])
    s = np.zeros(n, int)
    for t in looked:
        s[t + 1 :] = r[t + 1]
    series = steps_of(variables((2,), (2,), 1), s, look, r).of(Event(0, 0, 0))
    loose, _ = gains(tables(series), 2.0)
    assert loose[0, 1, 1, 1] > 0.5, "else there is nothing that lasts"
    assert (followed_map(Event(0, 0, 0), series, 0, LocalConfig()).command == OFFERS_NOTHING).all()
    assert log_evidence(tables(series)) > 100
    assert log_evidence(tables(beyond_last(series))) < 0


def tables(series) -> np.ndarray:
    table = np.zeros(series.sizes)
    count(*series.columns, (0, len(series.columns[0])), table)
    return table


def test_gain_is_the_difference_of_two_shares():
    table = np.array([[[[2.0, 8.0]], [[9.0, 1.0]]]])  # (R, S, A, R') = (1, 2, 1, 2)
    gain, spread = gains(table, 0.0)
    assert gain[0, :, 1, 0] == pytest.approx([0.7, -0.7])
    assert spread[0, 0, 1, 0] == pytest.approx(np.sqrt(0.8 * 0.2 / 11 + 0.1 * 0.9 / 11))


def test_hindsight_says_where_the_map_would_have_been_followed():
    world = variables((2,), (2,), 1).with_module("m")
    s, a = np.array([[0, 1], [1, 1], [0, 0], [1, 0]]), np.array([[0, 0], [0, 0], [1, 0], [1, 0]])
    steps = steps_of(world, s, a, np.zeros((4, 1)))
    shape = np.array([[0, 1], [OFFERS_NOTHING, OFFERS_NOTHING]])
    steps.see_in_hindsight(0, Module(Event(0, 0, 0), shape, shape * 1.0, shape, np.zeros((2, 2, 2, 2))))
    assert steps.of(Event(1, 0, 0)).columns[0].tolist() == [0, 1, 0, 0]


def test_of_too_many_steps_the_last_are_kept():
    world = variables((3,), (2,), 1)
    kept = empty_experience(4, 1, 1, 1)
    for t in range(6):
        keep(kept, t, np.array([t % 3]), np.array([t % 2]), np.array([0]))
    steps = PastSteps(kept, 6, world)
    assert (steps.n_steps, steps.forgotten) == (4, 2)
    s, a, _, _ = steps.of(Event(0, 0, 0)).columns
    assert (s.tolist(), a.tolist()) == ([2, 0, 1, 2], [0, 1, 0, 1])


def test_of_many_results_what_occurred_is_numbered():
    """Seventy results of two values each have more combinations than there are numbers."""
    rng = np.random.default_rng(8)
    rows = rng.integers(0, 2, (5, 70))
    r = rows[[0, 1, 0, 2, 3, 4, 2]]
    world, s, a = variables((2,), (2,), 70), rng.integers(0, 2, (7, 1)), np.zeros((7, 1))
    columns = steps_of(world, s, a, r).columns([Event(0, 0, 3)], joint=True, given={3: [0]})
    expected = np.unique(np.column_stack([r, s]), axis=0, return_inverse=True)[1].ravel()
    assert columns.before[:, 3].tolist() == expected.tolist()
    assert columns.sizes[0, 0] == expected.max() + 1
    assert columns.before[:, 4].tolist() == np.unique(r, axis=0, return_inverse=True)[1].ravel().tolist()
    assert ranks(np.array([10**12, 5, 10**12])).tolist() == ranks(np.array([7, 5, 7])).tolist() == [1, 0, 1]


def test_joint_code_is_a_number_for_each_combination():
    values = np.array([[0, 0], [0, 2], [1, 0], [1, 2]])
    assert joint_code(values, [2, 3]).tolist() == [0, 2, 3, 5]


def test_curiosity_goes_by_perplexity():
    """After the first command the next sensation is one of four, after the second always the same."""
    rng = np.random.default_rng(0)
    n = 20_000
    a = rng.integers(0, 2, n)
    s = np.r_[0, np.where(a[:-1] == 0, rng.integers(0, 4, n - 1), 0)]
    world = variables((4,), (2,), 1)
    module = CuriousModule("a0")
    assert module.table(world).odds == pytest.approx(np.full((4, 2), 0.5))
    odds = module.learned(world, steps_of(world, s, a, np.zeros(n))).odds
    assert odds[:, 0] == pytest.approx(np.full(4, 0.8), abs=0.01)
