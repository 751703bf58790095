"""From a table of events, whose columns are known, to events."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from jointattn_mj.errors import SeriesError
from jointattn_mj.io.progress import count
from jointattn_mj.options import shown
from jointattn_mj.recordings.event_layout import EventLayout, EventTrack
from jointattn_mj.recordings.events import Events, first_met
from jointattn_mj.recordings.groups import one_value
from jointattn_mj.recordings.labels import missing_labels, ordered
from jointattn_mj.recordings.table_files import TableFile
from jointattn_mj.recordings.texts import Texts
from jointattn_mj.recordings.tier_codes import dictionary
from jointattn_mj.recordings.times import TimeUnit, has_fraction, seconds, unit_of

START, STOP = {"start", "state start", "begin"}, {"stop", "state stop", "end"}
POINT = {"point", "state point", "point event", "event"}
"""What the kind of a row is called."""
PARTS = "|"
"""Stands between the parts of a code that several columns make."""


@dataclass(frozen=True)
class _TrackEvents:
    """Events of one track."""

    rows: np.ndarray
    """Row of each event, int64 (events,)."""
    tier: Texts
    code: Texts
    onset: np.ndarray
    offset: np.ndarray
    nameless: int
    """Events of no tier's name, where others have one."""


class _Columns:
    """Columns of a table, each with its different texts, blanks around them left out."""

    def __init__(self, table: TableFile, locations: Collection[int], missing: Collection[str]):
        self.table, self._missing = table, missing
        different = sorted(set(locations))
        columns = table.columns(different)
        self.rows: int = columns.num_rows
        self._columns = {i: dictionary(column) for i, column in zip(different, columns.columns, strict=True)}

    def texts(self, location: int) -> Texts:
        """A column of texts, those that stand for none left out."""
        numbers, names = self._columns[location]
        stripped = [name.strip() for name in names]
        none = missing_labels(stripped, self._missing)
        return Texts.numbered(numbers, ["" if name in none else name for name in stripped])

    def unit(self, location: int, unit: TimeUnit, layout: EventLayout) -> TimeUnit:
        """Unit of a column of times: as is said, its header, or the kind of table."""
        told: tuple[TimeUnit, ...] = unit, unit_of(self.table.header[location]), layout.unit
        return next((choice for choice in told if choice != "auto"), "auto")

    def has_fractions(self, location: int) -> bool:
        """Whether a column has numbers that are not whole."""
        return any(map(has_fraction, self._columns[location][1]))

    def times(self, location: int, unit: TimeUnit, rate: float | None) -> np.ndarray:
        """Seconds (rows,) of a column of times, NaN where missing."""
        header = self.table.header[location]
        numbers, names = self._columns[location]
        stripped = list(map(str.strip, names))
        none = missing_labels(stripped, self._missing)
        present = [i for i, name in enumerate(stripped) if name not in none]
        values = np.full(len(names) + 1, np.nan)
        values[present] = seconds([stripped[i] for i in present], unit, rate, f"column {header!r} of {self.table.path}")
        times: np.ndarray = values[numbers]
        return times

    def joined(self, locations: Sequence[int], between: str) -> Texts:
        """Texts of several columns together."""
        return Texts.joined([self.texts(location) for location in locations], between)


