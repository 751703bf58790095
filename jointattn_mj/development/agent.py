"""The agent of chapter 5 (Fig. 5.1): finds a contingent event, makes a module that reproduces it, and goes on.

Its parts are in ``contingency.online``: counts of all events (``counts``), contingency detector (``detector``),
contingency reproduction modules and their maps (``modules``), reactive modules (``reactive``) and module selector
(``selector``). In each step the agent observes sensors and results, (S, R), and chooses actions, A. It knows the names
and values of its variables, and nothing of the world behind them.
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
from jointattn_mj.contingency.online.detector import NOTHING, DetectorConfig, Watch, grown, new_watch, update
from jointattn_mj.contingency.online.events import Event, Variable, Variables
from jointattn_mj.contingency.online.experience import (
    Experience,
    PastSteps,
    check_kept,
    empty_experience,
    keep,
    roomier,
)
from jointattn_mj.contingency.online.local import LocalConfig
from jointattn_mj.contingency.online.modules import Module, ReproductionConfig, make_module
from jointattn_mj.contingency.online.reactive import RandomModule, ReactiveModule, learns
from jointattn_mj.contingency.online.selector import NOBODY, Maps, SelectorConfig, flat_maps, select
from jointattn_mj.development.looks import Looks
from jointattn_mj.development.one_type import one_type
from jointattn_mj.development.restored_agent import check_agent, check_module
from jointattn_mj.errors import ConfigError, SeriesError
from jointattn_mj.guards.finite import check_finite
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked, Whole


@dataclass(frozen=True)
class DeveloperConfig(Checked):
    """Settings of the agent of chapter 5."""

    detector: DetectorConfig = field(default_factory=DetectorConfig)
    local: LocalConfig = field(default_factory=LocalConfig)
    """Stop rule local: how it ranks events, and what an agent with it does at its looks."""
    reproduction: ReproductionConfig = field(default_factory=ReproductionConfig)
    selector: SelectorConfig = field(default_factory=SelectorConfig)
    memory: Literal["whole", "reset", "window", "fading"] = "whole"
    """Which transitions the counts hold. ``whole``: all. ``reset``: those since the last module was made, which changed
    the robot's behaviour. ``window``: the last ``horizon``. ``fading``: all, older ones with less weight. Stop rule
    local knows the first and the third."""
    horizon: Annotated[int, Whole("[2, 1e10]")] = 20_000
    """Memory window: how many transitions; memory fading: transitions after which the weight is 1/e."""
    history: Literal["since_creation", "full"] = "since_creation"
    """What the counts of a new module's variables begin with. ``since_creation``: nothing. ``full``: all steps before
    the module was made, as steps in which it was not used."""
    refresh_every: Annotated[int, Whole("[0, 1e10]")] = 0
    """Steps after which all maps are made anew from the counts; 0: a module's map stays as it was made. While a module
    is used, its behaviour lowers its event's saliency, so that maps which follow the counts undo themselves."""
    most_modules: Annotated[int, Whole("[0, 127]")] = 20
    """Largest number of modules. The number of events grows with its square."""

    OLD_CHOICES: ClassVar[Mapping[str, Mapping[str, str]]] = {"history": {"made": "since_creation", "ever": "full"}}

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.detector.stop_rule == "local":
            self._check_local()
        if self.memory == "fading" and (self.detector.stop_rule == "confidence" or self.detector.correction != "none"):
            raise ConfigError(
                "memory fading keeps weights, for which neither stop_rule confidence nor a correction is defined; "
                "choose memory window, or stop_rule convergence without correction"
            )
        if self.history == "full" and self.memory != "whole":
            raise ConfigError(f"history full needs memory whole; got {self.memory}")

    def _check_local(self) -> None:
        """Refuse options that have no meaning with stop rule local."""
        if self.memory not in ("whole", "window") or self.refresh_every:
            raise ConfigError(
                "stop_rule local keeps steps and reads maps anew at its own looks: it needs memory whole or window, "
                f"and refresh_every 0; got {self.memory} and {self.refresh_every}"
            )
        given = self.detector.measure, self.detector.correction, self.history
        if given != ("sac", "none", "since_creation"):
            raise ConfigError(
                "stop_rule local has a measure of its own, with a posterior in place of a correction, and counts steps "
                "anew: it needs measure sac, correction none and history since_creation; got "
                f"{given[0]}, {given[1]} and {given[2]}"
            )


