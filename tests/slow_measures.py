"""The measures once more, straight from the formulas, with dictionaries: what the fast ones are held against."""

from collections import Counter
from collections.abc import Callable, Sequence
from itertools import product
from math import log2

Recordings = Sequence[Sequence[int]]


def transitions(s: Recordings, a: Recordings, r: Recordings) -> list[tuple[int, int, int, int]]:
    """(r', r, s, a) of every step that has a next one."""
    return [
        (results[t + 1], results[t], sources[t], actions[t])
        for sources, actions, results in zip(s, a, r, strict=True)
        for t in range(len(results) - 1)
    ]


class Histogram:
    """Joint and conditional probabilities as relative frequencies; variables are positions in (r', r, s, a)."""

    def __init__(self, observed: list[tuple[int, int, int, int]]):
        self.observed, self.n = observed, len(observed)

    def p(self, **values: int) -> float:
        """p(n=.., r=.., s=.., a=..) of the variables that are named."""
        position = {"n": 0, "r": 1, "s": 2, "a": 3}
        return sum(all(row[position[name]] == v for name, v in values.items()) for row in self.observed) / self.n

    def given(self, of: dict[str, int], what: dict[str, int]) -> float:
        """p(of | what)."""
        return self.p(**of, **what) / self.p(**what)


def flow(h: Histogram, source: str, condition: str = "", before: str = "r") -> float:
    """Sum of p log2 p(n | before, source, condition) / p(n | before, condition), eq. 4.1 to 4.3."""
    names = "nrsa"
    used = "n" + before + source + condition
    cells = Counter(tuple(row[names.index(name)] for name in used) for row in h.observed)
    total = 0.0
    for cell, count in cells.items():
        value = dict(zip(used, cell, strict=True))
        context = {name: value[name] for name in before + condition}
        whole = context | {name: value[name] for name in source}
        total += count / h.n * log2(h.given({"n": value["n"]}, whole) / h.given({"n": value["n"]}, context))
    return total


def contingency(h: Histogram) -> float:
    """SAC by the first line of eq. 5.2."""
    return flow(h, "sa") - (flow(h, "s") + flow(h, "a"))


def saliency(h: Histogram, n: int, a: int, r: int, s: int) -> float:
    """Eq. 5.3 for an observed pair (r, s); terms with probability 0 are 0."""
    first = h.p(n=n, a=a, r=r, s=s) / h.p(r=r, s=s)
    second = h.p(n=n, a=a, r=r) / h.p(r=r)
    value = 0.0
    if first > 0:
        value += first * log2(h.given({"n": n}, {"r": r, "s": s, "a": a}) / h.given({"n": n}, {"r": r, "s": s}))
    if second > 0:
        value -= second * log2(h.given({"n": n}, {"r": r, "a": a}) / h.given({"n": n}, {"r": r}))
    return value


def every_case(result: Callable[[int, int], int], values: int = 2) -> tuple[list, list, list]:
    """Recordings of two steps in which every (r, s, a) occurs once, and ``result(s, a)`` follows."""
    s, a, r = [], [], []
    for before, sensed, done in product(range(2), range(values), range(values)):
        s.append([sensed, 0])
        a.append([done, 0])
        r.append([before, result(sensed, done)])
    return s, a, r
