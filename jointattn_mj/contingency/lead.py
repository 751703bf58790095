"""Local contingency of an event in whole series: how contingent it is where it holds, and whether that is chance.

SAC (eq. 5.2) weighs each situation (r, s) by how often it comes, so that an event that is strong but rare ranks below
one that is weak but frequent. Here an event is worth the mean of D(r, s) (see ``situations``) over those of its
situations that are surest to be contingent, as in the detector's stop rule ``local``: sorted by the mean of their
posterior, the first ones that fill a share of the transitions, and of such sets the one whose mean less some standard
deviations is highest. Posterior draws say how much is known of it. They take transitions as exchangeable, and the best
set is chosen on the same data; whether there is anything at all is therefore told by surrogates, for each of which the
set is chosen anew.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from jointattn_mj.contingency.displaced import displaced, moves
from jointattn_mj.contingency.information import CONTINGENCY
from jointattn_mj.contingency.memory import memory
from jointattn_mj.contingency.online.local_values import Weighing, value_of
from jointattn_mj.contingency.series import combined
from jointattn_mj.contingency.significance import Significance, Surrogate, TestOptions, chosen_method, drawn
from jointattn_mj.contingency.situations import Policy, PosteriorOptions, Situations, situations_of_steps
from jointattn_mj.contingency.table import Steps
from jointattn_mj.errors import SeriesError
from jointattn_mj.options import Checked, NotNegative, Positive, Real, Whole

MOST_ENTRIES = 2**20
"""Largest table of counts of (r, s, a, r')."""


@dataclass(frozen=True)
class LeadOptions(Checked):
    """How local contingency weighs situations.

    Examples:
        >>> LeadOptions(policy="reference", draws=200).smallest_share
        0.05
    """

    policy: Policy = "actual"
    """Over which actions a situation's contingency is taken: as often as each was done (actual), or each equally
    (reference), so that habits of acting do not count."""
    smallest_share: Annotated[float, Real("(0, 1]")] = 0.05
    """Share of steps that an event's situations must fill together. What is rarer is not looked for; 1 ranks by SAC."""
    deviations: NotNegative = 3.0
    """Situations are chosen by the mean of the posterior less so many standard deviations."""
    concentration: Positive = 2.0
    """Steps that the prior "the sensor says nothing" is worth in each situation and action."""
    draws: Annotated[int, Whole("[2, 1e5]")] = 1000
    """Draws from the posterior, behind intervals and the probability of being the first."""
    level: Annotated[float, Real("(0, 1)")] = 0.95
    """Probability that the interval holds."""


@dataclass(frozen=True)
class LeadSituation:
    """A situation (r, s) in which an event is contingent; in units of the logarithm's base."""

    result: int
    """r before the step."""
    sensor: int
    """What was sensed."""
    transitions: int
    """How often it came."""
    value: float
    """D(r, s), mean of the posterior."""
    interval: tuple[float, float]
    """Where the posterior lies."""


@dataclass(frozen=True, repr=False)
class Lead:
    """Where an event is surest to be contingent, and what is known of it.

    Examples:
        >>> from jointattn_mj.contingency import TestOptions, discover
        >>> face, gaze = np.random.default_rng(0).integers(0, 3, (2, 600))
        >>> toy = np.append(0, (face == gaze) & (face == 2))[:-1].astype(int)  # only the third face says something
        >>> data = {"face": face, "gaze": gaze, "toy": toy}
        >>> options = TestOptions(surrogates=99)
        >>> (finding,) = discover(data, ["face"], ["gaze"], ["toy"], measure="local", options=options)
        >>> {situation.sensor for situation in finding.lead.situations}
        {2}
    """

    significance: Significance
    """``value`` is the mean of the posterior, and ``interval`` its interval; the rest is of surrogates."""
    draws: np.ndarray
    """(draws,) of the value from the posterior."""
    share: float
    """Share of the transitions that the situations fill."""
    situations: tuple[LeadSituation, ...]
    """The most contingent first."""

    def __repr__(self) -> str:
        return f"Lead({self.significance.value:.3g} in {self.share:.0%} of the transitions, {self.significance!r})"


def lead_of_steps(
    given: Steps,
    how: LeadOptions,
    options: TestOptions,
    unit: float,
    rng: np.random.Generator,
    progress: Callable[[int], object] = lambda done: None,
) -> Lead:
    """Find where an event is surest to be contingent, in series that are checked.

    Args:
        given: The transitions, with one past value of the result.
        how: How situations are weighed.
        options: Number and kind of surrogates; nothing is resampled.
        unit: Natural logarithm of the base.
        rng: Draws from the posterior, then surrogates.
        progress: Called with the number of surrogates drawn since the last call.

    Raises:
        SeriesError: Too many values.
    """
    _check_size(given)
    posterior = PosteriorOptions(how.draws, how.concentration)
    situations = situations_of_steps(given, how.policy, unit, posterior, rng)
    chosen = surest(situations, how)
    weight = situations.share[chosen] / situations.share[chosen].sum()
    draws: np.ndarray = situations.draws[:, chosen] @ weight
    tails = np.array([0.5 - how.level / 2, 0.5 + how.level / 2])
    low, high = np.quantile(draws, tails)
    limits = np.quantile(situations.draws[:, chosen], tails, axis=0)
    leading = tuple(
        LeadSituation(
            int(situations.result[i]),
            int(situations.sensor[i]),
            int(situations.transitions[i]),
            float(situations.draws[:, i].mean()),
            (float(limits[0, at]), float(limits[1, at])),
        )
        for at, i in enumerate(chosen)
    )
    null, bounds, kind, inflation, exchangeable = _surrogates(given, how, options, rng, progress)
    value, of_chance, spread = float(draws.mean()), float(null[:, 0].mean()) / unit, float(null[:, 0].std()) / unit
    surely = bounds[1] >= bounds[0] - 1e-12
    significance = Significance(
        value=value,
        corrected=value - of_chance,
        null_mean=of_chance,
        null_sd=spread,
        z=(value - of_chance) / spread if spread > 1e-12 else 0.0,
        p=float((1 + surely.sum()) / (1 + len(null))),
        interval=(float(low), float(high)),
        level=how.level,
        transitions=given.transitions,
        exchangeable=exchangeable,
        surrogates=len(null),
        resampled="posterior",
        method=kind,
        inflation=inflation,
        null=null[:, 0] / unit,
    )
    return Lead(significance, draws, float(situations.share[chosen].sum()), leading)


def _check_size(given: Steps) -> None:
    """Refuse a table that is too large."""
    r, a, s, n = (len(np.unique(column)) for column in given.columns())
    if r * s * a * n > MOST_ENTRIES:
        raise SeriesError(
            f"local contingency keeps a table of all values: expected at most {MOST_ENTRIES:,} entries; got "
            f"{r} x {s} x {a} x {n}. Sort the values into fewer bins"
        )


def surest(situations: Situations, how: LeadOptions) -> np.ndarray:
    """Choose the situations in which an event is surest to be contingent.

    Args:
        situations: All situations, with posterior draws.
        how: How they are weighed.

    Returns:
        Their numbers, the most contingent first.

    Examples:
        >>> from jointattn_mj.contingency.situations import situation_contingency
        >>> rng = np.random.default_rng(0)
        >>> face, gaze = rng.integers(0, 3, (2, 600))
        >>> toy = np.append(0, (face == gaze) & (face == 2))[:-1].astype(int)  # only the third face says something
        >>> situations = situation_contingency(face, gaze, toy, posterior=PosteriorOptions(draws=100))
        >>> sorted(set(situations.sensor[surest(situations, LeadOptions(draws=100))].tolist()))
        [2]
    """
    order = np.argsort(-situations.draws.mean(axis=0), kind="stable")
    share = situations.share[order]
    filled = np.cumsum(share)
    means = np.cumsum(share * situations.draws.mean(axis=0)[order]) / filled
    spreads = np.sqrt(np.cumsum(share**2 * situations.draws.var(axis=0)[order])) / filled
    bounds = np.where(filled >= how.smallest_share - 1e-12, means - how.deviations * spreads, -np.inf)
    return order[: int(bounds.argmax()) + 1]


@dataclass(frozen=True)
class _Permutations:
    """The source in other orders, changing places within each stratum; as pieces of one transition each."""

    stratum: np.ndarray

    def draw(self, count: int, rng: np.random.Generator) -> Iterator[np.ndarray]:
        """See ``displaced.Moves``."""
        at = np.argsort(self.stratum, kind="stable")
        for _ in range(count):
            pieces = np.ones((len(at), 3), np.int64)
            pieces[at, 0] = at
            pieces[at, 1] = np.lexsort((rng.random(len(at)), self.stratum))
            yield pieces


def _surrogates(
    given: Steps,
    how: LeadOptions,
    options: TestOptions,
    rng: np.random.Generator,
    progress: Callable[[int], object],
) -> tuple[np.ndarray, tuple[float, np.ndarray], str, float, int]:
    """Values of surrogates (surrogates, 2), nats: mean, and mean less deviations; the series' own bound and theirs; the
    method; and what significance tells of it."""
    remembered = memory(given, CONTINGENCY)
    method = chosen_method(given, remembered, options)
    table = displaced(given, [CONTINGENCY])
    (r, a, n), source = (np.unique(codes, return_inverse=True)[1] for codes in table.rest), np.arange(len(table.source))
    shape = int(r.max()) + 1, len(source), int(a.max()) + 1, int(n.max()) + 1
    weighing = Weighing(
        float(how.concentration), float(how.smallest_share), float(how.deviations), how.policy == "actual",
        how.policy == "reference",
    )  # fmt: skip

    def values(pieces: np.ndarray) -> np.ndarray:
        counts = np.zeros(shape)
        counts[r[:, None], source[None], a[:, None], n[:, None]] = table.counter.table(pieces)
        lead, hoped = np.zeros(2), np.zeros(2)
        value_of(counts, how.policy == "reference", weighing, lead, hoped)
        return np.array([lead[0], lead[0] - how.deviations * lead[1]])

    own = values(np.array([[0, 0, given.transitions]], np.int64))
    if method == "permutation":
        columns, sizes = given.columns(), given.sizes
        part = np.zeros(given.transitions, np.int64) if options.across_recordings else given.recordings()
        ways: Surrogate = _Permutations(combined([part, columns[0], columns[1]], [int(part[-1]) + 1, *sizes[:2]])[0])
    else:
        ways = moves(given, method, remembered.fresh_after, remembered.block)
    null = drawn(ways, values, given.transitions, options.surrogates, rng, progress)
    return null, (float(own[1]), null[:, 1]), method, remembered.inflation, table.exchangeable
