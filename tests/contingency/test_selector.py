"""The selector: frequencies of many draws against eq. 5.6, habituation turn by turn, modules that use others."""

from dataclasses import dataclass

import numpy as np
import pytest
from worlds import variables

from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING, Module
from jointattn_mj.contingency.online.reactive import RandomModule, ReactiveTable
from jointattn_mj.contingency.online.selector import NOBODY, SelectorConfig, flat_maps, select
from jointattn_mj.errors import ConfigError

WORLD = variables([3, 2], [4, 2], [2, 2])
DRAWS = 3000


def module(sensor, action, result, command, reliability, world=WORLD):
    """A module with these maps (R, S)."""
    command = np.array(command)
    return Module(Event(sensor, action, result), command, np.array(reliability, float), command, np.zeros(0))


FIRST = module(0, 0, 1, [[0, 1, 2], [3, OFFERS_NOTHING, 1]], [[1.0, 0.5, 2.0], [0.3, 0.0, 1.5]])
SECOND = module(1, 0, 0, [[2, 1], [OFFERS_NOTHING, 0]], [[0.7, 1.2], [0.0, 0.9]])
OTHER = module(0, 1, 0, [[1, 1, 0], [0, 0, 1]], [[1.0, 1.0, 1.0], [1.0, 1.0, 1.0]])


class Choosing:
    """A selector with its working arrays."""

    def __init__(self, modules, config=None, reactive=None, seed=0, world=WORLD):
        for number in range(len(modules)):
            world = world.with_module(f"module {number + 1}")
        reactive = reactive or [RandomModule("a0"), RandomModule("a1")]
        tables = [module.table(world) for module in reactive]
        self.maps = flat_maps(world, modules, tables, config or SelectorConfig())
        self.a, self.driver = np.full(len(world.actions), 7), np.full(len(world.joints), -9)
        self.random, self.strength = np.random.default_rng(seed), np.zeros(len(modules) + len(reactive))
        self.sensors = len(world.sensors)

    def choose(self, s, r):
        """Commands, A_Pi, and drivers of a turn."""
        observed = np.array([*s, *[0] * (self.sensors - len(s))])
        select(self.maps, observed, np.array(r), self.random, self.strength, self.a, self.driver)
        return self.a.copy(), self.driver.copy()

    def frequencies(self, s, r, repeats=0, joint=0):
        """How often each module drove a joint, with the same t' before each draw."""
        counts = np.zeros(len(self.strength))
        for _ in range(DRAWS):
            self.maps.repeats[:] = repeats
            for m in range(self.maps.made):
                self.maps.under[m] = r[self.maps.result[m]] * self.maps.size[m] + s[self.maps.sensor[m]]
            counts[self.choose(s, r)[1][joint]] += 1
        return counts / DRAWS


def expected(reliabilities, modules, habituated=None):
    """Eq. 5.6 with tau = 1 / (CMs + 1); None for a module that offers nothing."""
    tau = 1 / (modules + 1)
    factors = habituated or [1.0] * len(reliabilities)
    odds = [0.0 if z is None else np.exp(z * f / tau) for z, f in zip(reliabilities, factors, strict=True)]
    return np.array(odds) / sum(odds)


def close(frequencies, probabilities):
    spread = np.sqrt(probabilities * (1 - probabilities) / DRAWS)
    assert (np.abs(frequencies - probabilities) <= 4 * spread).all(), (frequencies, probabilities)


CASES = [
    ((0, 0), (0, 0), (1.0, 0.7)),
    ((2, 1), (0, 0), (2.0, 1.2)),
    ((0, 1), (0, 1), (0.3, 1.2)),
    ((1, 0), (1, 1), (None, None)),
    ((0, 1), (1, 1), (0.3, 0.9)),
]


@pytest.mark.parametrize(("s", "r", "reliabilities"), CASES)
def test_probabilities(s, r, reliabilities):
    """Reactive modules say trust under everything; the other joint's are no competitors."""
    both = Choosing([FIRST, SECOND])
    close(both.frequencies(s, r), expected([*reliabilities, 1.0, None], 2))
    assert both.frequencies(s, r, joint=1).tolist() == [0, 0, 0, 1]


def test_temperature_falls_with_the_modules_of_the_joint_only():
    alone = Choosing([FIRST, OTHER])
    close(alone.frequencies((2, 0), (0, 0)), expected([2.0, None, 1.0, None], 1))


def test_several_reactive_modules_and_their_trust():
    reactive = [RandomModule("a0", 0.5), RandomModule("a0", 1.5), RandomModule("a1")]
    choosing = Choosing([FIRST], reactive=reactive)
    close(choosing.frequencies((0, 0), (0, 0)), expected([1.0, 0.5, 1.5, None], 1))
    certain = Choosing([FIRST], reactive=[RandomModule("a0", 1e4), RandomModule("a1")])
    assert certain.frequencies((0, 0), (0, 0)).tolist() == [0, 1, 0]


@pytest.mark.parametrize("beta", [0.0, 0.5, 2.0])
def test_habituation_weakens(beta):
    choosing = Choosing([FIRST, SECOND], SelectorConfig(habituation=beta))
    tired = [np.exp(-beta * 3), np.exp(-beta * 3), 1, 1]
    close(choosing.frequencies((2, 1), (0, 0), repeats=3), expected([2.0, 1.2, 1.0, None], 2, tired))


