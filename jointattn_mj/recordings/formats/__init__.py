"""Event tables of coding programs: which columns say what, told from the names of the columns."""

from collections.abc import Callable, Sequence
from typing import Literal

from jointattn_mj.recordings.event_layout import EventLayout
from jointattn_mj.recordings.formats import boris, interact, observer, plain

Format = Literal["auto", "steps", "events", "boris", "datavyu", "elan", "interact", "observer"]
"""What a file is: a table with a row for every step, any table of events, or what a coding program writes."""

LAYOUTS: dict[str, Callable[[Sequence[str]], EventLayout | None]] = {
    "boris": boris.layout,
    "observer": observer.layout,
    "interact": interact.layout,
    "events": plain.layout,
}
"""For a format, what finds its columns among the names of a header; in the order in which they are tried."""


def event_layout(names: Sequence[str], chosen: Format = "auto") -> EventLayout | None:
    """Which columns say what in an event table; None where the names are those of no event table."""
    name = {"datavyu": "events", "elan": "events"}.get(chosen, chosen)
    layouts = (find(names) for known, find in LAYOUTS.items() if name in ("auto", known))
    return next((layout for layout in layouts if layout is not None), None)