def read_event_table(
    table: TableFile,
    layout: EventLayout,
    name: str,
    unit: TimeUnit = "auto",
    rate: float | None = None,
    missing: Collection[str] = (),
    about: Mapping[str, int] | None = None,
) -> Events:
    """Read the events of a table.

    Args:
        table: The table.
        layout: What its columns are.
        name: What the recording is called where no column tells it.
        unit: Unit of times that are plain numbers.
        rate: Frames a second, where times are frames or end in them.
        missing: Texts that stand for no code, beside the usual ones.
        about: Columns, by their names, that say what each recording is.

    Raises:
        SeriesError: Times that cannot be read, an event without an end, or without a recording where others have one,
            no events, or a recording that is two things.
    """
    tracks = layout.tracks
    used = {
        i
        for track in tracks
        for i in (track.onset, track.offset, track.duration, track.kind, track.moment, *track.code, *track.tier)
    }
    about = about or {}
    wanted = {i for i in (*used, *layout.recording, layout.level, *about.values()) if i is not None}
    columns = _Columns(table, wanted, missing)
    named, kept = _recordings(columns, layout, name)
    recordings = named.with_default(name)
    when = {i for track in tracks for i in (track.onset, track.offset, track.duration) if i is not None}
    units = {i: columns.unit(i, unit, layout) for i in when}
    if any(units[i] == "auto" and columns.has_fractions(i) for i in when):
        units = {i: "s" if choice == "auto" else choice for i, choice in units.items()}
    times = {i: columns.times(i, units[i], rate) for i in when}
    bare = _without_codes(columns, tracks, times, kept)
    gathered = [_gathered(columns, track, times, recordings, kept) for track in tracks]
    rows = np.concatenate([part.rows for part in gathered])
    if not len(rows):
        raise SeriesError(f"{table.path} has no events below its header")
    tier = Texts.stacked([part.tier for part in gathered])
    _check_named(named, layout, rows, table)
    recording = recordings.take(rows)
    tiers = tuple(track.name for track in tracks if not track.tier)
    try:
        return Events.of(
            tier,
            _same_numbers(tier, Texts.stacked([part.code for part in gathered])),
            np.concatenate([part.onset for part in gathered]),
            np.concatenate([part.offset for part in gathered]),
            recording,
            tiers={recording.names[i]: tiers for i in first_met(recording.numbers)},
            resolution=1 / rate if rate and {"frames", "auto"} & set(units.values()) else 0.001,
            remarks=_remarks(table.path, bare, sum(part.nameless for part in gathered)),
            about={name: _said(name, recordings, columns.texts(at), rows) for name, at in about.items()},
        )
    except SeriesError as error:
        raise SeriesError(f"{table.path}: {error}") from error


def _recordings(columns: _Columns, layout: EventLayout, name: str) -> tuple[Texts, np.ndarray]:
    """The recording of each row, as far as columns name it, and which rows are events."""
    if layout.level is None:
        named = columns.joined(layout.recording, " ") if layout.recording else Texts(np.full(columns.rows, -1), [])
        return named, np.ones(columns.rows, bool)
    level = columns.texts(layout.level)
    group, part, recordings = 0, 0, []
    levels = [level.at(row).removesuffix(".0") for row in range(columns.rows)]
    for text in levels:
        group, part = (group + 1, 0) if text == "1" else (group, part + 1 if text == "2" else part)
        recordings.append(f"{name} {group}.{part}" if group or part else name)
    return Texts.of(recordings), np.array([text == "3" for text in levels], bool)


def _check_named(recordings: Texts, layout: EventLayout, rows: np.ndarray, table: TableFile) -> None:
    """Refuse events without the name of a recording where others have one."""
    without = rows[recordings.numbers[rows] < 0]
    if 0 < len(without) < len(rows):
        raise SeriesError(
            f"column {table.header[layout.recording[0]]!r} of {table.path} names no recording in "
            f"{count(len(without), 'row')}, the first in data row {int(without.min()) + 1}; fill it in"
        )


def _remarks(path: Path, bare: int, nameless: int) -> tuple[str, ...]:
    """What is to be known of rows that lack something."""
    remarks = [f"{bare} rows of {path} have times and no code, and are left out"] if bare else []
    if nameless:
        remarks.append(f"{count(nameless, 'row')} of {path} without a tier, on the tier {EventTrack.name!r}")
    return tuple(remarks)


def _said(name: str, recordings: Texts, said: Texts, rows: np.ndarray) -> dict[str, str]:
    """What a column says of each recording; blank rows say nothing."""
    rows = rows[said.numbers[rows] >= 0]
    first = np.unique(recordings.numbers[rows] * (len(said.names) + 1) + said.numbers[rows], return_index=True)[1]
    return one_value(name, [(recordings.at(row), said.at(row)) for row in rows[np.sort(first)].tolist()])


def _without_codes(
    columns: _Columns, tracks: Sequence[EventTrack], times: Mapping[int, np.ndarray], kept: np.ndarray
) -> int:
    """Number of rows that have an onset, and no code in any of several columns."""
    if any(track.alone for track in tracks):
        return 0
    timed, coded = np.zeros(columns.rows, bool), np.zeros(columns.rows, bool)
    for track in tracks:
        timed |= ~np.isnan(times[track.onset])
        coded |= columns.joined(track.code, PARTS).numbers >= 0
    return int((timed & ~coded & kept).sum())


