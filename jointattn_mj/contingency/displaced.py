"""Surrogates that leave every series its own course, and move the source as a whole against the rest.

A source that was shifted, put together anew from long blocks, or taken from another recording has looks as long as
those that were observed. Only when they come, relative to the target, is left to chance.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import Literal

import numpy as np

from jointattn_mj.contingency.counting import Counter, counter
from jointattn_mj.contingency.information import Measure
from jointattn_mj.contingency.series import combined, distinct
from jointattn_mj.contingency.surrogates import MOST_CELLS
from jointattn_mj.contingency.table import AXES, Steps
from jointattn_mj.errors import SeriesError
from jointattn_mj.io.compiled import njit

Displacement = Literal["shift", "bootstrap", "partners"]
"""``shift``: the source of each recording is shifted in a circle. ``bootstrap``: it is put together from blocks of
random length, from anywhere in its recording (stationary bootstrap, Politis and Romano 1994). ``partners``: it is taken
from another recording, from the start, and over again where that is shorter."""

FEWEST_RECORDINGS = 3
"""Recordings with fewer others have no partners to change with."""


@dataclass(frozen=True)
class Moves:
    """From where in the source the transitions of a surrogate take theirs."""

    how: Displacement
    spans: np.ndarray
    """int64 (k + 1,): where recordings begin, in transitions, and the end."""
    least: int = 1
    """Shortest shift, either way, in transitions; a quarter of a recording at most."""
    block: int = 1
    """Mean block, in transitions."""

    def distinct(self) -> float:
        """How many different surrogates there are; infinite for the bootstrap."""
        if self.how == "bootstrap":
            return float("inf")
        if self.how == "shift":
            return float(prod(float(high - low) for low, high in self._ranges()))
        count = len(self.spans) - 1
        return float(round(np.exp(float(np.sum(np.log(np.arange(1, count + 1)))) - 1))) if count < 170 else float("inf")

    def draw(self, count: int, rng: np.random.Generator) -> Iterator[np.ndarray]:
        """Pieces of ``count`` surrogates, int64 (m, 3) each: transition, source's transition, length.

        Where there are no more than ``count`` different shifts, each is given once.
        """
        if self.how == "shift":
            ranges = self._ranges()
            if self.distinct() <= count:
                for offsets in product(*(range(low, high) for low, high in ranges)):
                    yield _shifted(self.spans, np.array(offsets, np.int64))
                return
            low, high = np.array(ranges).T
            for _ in range(count):
                yield _shifted(self.spans, rng.integers(low, high))
        elif self.how == "bootstrap":
            for _ in range(count):
                yield _blocks(self.spans, 1 / self.block, rng)
        else:
            for _ in range(count):
                yield _exchanged(self.spans, _derangement(len(self.spans) - 1, rng))

    def _ranges(self) -> list[tuple[int, int]]:
        """Shifts of each recording that are drawn from, from and up to."""
        lengths = np.diff(self.spans).tolist()
        margins = [max(1, min(self.least, length // 4)) for length in lengths]
        return [
            (margin, max(margin, length - margin) + 1) if length > 1 else (0, 1)
            for margin, length in zip(margins, lengths, strict=True)
        ]


@dataclass(frozen=True)
class Displaced:
    """What surrogates of some measures are counted from; ``displaced`` makes it."""

    counter: Counter
    """Counts each (r, a, n) with each value of the source."""
    transitions: int
    """Number of transitions."""
    names: tuple[str, ...]
    """Axes of each term of a measure."""
    groups: np.ndarray
    """int64 (terms, rest): to which group each (r, a, n) belongs in each term of a measure."""
    weights: np.ndarray
    """(measures, terms): the sign of each term in each measure."""
    fixed: np.ndarray
    """(measures,): the part that does not hang on the source, nats times transitions."""
    exchangeable: int
    """Transitions in recordings whose source varies."""
    whole: tuple[int, ...]
    """For each measure, the term over all its variables."""
    rest: np.ndarray
    """int64 (3, rest): r, a and n of each (r, a, n)."""
    source: np.ndarray
    """int64 (sources,): codes of the values of the source."""

    def values(self, pieces: np.ndarray) -> np.ndarray:
        """Plug-in values (measures,) in nats of one surrogate, for all measures from the same counts."""
        return self._values(self.counter.table(pieces))

    def _values(self, table: np.ndarray) -> np.ndarray:
        values: np.ndarray = (self.weights @ _terms(table, self.groups) + self.fixed) / self.transitions
        return values

    @property
    def cells(self) -> tuple[int, ...]:
        """Number of combinations of values of each measure."""
        return tuple(int(self.groups[term].max() + 1) * len(self.source) for term in self.whole)

    def values_and_counts(self, pieces: np.ndarray) -> np.ndarray:
        """Values as above, then how often each combination of values comes (measures + all cells,)."""
        table = self.counter.table(pieces)
        counts = [_summed(table, self.groups[term]).ravel() for term in self.whole]
        return np.concatenate([self._values(table), *counts])

    def combinations(self, measure: int) -> np.ndarray:
        """int64 (4, cells): r, a, s and n of each combination of a measure, 0 for a variable that it has not."""
        term = self.whole[measure]
        first = np.unique(self.groups[term], return_index=True)[1]
        r, a, n = (
            np.where(axis in self.names[term], column[first], 0) for axis, column in zip("ran", self.rest, strict=True)
        )
        sources = len(self.source)
        every = (np.repeat(r, sources), np.repeat(a, sources), np.tile(self.source, len(first)), np.repeat(n, sources))
        return np.array(every, np.int64)


def displaced(steps: Steps, measures: Sequence[Measure]) -> Displaced:
    """Prepare the transitions of ``steps`` for ``measures``.

    Raises:
        SeriesError: Source, context and target have too many values.
    """
    columns, sizes = steps.columns(), steps.sizes
    rest, first = _numbered([columns[i] for i in (0, 1, 3)], [sizes[i] for i in (0, 1, 3)])
    source, first_of_source = _numbered([columns[2]], [sizes[2]])
    rests, sources = len(first), int(source.max()) + 1
    if rests * sources > MOST_CELLS:
        raise SeriesError(
            f"a source of {sources} values and {rests} combinations of context and target have too many combinations "
            "for surrogates; sort the values into fewer bins"
        )
    signs = [_signs(measure) for measure in measures]
    names = list(dict.fromkeys(axes for terms in signs for axes in terms))
    groups = np.zeros((len(names), rests), np.int64)
    counts = np.bincount(rest, minlength=rests)
    alone = np.empty(len(names))
    for i, axes in enumerate(names):
        if axes:
            chosen = [AXES.index(axis) for axis in axes]
            keys = combined([columns[j][first] for j in chosen], [sizes[j] for j in chosen])[0]
            groups[i] = np.unique(keys, return_inverse=True)[1]
        of_group = np.bincount(groups[i], counts)
        alone[i] = of_group @ np.log(of_group)
    weights = np.array([[float(terms.get(axes, 0)) for axes in names] for terms in signs])
    spans = steps.spans(whole=True)
    lowest, highest = (extreme.reduceat(source, spans[:-1]) for extreme in (np.minimum, np.maximum))
    return Displaced(
        counter(rest, source, rests, sources), len(rest), tuple(names), groups, weights, -weights @ alone,
        int(np.diff(spans)[highest > lowest].sum()),
        tuple(names.index(measure.given + "n") for measure in measures),
        np.array([columns[i][first] for i in (0, 1, 3)], np.int64), columns[2][first_of_source].astype(np.int64),
    )  # fmt: skip


def moves(steps: Steps, how: Displacement, least: int, block: int) -> Moves:
    """Moves of the source of ``steps``.

    Args:
        steps: The transitions.
        how: Kind of surrogate.
        least: Shortest shift, in transitions.
        block: Mean block of the bootstrap, in transitions.

    Raises:
        SeriesError: There are too few recordings to exchange partners.
    """
    spans = steps.spans(whole=True).astype(np.int64)
    if how == "partners" and len(spans) - 1 < FEWEST_RECORDINGS:
        raise SeriesError(
            f"partners of other recordings need at least {FEWEST_RECORDINGS} recordings; got {len(spans) - 1}. Name "
            "the column that tells them apart, or take shifts"
        )
    return Moves(how, spans, least, block)


def _signs(measure: Measure) -> dict[str, int]:
    """Sum of c ln c over which groups of (r, a, n), each with s, with which sign; without s, with the other sign."""
    signs: dict[str, int] = {}
    for given, sign in ((measure.given, 1), (measure.less, -1)):
        if given is not None:
            signs[given + "n"] = signs.get(given + "n", 0) + sign
            signs[given] = signs.get(given, 0) - sign
    return signs


def _numbered(columns: Sequence[np.ndarray], sizes: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Numbers (n,) int32 of the combinations that occur, from 0, and where each occurs first."""
    combinations = distinct(*combined(columns, sizes))
    return combinations.which.astype(np.int32), combinations.first


