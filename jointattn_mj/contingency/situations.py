"""Contingency situation by situation: how strongly each pair (r, s) makes the next result depend on s and a together.

SAC (eq. 5.2) of a whole series weighs each situation by how often it comes. A situation that is rare but strongly
contingent then looks weak. Here each has a value of its own,

    D(r, s) = sum_a u(a) KL(p(r' | r, s, a) || p(r' | r, a)) - KL(sum_a u(a) p(r' | r, s, a) || q(r'))

for a policy u over the actions that were seen in it. With the ``actual`` policy, u(a) = p(a | r, s) and q = p(r' | r):
the sum of all D, weighed by the situations' shares of time, is SAC exactly. With the ``reference`` policy, u is uniform
and q = sum_a u(a) p(r' | r, a): what was done often or seldom does not count, as long as it was done.

Few transitions give large values by chance. A posterior says how much is known: p(r' | r, s, a) has a Dirichlet prior
around p(r' | r, a), which says that s tells nothing, worth ``concentration`` transitions.
"""

from dataclasses import dataclass
from typing import Annotated, Literal, get_args

import numpy as np

from jointattn_mj.contingency.series import Coded, Series, check_base
from jointattn_mj.contingency.significance import generator
from jointattn_mj.contingency.table import Steps, acted
from jointattn_mj.errors import SeriesError
from jointattn_mj.options import Checked, Real, Whole, shown

Policy = Literal["actual", "reference"]
"""Over which actions a situation's contingency is taken: as often as each was done, or each equally."""


@dataclass(frozen=True)
class PosteriorOptions(Checked):
    """How many draws tell what is known of each situation, and from which prior.

    Examples:
        >>> rng = np.random.default_rng(0)
        >>> face, gaze = rng.integers(0, 2, (2, 300))
        >>> toy = np.append(0, face == gaze)[:-1].astype(int)
        >>> known = situation_contingency(face, gaze, toy, posterior=PosteriorOptions(draws=50))
        >>> known.draws.shape == (50, len(known.value))
        True
    """

    draws: Annotated[int, Whole("[0, 1e6]")] = 0
    """Posterior draws of every value; 0 leaves them out."""
    concentration: Annotated[float, Real("(0, 1e9]")] = 2.0
    """Transitions that the prior "s says nothing" is worth."""


@dataclass(frozen=True)
class Situations:
    """Contingency of each situation (r, s) that was seen k times in all; in units of the logarithm's base."""

    result: np.ndarray
    """(k,) code of the result r before the step."""
    sensor: np.ndarray
    """(k,) code of what was sensed."""
    transitions: np.ndarray
    """(k,) how often the situation came."""
    value: np.ndarray
    """(k,) plug-in values D(r, s); negative where sensor and action say the same."""
    draws: np.ndarray
    """(draws, k) posterior draws of D."""
    policy: Policy
    """Policy over actions."""

    @property
    def share(self) -> np.ndarray:
        """(k,) share of all transitions."""
        share: np.ndarray = self.transitions / self.transitions.sum()
        return share

    def total(self) -> float:
        """Sum up the values, weighed by their shares.

        Returns:
            SAC with the actual policy, in units of the base.

        Examples:
            >>> s, a, r = [0, 1, 1, 0, 1, 0, 0, 1], [0, 0, 1, 1, 0, 1, 0, 0], [0, 0, 1, 0, 1, 1, 1, 0]
            >>> round(situation_contingency(s, a, r).total(), 3)
            0.749
        """
        return float(self.share @ self.value)

    def __repr__(self) -> str:
        first = int(self.value.argmax())
        return (
            f"Situations({len(self.value)}, {self.policy} policy, total {self.total():.3g}, highest "
            f"{self.value[first]:.3g} at r = {self.result[first]}, s = {self.sensor[first]})"
        )


