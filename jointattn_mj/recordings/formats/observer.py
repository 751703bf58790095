"""Noldus Observer XT: the event log, with a row where a state starts and one where it stops.

Behaviours of one subject are values of one tier.
"""

from collections.abc import Sequence

from jointattn_mj.recordings.event_layout import EventLayout, EventTrack

TIMES = ("time_relative_sf", "time_relative_hms", "time_relative_hmsf", "time_relative_s", "time_relative_f")
"""Columns of times, the more exact first."""


def layout(names: Sequence[str]) -> EventLayout | None:
    """Which columns say what; None where the names are not those of an event log."""
    at = {name.casefold().replace(" ", "_"): i for i, name in reversed(list(enumerate(names)))}
    time = next((at[name] for name in TIMES if name in at), None)
    if time is None or "behavior" not in at or "event_type" not in at:
        return None
    modifiers = [i for name, i in sorted(at.items(), key=lambda item: item[1]) if name.startswith("modifier")]
    tier = tuple(at[name] for name in ("subject",) if name in at)
    recording = tuple(at[name] for name in ("observation",) if name in at)
    track = EventTrack(time, None, at.get("duration_sf"), (at["behavior"], *modifiers), tier, kind=at["event_type"])
    return EventLayout((track,), recording, "s")
