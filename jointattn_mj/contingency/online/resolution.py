"""Growing resolution (section 7.1): sensations and actions start coarse, and split where contingency rises.

A sensation is one of finitely many prototypes, such as the units of a map of faces; a tree says which are alike. An
action is a point in a space of commands, or the other action, which lies outside it. S starts with two values,
something sensed or nothing; A starts with two, some point or the other action. A value of S is split into a branch of
the tree and the rest, a value of A by a cut through its box of commands. For each split, and for each pair of one of S
and one of A, the gain of the event's contingency SAC (eq. 5.2) is computed, corrected for the bias of finer histograms.
Where S says nothing as long as A is coarse, and A nothing as long as S is, only a pair can begin.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import numpy as np

from jointattn_mj.errors import SeriesError
from jointattn_mj.options import Checked, Count, NotNegative, Positive, Whole

NOTHING_SENSED = -1


@dataclass(frozen=True)
class ResolutionConfig(Checked):
    """When values are split."""

    deviations: NotNegative = 4.0
    """Standard errors that a split's gain must exceed. Some ten thousand splits compete at each test, so that the best
    of them gains three by chance."""
    least_gain: NotNegative = 0.1
    """Share of the present contingency that the gain must also exceed. Without it, any border would be followed ever
    more closely with time."""
    cuts: Annotated[int, Whole("[1, 10000]")] = 15
    """Cuts that are tried along each axis of a box, with equally many commands between two of them."""
    look_again: Positive = 0.2
    """Share of further transitions after which splits are tested again."""
    warm_up: Count = 500
    """Transitions before the first test."""
    linkage: Literal["average", "complete", "single", "ward"] = "average"
    """Distance of two groups of prototypes in the tree; names as in scipy's ``linkage``."""


class Transitions(NamedTuple):
    """What a robot sensed and did in n steps, and the result that followed."""

    units: np.ndarray
    """(n,) nearest prototype of the sensation, or NOTHING_SENSED."""
    commands: np.ndarray
    """(n, d) command in that step; NaN for the other action."""
    before: np.ndarray
    """(n,) result in that step: 0, 1, ..."""
    after: np.ndarray
    """(n,) result in the next step."""

    def some(self, which: np.ndarray | slice) -> "Transitions":
        """Some of the transitions, by a mask, indices or a slice."""
        return Transitions(*(column[which] for column in self))


def transitions(units: np.ndarray, commands: np.ndarray, results: np.ndarray) -> Transitions:
    """Transitions of T steps.

    Args:
        units: (T,) nearest prototype, or NOTHING_SENSED.
        commands: (T, d) command; NaN for the other action.
        results: (T,) result: 0, 1, ...

    Raises:
        SeriesError: They are not equally long.
    """
    if commands.ndim != 2 or not len(commands) == len(results) == len(units):
        raise SeriesError(
            "units (T,), commands (T, d) and results (T,) must be of equal length; "
            f"got {units.shape}, {commands.shape}, {results.shape}"
        )
    return Transitions(units[:-1], commands[:-1], results[:-1], results[1:])


@dataclass(frozen=True)
class Resolution:
    """Values of S and A."""

    sensed: tuple[frozenset[int], ...]
    """Prototypes of each value of S but the last, which stands for nothing sensed."""
    boxes: tuple[np.ndarray, ...]
    """(d, 2) bounds of the commands of each value of A but the last, which stands for the other action."""

    def __repr__(self) -> str:
        return f"Resolution({len(self.sensed) + 1} values of S, {len(self.boxes) + 1} of A)"

    def sensor(self, units: np.ndarray) -> np.ndarray:
        """(T,) value of S for each prototype in ``units`` (T,)."""
        value = np.full(max([-1, *(max(leaf, default=-1) for leaf in self.sensed)]) + 2, len(self.sensed))
        for number, leaf in enumerate(self.sensed):
            value[list(leaf)] = number
        looked_up: np.ndarray = value[units]  # NOTHING_SENSED, -1, is the last
        return looked_up

    def action(self, commands: np.ndarray) -> np.ndarray:
        """(T,) value of A for each of ``commands`` (T, d)."""
        value = np.full(len(commands), len(self.boxes))
        for number, box in enumerate(self.boxes):
            value[((commands >= box[:, 0]) & (commands < box[:, 1])).all(axis=1)] = number
        return value


