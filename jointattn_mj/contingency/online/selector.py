"""The module selector: which module drives which joint (section 5.2.4, eq. 5.6); compiled, on flat arrays."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from jointattn_mj.contingency.online.events import Variables
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING, Module
from jointattn_mj.contingency.online.reactive import ReactiveModule, ReactiveTable
from jointattn_mj.errors import ConfigError, ObservationError
from jointattn_mj.guards.border import checked_by, require_array
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked, NotNegative

NOBODY = -1


@dataclass(frozen=True)
class SelectorConfig(Checked):
    """How modules compete for a joint."""

    habituation: NotNegative = 0.5
    """beta, eq. 5.6: how fast a module loses reliability that goes on under the same observables; 0 turns it off."""
    habituates: Literal["driven", "observed"] = "driven"
    """What t' of eq. 5.6 counts: ``driven``, turns on end in which the module itself drove the joint under these very
    observables ("producing the same behavior continuously"), or ``observed``, in which they were the same. Only
    ``driven`` gives the behaviour of Fig. 5.5: with ``observed``, a module that has not acted yet tires of waiting."""


class Maps(NamedTuple):
    """All modules in flat arrays: those that reproduce a contingency (CM), in their order, then the reactive ones."""

    sensor: np.ndarray
    """(M,) the sensor that a module looks at."""
    result: np.ndarray
    """(M,) and the result; NOBODY for a reactive module, which looks at none."""
    joint: np.ndarray
    """(M,) the joint it drives."""
    uses: np.ndarray
    """(M,) the module whose command it gives on, or NOBODY for a module with commands of its own."""
    size: np.ndarray
    """(M,) how many values its sensor has."""
    offset: np.ndarray
    """(M,) where its map begins in ``command`` and ``reliability``, for a reactive one in ``odds``."""
    command: np.ndarray
    reliability: np.ndarray
    """Maps (R, S) of all CMs, one after the other."""
    odds: np.ndarray
    """Cumulative odds (S, commands) of all reactive modules, one after the other."""
    trust: np.ndarray
    """(M,) alpha of a reactive module."""
    commands: np.ndarray
    """(joints,) how many commands a joint knows."""
    repeats: np.ndarray
    """(M,) t' of eq. 5.6, and under which observables it was counted: (M,) each, changed from turn to turn."""
    under: np.ndarray
    made: int
    """How many of the modules are CMs."""
    habituation: float
    by_driver: bool


def flat_maps(
    variables: Variables, modules: Sequence[Module], reactive: Sequence[ReactiveModule], config: SelectorConfig
) -> Maps:
    """The modules as arrays, without habituation.

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
    tables = [_fitting(module.table(variables), variables) for module in reactive]
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
    """The table, if compiled code can use it with these variables."""
    shape = []
    for kind, name, group in (("sensor", table.sensor, variables.sensors), ("joint", table.joint, variables.joints)):
        sizes = {one.name: len(one.values) for one in group}
        if name not in sizes:
            raise ConfigError(f"a reactive module names the {kind} {name!r}; there are {list(sizes)}")
        shape.append(sizes[name])
    if np.shape(table.odds) != tuple(shape):
        raise ConfigError(
            f"odds of {table.joint!r} under {table.sensor!r} need shape {tuple(shape)}; got {np.shape(table.odds)}"
        )
    return table


@njit(cache=True, forceinline=True)
def _offer(maps, m, s, r):
    """Command of a module under these observables, or OFFERS_NOTHING; one that uses another offers what that does."""
    while True:
        location = maps.offset[m] + r[maps.result[m]] * maps.size[m] + s[maps.sensor[m]]
        command = maps.command[location]
        if maps.uses[m] == NOBODY or command == OFFERS_NOTHING:
            return command
        if command == 0:  # it is better not to use that one: nothing to offer
            return OFFERS_NOTHING
        m = maps.uses[m]


def _check_select(maps, s, r, random, strength, a, driver):
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
@njit(cache=True, forceinline=True)
def select(maps, s, r, random, strength, a, driver):
    """Choose a module for each joint, and carry out what it offers.

    Args:
        maps: The modules; their habituation goes on.
        s: Values (sensors,) observed now, modules' S_Pi included.
        r: Values (results,) observed now.
        random: Generator of the mind.
        strength: Working space (M,).
        a: Values (actions,) are written here: the joints' commands, then 1 for each CM in use (A_Pi).
        driver: (joints,) the modules that drive are written here.
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
            strength[m] = np.exp(strength[m] - highest)  # the odds stay, and nothing overflows
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
