"""The module selector (section 5.2.4, eq. 5.6): chooses the module that drives each joint; compiled, on flat arrays."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from jointattn_mj.contingency.online.events import Variables
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING, Module
from jointattn_mj.contingency.online.reactive import ReactiveTable
from jointattn_mj.errors import ConfigError, ObservationError
from jointattn_mj.guards.border import checked_by, require_array
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked, NotNegative

NOBODY = -1


@dataclass(frozen=True)
class SelectorConfig(Checked):
    """How modules compete for a joint."""

    habituation: NotNegative = 0.5
    """beta (eq. 5.6), loss of a module's reliability per repetition under the same observables; 0 turns it off."""
    habituates: Literal["driven", "observed"] = "driven"
    """Steps in a row that t' of eq. 5.6 counts. ``driven``: those in which the module drove the joint under the same
    observables ("producing the same behavior continuously"). ``observed``: those with the same observables. Only
    ``driven`` gives the behaviour of Fig. 5.5: with ``observed`` a module habituates before it has acted."""


class Maps(NamedTuple):
    """Maps of all M modules in flat arrays: contingency reproduction modules (CM) in order, then reactive ones."""

    sensor: np.ndarray
    """(M,) sensor that a module depends on."""
    result: np.ndarray
    """(M,) result that it depends on; NOBODY for a reactive module."""
    joint: np.ndarray
    """(M,) joint that it drives."""
    uses: np.ndarray
    """(M,) module that it switches on or off, or NOBODY for a module with commands of its own."""
    size: np.ndarray
    """(M,) number of values of its sensor."""
    offset: np.ndarray
    """(M,) where its map begins in ``command`` and ``reliability``; for a reactive module in ``odds``."""
    command: np.ndarray
    """Commands (R, S) of all CMs, one after the other."""
    reliability: np.ndarray
    """Reliabilities (R, S) of all CMs, likewise."""
    odds: np.ndarray
    """Cumulative probabilities (S, commands) of all reactive modules, likewise."""
    trust: np.ndarray
    """(M,) alpha of a reactive module; 0 for a CM."""
    commands: np.ndarray
    """(joints,) number of commands of each joint."""
    repeats: np.ndarray
    """(M,) t' of eq. 5.6, changed in every step."""
    under: np.ndarray
    """(M,) observables under which it was counted, likewise."""
    made: int
    """Number of CMs."""
    habituation: float
    """beta of eq. 5.6."""
    by_driver: bool
    """Whether t' counts steps in which the module drove."""


def flat_maps(
    variables: Variables,
    modules: Sequence[Module],
    tables: Sequence[ReactiveTable],
    config: SelectorConfig,
) -> Maps:
    """The modules as arrays, without habituation.

    Args:
        variables: Variables of the agent.
        modules: Contingency reproduction modules, in the order in which they were made.
        tables: Tables of the reactive modules, one or more for each joint.
        config: Settings of the selector.

    Raises:
        ConfigError: A reactive module's table does not fit the variables, or a joint has no reactive module.
    """
    joints = [joint.name for joint in variables.joints]
    sensors = [sensor.name for sensor in variables.sensors]
    drives: list[int] = []
    uses: list[int] = []
    for module in modules:
        used = module.event.action - len(joints)
        drives.append(module.event.action if used < 0 else drives[used])
        uses.append(NOBODY if used < 0 else used)
    tables = [_fitting(table, variables) for table in tables]
    unserved = set(joints) - {table.joint for table in tables}
    if unserved:
        raise ConfigError(f"each joint needs a reactive module; {', '.join(sorted(unserved))} got none")
    looks = [m.event.sensor for m in modules] + [sensors.index(table.sensor) for table in tables]
    maps = [m.command.size for m in modules]
    odds = [np.size(table.odds) for table in tables]
    return Maps(
        sensor=np.array(looks, np.int64),
        result=np.array([m.event.result for m in modules] + [NOBODY] * len(tables), np.int64),
        joint=np.array(drives + [joints.index(table.joint) for table in tables], np.int64),
        uses=np.array(uses + [NOBODY] * len(tables), np.int64),
        size=np.array([len(variables.sensors[number].values) for number in looks], np.int64),
        offset=np.concatenate([np.cumsum([0, *maps])[:-1], np.cumsum([0, *odds])[:-1]]).astype(np.int64),
        command=np.concatenate([np.zeros(0, np.int64), *(m.command.ravel() for m in modules)]).astype(np.int64),
        reliability=np.concatenate([np.zeros(0), *(m.reliability.ravel() for m in modules)]),
        odds=np.concatenate([np.cumsum(table.odds, axis=1).ravel() for table in tables]),
        trust=np.array([0.0] * len(modules) + [table.trust for table in tables]),
        commands=np.array([len(joint.values) for joint in variables.joints], np.int64),
        repeats=np.zeros(len(looks), np.int64),
        under=np.full(len(looks), NOBODY, np.int64),
        made=len(modules),
        habituation=float(config.habituation),
        by_driver=config.habituates == "driven",
    )