def _shifted(spans: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Each recording in two pieces; transition t takes the source of t + offset."""
    starts, stops = spans[:-1], spans[1:]
    offsets = offsets % np.maximum(stops - starts, 1)
    head = np.stack([starts, starts + offsets, stops - starts - offsets], 1)
    tail = np.stack([stops - offsets, starts, offsets], 1)
    pieces = np.concatenate([head, tail])
    return pieces[pieces[:, 2] > 0]


def _derangement(count: int, rng: np.random.Generator) -> np.ndarray:
    """A random order in which nothing stays."""
    while True:
        order = rng.permutation(count)
        if not np.any(order == np.arange(count)):
            return order


def _exchanged(spans: np.ndarray, order: np.ndarray) -> np.ndarray:
    """Recording i takes the source of recording ``order[i]``, over and over."""
    pieces = []
    for i, other in enumerate(order):
        t, stop = spans[i], spans[i + 1]
        length = spans[other + 1] - spans[other]
        while t < stop:
            taken = min(length, stop - t)
            pieces.append((t, spans[other], taken))
            t += taken
    return np.array(pieces, np.int64)


@njit(cache=True)
def _blocks(spans: np.ndarray, chance: float, rng: np.random.Generator) -> np.ndarray:
    """Blocks of geometric lengths, each from anywhere in its recording, going on at its start."""
    pieces = np.empty((max(16, int(2 * spans[-1] * chance) + 4 * len(spans)), 3), np.int64)
    used = 0
    for i in range(len(spans) - 1):
        t, start, stop = spans[i], spans[i], spans[i + 1]
        while t < stop:
            length = min(1 + int(np.log(1 - rng.random()) / np.log(1 - min(chance, 1 - 1e-12))), stop - t)
            u = start + int(rng.random() * (stop - start))
            while length > 0:
                taken = min(length, stop - u)
                if used == len(pieces):
                    more = np.empty((2 * used, 3), np.int64)
                    more[:used] = pieces
                    pieces = more
                pieces[used, 0], pieces[used, 1], pieces[used, 2] = t, u, taken
                used += 1
                t, length, u = t + taken, length - taken, start
    return pieces[:used]


@njit(cache=True, nogil=True)
def _summed(table: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Counts (groups, sources) of the groups of a term."""
    sums = np.zeros((group.max() + 1, table.shape[1]), np.int64)
    for rest in range(len(group)):
        for s in range(table.shape[1]):
            sums[group[rest], s] += table[rest, s]
    return sums


@njit(cache=True, nogil=True)
def _terms(table: np.ndarray, groups: np.ndarray) -> np.ndarray:
    """Sum of c ln c over the groups of each term, each with s."""
    rests, sources = table.shape
    terms = np.zeros(len(groups))
    sums = np.zeros((rests, sources), np.int64)
    for term in range(len(groups)):
        sums[:] = 0
        for rest in range(rests):
            group = groups[term, rest]
            for s in range(sources):
                sums[group, s] += table[rest, s]
        for group in range(rests):
            for s in range(sources):
                count = sums[group, s]
                if count > 1:
                    terms[term] += count * np.log(count)
    return terms
