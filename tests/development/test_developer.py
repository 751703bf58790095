"""The agent of chapter 5 in worlds that it has never heard of: what it remembers, finds and makes of it."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from numba import typeof
from numba.core.typing.typeof import Purpose, _TypeofContext
from numba.extending import typeof_impl
from worlds import contingency, joint_counts, variables

from jointattn_mj.contingency.online.counts import ALONE, OF_ACTION, OF_SENSOR, OFFSET, OWN, joint_table
from jointattn_mj.contingency.online.detector import DetectorConfig
from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.online.modules import make_module
from jointattn_mj.contingency.online.reactive import CuriousModule, RandomModule
from jointattn_mj.development.agent import FADED, Developer, DeveloperConfig
from jointattn_mj.errors import ConfigError, SeriesError

HASTY = DeveloperConfig(
    detector=DetectorConfig(warm_up=100, hold=3, threshold=5e-3, modelled="drop"), horizon=150, most_modules=3
)


class Doors:
    """Each turn a light shows which door leads out; the result says whether the one that was tried did."""

    def __init__(self, doors=3, noise=0.0, seed=0, result=lambda light, door: light == door):
        self.variables = variables([doors, 2], [doors, 2], [2, 2])
        self._doors, self._noise, self._random, self._result = doors, noise, np.random.default_rng(seed), result
        self._light = 0

    def step(self, door=0, *_):
        """Observables s and r after an action."""
        opened = self._result(self._light, door) ^ (self._random.random() < self._noise)
        self._light = int(self._random.integers(self._doors))
        noise = self._random.integers(0, 2, 2)
        return np.array([self._light, noise[0]]), np.array([int(opened), noise[1]])


class Diary:
    """What an agent observed and did, S_Pi and A_Pi included, as if all variables had been there from the start."""

    def __init__(self, config, n_steps, world=None, seed=1):
        world = world or Doors(noise=0.2)
        self.agent = Developer(world.variables, config, seed)
        self.born = {event: 0 for event in self.agent.events}
        rows, a = [], (0, 0)
        for step in range(n_steps):
            s, r = world.step(*a)
            a = self.agent.act(s, r)
            rows.append((self.agent.state.s.copy(), self.agent.state.a.copy(), self.agent.state.r.copy()))
            for event in self.agent.events:
                self.born.setdefault(event, step)
        self.n_steps = n_steps
        self.series = tuple(
            np.array([np.pad(row[part], (0, width - len(row[part]))) for row in rows])
            for part, width in enumerate((len(self.agent.state.s), len(self.agent.state.a), len(self.agent.state.r)))
        )

    def check(self, weigh):
        """Every table, and every measure, against the diary with weights ``weigh(transitions, born)``."""
        counts, transitions = self.agent.state.counts, np.arange(self.n_steps - 1)
        unit = self.agent.state.past.weight[0]
        parts = counts.sums[counts.of_event]
        for number, event in enumerate(self.agent.events):
            weights = weigh(transitions, self.born[event])
            expected = joint_counts(self.series, self.agent.variables, event, weights)
            assert joint_table(counts, number) / unit == pytest.approx(expected, abs=1e-9), event
            n = counts.n[counts.of_event[number, OWN]]
            if n > 0:
                combined = parts[number, OWN] - parts[number, OF_ACTION]
                single = combined - parts[number, OF_SENSOR] + parts[number, ALONE]
                assert (combined / n, single / n) == pytest.approx(contingency(expected), abs=1e-10)
                base = 1 / np.log(2)
                assert self.agent.state.watch.values[number] == pytest.approx(base * single / n, abs=1e-12)


@pytest.mark.parametrize(("n_steps", "modules"), [(90, 0), (900, 3)])
def test_memory_whole(n_steps, modules):
    diary = Diary(HASTY, n_steps)
    diary.check(lambda t, initial: (t >= initial).astype(float))
    assert len(diary.agent.modules) == modules


@pytest.mark.parametrize("n_steps", [400, 900])
def test_history_full(n_steps):
    """As in a life in which the variables of all modules had existed from the beginning."""
    diary = Diary(replace(HASTY, history="full"), n_steps)
    diary.check(lambda t, initial: np.ones(len(t)))
    assert diary.agent.modules


@pytest.mark.parametrize("n_steps", [400, 900])
def test_memory_reset(n_steps):
    diary = Diary(replace(HASTY, memory="reset"), n_steps)
    last = max(diary.born.values())
    assert last > 0
    diary.check(lambda t, initial: (t >= last).astype(float))


@pytest.mark.parametrize("n_steps", [140, 151, 152, 400, 900])
def test_memory_window(n_steps):
    diary = Diary(replace(HASTY, memory="window"), n_steps)
    diary.check(lambda t, initial: (t >= max(initial, len(t) - 150)).astype(float))
    assert n_steps < 900 or diary.agent.modules


@pytest.mark.parametrize("n_steps", [150, 1000])
def test_memory_fading(n_steps):
    patient = replace(HASTY.detector, threshold=0.05)
    diary = Diary(replace(HASTY, memory="fading", horizon=40, detector=patient), n_steps)
    diary.check(lambda t, initial: np.where(t >= initial, np.exp((t - t[-1]) / 40), 0.0))
    assert (np.exp(n_steps / 40) > FADED > diary.agent.state.past.weight[0]) == (n_steps == 1000)
    assert n_steps < 1000 or diary.agent.modules


@pytest.mark.parametrize("options", [{}, *({"memory": kind} for kind in ("reset", "window", "fading"))], ids=str)
def test_all_agents_are_of_one_type(options):
    """Else compiled code would take what it is given for something else."""
    diary = Diary(replace(HASTY, refresh_every=50, **options), 300)
    other = Developer(variables([2], [2], [2]), DeveloperConfig(detector=DetectorConfig(stop_rule="confidence")), 0)
    stored = pickle.loads(pickle.dumps(diary.agent))
    known = typeof(other.state)
    for agent in (diary.agent.state, other.state, stored.state):
        assert typeof_impl.dispatch(tuple)(agent, _TypeofContext(Purpose.argument)) == known


def test_xor_is_found():
    """What no single variable says anything about."""
    world = Doors(doors=2, result=lambda light, door: light ^ door)
    config = DeveloperConfig(detector=DetectorConfig(stop_rule="confidence", correction="miller_madow"), most_modules=1)
    agent, a = Developer(world.variables, config, 0), (0, 0)
    for _ in range(300):
        a = agent.act(*world.step(*a))
    assert [module.event for module in agent.modules] == [Event(0, 0, 0)]


def test_what_is_found_is_used():
    """It goes through the door with the light more often than by chance, and tries others in between."""
    world = Doors(noise=0.1)
    config = DeveloperConfig(detector=DetectorConfig(stop_rule="confidence", correction="miller_madow"), most_modules=1)
    agent, a, opened = Developer(world.variables, config, 0), (0, 0), []
    for _ in range(1500):
        s, r = world.step(*a)
        opened.append(r[0])
        a = agent.act(s, r)
    (module,) = agent.modules
    assert module.event == Event(0, 0, 0)
    offered = module.command >= 0
    assert offered.sum() >= 5
    assert (module.command == [[0, 1, 2]] * 2)[offered].all()
    assert (module.expected[offered] == 1).all()
    assert np.mean(opened[:100]) < 0.5 < 0.6 < np.mean(opened[500:]) < 0.88
    assert agent.drivers() == ["module 1", "RandomModule", "RandomModule"]


def test_modules_stay_as_they_were_made_or_are_refreshed():
    made = Diary(HASTY, 600).agent
    refreshed = Diary(replace(HASTY, refresh_every=100), 600).agent
    for agent, now in ((made, False), (refreshed, True)):
        table = joint_table(agent.state.counts, agent.events.index(agent.modules[0].event))
        fresh = make_module(agent.modules[0].event, table, agent.config.reproduction)
        assert np.array_equal(fresh.saliency, agent.modules[0].saliency, equal_nan=True) == now
        assert agent.state.maps.reliability[: fresh.command.size] == pytest.approx(agent.modules[0].reliability.ravel())


def test_refreshing_does_not_rest_what_is_tired():
    world, agent = Doors(noise=0.2), Developer(Doors().variables, replace(HASTY, refresh_every=7), 1)
    a, tired = (0, 0), 0
    for _ in range(600):
        s, r = world.step(*a)
        before = agent.state.maps
        a = agent.act(s, r)
        after = agent.state.maps
        if after is not before and after.made == before.made:  # ``before`` chose, then made place for ``after``
            assert after.repeats.tolist() == before.repeats.tolist()
            assert after.under.tolist() == before.under.tolist()
            tired += before.repeats[: before.made].max()
    assert tired > 0


def test_stored_and_continued():
    world, agent = Doors(noise=0.2), Developer(Doors().variables, HASTY, 1)
    a, own, other = (0, 0), [], []
    for step in range(600):
        if step == 300:
            twin, twin_world, twin_a = pickle.loads(pickle.dumps((agent, world_state(world), a)))
        a = agent.act(*world.step(*a))
        own.append(tuple(a))
    twin_world = restored(twin_world)
    for _ in range(300, 600):
        twin_a = twin.act(*twin_world.step(*twin_a))
        other.append(tuple(twin_a))
    assert own[300:] == other


def world_state(world):
    return world._light, world._random


def restored(state):
    world = Doors(noise=0.2)
    world._light, world._random = state
    return world


def test_a_command_stays_what_it_was():
    world = Doors()
    agent = Developer(world.variables, HASTY, 0)
    first = agent.act(*world.step())
    kept = first.copy()
    for _ in range(20):
        agent.act(*world.step())
    assert first.tolist() == kept.tolist()


def test_observations_need_not_be_arrays():
    agent, twin = (Developer(Doors().variables, HASTY, 0) for _ in range(2))
    for _ in range(5):
        assert agent.act([1, 0], (True, False)).tolist() == twin.act(np.array([1, 0]), np.array([1, 0])).tolist()


@pytest.mark.parametrize(
    ("s", "r", "words"),
    [
        ([3, 0], [0, 0], ("s0 0 to 2", "3")),
        ([-1, 0], [0, 0], ("s0", "-1")),
        ([0], [0, 0], ("s1", "[0]")),
        ([0, 0], [0, 2], ("r1 0 to 1", "2")),
        ([0.5, 0], [0, 0], ("whole", "0.5")),
        ([0, 0], [[0, 0]], ("r0", "[[0, 0]]")),
    ],
)
def test_observations_that_cannot_be(s, r, words):
    agent = Developer(Doors().variables, HASTY, 0)
    with pytest.raises(SeriesError) as refused:
        agent.act(s, r)
    for word in words:
        assert word in str(refused.value)
    assert agent.state.n_steps[0] == 0


def test_joints_without_a_reactive_module_move_at_random():
    agent = Developer(Doors().variables, HASTY, 0, [RandomModule("a1", trust=3.0)])
    assert [module.joint for module in agent.reactive] == ["a1", "a0"]
    with pytest.raises(ConfigError, match="tail"):
        Developer(Doors().variables, HASTY, 0, [RandomModule("tail")])


@pytest.mark.parametrize("part", range(3))
def test_more_values_than_steps_are_kept_with(part):
    sizes = [[2, 2], [2, 2], [2, 2]]
    sizes[part] = [2, 128]
    keeps = DeveloperConfig(DetectorConfig(stop_rule="local"))
    with pytest.raises(ConfigError, match="at most 127 values each; got 128 values of "):
        Developer(variables(*sizes), keeps)
    with pytest.raises(ConfigError, match="at most 127 values"):
        Developer(variables(*sizes), DeveloperConfig(), 0, [CuriousModule("a0")])


BAD = [
    ({"memory": "long"}, ("memory", "long")),
    ({"history": "never"}, ("history", "never")),
    ({"horizon": 1}, ("horizon", "1")),
    ({"refresh_every": -1}, ("refresh_every", "-1")),
    ({"most_modules": -1}, ("most_modules", "-1")),
    ({"memory": "fading", "detector": DetectorConfig(stop_rule="confidence")}, ("fading", "confidence")),
    ({"memory": "fading", "detector": DetectorConfig(correction="miller_madow")}, ("fading", "correction")),
    ({"memory": "window", "history": "full"}, ("full", "window")),
    ({"detector": DetectorConfig(stop_rule="local", measure="tc")}, ("local", "measure sac", "got tc")),
    ({"detector": DetectorConfig(stop_rule="local", correction="miller_madow")}, ("correction none", "miller_madow")),
    ({"detector": DetectorConfig(stop_rule="local"), "history": "full"}, ("history since_creation", "full")),
]


@pytest.mark.parametrize(("options", "words"), BAD, ids=str)
def test_impossible_options(options, words):
    with pytest.raises(ConfigError) as refused:
        DeveloperConfig(**options)
    for word in words:
        assert word in str(refused.value)


@pytest.mark.parametrize("memory", ["whole", "window", "fading"])
@pytest.mark.parametrize("tampered", ["entries", "n"])
def test_counts_of_a_restored_agent_add_up(memory, tampered):
    """Compiled code looks up what a count adds, and would look beyond the end of the list."""
    agent = Diary(replace(HASTY, memory=memory), 120).agent
    copy = pickle.loads(pickle.dumps(agent))
    assert np.array_equal(copy.state.counts.entries, agent.state.counts.entries)
    own = agent.state.counts.of_event[0, OWN]
    begin = agent.state.counts.layout[own, OFFSET]
    if tampered == "entries":
        agent.state.counts.entries[begin + 1] = 1e9
    else:
        agent.state.counts.n[own] = -1e9
    if memory == "fading":  # with logarithms, and no list
        pickle.loads(pickle.dumps(agent))
    else:
        with pytest.raises(ValueError, match="do not add up" if memory == "whole" else "others than"):
            pickle.loads(pickle.dumps(agent))
