"""The mind of chapter 5 (Fig. 5.1): finds what is contingent, makes a module that reproduces it, and goes on.

It knows the names and values of its variables and nothing of the world behind them: each turn it observes sensors and
results, (S, R), and chooses actions, A.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np

from jointattn_mj.contingency.online.counts import (
    Counts,
    add,
    divide,
    empty_counts,
    joined,
    joint_table,
    set_joint_table,
)
from jointattn_mj.contingency.online.detector import NOTHING, DetectorConfig, Watch, grown, look, new_watch
from jointattn_mj.contingency.online.events import Event, Variable, Variables
from jointattn_mj.contingency.online.modules import Module, ReproductionConfig, make_module
from jointattn_mj.contingency.online.reactive import RandomModule, ReactiveModule
from jointattn_mj.contingency.online.selector import NOBODY, Maps, SelectorConfig, flat_maps, select
from jointattn_mj.development.one_type import one_type
from jointattn_mj.development.restored_agent import check_agent, check_module
from jointattn_mj.errors import ConfigError, SeriesError
from jointattn_mj.guards.finite import check_finite
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked, Whole


@dataclass(frozen=True)
class DeveloperConfig(Checked):
    """Everything that the mind of chapter 5 leaves open."""

    detector: DetectorConfig = field(default_factory=DetectorConfig)
    reproduction: ReproductionConfig = field(default_factory=ReproductionConfig)
    selector: SelectorConfig = field(default_factory=SelectorConfig)
    memory: Literal["whole", "reset", "window", "fading"] = "whole"
    """What the counts hold: ``whole``, everything; ``reset``, what has come since the last module was made, because
    with it the robot behaves differently, and old counts tell of a robot that is no more; ``window``, the last
    ``horizon`` transitions; ``fading``, older ones weigh less."""
    horizon: Annotated[int, Whole("[2, 1e10]")] = 20_000
    """Memory window: transitions; memory fading: after so many, a transition weighs 1/e."""
    history: Literal["since_creation", "full"] = "since_creation"
    """What the counts of a new module's variables begin with. ``since_creation``: nothing. ``full``: all steps before
    the module was made, as steps in which it was not used."""
    refresh_every: Annotated[int, Whole("[0, 1e10]")] = 0
    """Turns after which all maps are read off the counts anew; 0: a module's map stays as it was made. What a module
    does sinks in the counts while it is used, so that maps which follow them undo themselves."""
    most_modules: Annotated[int, Whole("[0, 127]")] = 20
    """Largest number of modules. The number of events grows with its square."""

    OLD_CHOICES: ClassVar[Mapping[str, Mapping[str, str]]] = {"history": {"made": "since_creation", "ever": "full"}}

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.memory == "fading" and (self.detector.stop_rule == "confidence" or self.detector.correction != "none"):
            raise ConfigError(
                "memory fading keeps weights, for which neither stop_rule confidence nor a correction is defined; "
                "choose memory window, or stop_rule convergence without correction"
            )
        if self.history == "full" and self.memory != "whole":
            raise ConfigError(f"history full needs memory whole; got {self.memory}")


class RecentSteps(NamedTuple):
    """Transitions that will have to be forgotten, in a ring."""

    s: np.ndarray
    a: np.ndarray
    r: np.ndarray
    r_next: np.ndarray
    contexts: np.ndarray
    """(horizon,) in how many contexts they were counted."""
    weight: np.ndarray
    """(2,) of the next transition, and by how much that grows each time; 1 where nothing fades."""


@one_type
class AgentState(NamedTuple):
    """What a turn needs, for compiled code."""

    counts: Counts
    watch: Watch
    maps: Maps
    past: RecentSteps
    forgets: bool
    """Whether ``past`` is needed."""
    s: np.ndarray
    """(sensors,) values now, S_Pi included."""
    r: np.ndarray
    a: np.ndarray
    """(actions,) A_Pi included."""
    driver: np.ndarray
    """(joints,) which module drives each."""
    strength: np.ndarray
    """Working space (modules,)."""
    n_steps: np.ndarray
    """(1,) turns so far."""
    random: np.random.Generator


FADED = 1e9
"""A weight that has grown so large is made 1 again, and all counts with it."""


@njit(cache=True, forceinline=True)
def _copy(values, to):
    """As slices, numba would compile them together with messages about every shape that does not fit."""
    for location in range(len(values)):
        to[location] = values[location]


@njit(cache=True)
def _remember_for_a_while(state, r_next):
    """Count the transition from the turn before to this one, and let older ones fade or take the oldest out."""
    counts, past = state.counts, state.past
    contexts = len(counts.contexts)
    if past.weight[1] != 1.0:
        past.weight[0] *= past.weight[1]
        add(counts, state.s, state.a, state.r, r_next, past.weight[0], contexts)
        if past.weight[0] > FADED:
            divide(counts, past.weight[0])
            past.weight[0] = 1.0
        return
    location = (state.n_steps[0] - 1) % len(past.contexts)
    if past.contexts[location] > 0:
        add(
            counts,
            past.s[location],
            past.a[location],
            past.r[location],
            past.r_next[location],
            -1,
            past.contexts[location],
        )
    add(counts, state.s, state.a, state.r, r_next, 1, contexts)
    _copy(state.s, past.s[location])
    _copy(state.a, past.a[location])
    _copy(state.r, past.r[location])
    _copy(r_next, past.r_next[location])
    past.contexts[location] = contexts


@njit(cache=True, forceinline=True)
def think(state, s, r):
    """A turn: learn from what has come of the last one, then choose ``state.a``.

    Args:
        mind: Changed in place.
        s: Observed values of the world's sensors, without S_Pi.
        r: Observed values (results,).

    Returns:
        Number of the event that was just found to be contingent, or NOTHING.
    """
    found = NOTHING
    if state.n_steps[0] > 0:
        if state.forgets:
            _remember_for_a_while(state, r)
        else:
            add(state.counts, state.s, state.a, state.r, r, 1, len(state.counts.contexts))
        found = look(state.watch, state.counts)
    state.n_steps[0] += 1
    _copy(s, state.s)
    _copy(state.a[len(state.driver) :], state.s[len(s) :])
    _copy(r, state.r)
    select(state.maps, state.s, state.r, state.random, state.strength, state.a, state.driver)
    return found


class Developer:
    """A mind and its modules; grows by a module whenever the detector finds something."""

    def __init__(
        self,
        variables: Variables,
        config: DeveloperConfig = DeveloperConfig(),
        seed: np.random.SeedSequence | int = 0,
        reactive: Sequence[ReactiveModule] = (),
    ):
        """``reactive``: what the robot is born with, for one joint or more; a joint without any moves at random."""
        self.config, self.variables = config, variables
        self.events = list(variables.events())
        self.modules: list[Module] = []
        self.reactive = list(reactive)
        served = {module.table(variables).joint for module in self.reactive}
        self.reactive += [RandomModule(joint.name) for joint in variables.joints if joint.name not in served]
        joints = len(variables.joints)
        maps = flat_maps(variables, [], self.reactive, config.selector)
        self.state = AgentState(
            counts=empty_counts(variables, self.events),
            watch=new_watch(config.detector, len(self.events)),
            maps=maps,
            past=self._empty_past(),
            forgets=config.memory in ("window", "fading"),
            s=np.zeros(len(variables.sensors), np.int64),
            r=np.zeros(len(variables.results), np.int64),
            a=np.zeros(joints, np.int64),
            driver=np.full(joints, NOBODY, np.int64),
            strength=np.zeros(len(maps.joint)),
            n_steps=np.zeros(1, np.int64),
            random=np.random.default_rng(seed),
        )

    def act(self, s: np.ndarray, r: np.ndarray) -> np.ndarray:
        """Observe ``s`` (sensors,) and ``r`` (results,), and choose commands (joints,).

        Raises:
            SeriesError: An observation is no position among the values of its variable, or one is missing.
        """
        variables = self.variables
        sensors = variables.sensors[: len(variables.sensors) - variables.modules]
        self.take_in(think(self.state, _observed(s, sensors), _observed(r, variables.results)))
        return self.state.a[: len(self.state.driver)].copy()

    def take_in(self, found: int) -> Module | None:
        """What follows a turn: a module for the event of number ``found``, unless that is NOTHING; maps made anew."""
        every = self.config.refresh_every
        if every and self.modules and self.state.n_steps[0] % every == 0:
            self._set_modules([self._module(module.event) for module in self.modules])
        if found == NOTHING:
            return None
        if len(self.modules) >= self.config.most_modules:
            self.state.watch.modelled[found] = True
            return None
        made = self._module(self.events[found])
        self._grow(found, made)
        return made

    def check(self) -> None:
        """Go on only with finite numbers.

        Raises:
            NotFiniteError: Counts, measures or maps hold NaN or infinity.
        """
        counts, maps = self.state.counts, self.state.maps
        check_finite(
            {
                "counts": counts.cells,
                "sums of counts": counts.contexts["sum"],
                "contingency": self.state.watch.values,
                "reliability": maps.reliability,
                "odds": maps.odds,
                "trust": maps.trust,
            }
        )

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a mind.

        Raises:
            ValueError: It is none that compiled code can live with.
        """
        self.__dict__.update(state)
        check_agent(self.state, self._unlived().state, self.variables)

    def _unlived(self) -> "Developer":
        """A mind of the same variables and modules that has lived nothing."""
        other = Developer(self.variables.without_modules(), self.config, 0, self.reactive)
        for module in self.modules:
            check_module(module, other.variables)
            other._grow(other.events.index(module.event), module)
        if (other.variables, other.events) != (self.variables, self.events):
            raise ValueError("the mind's events are others than those of its modules")
        return other

    def drivers(self) -> list[str]:
        """Names of all modules, in the order that ``state.driver`` counts them in."""
        made = [f"module {number}" for number in range(1, len(self.modules) + 1)]
        return made + [type(module).__name__ for module in self.reactive]

    def _module(self, event: Event) -> Module:
        table = joint_table(self.state.counts, self.events.index(event))
        return make_module(event, table, self.config.reproduction)

    def _grow(self, found: int, made: Module) -> None:
        """Add a module, its two variables, and all events with them."""
        state, config = self.state, self.config
        self.variables = self.variables.with_module(f"module {len(self.modules) + 1}")
        known = set(self.events)
        new = [event for event in self.variables.events() if event not in known]
        self.events += new
        anew = config.memory == "reset"
        if anew:
            counts = empty_counts(self.variables, self.events)
        else:
            counts = joined(state.counts, empty_counts(self.variables, new))
        if config.history == "full":
            for event in new:
                set_joint_table(counts, self.events.index(event), self._unused(event))
        self.state = state._replace(
            counts=counts,
            watch=grown(state.watch, len(self.events), found, anew),
            past=self._wider(state.past),
            s=np.append(state.s, 0),
            a=np.append(state.a, 0),
            driver=np.where(state.driver >= len(self.modules), state.driver + 1, state.driver),
        )
        self._set_modules([*self.modules, made])

    def _set_modules(self, modules: list[Module]) -> None:
        """Let the selector choose among these; those that it knew keep their habituation."""
        old, known = self.state.maps, len(self.modules)
        maps = flat_maps(self.variables, modules, self.reactive, self.config.selector)
        maps.repeats[:known], maps.under[:known] = old.repeats[:known], old.under[:known]
        self.modules = modules
        self.state = self.state._replace(maps=maps, strength=np.zeros(len(maps.joint)))

    def _unused(self, event: Event) -> np.ndarray:
        """Counts (R, S, A, R') of a new event, had its module's variables been there, and 0, from the beginning."""
        sensors, actions = len(self.variables.sensors) - 1, len(self.variables.actions) - 1
        alike = Event(
            event.sensor if event.sensor < sensors else 0, event.action if event.action < actions else 0, event.result
        )
        table = joint_table(self.state.counts, self.events.index(alike))
        for axis, is_new in ((1, event.sensor == sensors), (2, event.action == actions)):
            if is_new:
                table = table.sum(axis, keepdims=True)
                table = np.concatenate([table, np.zeros_like(table)], axis)
        return table

    def _empty_past(self) -> RecentSteps:
        config, variables = self.config, self.variables
        horizon = config.horizon if config.memory == "window" else 0
        grows = np.exp(1 / config.horizon) if config.memory == "fading" else 1.0
        widths = (len(variables.sensors), len(variables.actions), len(variables.results), len(variables.results))
        s, a, r, r_next = (np.zeros((horizon, width), np.int64) for width in widths)
        return RecentSteps(s, a, r, r_next, contexts=np.zeros(horizon, np.int64), weight=np.array([1.0, grows]))

    def _wider(self, past: RecentSteps) -> RecentSteps:
        """The ring with room for one more sensor and one more action."""
        blank = np.zeros((len(past.contexts), 1), np.int64)
        return past._replace(s=np.hstack([past.s, blank]), a=np.hstack([past.a, blank]))


def _observed(values: np.ndarray, variables: Sequence[Variable]) -> np.ndarray:
    """The observations for compiled code, which would look them up anywhere."""
    try:
        codes = np.asarray(values)
    except ValueError:  # lists of unequal lengths
        codes = np.array(values, object)
    sizes = np.array([len(variable.values) for variable in variables])
    if codes.shape != sizes.shape or codes.dtype.kind not in "biu" or (codes < 0).any() or (codes >= sizes).any():
        wanted = ", ".join(f"{variable.name} 0 to {len(variable.values) - 1}" for variable in variables)
        raise SeriesError(f"a turn needs whole numbers for {wanted}; got {codes.tolist()}")
    return codes.astype(np.int64)