def _fitting(table: ReactiveTable, variables: Variables) -> ReactiveTable:
    """The table, checked against the variables."""
    shape = []
    for kind, name, group in (("sensor", table.sensor, variables.sensors), ("joint", table.joint, variables.joints)):
        sizes = {variable.name: len(variable.values) for variable in group}
        if name not in sizes:
            raise ConfigError(f"a reactive module names the {kind} {name!r}; there are {list(sizes)}")
        shape.append(sizes[name])
    if np.shape(table.odds) != tuple(shape):
        raise ConfigError(
            f"odds of {table.joint!r} under {table.sensor!r} need shape {tuple(shape)}; got {np.shape(table.odds)}"
        )
    return table


@njit(cache=True, borrows=True, forceinline=True)
def _offer(maps: Maps, m: int, s: np.ndarray, r: np.ndarray) -> int:
    """Command of module ``m`` under ``s`` and ``r``, or OFFERS_NOTHING; a switching module offers another's."""
    while True:
        location = maps.offset[m] + r[maps.result[m]] * maps.size[m] + s[maps.sensor[m]]
        command: int = maps.command[location]
        if maps.uses[m] == NOBODY or command == OFFERS_NOTHING:
            return command
        if command == 0:  # it switches the other module off
            return OFFERS_NOTHING
        m = maps.uses[m]


def _check_select(
    maps: Maps,
    s: np.ndarray,
    r: np.ndarray,
    random: np.random.Generator,
    strength: np.ndarray,
    a: np.ndarray,
    driver: np.ndarray,
) -> None:
    joints, made = len(maps.commands), maps.made
    require_array("s", s, (-1,), "iu")
    require_array("r", r, (-1,), "iu")
    require_array("strength", strength, maps.sensor.shape, "f")
    require_array("a", a, (joints + made,), "i")
    require_array("driver", driver, (joints,), "i")
    rows = np.diff(np.append(maps.offset[:made], len(maps.command))) // maps.size[:made]
    for name, values, numbers, sizes in (("s", s, maps.sensor, maps.size), ("r", r, maps.result[:made], rows)):
        if numbers.max(initial=-1) >= len(values):
            raise ObservationError(f"{name}: expected {numbers.max() + 1} values or more; got {len(values)}")
        require_array(name, values[numbers], numbers.shape, "iu", 0, sizes - 1)


@checked_by(_check_select)
@njit(cache=True, borrows=True, forceinline=True)
def select(
    maps: Maps,
    s: np.ndarray,
    r: np.ndarray,
    random: np.random.Generator,
    strength: np.ndarray,
    a: np.ndarray,
    driver: np.ndarray,
) -> None:
    """Choose a module for each joint, and the command that it offers.

    Args:
        maps: Modules; their habituation is updated.
        s: (sensors,) values in this step, modules' S_Pi included.
        r: (results,) values in this step.
        random: Generator of the agent.
        strength: (M,) working space.
        a: (actions,) is written: the joints' commands, then 1 for each CM in use (A_Pi).
        driver: (joints,) is written: the module that drives each joint.
    """
    joints, modules = len(maps.commands), len(maps.sensor)
    made = maps.made
    for m in range(made):
        a[joints + m] = 0
    for joint in range(joints):
        crowd = 1
        for m in range(made):
            crowd += maps.joint[m] == joint
        highest = -np.inf
        for m in range(modules):
            strength[m] = -np.inf
            if maps.joint[m] != joint:
                continue
            if m >= made:
                strength[m] = maps.trust[m] * crowd
            elif _offer(maps, m, s, r) != OFFERS_NOTHING:
                pair = r[maps.result[m]] * maps.size[m] + s[maps.sensor[m]]
                if pair != maps.under[m]:
                    maps.repeats[m] = 0
                tired = np.exp(-maps.habituation * maps.repeats[m])
                strength[m] = maps.reliability[maps.offset[m] + pair] * tired * crowd
            if strength[m] > highest:
                highest = strength[m]
        total = 0.0
        for m in range(modules):
            strength[m] = np.exp(strength[m] - highest)  # the ratios stay, and nothing overflows
            total += strength[m]
        left = random.random() * total
        chosen = modules - 1
        while strength[chosen] == 0.0:
            chosen -= 1
        for m in range(chosen):
            left -= strength[m]
            if left < 0.0:
                chosen = m
                break
        driver[joint] = chosen
        if chosen < made:
            a[joint] = _offer(maps, chosen, s, r)
            m = chosen
            while m != NOBODY:
                a[joints + m] = 1
                m = maps.uses[m]
        else:
            begin = maps.offset[chosen] + s[maps.sensor[chosen]] * maps.commands[joint]
            drawn, command = random.random(), 0
            while command < maps.commands[joint] - 1 and maps.odds[begin + command] <= drawn:
                command += 1
            a[joint] = command
    for m in range(made):
        pair = r[maps.result[m]] * maps.size[m] + s[maps.sensor[m]]
        if pair != maps.under[m]:
            maps.repeats[m] = 0
            maps.under[m] = pair
        if not maps.by_driver or driver[maps.joint[m]] == m:
            maps.repeats[m] += 1
        else:
            maps.repeats[m] = 0