class RecentSteps(NamedTuple):
    """Ring buffer of transitions that will be taken out of the counts again."""

    s: np.ndarray
    a: np.ndarray
    r: np.ndarray
    r_next: np.ndarray
    contexts: np.ndarray
    """(horizon,) number of contexts in which each was counted."""
    weight: np.ndarray
    """(2,) weight of the next transition, and its growth factor; 1 where nothing fades."""


@one_type
class AgentState(NamedTuple):
    """State of the agent, for compiled code."""

    counts: Counts
    watch: Watch
    maps: Maps
    past: RecentSteps
    forgets: bool
    """Whether old transitions lose their weight (memory window or fading)."""
    counting: bool
    """Whether counts and detector follow every step; not with stop rule local, which counts at its looks."""
    keeping: bool
    """Whether all steps are kept."""
    experience: Experience
    """The steps that are kept."""
    s: np.ndarray
    """(sensors,) values in this step, S_Pi of the modules included."""
    r: np.ndarray
    """(results,) values in this step."""
    a: np.ndarray
    """(actions,) commands of the joints, then A_Pi of the modules."""
    driver: np.ndarray
    """(joints,) module that drives each joint."""
    strength: np.ndarray
    """(modules,) working space of the selector."""
    n_steps: np.ndarray
    """(1,) steps so far."""
    random: np.random.Generator


FADED = 1e9
"""Memory fading: when the weight exceeds this, it becomes 1 again and all counts are divided by it."""


@njit(cache=True, borrows=True, forceinline=True)
def _copy(values: np.ndarray, to: np.ndarray) -> None:
    """Copy into the first elements of ``to``."""
    for i in range(len(values)):
        to[i] = values[i]


@njit(cache=True, borrows=True)
def _remember_for_a_while(state: AgentState, r_next: np.ndarray) -> None:
    """Count the last transition, and let older ones fade or take the oldest out."""
    counts, past = state.counts, state.past
    contexts = len(counts.layout)
    if past.weight[1] != 1.0:
        past.weight[0] *= past.weight[1]
        add(counts, state.s, state.a, state.r, r_next, past.weight[0], contexts)
        if past.weight[0] > FADED:
            divide(counts, past.weight[0])
            past.weight[0] = 1.0
        return
    slot = (state.n_steps[0] - 1) % len(past.contexts)
    if past.contexts[slot] > 0:
        add(counts, past.s[slot], past.a[slot], past.r[slot], past.r_next[slot], -1, past.contexts[slot])
    add(counts, state.s, state.a, state.r, r_next, 1, contexts)
    _copy(state.s, past.s[slot])
    _copy(state.a, past.a[slot])
    _copy(state.r, past.r[slot])
    _copy(r_next, past.r_next[slot])
    past.contexts[slot] = contexts


@njit(cache=True, borrows=True, forceinline=True)
def think(state: AgentState, s: np.ndarray, r: np.ndarray) -> int:
    """A step: count the last transition, look for a contingent event, then choose ``state.a``.

    Args:
        state: Changed in place.
        s: (sensors,) observed values of the world's sensors, without S_Pi.
        r: (results,) observed values.

    Returns:
        Number of the event that was just found to be contingent, or NOTHING.
    """
    event = count(state, r)
    choose(state, s, r)
    return event


@njit(cache=True, borrows=True)
def count(state: AgentState, r: np.ndarray) -> int:
    """Count the last transition, which led to the results ``r`` (results,), and look for a contingent event.

    Returns:
        Number of the event that was just found to be contingent, or NOTHING.
    """
    if state.n_steps[0] == 0 or not state.counting:
        return NOTHING
    if state.forgets:
        _remember_for_a_while(state, r)
    else:
        add(state.counts, state.s, state.a, state.r, r, 1, len(state.counts.layout))
    return update(state.watch, state.counts)


