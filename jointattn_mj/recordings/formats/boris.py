"""BORIS: tabular events, with a row where a state starts and one where it stops, and aggregated events.

Behaviours of one category are values of one tier, such as ``infant.gaze``; without categories those of one subject.
"""

from collections.abc import Sequence

from jointattn_mj.recordings.event_layout import EventLayout, EventTrack


def layout(names: Sequence[str]) -> EventLayout | None:
    """Which columns say what; None where the names are not those of BORIS."""
    at = {name.casefold(): i for i, name in reversed(list(enumerate(names)))}
    if "behavior" not in at or "subject" not in at:
        return None
    category = at.get("behavioral category")
    tier = (at["subject"], *([] if category is None else [category]))
    code = (at["behavior"], *_modifiers(names, at))
    recording = tuple(at[name] for name in ("observation id",) if name in at)
    if "start (s)" in at and "stop (s)" in at:
        track = EventTrack(
            at["start (s)"], at["stop (s)"], at.get("duration (s)"), code, tier, moment=at.get("behavior type")
        )
    elif "time" in at and ("behavior type" in at or "status" in at):
        track = EventTrack(at["time"], None, None, code, tier, kind=at.get("behavior type", at.get("status")))
    else:
        return None
    return EventLayout((track,), recording, "s")


def _modifiers(names: Sequence[str], at: dict[str, int]) -> list[int]:
    """Columns of modifiers: by their names, or between category and type, where newer versions name them by sets."""
    named = [i for i, name in enumerate(names) if name.casefold().startswith("modifier")]
    if named or not {"behavioral category", "behavior type"} <= set(at):
        return named
    return list(range(at["behavioral category"] + 1, at["behavior type"]))
