"""Names of the measures: one table for the Python API, for the command line and for the robot's detector."""

from collections.abc import Iterable
from typing import NamedTuple

from jointattn_mj.errors import SeriesError
from jointattn_mj.options import Choice, meant, shown


class MeasureName(NamedTuple):
    """A measure's names; each is accepted wherever a measure is chosen, in any case."""

    full: str
    """Of the function that computes it."""
    short: str
    symbol: str
    """As the dissertation writes it, and as tables print it."""


NAMES = (
    MeasureName("state_action_contingency", "sac", "SAC"),
    MeasureName("combined_transfer_entropy", "tc", "T^C"),
    MeasureName("transfer_entropy", "te", "TE(s -> r)"),
    MeasureName("mutual_information", "mi", "I(s; r')"),
    MeasureName("conditional_mutual_information", "cmi", "I(s; r' | a)"),
)
OF_EVENTS = ("sac", "tc")
"""Short names of the measures that rank events (sensor, action) -> result."""


def full_name(name: str, among: Iterable[str] | None = None) -> str:
    """The full name of a measure.

    Args:
        name: One of its names, in any case.
        among: Short names of the measures that are allowed; all by default.

    Raises:
        SeriesError: No such measure, or not one of those that are allowed.
    """
    allowed = [names for names in NAMES if among is None or names.short in among]
    for names in allowed:
        if isinstance(name, str) and name.lower() in {each.lower() for each in names}:
            return names.full
    expected = ", ".join(f"{names.full} ({names.short})" for names in allowed)
    near = meant(name, [each for names in allowed for each in names])
    raise SeriesError(f"measure: expected one of {expected}; got {shown(name)}{near}")


def measure_choice(names: Iterable[str]) -> Choice:
    """Marks a field of a config that is the short name of a measure; the other names are accepted, too.

    Args:
        names: Short names of the measures that are allowed.
    """
    chosen = [name for name in NAMES if name.short in names]
    return Choice(
        [measure.short for measure in chosen],
        other_names={each: measure.short for measure in chosen for each in measure},
    )
