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
    allowed = [one for one in NAMES if among is None or one.short in among]
    for one in allowed:
        if isinstance(name, str) and name.lower() in {each.lower() for each in one}:
            return one.full
    expected = ", ".join(f"{one.full} ({one.short})" for one in allowed)
    near = meant(name, [each for one in allowed for each in one])
    raise SeriesError(f"measure: expected one of {expected}; got {shown(name)}{near}")


def measure_choice(names: Iterable[str]) -> Choice:
    """Marks a field of a config that is the short name of a measure; the other names are accepted, too.

    Args:
        names: Short names of the measures that are allowed.
    """
    chosen = [one for one in NAMES if one.short in names]
    return Choice([one.short for one in chosen], other_names={each: one.short for one in chosen for each in one})
