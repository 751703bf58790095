"""Resolution that grows (section 7.1): sensations and actions start coarse, and split where contingency rises.

A sensation falls on one of finitely many prototypes, in a tree of which is more like which; an action is a point in a
space of commands, or one that has no place there. S starts with two values, something sensed or nothing, and A with
two, some point or the other action. A value of S can be split into a branch of the tree and the rest, one of A by a
cut through its box of commands. Of each such split, and of each pair of one of S and one of A, the gain of the
event's contingency SAC (eq. 5.2) is asked, corrected for what finer histograms gain from nothing. Where S says
nothing as long as A is coarse, and A nothing as long as S is, only a pair can begin.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import numpy as np
from scipy.cluster.hierarchy import linkage

from jointattn_mj.errors import SeriesError
from jointattn_mj.options import Checked, Count, NotNegative, Positive, Whole

NOTHING_SENSED = -1


@dataclass(frozen=True)
class ResolutionConfig(Checked):
    """When a split is worth it."""

    deviations: NotNegative = 4.0
    """A split's gain must exceed this many of its standard errors. Some ten thousand splits compete at each look, so
    that the best of them gains three by chance."""
    least_gain: NotNegative = 0.1
    """The gain must also exceed this share of the contingency that there is: with time any border could be followed
    ever more closely."""
    cuts: Annotated[int, Whole("[1, 10000]")] = 15
    """Places along each axis of a box of commands where a cut is tried, with as many commands between two of them."""
    look_again: Positive = 0.2
    """It looks for splits when there are more transitions by this share than at the last look."""
    warm_up: Count = 500
    """Transitions before the first look."""
    linkage: Literal["average", "complete", "single", "ward"] = "average"
    """Distance of two groups of prototypes, for the tree: ``average``, ``complete``, ``single`` or ``ward``."""


class Transitions(NamedTuple):
    """What a robot sensed and did in some turns, and what came of it."""

    cells: np.ndarray
    """(n,) prototype that the sensation was nearest to, or NOTHING_SENSED."""
    commands: np.ndarray
    """(n, d) what was then commanded; NaN for the other action."""
    before: np.ndarray
    """(n,) result that was there with the sensation: 0, 1, ..."""
    after: np.ndarray
    """(n,) result that followed."""

    def some(self, which: np.ndarray | slice) -> "Transitions":
        """Those of them."""
        return Transitions(*(column[which] for column in self))


def transitions(cells: np.ndarray, commands: np.ndarray, results: np.ndarray) -> Transitions:
    """From series (T,), (T, d) and (T,), turn by turn.

    Raises:
        SeriesError: They are not equally long.
    """
    if commands.ndim != 2 or not len(commands) == len(results) == len(cells):
        raise SeriesError(
            "cells (T,), commands (T, d) and results (T,) of as many turns are needed; "
            f"got {cells.shape}, {commands.shape}, {results.shape}"
        )
    return Transitions(cells[:-1], commands[:-1], results[:-1], results[1:])


@dataclass(frozen=True)
class Resolution:
    """The values that S and A have."""

    sensed: tuple[frozenset[int], ...]
    """Prototypes of each value of S but the last, which is nothing sensed."""
    boxes: tuple[np.ndarray, ...]
    """(d, 2) lower and upper bounds of the commands of each value of A but the last, which is the other action."""

    def sensor(self, cells: np.ndarray) -> np.ndarray:
        """(T,) value of S for each of ``cells`` (T,)."""
        value = np.full(max([-1, *(max(leaf, default=-1) for leaf in self.sensed)]) + 2, len(self.sensed))
        for number, leaf in enumerate(self.sensed):
            value[list(leaf)] = number
        return value[cells]  # NOTHING_SENSED finds the last place

    def action(self, commands: np.ndarray) -> np.ndarray:
        """(T,) value of A for each of ``commands`` (T, d)."""
        value = np.full(len(commands), len(self.boxes))
        for number, box in enumerate(self.boxes):
            value[((commands >= box[:, 0]) & (commands < box[:, 1])).all(axis=1)] = number
        return value


class Split(NamedTuple):
    """A way to refine a resolution."""

    kind: str
    """``S``, ``A`` or ``S and A``."""
    leaf: int
    """Value of S that is split, or -1."""
    branch: frozenset[int]
    """Prototypes that become a value of their own; the rest keeps the old place."""
    box: int
    """Value of A that is split, or -1."""
    axis: int
    at: float
    gain: float
    """Of corrected contingency, nats."""
    error: float = np.nan
    """Its standard error."""


class Step(NamedTuple):
    """A split that was made."""

    turns: int
    """After how many transitions."""
    split: Split
    resolution: Resolution
    """As it was then."""
    contingency: float
    """Corrected, nats, then."""


def coarse(prototypes: int, space: np.ndarray) -> Resolution:
    """Something sensed or nothing, some command of the box ``space`` (d, 2) or the other action."""
    return Resolution((frozenset(range(prototypes)),), (np.array(space, float),))


def branches(points: np.ndarray, method: str) -> list[frozenset[int]]:
    """All branches, single prototypes included, of the tree of ``points`` (k, d); the whole is none."""
    groups = [frozenset([number]) for number in range(len(points))]
    if len(points) > 1:
        for left, right in linkage(points, method)[:-1, :2].astype(int):
            groups.append(groups[left] | groups[right])
    return groups


def contingency(given: Transitions, resolution: Resolution) -> float:
    """SAC of S, A and the result at this resolution, nats, corrected by Miller and Madow."""
    return _sac(np.moveaxis(_table(given, resolution), 0, 2))


def local_contingency(given: Transitions, resolution: Resolution) -> np.ndarray:
    """(n,) SAC transition by transition, nats, uncorrected."""
    counts = _table(given, resolution)
    r, s, a, after = _coded(given, resolution)

    def share(axes: tuple[int, ...]) -> np.ndarray:
        joint = counts.sum(axis=axes, keepdims=True)
        with np.errstate(invalid="ignore"):
            return np.broadcast_to(joint / joint.sum(axis=3, keepdims=True), counts.shape)[r, s, a, after]

    return np.log(share(()) * share((1, 2)) / (share((1,)) * share((2,))))


class Growth:
    """A resolution that grows with experience.

    Attributes:
        resolution: As it is now.
        steps: How it came about.
    """

    def __init__(self, prototypes: np.ndarray, space: np.ndarray, config: ResolutionConfig = ResolutionConfig()):
        """``prototypes`` (k, n) of sensations; ``space`` (d, 2) lower and upper bounds of commands."""
        self.config = config
        self.resolution = coarse(len(prototypes), space)
        self.steps: list[Step] = []
        self._branches = branches(prototypes, config.linkage)
        self._next = config.warm_up

    def due(self, turns: int) -> bool:
        """Whether so many transitions are enough to look again."""
        return turns >= self._next

    def update(self, given: Transitions) -> list[Step]:
        """Split where all that was ``given`` so far says so, if enough of it is new; returns what was done."""
        turns, known = len(given.cells), len(self.steps)
        if not self.due(turns):
            return []
        self._next = int(turns * (1 + self.config.look_again)) + 1
        while (split := self._best(given)) is not None:
            self.resolution = refined(self.resolution, split)
            self.steps.append(Step(turns, split, self.resolution, contingency(given, self.resolution)))
        return self.steps[known:]

    def _best(self, given: Transitions) -> Split | None:
        """The split that is worth most; a pair only where neither of S nor of A alone is any."""
        best: dict[str, Split] = {}
        for split in splits(given, self.resolution, self._branches, self.config.cuts):
            if split.kind not in best or split.gain > best[split.kind].gain:
                best[split.kind] = split
        had, before = contingency(given, self.resolution), local_contingency(given, self.resolution)
        for kinds in (("S", "A"), ("S and A",)):
            worth = []
            for split in (best[kind] for kind in kinds if kind in best):
                finer = refined(self.resolution, split)
                error = float((local_contingency(given, finer) - before).std() / np.sqrt(len(before)))
                if split.gain > max(self.config.deviations * error, self.config.least_gain * had):
                    worth.append(split._replace(error=error))
            if worth:
                return max(worth, key=lambda split: split.gain)
        return None


def refined(resolution: Resolution, split: Split) -> Resolution:
    """The resolution after a split; what is new comes last."""
    sensed, boxes = list(resolution.sensed), list(resolution.boxes)
    if split.leaf >= 0:
        sensed[split.leaf] = sensed[split.leaf] - split.branch
        sensed.append(split.branch)
    if split.box >= 0:
        below, above = boxes[split.box].copy(), boxes[split.box].copy()
        below[split.axis, 1] = above[split.axis, 0] = split.at
        boxes[split.box] = below
        boxes.append(above)
    return Resolution(tuple(sensed), tuple(boxes))


def splits(given: Transitions, resolution: Resolution, tree: list[frozenset[int]], cuts: int) -> Iterator[Split]:
    """Every split of S, every cut of A, and with each cut the best split of S."""
    counts, per_cell = _by_cell(given, resolution, 1 + max(max(branch) for branch in tree))
    own = _Branches(resolution, tree, counts)
    had = own.value(counts)
    for leaf, branch, value in own.splits(counts):
        yield Split("S", leaf, branch, -1, 0, 0.0, value - had)
    for box, axis, at, above in _cuts(given, resolution, per_cell, counts.shape, cuts):
        cut = np.concatenate([counts, above[:, None]], axis=1)
        cut[:, box] -= above
        yield Split("A", -1, frozenset(), box, axis, at, own.value(cut) - had)
        leaf, branch, value = max(own.splits(cut), key=lambda one: one[2], default=(-1, frozenset[int](), -np.inf))
        if leaf >= 0:
            yield Split("S and A", leaf, branch, box, axis, at, value - had)


class _Branches:
    """Splits of S, whose contingencies are worked out together for any partition of A."""

    def __init__(self, resolution: Resolution, tree: list[frozenset[int]], by_cell: np.ndarray):
        """``by_cell`` (cells + 1, A, R, R') says on which prototypes anything has fallen."""
        self._leaves = [np.array(sorted(leaf), int) for leaf in resolution.sensed]
        used = set(np.flatnonzero(by_cell[:-1].sum(axis=(1, 2, 3))))
        self._inside: list[tuple[int, frozenset[int]]] = []
        tried = set[tuple[int, frozenset[int]]]()
        for number, leaf in enumerate(resolution.sensed):
            for branch in tree:
                part, of = branch & leaf & used, leaf & used
                if part and part != of and not {(number, part), (number, of - part)} & tried:
                    tried.add((number, part))
                    self._inside.append((number, branch & leaf))
        self._member = np.zeros((len(self._inside), len(by_cell)))
        for row, (_, branch) in zip(self._member, self._inside, strict=True):
            row[list(branch)] = 1
        self._of = np.array([number for number, _ in self._inside], int)

    def value(self, by_cell: np.ndarray) -> float:
        """Corrected SAC, nats, at a partition of A."""
        return _sac(self._by_leaf(by_cell))

    def splits(self, by_cell: np.ndarray) -> Iterator[tuple[int, frozenset[int], float]]:
        """Value of S, branch, and corrected SAC after the split, of each."""
        leaves = self._by_leaf(by_cell)
        inside = (self._member @ by_cell.reshape(len(by_cell), -1)).reshape(len(self._of), *by_cell.shape[1:])
        rise = _rise(inside, leaves[self._of])
        rise -= _rise(inside.sum(axis=1, keepdims=True), leaves[self._of].sum(axis=1, keepdims=True))
        values = _sac(leaves) + rise / by_cell.sum()
        for (number, branch), value in zip(self._inside, values, strict=True):
            yield number, branch, float(value)

    def _by_leaf(self, by_cell: np.ndarray) -> np.ndarray:
        """(S, A, R, R')."""
        return np.stack([*(by_cell[leaf].sum(axis=0) for leaf in self._leaves), by_cell[-1]])


def _h(counts: np.ndarray) -> np.ndarray:
    """c ln c - [c > 0] / 2: sums of it are the entropies of counts, as Miller and Madow correct them."""
    return counts * np.log(np.maximum(counts, 1)) - 0.5 * (counts > 0)


def _p(counts: np.ndarray) -> np.ndarray:
    """P of ``contingency.counts``, corrected, of counts (..., A, R, R')."""
    return _h(counts).sum(axis=(-3, -2, -1)) - _h(counts.sum(axis=-1)).sum(axis=(-2, -1))


def _rise(inside: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """By how much P grows where counts (..., A, R, R') are told apart into those ``inside`` and the rest."""
    return _p(inside) + _p(whole - inside) - _p(whole)


def _sac(counts: np.ndarray) -> float:
    """SAC, nats, corrected, of counts (S, A, R, R')."""
    per_action, per_sensor = counts.sum(axis=0, keepdims=True), counts.sum(axis=1, keepdims=True)
    alone = per_action.sum(axis=1, keepdims=True)
    return float((_p(counts).sum() - _p(per_action) - _p(per_sensor).sum() + _p(alone)).item() / counts.sum())


def _coded(given: Transitions, resolution: Resolution) -> tuple[np.ndarray, ...]:
    """r, s, a and r' (n,)."""
    return given.before, resolution.sensor(given.cells), resolution.action(given.commands), given.after


def _counted(codes: tuple[np.ndarray, ...], shape: tuple[int, ...]) -> np.ndarray:
    return np.bincount(np.ravel_multi_index(codes, shape), minlength=int(np.prod(shape))).reshape(shape).astype(float)


def _table(given: Transitions, resolution: Resolution) -> np.ndarray:
    """Counts (R, S, A, R')."""
    results = int(max(given.before.max(), given.after.max())) + 1
    shape = (results, len(resolution.sensed) + 1, len(resolution.boxes) + 1, results)
    return _counted(_coded(given, resolution), shape)


def _by_cell(given: Transitions, resolution: Resolution, prototypes: int) -> tuple[np.ndarray, np.ndarray]:
    """Counts (prototypes + 1, A, R, R'), and of each transition the number (n,) of its (prototype, r, r')."""
    cells = np.where(given.cells == NOTHING_SENSED, prototypes, given.cells)
    results = int(max(given.before.max(), given.after.max())) + 1
    shape = (prototypes + 1, len(resolution.boxes) + 1, results, results)
    counts = _counted((cells, resolution.action(given.commands), given.before, given.after), shape)
    return counts, np.ravel_multi_index((cells, given.before, given.after), (shape[0], results, results))


def _cuts(
    given: Transitions, resolution: Resolution, per_cell: np.ndarray, shape: tuple[int, ...], cuts: int
) -> Iterator[tuple[int, int, float, np.ndarray]]:
    """Box, axis, place of a cut, and the counts (prototypes + 1, R, R') beyond it."""
    rest = shape[0], *shape[2:]
    action = resolution.action(given.commands)
    for box in range(len(resolution.boxes)):
        own = np.flatnonzero(action == box)
        for axis in range(given.commands.shape[1]):
            along = given.commands[own, axis]
            if len(along) <= cuts:
                continue
            locations = np.unique(np.quantile(along, np.arange(1, cuts + 1) / (cuts + 1)))
            between = np.searchsorted(locations, along, side="right")
            size = int(np.prod(rest))
            fine = np.bincount(between * size + per_cell[own], minlength=(len(locations) + 1) * size)
            beyond = np.cumsum(fine.reshape(len(locations) + 1, *rest)[::-1], axis=0)[::-1]
            for number, at in enumerate(locations, 1):
                yield box, axis, float(at), beyond[number]