@njit(cache=True, borrows=True, forceinline=True)
def choose(state: AgentState, s: np.ndarray, r: np.ndarray) -> None:
    """A step without what ``think`` counts: take the observations over, and choose ``state.a``.

    Args:
        state: Changed in place.
        s: (sensors,) observed values of the world's sensors, without S_Pi.
        r: (results,) observed values.
    """
    state.n_steps[0] += 1
    _copy(s, state.s)
    _copy(state.a[len(state.driver) :], state.s[len(s) :])
    _copy(r, state.r)
    select(state.maps, state.s, state.r, state.random, state.strength, state.a, state.driver)
    if state.keeping:
        keep(state.experience, state.n_steps[0] - 1, state.s, state.a, state.r)


class Developer:
    """The agent: its variables, its modules, and the state that compiled code changes in every step.

    Attributes:
        variables: What it senses and does, variables of its modules included.
        events: All (S, A, R) that the detector ranks.
        modules: Contingency reproduction modules, in the order in which they were made.
        reactive: Reactive modules, one or more for each joint.
        state: Counts, detector, maps and current values.
    """

    def __init__(
        self,
        variables: Variables,
        config: DeveloperConfig = DeveloperConfig(),
        seed: np.random.SeedSequence | int = 0,
        reactive: Sequence[ReactiveModule] = (),
    ):
        """An agent before its first step.

        Args:
            variables: What it senses and does.
            config: Settings of detector, modules and selector.
            seed: Of the selector.
            reactive: Initial modules; a joint without any moves at random.

        Raises:
            ConfigError: A variable has more values than steps are kept with.
        """
        self.config, self.variables = config, variables
        self.local = config.detector.stop_rule == "local"
        self.events = list(variables.events(of_joints=self.local))
        self.modules: list[Module] = []
        self.reactive = list(reactive)
        served = {module.table(variables).joint for module in self.reactive}
        self.reactive += [RandomModule(joint.name) for joint in variables.joints if joint.name not in served]
        joints, results = len(variables.joints), len(variables.results)
        self._tables = [module.table(variables) for module in self.reactive]
        keeping = self.local or any(learns(module) for module in self.reactive)
        if keeping:
            check_kept(variables)
        sequence = seed if isinstance(seed, np.random.SeedSequence) else np.random.SeedSequence(seed)
        self._looks = Looks(config.local)
        rows = (self._window or self._looks.next) if keeping else 0
        maps = flat_maps(variables, [], self._tables, config.selector)
        self.state = AgentState(
            counts=empty_counts(variables, [] if self.local else self.events),
            watch=new_watch(config.detector, len(self.events)),
            maps=maps,
            past=self._empty_past(),
            forgets=config.memory in ("window", "fading") and not self.local,
            counting=not self.local,
            keeping=keeping,
            experience=empty_experience(rows, len(variables.sensors), len(variables.actions), results),
            s=np.zeros(len(variables.sensors), np.int64),
            r=np.zeros(results, np.int64),
            a=np.zeros(joints, np.int64),
            driver=np.full(joints, NOBODY, np.int64),
            strength=np.zeros(len(maps.joint)),
            n_steps=np.zeros(1, np.int64),
            random=np.random.default_rng(sequence),
        )

    def act(self, s: np.ndarray, r: np.ndarray) -> np.ndarray:
        """A step: observe, learn, and choose.

        Args:
            s: (sensors,) values of the world's sensors, as positions among their values.
            r: (results,) values of the results.

        Returns:
            (joints,) commands.

        Raises:
            SeriesError: An observation is no position among the values of its variable, or one is missing.
        """
        variables = self.variables
        sensors = variables.sensors[: len(variables.sensors) - variables.modules]
        self.take_in(self.looked(think(self.state, _observed(s, sensors), _observed(r, variables.results))))
        return self.state.a[: len(self.state.driver)].copy()

    @property
    def _window(self) -> int | None:
        """How many of the last steps are kept whole; None for all."""
        return int(self.config.horizon) if self.local and self.config.memory == "window" else None

    @property
    def next_pause(self) -> int | None:
        """Number of steps after which the agent has something to do between two steps; None for never."""
        every, pauses = self.config.refresh_every, list[int]()
        if self.state.keeping:
            pauses.append(self._looks.next)
        if every and not self.local:
            pauses.append((int(self.state.n_steps[0]) // every + 1) * every)
        return min(pauses, default=None)

    def looked(self, event: int) -> int:
        """Look back over all steps where that is due.

        Args:
            event: Number of the event that was found in the last step, or NOTHING.

        Returns:
            Number of the event that is found, or NOTHING.
        """
        n_steps = int(self.state.n_steps[0])
        if not self.state.keeping or n_steps < self._looks.next:
            return event
        steps = self.steps()
        self._tables = [
            module.learned(self.variables, steps) if learns(module) else table
            for module, table in zip(self.reactive, self._tables, strict=True)
        ]
        modules = self.modules
        if self.local:
            modules = self._looks.followed(steps, self.modules)
            event, values = self._looks.find(steps, self.events, modules, self.state.watch.modelled)
            self.state.watch.values[:] = values / np.log(self.config.detector.base)
        self._set_modules(modules)
        self._looks.postpone(n_steps)
        widths, rows = (len(self.variables.sensors), len(self.variables.actions)), self._window or self._looks.next
        self.state = self.state._replace(experience=roomier(self.state.experience, rows, *widths))
        return event

    def take_in(self, event: int) -> Module | None:
        """Make maps anew where that is due, and a module of the event of number ``event``, unless it is NOTHING.

        Returns:
            The new module; None where there is none.
        """
        every = self.config.refresh_every
        if every and not self.local and self.modules and self.state.n_steps[0] % every == 0:
            self._set_modules([self._module(module.event) for module in self.modules])
        if event == NOTHING:
            return None
        if len(self.modules) >= self.config.most_modules:
            self.state.watch.modelled[event] = True
            return None
        made = self._module(self.events[event])
        self._grow(event, made)
        return made

    def steps(self, variables: Variables | None = None, modules: Sequence[Module] | None = None) -> PastSteps:
        """All steps that are kept, with what hindsight says of the use of modules.

        Args:
            variables: Those of another agent at the same joints and sensors, for its modules; None: its own.
            modules: Those of the other; None: its own.
        """
        n_steps, own = int(self.state.n_steps[0]), self.modules if self.local else []
        known = variables or self.variables
        widths = len(known.sensors), len(known.actions)
        experience = roomier(self.state.experience, 0, *widths)
        return self._looks.steps(experience, n_steps, known, own if modules is None else modules)

    def check(self) -> None:
        """Check that all numbers are finite.

        Raises:
            NotFiniteError: Counts, measures or maps hold NaN or infinity.
        """
        counts, maps = self.state.counts, self.state.maps
        check_finite(
            {
                "counts": counts.entries,
                "sums of counts": counts.sums,
                "contingency": self.state.watch.values,
                "reliability": maps.reliability,
                "odds": maps.odds,
                "trust": maps.trust,
            }
        )

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore an agent.

        Raises:
            ValueError: Compiled code cannot use it.
        """
        self.__dict__.update(state)
        self._looks.check(len(self.modules))
        check_agent(self.state, self._untrained().state, self.variables, self._window)
        if self.state.keeping and not self._window and len(self.state.experience.s) < self._looks.next:
            raise ValueError(f"there is no room for the steps until the next look, {self._looks.next}")
        flat_maps(self.variables, self.modules, self._tables, self.config.selector)

    def _untrained(self) -> "Developer":
        """A new agent with the same variables and modules."""
        other = Developer(self.variables.without_modules(), self.config, 0, self.reactive)
        for module in self.modules:
            check_module(module, other.variables)
            other._grow(other.events.index(module.event), module)
        if (other.variables, other.events) != (self.variables, self.events):
            raise ValueError("the agent's events are others than those of its modules")
        return other

    def drivers(self) -> list[str]:
        """Names of all modules, in the order in which ``state.driver`` numbers them."""
        made = [f"module {number}" for number in range(1, len(self.modules) + 1)]
        return made + [type(module).__name__ for module in self.reactive]

    def _module(self, event: Event) -> Module:
        if self.local:
            return self._looks.module(event, self.steps())
        table = joint_table(self.state.counts, self.events.index(event))
        return make_module(event, table, self.config.reproduction)

    def _grow(self, event: int, made: Module) -> None:
        """Add the module of an event (by its number), its two variables, and all events with them."""
        state, config = self.state, self.config
        self.variables = self.variables.with_module(f"module {len(self.modules) + 1}")
        known = set(self.events)
        new = [added for added in self.variables.events(of_joints=self.local) if added not in known]
        self.events += new
        self._looks.made_at.append(int(state.n_steps[0]))
        anew = config.memory == "reset"
        if self.local:
            counts = state.counts
        elif anew:
            counts = empty_counts(self.variables, self.events)
        else:
            counts = joined(state.counts, empty_counts(self.variables, new))
        if config.history == "full" and not self.local:
            for added in new:
                set_joint_table(counts, self.events.index(added), self._unused(added))
        self.state = state._replace(
            counts=counts,
            watch=grown(state.watch, len(self.events), event, anew),
            past=self._wider(state.past),
            experience=roomier(state.experience, 0, len(state.s) + 1, len(state.a) + 1),
            s=np.append(state.s, 0),
            a=np.append(state.a, 0),
            driver=np.where(state.driver >= len(self.modules), state.driver + 1, state.driver),
        )
        self._set_modules([*self.modules, made])

    def _set_modules(self, modules: list[Module]) -> None:
        """Let the selector choose among these modules; those that it had keep their habituation."""
        old, known = self.state.maps, len(self.modules)
        maps = flat_maps(self.variables, modules, self._tables, self.config.selector)
        maps.repeats[:known], maps.under[:known] = old.repeats[:known], old.under[:known]
        self.modules = modules
        self.state = self.state._replace(maps=maps, strength=np.zeros(len(maps.joint)))

    def _unused(self, event: Event) -> np.ndarray:
        """Counts (R, S, A, R') of a new event, as if its module had existed from the beginning and never been used."""
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
        horizon = config.horizon if config.memory == "window" and not self.local else 0
        grows = np.exp(1 / config.horizon) if config.memory == "fading" else 1.0
        widths = (len(variables.sensors), len(variables.actions), len(variables.results), len(variables.results))
        s, a, r, r_next = (np.zeros((horizon, width), np.int64) for width in widths)
        return RecentSteps(s, a, r, r_next, contexts=np.zeros(horizon, np.int64), weight=np.array([1.0, grows]))

    def _wider(self, past: RecentSteps) -> RecentSteps:
        """The ring buffer with room for one more sensor and one more action."""
        blank = np.zeros((len(past.contexts), 1), np.int64)
        return past._replace(s=np.hstack([past.s, blank]), a=np.hstack([past.a, blank]))


def _observed(values: np.ndarray, variables: Sequence[Variable]) -> np.ndarray:
    """Observations for compiled code, which looks up positions without a check."""
    try:
        codes = np.asarray(values)
    except ValueError:  # lists of unequal lengths
        codes = np.array(values, object)
    sizes = np.array([len(variable.values) for variable in variables])
    if codes.shape != sizes.shape or codes.dtype.kind not in "biu" or (codes < 0).any() or (codes >= sizes).any():
        wanted = ", ".join(f"{variable.name} 0 to {len(variable.values) - 1}" for variable in variables)
        raise SeriesError(f"a step needs whole numbers for {wanted}; got {codes.tolist()}")
    return codes.astype(np.int64)