def _gathered(
    columns: _Columns, track: EventTrack, times: Mapping[int, np.ndarray], recordings: Texts, kept: np.ndarray
) -> _TrackEvents:
    """The events of one track."""
    code = columns.joined(track.code, PARTS)
    tier = columns.joined(track.tier, ".") if track.tier else Texts(np.full(columns.rows, -1), [])
    if track.tier and track.name.startswith("."):
        tier = Texts(tier.numbers, [name + track.name for name in tier.names])
    nameless = tier.numbers < 0
    tier = tier.with_default(track.name)
    onset = times[track.onset]
    offset, duration = (
        np.full(columns.rows, np.nan) if location is None else times[location]
        for location in (track.offset, track.duration)
    )
    offset = np.where(np.isnan(offset), onset + duration, offset)
    if track.moment is not None:
        kinds = columns.texts(track.moment)
        points = [i for i, name in enumerate(kinds.names) if name.casefold() in POINT]
        offset = np.where(np.isnan(offset) & np.isin(kinds.numbers, points), onset, offset)
    coded = code.numbers >= 0
    rows = np.flatnonzero(kept & (coded | (track.alone & ~(np.isnan(onset) & np.isnan(offset)))))
    path = columns.table.path
    unknown = rows[np.isnan(onset[rows])]
    if len(unknown):
        raise SeriesError(f"{path} has no onset for {shown(code.at(unknown[0]))} in data row {unknown[0] + 1}")
    if track.kind is not None:
        rows, offset = _paired(rows, columns.texts(track.kind), (recordings, tier, code), onset, path)
    unknown = rows[np.isnan(offset[rows])]
    if len(unknown):
        raise SeriesError(
            f"{path} does not say when {shown(code.at(unknown[0]))} ends in data row {unknown[0] + 1}; a point event "
            "has its onset as its offset"
        )
    lost = int(nameless[rows].sum()) if track.tier else 0
    return _TrackEvents(
        rows, tier.take(rows), code.take(rows), onset[rows], offset[rows], lost if lost < len(rows) else 0
    )


def _paired(
    rows: np.ndarray, kinds: Texts, what: tuple[Texts, Texts, Texts], onset: np.ndarray, path: Path
) -> tuple[np.ndarray, np.ndarray]:
    """Rows that begin events, or are point events, and when the events end (rows of the table,).

    Args:
        rows: Rows that say when something starts, stops or happens.
        kinds: Which of these each is.
        what: Recording, tier and code of each row of the table.
        onset: Time of each row of the table.
        path: The file, for messages.
    """
    offset = onset.copy()
    begun: list[int] = []
    running: dict[tuple[str, ...], int] = {}
    for row in rows.tolist():
        kind, event = kinds.at(row).casefold(), tuple(column.at(row) for column in what)
        if kind in START:
            if event in running:
                raise SeriesError(
                    f"{path} starts {shown(event[2])} twice, in data rows {running[event] + 1} and {row + 1}"
                )
            running[event] = row
        elif kind in STOP:
            if event not in running:
                raise SeriesError(
                    f"{path} stops {shown(event[2])} on {event[1]!r} in data row {row + 1}, and never starts it"
                )
            offset[running.pop(event)] = onset[row]
            continue
        elif kind not in POINT:
            raise SeriesError(
                f"{path} has an event of kind {shown(kind)} in data row {row + 1}; expected start, stop or point"
            )
        begun.append(row)
    if running:
        event, row = next(iter(running.items()))
        raise SeriesError(
            f"{path} does not say when {shown(event[2])} on {event[1]!r} of {event[0]!r} stops that starts in data row "
            f"{row + 1}; add where it stops"
        )
    return np.array(begun, np.int64), offset


def _same_numbers(tier: Texts, code: Texts) -> Texts:
    """Codes in which 1.0 and 1,0 are the same as 1 on each tier, as in a table of steps."""
    width = len(code.names) + 1
    pairs, numbers = np.unique(tier.numbers * width + code.numbers + 1, return_inverse=True)
    names = [(int(pair) // width, code.names[pair % width - 1] if pair % width else "") for pair in pairs]
    by_tier: dict[int, set[str]] = {}
    for number, name in names:
        by_tier.setdefault(number, set()).update([name] if name else [])
    same = {number: ordered(known, "code", fractions=True) for number, known in by_tier.items()}
    return Texts.numbered(numbers, [same[number][name] if name else "" for number, name in names])
