"""Small worlds for tests of the contingency mechanism: variables of any sizes, and series in them."""

import numpy as np
from numba import njit

from jointattn_mj.contingency.online.counts import Counts, add
from jointattn_mj.contingency.online.events import Variable, Variables

Series = tuple[np.ndarray, np.ndarray, np.ndarray]
"""s (T, sensors), a (T, actions) and r (T, results)."""


def variables(sensors, actions, results) -> Variables:
    """Variables with so many values each."""
    groups = (("s", sensors), ("a", actions), ("r", results))
    return Variables(
        *(
            tuple(Variable(f"{letter}{number}", tuple(map(str, range(size)))) for number, size in enumerate(sizes))
            for letter, sizes in groups
        )
    )


def series(of: Variables, length: int, rng: np.random.Generator) -> Series:
    """Random sensors and actions; each result follows from some of them half of the time."""
    s, a, r = (
        np.column_stack([rng.integers(0, len(variable.values), length) for variable in group]).astype(np.int64)
        for group in (of.sensors, of.actions, of.results)
    )
    for k, variable in enumerate(of.results):
        follows = np.flatnonzero(rng.random(length - 1) < 0.5)
        said = s[follows, k % s.shape[1]] + a[follows, k % a.shape[1]] + r[follows, k]
        r[follows + 1, k] = said % len(variable.values)
    return s, a, r


@njit(cache=True)
def count(counts, s, a, r, weight, contexts):
    """Add every transition of a series."""
    for t in range(len(s) - 1):
        add(counts, s[t], a[t], r[t], r[t + 1], weight, contexts)


def counted(counts: Counts, given: Series, weight: float = 1) -> Counts:
    """The same tables, with every transition of the series in them."""
    count(counts, *given, weight, len(counts.layout))
    return counts


def joint_counts(given: Series, of: Variables, event, weights=None) -> np.ndarray:
    """Counts (R, S, A, R') of an event, or weights (T - 1,), by numpy alone."""
    s, a, r = given
    sizes = [len(group[i].values) for group, i in zip((of.sensors, of.actions, of.results), event, strict=True)]
    table = np.zeros((sizes[2], sizes[0], sizes[1], sizes[2]))
    now = r[:-1, event.result], s[:-1, event.sensor], a[:-1, event.action], r[1:, event.result]
    np.add.at(table, now, 1.0 if weights is None else weights)
    return table


def contingency(table: np.ndarray) -> tuple[float, float]:
    """T^C (eq. 4.3) and SAC (eq. 5.2) in nats, term by term from a table (R, S, A, R')."""
    n = table.sum()

    def flow(axes: str) -> float:
        """T_{axes -> R}, eq. 4.1."""
        summed = table.sum(axis=tuple("rsan".index(axis) for axis in "sa" if axis not in axes), keepdims=True)
        given = summed / summed.sum(axis=3, keepdims=True).clip(1e-300)
        before = table.sum(axis=(1, 2), keepdims=True)
        alone = np.broadcast_to(before / before.sum(axis=3, keepdims=True).clip(1e-300), given.shape)
        visible = summed > 0
        return float((summed[visible] / n * np.log(given[visible] / alone[visible])).sum())

    return flow("sa") - flow("a"), flow("sa") - flow("s") - flow("a")