class Split(NamedTuple):
    """A refinement of a resolution."""

    kind: str
    """``S``, ``A`` or ``S and A``."""
    leaf: int
    """Value of S that is split, or -1."""
    branch: frozenset[int]
    """Prototypes that become a new value; the rest keeps the old one."""
    box: int
    """Value of A that is split, or -1."""
    axis: int
    """Axis of the cut through the box."""
    at: float
    """Position of the cut, in units of the command."""
    gain: float
    """Rise of corrected contingency, nats."""
    error: float = np.nan
    """Standard error of the gain, nats."""


class Step(NamedTuple):
    """A split that was made, and what it led to."""

    n_transitions: int
    """Transitions by then."""
    split: Split
    resolution: Resolution
    """Values of S and A after it."""
    contingency: float
    """Corrected contingency after it, nats."""


def coarse(prototypes: int, space: np.ndarray) -> Resolution:
    """The first values: something sensed or nothing, some command or the other action.

    Args:
        prototypes: How many there are.
        space: (d, 2) bounds of the commands.
    """
    return Resolution((frozenset(range(prototypes)),), (np.array(space, float),))


def branches(points: np.ndarray, method: str) -> list[frozenset[int]]:
    """All branches of the tree of ``points`` (k, d), single points included; ``method`` as in scipy's ``linkage``."""
    groups = [frozenset([number]) for number in range(len(points))]
    if len(points) > 1:
        from scipy.cluster.hierarchy import linkage  # takes .1 s to import

        for left, right in linkage(points, method)[:-1, :2].astype(int):
            groups.append(groups[left] | groups[right])
    return groups


def contingency(given: Transitions, resolution: Resolution) -> float:
    """SAC of S, A and the result at a resolution, nats, with the correction of Miller and Madow."""
    return _sac(np.moveaxis(_table(given, resolution), 0, 2))


def local_contingency(given: Transitions, resolution: Resolution) -> np.ndarray:
    """(n,) local SAC of each transition, nats, uncorrected."""
    counts = _table(given, resolution)
    r, s, a, after = _coded(given, resolution)

    def share(axes: tuple[int, ...]) -> np.ndarray:
        joint = counts.sum(axis=axes, keepdims=True)
        with np.errstate(invalid="ignore"):
            shares: np.ndarray = joint / joint.sum(axis=3, keepdims=True)
        of_each: np.ndarray = np.broadcast_to(shares, counts.shape)[r, s, a, after]
        return of_each

    local: np.ndarray = np.log(share(()) * share((1, 2)) / (share((1,)) * share((2,))))
    return local


