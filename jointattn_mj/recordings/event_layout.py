"""Which columns of an event table say what: onset, offset or duration, tier, code, recording."""

from dataclasses import dataclass

from jointattn_mj.recordings.times import TimeUnit


@dataclass(frozen=True)
class EventTrack:
    """Columns, by their locations, that together say what is coded from when to when."""

    onset: int
    offset: int | None
    duration: int | None
    """Used where there is no offset."""
    code: tuple[int, ...]
    """Columns of the code; several are joined by |."""
    tier: tuple[int, ...] = ()
    """Columns of the tier's name; several are joined by a full stop."""
    name: str = "events"
    """Name of the tier where no column tells it."""
    kind: int | None = None
    """Column that says whether a row starts an event, stops it, or is a point event."""
    moment: int | None = None
    """Column that says where an event is a point event, which may lack an offset."""
    alone: bool = True
    """Whether a row is an event although its code is blank: not where several codes share onset and offset."""


@dataclass(frozen=True)
class EventLayout:
    """What an event table's columns are."""

    tracks: tuple[EventTrack, ...]
    recording: tuple[int, ...] = ()
    """Columns that together name the recording, if any do."""
    unit: TimeUnit = "auto"
    """Unit of plain numbers where no column's name tells it."""
    level: int | None = None
    """Column in which only rows with 3 are events."""
