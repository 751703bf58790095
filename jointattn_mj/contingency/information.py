"""What all measures have in common: n * I(n; s | context) from the table, corrections for its bias, upper bounds.

Every measure is information that s gives on what comes next, n, in a context, less such information in a coarser one.
As signed sums of entropies, I(n; s | z) = H(n, z) + H(s, z) - H(z) - H(n, s, z).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from jointattn_mj.contingency.table import Entries, dense_information

Correction = Literal["none", "miller_madow", "degrees_of_freedom", "shuffle"]
"""What is taken off the plug-in value. ``miller_madow``: each entropy gains (observed entries - 1) / 2n.
``degrees_of_freedom``: df / 2n, what the plug-in expects of independent n and s, where df adds up (values of n - 1)
(values of s - 1) as observed within each context. ``shuffle``: the mean of surrogates (see ``surrogates``)."""

Normalise = Literal["none", "result", "smallest"]
"""What the value is divided by. ``result``: the uncertainty H(n | context) of the result. ``smallest``: that, or the
source's H(s | context) where it is smaller (for SAC also the action's, H(a | r)), so that variables of unequal numbers
of values compare (section 4.6). Plug-in values then lie in 0..1 (SAC: -1..1), and are 0 where the bound is 0; corrected
ones may go beyond a little. The context is the finest one that the measure conditions on, for SAC the coarser, r."""


@dataclass(frozen=True)
class Measure:
    """I(n; s | given) - I(n; s | less), named by axes of the table."""

    name: str
    given: str
    less: str | None = None

    def local(self, entries: Entries) -> np.ndarray:
        """Contribution (m,) of one transition in each entry, nats; its mean over transitions is the measure."""
        inner = entries.information(self.given)
        return inner if self.less is None else inner - entries.information(self.less)

    def value(self, entries: Entries) -> float:
        """Plug-in value in nats."""
        return float(entries.counts @ self.local(entries)) / entries.transitions

    def dense_value(self, table: np.ndarray, transitions: int) -> float:
        """The same of a table over (r, a, s, n) of so many transitions."""
        total = dense_information(table, self.given)
        if self.less is not None:
            total -= dense_information(table, self.less)
        return total / transitions

    def bias(self, entries: Entries, correction: Literal["miller_madow", "degrees_of_freedom"]) -> float:
        """What ``correction`` takes off, nats; of either sign for SAC."""
        excess = _occupied if correction == "miller_madow" else _degrees
        twice = excess(entries, self.given) - (0 if self.less is None else excess(entries, self.less))
        return twice / (2 * entries.transitions)

    def bound(self, entries: Entries, normalise: Literal["result", "smallest"]) -> float:
        """What ``normalise`` divides by, nats."""
        context = self.given if self.less is None else self.less
        others = "n" if normalise == "result" else "ns" if self.less is None else "nsa"
        return min(entries.entropy(axis, context) for axis in others)


TRANSFER = Measure("TE(s -> r)", "r")
"""Eq. 4.1, 5.1."""
COMBINED = Measure("T^C", "ra")
"""Eq. 4.3: TE(s -> r | a)."""
CONTINGENCY = Measure("SAC", "ra", "r")
"""Eq. 5.2: TE(s, a -> r) - TE(s -> r) - TE(a -> r) = TE(s -> r | a) - TE(s -> r)."""
MUTUAL = Measure("I(s; r')", "")
"""Mutual information of the source and the next result."""
CONDITIONAL_MUTUAL = Measure("I(s; r' | a)", "a")
"""The same given another variable."""


def _occupied(entries: Entries, given: str) -> int:
    """Occupied entries of the four marginals of I(n; s | given), with the signs that their entropies do not have."""
    count = {axes: len(entries.distribution(given + axes)) for axes in ("", "n", "s", "sn")}
    return count[""] + count["sn"] - count["n"] - count["s"]


def _degrees(entries: Entries, given: str) -> int:
    """Degrees of freedom of independence of n and s, added up over the contexts."""
    contexts, bound = entries.ids(given)
    values = []
    for axis in "ns":
        first = np.unique(entries.ids(given + axis)[0], return_index=True)[1]
        values.append(np.bincount(contexts[first], minlength=bound))
    return int(np.sum((values[0] - 1) * (values[1] - 1) * (values[0] > 0)))