class Growth:
    """A resolution that grows with experience.

    Attributes:
        resolution: Values of S and A now.
        steps: Splits so far.
    """

    def __init__(self, prototypes: np.ndarray, space: np.ndarray, config: ResolutionConfig = ResolutionConfig()):
        """Begin with the coarsest values.

        Args:
            prototypes: (k, n) prototypes of sensations.
            space: (d, 2) lower and upper bounds of commands.
            config: When values are split.
        """
        self.config = config
        self.resolution = coarse(len(prototypes), space)
        self.steps: list[Step] = []
        self._branches = branches(prototypes, config.linkage)
        self._next = config.warm_up

    def due(self, n_transitions: int) -> bool:
        """Whether so many transitions are enough to test for splits again."""
        return n_transitions >= self._next

    def update(self, given: Transitions) -> list[Step]:
        """Split values by all transitions ``given`` so far, if enough of them are new; returns the splits."""
        n_transitions, known = len(given.units), len(self.steps)
        if not self.due(n_transitions):
            return []
        self._next = int(n_transitions * (1 + self.config.look_again)) + 1
        while (split := self._best(given)) is not None:
            self.resolution = refined(self.resolution, split)
            self.steps.append(Step(n_transitions, split, self.resolution, contingency(given, self.resolution)))
        return self.steps[known:]

    def _best(self, given: Transitions) -> Split | None:
        """The split with the highest gain; a pair only where no split of S or of A alone gains enough."""
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
    """The resolution after a split; new values come last."""
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
    """Every split of S, every cut of A, and with each cut the best split of S.

    Args:
        given: All transitions.
        resolution: Values of S and A.
        tree: Branches, as sets of prototypes.
        cuts: Cuts that are tried along each axis of a box.
    """
    counts, per_unit = _by_unit(given, resolution, 1 + max(max(branch) for branch in tree))
    own = _Branches(resolution, tree, counts)
    had = own.value(counts)
    for leaf, branch, value in own.splits(counts):
        yield Split("S", leaf, branch, -1, 0, 0.0, value - had)
    for box, axis, at, above in _cuts(given, resolution, per_unit, counts.shape, cuts):
        cut = np.concatenate([counts, above[:, None]], axis=1)
        cut[:, box] -= above
        yield Split("A", -1, frozenset(), box, axis, at, own.value(cut) - had)
        leaf, branch, value = max(own.splits(cut), key=lambda split: split[2], default=(-1, frozenset[int](), -np.inf))
        if leaf >= 0:
            yield Split("S and A", leaf, branch, box, axis, at, value - had)


class _Branches:
    """All splits of S, whose contingencies are computed together for any partition of A."""

    def __init__(self, resolution: Resolution, tree: list[frozenset[int]], by_unit: np.ndarray):
        """``by_unit`` (units + 1, A, R, R'): counts by prototype; those that never occurred are not split off."""
        self._leaves = [np.array(sorted(leaf), int) for leaf in resolution.sensed]
        used = set(np.flatnonzero(by_unit[:-1].sum(axis=(1, 2, 3))))
        self._inside: list[tuple[int, frozenset[int]]] = []
        tried = set[tuple[int, frozenset[int]]]()
        for number, leaf in enumerate(resolution.sensed):
            for branch in tree:
                part, of = branch & leaf & used, leaf & used
                if part and part != of and not {(number, part), (number, of - part)} & tried:
                    tried.add((number, part))
                    self._inside.append((number, branch & leaf))
        self._member = np.zeros((len(self._inside), len(by_unit)))
        for row, (_, branch) in zip(self._member, self._inside, strict=True):
            row[list(branch)] = 1
        self._of = np.array([number for number, _ in self._inside], int)

    def value(self, by_unit: np.ndarray) -> float:
        """Corrected SAC, nats, at the partition of A in ``by_unit`` (units + 1, A, R, R')."""
        return _sac(self._by_leaf(by_unit))

    def splits(self, by_unit: np.ndarray) -> Iterator[tuple[int, frozenset[int], float]]:
        """Of each split: value of S, branch, and corrected SAC after it, nats."""
        leaves = self._by_leaf(by_unit)
        inside = (self._member @ by_unit.reshape(len(by_unit), -1)).reshape(len(self._of), *by_unit.shape[1:])
        rise = _rise(inside, leaves[self._of])
        rise -= _rise(inside.sum(axis=1, keepdims=True), leaves[self._of].sum(axis=1, keepdims=True))
        values = _sac(leaves) + rise / by_unit.sum()
        for (number, branch), value in zip(self._inside, values, strict=True):
            yield number, branch, float(value)

    def _by_leaf(self, by_unit: np.ndarray) -> np.ndarray:
        """Counts (S, A, R, R')."""
        return np.stack([*(by_unit[leaf].sum(axis=0) for leaf in self._leaves), by_unit[-1]])


