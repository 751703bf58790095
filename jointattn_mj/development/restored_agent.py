"""Checks of an agent from a checkpoint, before compiled code uses it."""

from typing import TYPE_CHECKING

import numpy as np

from jointattn_mj.contingency.online.counts import Counts, add, check_add_up
from jointattn_mj.contingency.online.events import Variables
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING, Module
from jointattn_mj.guards.restored import check_alike, check_array
from jointattn_mj.io.compiled import njit

if TYPE_CHECKING:
    from jointattn_mj.development.agent import AgentState, RecentSteps


def check_module(module: Module, variables: Variables) -> None:
    """Refuse a module whose maps do not fit the variables that there were when it was made.

    Args:
        module: The module.
        variables: Those before it was made.

    Raises:
        ValueError: They do not fit.
    """
    event = module.event
    sensors, actions = len(variables.sensors[event.sensor].values), len(variables.actions[event.action].values)
    results = len(variables.results[event.result].values)
    shape = (results, sensors)
    check_array("a module's command", module.command, shape, np.int64, OFFERS_NOTHING, actions - 1)
    check_array("a module's expected", module.expected, shape, np.int64, OFFERS_NOTHING, results - 1)
    check_array("a module's reliability", module.reliability, shape, float)
    check_array("a module's saliency", module.saliency, (*shape, results, actions), float)


def check_agent(state: "AgentState", model: "AgentState", variables: Variables, window: int | None = None) -> None:
    """Refuse an agent whose state is not laid out as that of a new one.

    Args:
        state: State of the agent.
        model: State of a new agent with the same variables and modules.
        variables: The agent's.
        window: How many of the last steps are kept whole; None for all.

    Raises:
        ValueError: Something differs, or a value is none of its variable.
    """
    check_alike(state._replace(experience=model.experience), model)
    check_array("n_steps", state.n_steps, (1,), np.int64, 0)
    counts, maps, past = state.counts, state.maps, state.past
    fixed = {name: (getattr(counts, name), getattr(model.counts, name)) for name in ("of_event", "layout")}
    of_maps = ("sensor", "result", "joint", "uses", "size", "offset", "command", "commands")
    fixed |= {name: (getattr(maps, name), getattr(model.maps, name)) for name in of_maps}
    for name, (given, expected) in fixed.items():
        if not np.array_equal(given, expected):
            raise ValueError(f"{name} is another than its variables and modules have")
    sizes = [
        np.array([len(variable.values) for variable in group])
        for group in (variables.sensors, variables.actions, variables.results)
    ]
    for name, values, size in zip("sar", (state.s, state.a, state.r), sizes, strict=True):
        check_array(name, values, values.shape, np.int64, 0, size - 1)
    for values, size in ((past.s, sizes[0]), (past.a, sizes[1]), (past.r, sizes[2]), (past.r_next, sizes[2])):
        check_array("past", values, values.shape, np.int64, 0, size - 1)
    check_array("past", past.contexts, past.contexts.shape, np.int64, 0, len(counts.layout))
    rows = window or max(len(state.experience.s), int(state.n_steps[0]) if state.keeping else 0)
    for name, part, size in zip("sar", state.experience, sizes, strict=True):
        check_array(f"experience of {name}", part, (rows, len(size)), np.int8, 0, size - 1)
    check_array("driver", state.driver, state.driver.shape, np.int64, -1, len(maps.joint) - 1)
    check_array("first", state.watch.first[:1], (1,), np.int64, -1, len(state.watch.values) - 1)
    check_array("counts", counts.entries, counts.entries.shape, float, 0)
    if not state.forgets:  # counts that fade are no whole numbers
        check_add_up(counts)
    if len(past.contexts):  # what is forgotten is taken out of the counts again
        blank = {name: np.zeros_like(getattr(counts, name)) for name in ("entries", "sums", "n", "occupied")}
        remembered = counts._replace(**blank)
        _remember(remembered, past)
        if not (np.array_equal(remembered.entries, counts.entries) and np.array_equal(remembered.n, counts.n)):
            raise ValueError("counts are others than those of what is remembered")


@njit(cache=True)
def _remember(counts: Counts, past: "RecentSteps") -> None:
    """Count all transitions of a ring buffer."""
    for location in range(len(past.contexts)):
        if past.contexts[location] > 0:
            add(
                counts,
                past.s[location],
                past.a[location],
                past.r[location],
                past.r_next[location],
                1,
                past.contexts[location],
            )