def situation_contingency(
    s: Series,
    a: Series,
    r: Series,
    policy: Policy = "actual",
    base: float = 2,
    *,
    posterior: PosteriorOptions | None = None,
    seed: int | np.random.Generator = 0,
) -> Situations:
    """Measure how contingent each situation (r, s) is.

    Args:
        s: What is sensed, (T,) integer codes, or a list of such arrays, one a recording.
        a: What is done, of the same lengths.
        r: What comes of it, likewise.
        policy: ``actual`` or ``reference`` (see the module).
        base: Base of the logarithm: 2 for bits.
        posterior: Number of posterior draws and the prior; None: no draws.
        seed: Seed of the draws, or a generator.

    Returns:
        A value for each situation that was seen, by r, then s.

    Raises:
        SeriesError: The series cannot be measured, or there is no such policy.

    Examples:
        >>> s, a = [0, 1, 1, 0, 1, 0, 0, 1], [0, 0, 1, 1, 0, 1, 0, 0]
        >>> r = [0, 0, 1, 0, 1, 1, 1, 0]  # whether s and a differed a step before
        >>> situations = situation_contingency(s, a, r)
        >>> round(situations.total(), 3)  # the same as state_action_contingency(s, a, r)
        0.749
    """
    if not isinstance(policy, str) or policy not in get_args(Policy):
        raise SeriesError(f"policy must be one of {', '.join(get_args(Policy))}; got {shown(policy)}")
    return situations_of_steps(acted(s, a, r), policy, check_base(base), posterior or PosteriorOptions(), seed)


def situations_of_steps(
    given: Steps, policy: Policy, unit: float, posterior: PosteriorOptions, seed: int | np.random.Generator = 0
) -> Situations:
    """Measure situations of series that are checked (see ``situation_contingency``).

    Args:
        given: The transitions.
        policy: Over actions.
        unit: Natural logarithm of the base.
        posterior: Number of posterior draws and the prior.
        seed: Seed of the draws, or a generator.
    """
    entries = given.entries()
    before, action, source, after = entries.columns
    after = np.unique(after, return_inverse=True)[1]
    taken, of_taken = _numbered(before, source, action)
    counts = np.zeros((len(taken), int(after.max()) + 1))
    np.add.at(counts, (of_taken, after), entries.counts)
    situation, of_situation = _numbered(taken[:, 0], taken[:, 1])
    n = counts.sum(axis=1)
    whole = np.bincount(of_situation, n)
    weight = n / whole[of_situation] if policy == "actual" else 1 / np.bincount(of_situation)[of_situation]
    expected = _pooled(counts, _numbered(taken[:, 0], taken[:, 2])[1])
    if policy == "actual":
        baseline = _pooled(counts, _numbered(taken[:, 0])[1])[np.unique(of_situation, return_index=True)[1]]
    else:
        baseline = _mixed(expected, weight, of_situation)

    def values(p: np.ndarray) -> np.ndarray:
        each = np.bincount(of_situation, weight * _divergence(p, expected))
        value: np.ndarray = (each - _divergence(_mixed(p, weight, of_situation), baseline)) / unit
        return value

    rng, prior = generator(seed), counts + posterior.concentration * expected
    draws = np.empty((posterior.draws, len(situation)))
    for draw in draws:
        gamma = rng.standard_gamma(prior)
        draw[:] = values(gamma / gamma.sum(axis=1, keepdims=True))
    result, sensor = _names(situation[:, 0], given.target), _names(situation[:, 1], given.source)
    return Situations(result, sensor, whole, values(counts / n[:, None]), draws, policy)


def _numbered(*columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Combinations (k, columns) that occur, in lexicographic order, and the number of each row's (n,)."""
    combinations, which = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
    return combinations, which.ravel()


def _pooled(counts: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Distribution (n, values) of the counts (n, values) of each row's group."""
    total = np.zeros((int(group.max()) + 1, counts.shape[1]))
    np.add.at(total, group, counts)
    pooled: np.ndarray = (total / total.sum(axis=1, keepdims=True))[group]
    return pooled


def _mixed(p: np.ndarray, weight: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Mixture (groups, values) of the rows of p (n, values) in each group, by weights (n,)."""
    mixed = np.zeros((int(group.max()) + 1, p.shape[1]))
    np.add.at(mixed, group, weight[:, None] * p)
    return mixed


def _divergence(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """KL(p || q) (n,) of rows (n, values), nats."""
    ratio = np.divide(p, q, out=np.ones_like(p), where=(p > 0) & (q > 0))
    divergence: np.ndarray = (p * np.log(np.where(p > 0, ratio, 1.0))).sum(axis=1)
    return divergence


def _names(codes: np.ndarray, coded: Coded) -> np.ndarray:
    """The codes as the caller has them."""
    names: np.ndarray = codes if coded.values is None else coded.values[codes]
    return names