def _h(counts: np.ndarray) -> np.ndarray:
    """c ln c - [c > 0] / 2: sums of it are the entropies of counts, as Miller and Madow correct them."""
    corrected: np.ndarray = counts * np.log(np.maximum(counts, 1)) - 0.5 * (counts > 0)
    return corrected


def _p(counts: np.ndarray) -> np.ndarray:
    """P of ``contingency.counts``, corrected, of counts (..., A, R, R')."""
    p: np.ndarray = _h(counts).sum(axis=(-3, -2, -1)) - _h(counts.sum(axis=-1)).sum(axis=(-2, -1))
    return p


def _rise(inside: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """Rise of P when counts (..., A, R, R') are told apart into those ``inside`` and the rest."""
    rise: np.ndarray = _p(inside) + _p(whole - inside) - _p(whole)
    return rise


def _sac(counts: np.ndarray) -> float:
    """SAC, nats, corrected, of counts (S, A, R, R')."""
    per_action, per_sensor = counts.sum(axis=0, keepdims=True), counts.sum(axis=1, keepdims=True)
    alone = per_action.sum(axis=1, keepdims=True)
    return float((_p(counts).sum() - _p(per_action) - _p(per_sensor).sum() + _p(alone)).item() / counts.sum())


def _coded(given: Transitions, resolution: Resolution) -> tuple[np.ndarray, ...]:
    """Series r, s, a and r', (n,) each."""
    return given.before, resolution.sensor(given.units), resolution.action(given.commands), given.after


def _counted(codes: tuple[np.ndarray, ...], shape: tuple[int, ...]) -> np.ndarray:
    return np.bincount(np.ravel_multi_index(codes, shape), minlength=int(np.prod(shape))).reshape(shape).astype(float)


def _table(given: Transitions, resolution: Resolution) -> np.ndarray:
    """Counts (R, S, A, R')."""
    results = int(max(given.before.max(), given.after.max())) + 1
    shape = (results, len(resolution.sensed) + 1, len(resolution.boxes) + 1, results)
    return _counted(_coded(given, resolution), shape)


def _by_unit(given: Transitions, resolution: Resolution, prototypes: int) -> tuple[np.ndarray, np.ndarray]:
    """Counts (prototypes + 1, A, R, R'), and of each transition the number (n,) of its (prototype, r, r')."""
    units = np.where(given.units == NOTHING_SENSED, prototypes, given.units)
    results = int(max(given.before.max(), given.after.max())) + 1
    shape = (prototypes + 1, len(resolution.boxes) + 1, results, results)
    counts = _counted((units, resolution.action(given.commands), given.before, given.after), shape)
    return counts, np.ravel_multi_index((units, given.before, given.after), (shape[0], results, results))


def _cuts(
    given: Transitions, resolution: Resolution, per_unit: np.ndarray, shape: tuple[int, ...], cuts: int
) -> Iterator[tuple[int, int, float, np.ndarray]]:
    """Of each cut: box, axis, position, and the counts (prototypes + 1, R, R') beyond it."""
    rest = shape[0], *shape[2:]
    action = resolution.action(given.commands)
    for box in range(len(resolution.boxes)):
        own = np.flatnonzero(action == box)
        for axis in range(given.commands.shape[1]):
            along = given.commands[own, axis]
            if len(along) <= cuts:
                continue
            positions = np.unique(np.quantile(along, np.arange(1, cuts + 1) / (cuts + 1)))
            between = np.searchsorted(positions, along, side="right")
            size = int(np.prod(rest))
            fine = np.bincount(between * size + per_unit[own], minlength=(len(positions) + 1) * size)
            beyond = np.cumsum(fine.reshape(len(positions) + 1, *rest)[::-1], axis=0)[::-1]
            for number, at in enumerate(positions, 1):
                yield box, axis, float(at), beyond[number]