@pytest.mark.parametrize("habituates", ["driven", "observed"])
def test_what_habituation_counts(habituates):
    choosing = Choosing([FIRST, SECOND], SelectorConfig(habituates=habituates))
    rng = np.random.default_rng(1)
    repeats, under = [0, 0], [None, None]
    situation = (0, 0), (0, 0)
    most = 0
    for _ in range(600):
        situation = (
            situation if rng.random() < 0.7 else (tuple(rng.integers(0, (3, 2))), tuple(rng.integers(0, (2, 2))))
        )
        s, r = situation
        _, driver = choosing.choose(s, r)
        for m, pair in enumerate(((s[0], r[1]), (s[1], r[0]))):
            repeats[m] = repeats[m] if pair == under[m] else 0
            under[m] = pair
            repeats[m] = repeats[m] + 1 if habituates == "observed" or driver[0] == m else 0
        assert choosing.maps.repeats[:2].tolist() == repeats
        most = max(most, *repeats)
    assert most >= 3


def test_a_module_is_fresh_under_other_observables():
    choosing = Choosing([FIRST])
    choosing.maps.repeats[0], choosing.maps.under[0] = 50, 2
    counts = np.zeros(3)
    for _ in range(DRAWS):
        choosing.maps.repeats[0], choosing.maps.under[0] = 50, 2
        counts[choosing.choose((0, 0), (0, 0))[1][0]] += 1
    close(counts / DRAWS, expected([1.0, 1.0, None], 1))


def test_commands_and_use():
    choosing = Choosing([FIRST, SECOND, OTHER])
    for _ in range(200):
        a, driver = choosing.choose((2, 1), (0, 0))
        assert a[2:].tolist() == [driver[0] == 0, driver[0] == 1, driver[1] == 2]
        assert driver[0] != 0 or a[0] == 2
        assert driver[0] != 1 or a[0] == 1
        assert driver[1] != 2 or a[1] == 0


@pytest.fixture
def chain():
    """A module whose action is to use the first one, and one that uses that."""
    uses = module(1, 2, 0, [[1, 1], [0, 1]], [[1.0, 1.0], [1.0, 1.0]])
    uses_that = module(0, 3, 0, [[1, 1, 1], [1, 0, OFFERS_NOTHING]], [[2.0] * 3, [2.0] * 3])
    return Choosing([FIRST, uses, uses_that])


def test_a_module_that_uses_another_drives_its_joint(chain):
    assert chain.maps.joint[:3].tolist() == [0, 0, 0]
    assert chain.maps.uses[:3].tolist() == [NOBODY, 0, 1]
    drove = set()
    for _ in range(200):
        a, driver = chain.choose((2, 0), (0, 0))
        drove.add(driver[0])
        in_use = {0: [1, 0, 0], 1: [1, 1, 0], 2: [1, 1, 1], 3: [0, 0, 0]}[driver[0]]
        assert a[2:].tolist() == in_use
        assert driver[0] == 3 or a[0] == 2  # what the first one says under s0 = 2, r1 = 0
    assert drove == {0, 1, 2, 3}


@pytest.mark.parametrize(
    ("s", "r", "reliabilities"),
    [
        ((2, 0), (0, 0), (2.0, 1.0, 2.0)),
        ((2, 0), (1, 0), (2.0, None, None)),  # better not to use that one; nothing
        ((0, 0), (1, 0), (1.0, None, None)),  # through one that says: better not
        ((1, 1), (1, 0), (0.5, 1.0, None)),  # better not
        ((1, 1), (0, 1), (None, None, None)),  # the first one has nothing to offer to any of them
    ],
)
def test_a_module_offers_what_the_one_that_it_uses_offers(chain, s, r, reliabilities):
    close(chain.frequencies(s, r), expected([*reliabilities, 1.0, None], 3))


@dataclass(frozen=True)
class Given:
    """A reactive module that gives a table as it is."""

    given: ReactiveTable

    def table(self, variables):
        return self.given


def test_reactive_odds():
    odds = np.array([[0.5, 0.2, 0.0, 0.3], [0, 0, 0, 1.0], [1.0, 0, 0, 0]])
    reactive = [Given(ReactiveTable("a0", "s0", odds, 1.0)), RandomModule("a1")]
    choosing = Choosing([], reactive=reactive)
    for s in range(3):
        drawn = np.array([choosing.choose((s, 0), (0, 0))[0] for _ in range(DRAWS)])
        close(np.bincount(drawn[:, 0], minlength=4) / DRAWS, odds[s])
        close(np.bincount(drawn[:, 1], minlength=2) / DRAWS, np.array([0.5, 0.5]))


@pytest.mark.parametrize(
    ("reactive", "words"),
    [
        ([RandomModule("a0")], ("a1", "reactive")),
        ([Given(ReactiveTable("a0", "s0", np.full((2, 4), 0.25), 1.0))], ("(3, 4)", "(2, 4)")),
        ([Given(ReactiveTable("tail", "s0", np.full((3, 4), 0.25), 1.0))], ("tail", "a0")),
        ([Given(ReactiveTable("a0", "nose", np.full((3, 4), 0.25), 1.0))], ("nose", "s0")),
    ],
)
def test_tables_that_do_not_fit(reactive, words):
    with pytest.raises(ConfigError) as refused:
        flat_maps(WORLD, [], [module.table(WORLD) for module in reactive], SelectorConfig())
    for word in words:
        assert word in str(refused.value)


@pytest.mark.parametrize("options", [{"habituates": "asleep"}, {"habituation": -1.0}, {"habituation": float("nan")}])
def test_impossible_options(options):
    ((name, value),) = options.items()
    with pytest.raises(ConfigError, match=name) as refused:
        SelectorConfig(**options)
    assert str(value) in str(refused.value)
