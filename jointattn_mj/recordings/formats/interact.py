"""Mangold INTERACT: an event list, with a column for each class of codes, in groups and sets."""

from collections.abc import Sequence

from jointattn_mj.recordings.event_layout import EventLayout, EventTrack

_GROUP, _SET = ("datagroup", "group"), ("dataset", "set")
_ONSET, _OFFSET = ("onset", "start time", "starttime", "start"), ("offset", "end time", "endtime", "end")
_OTHER = {"level", "event", "event no", "event number", "duration", "memo", "transcript", "comment", "lane", "no", "nr"}


def layout(names: Sequence[str]) -> EventLayout | None:
    """Which columns say what; None where the names are not those of INTERACT."""
    at = {name.casefold(): i for i, name in reversed(list(enumerate(names)))}
    group, set_, onset, offset = (
        next((at[name] for name in known if name in at), None) for known in (_GROUP, _SET, _ONSET, _OFFSET)
    )
    level = at.get("level")
    if onset is None or offset is None or (level is None and (group is None or set_ is None)):
        return None
    used = {group, set_, onset, offset, level}
    classes = [i for i, name in enumerate(names) if i not in used and name and name.casefold() not in _OTHER]
    tracks = tuple(EventTrack(onset, offset, None, (i,), name=names[i], alone=len(classes) == 1) for i in classes)
    recording = tuple(i for i in (group, set_) if i is not None)
    return EventLayout(tracks, recording, level=level) if tracks else None
