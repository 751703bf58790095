"""How p-values came about, in words: which surrogates, why these, and what else a reader should know."""

from collections.abc import Sequence

from jointattn_mj.contingency.significance import Significance

WORDS = {
    "permutation": "permutations of the source within its context",
    "shift": "circular shifts of the source within its recording",
    "bootstrap": "stationary bootstraps of the source within its recording",
    "partners": "the sources of other recordings",
}
"""By name of the method."""
ENOUGH_SHIFTS = 100
"""Fewer different surrogates than this are told of."""


def method_notes(named: Sequence[tuple[str, Significance]], asked: str, surrogates: int) -> list[str]:
    """Notes on the surrogates.

    Args:
        named: What was tested, and what was found.
        asked: The method that was asked for.
        surrogates: How many were asked for.
    """
    notes = []
    for method in dict.fromkeys(significance.method for _, significance in named):
        of_method = [(name, significance) for name, significance in named if significance.method == method]
        which = "" if len(of_method) == len(named) else f" of {_some([name for name, _ in of_method])}"
        low, high = (extreme(significance.inflation for _, significance in of_method) for extreme in (min, max))
        times = f"{low:.2f}" if f"{low:.2f}" == f"{high:.2f}" else f"{low:.2f} to {high:.2f}"
        why = ""
        if asked == "auto":
            why = (
                f"; measured autocorrelation changes the variance by chance to {times} times that of permutations"
                if method != "permutation"
                else f"; measured autocorrelation does not forbid it (variance by chance {times} times as large)"
            )
        notes.append(f"p and effective values{which} come from {WORDS[method]}{why}")
        few = min(significance.surrogates for _, significance in of_method)
        if few < min(surrogates, ENOUGH_SHIFTS):
            notes.append(f"there are only {few} different shifts, so p{which} cannot be below {1 / (few + 1):.3f}")
    if asked == "permutation" and any(significance.inflation > 1.1 for _, significance in named):
        worst = max(significance.inflation for _, significance in named)
        notes.append(
            f"looks are so long that by chance the measure varies {worst:.2f} times as much as permutations let it; p "
            "is too small. Take the method shift"
        )
    return notes


def _some(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) <= 3 else f"{len(names)} of them"
