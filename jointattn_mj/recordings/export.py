"""Writes coded events as coding programs have them: ELAN, BORIS, Datavyu, or a plain table."""

import csv
import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, Literal

from jointattn_mj.errors import ConfigError, OutputError, SeriesError
from jointattn_mj.io.files import make_room, write_whole
from jointattn_mj.options import shown
from jointattn_mj.recordings.events import Events

ExportFormat = Literal["elan", "boris", "datavyu", "table"]
"""``elan``: a file .eaf for each recording. ``boris``: aggregated events, one table. ``datavyu``: the export side by
side, a table for each recording. ``table``: recording, tier, code, onset and offset in seconds, one table."""
ENDINGS: dict[str, str] = {"elan": ".eaf", "boris": ".csv", "datavyu": ".csv", "table": ".csv"}
"""Ends of the files' names."""
Row = tuple[str, str, float, float]
"""Tier, code, onset and offset (s)."""


def write_events(events: Events, out: Path | str, form: ExportFormat = "elan") -> tuple[Path, ...]:
    """Write events for a coding program; ``recordings.read`` reads the files back.

    ELAN and Datavyu keep milliseconds. An event whose code is missing has an empty one there.

    Args:
        events: What is coded.
        out: Folder of the files; it is made where there is none.
        form: See ``ExportFormat``.

    Returns:
        The files, one for each recording, or one.

    Raises:
        ConfigError: No such format.
        SeriesError: There are no events.
        OutputError: A file is there already or cannot be written.

    Examples:
        >>> from jointattn_mj.recordings.export import write_events
        >>> looks = Events.of(["infant", "mother"], ["cup", "face"], [0, 0.5], [1.25, 2], "dyad 1")
        >>> [path.name for path in write_events(looks, "looks", "elan")]
        ['dyad 1.eaf']
        >>> from jointattn_mj import recordings
        >>> recordings.read("looks/dyad 1.eaf").events.to_pandas()["code"].tolist()
        ['cup', 'face']
    """
    if form not in ENDINGS:
        raise ConfigError(f"form: expected {', '.join(ENDINGS)}; got {shown(form)}")
    if not len(events):
        raise SeriesError("there are no events to write")
    folder = Path(out)
    writers: dict[str, Callable[[Path], object]] = {}
    if form in ("elan", "datavyu"):
        write = _elan if form == "elan" else _datavyu
        for recording in events.recordings:
            name, rows, tiers = _file_name(recording), _rows(events, recording), events.tiers[recording]
            if name in writers:
                raise SeriesError(f"two recordings would have the file name {name!r}; give them other names")
            writers[name] = lambda path, rows=rows, tiers=tiers: write(path, tiers, rows)  # type: ignore[misc]
    else:
        writers["events"] = lambda path: (_boris if form == "boris" else _table)(path, events)
    paths = {folder / f"{name}{ENDINGS[form]}": write for name, write in writers.items()}
    there = next((path for path in paths if path.exists()), None)
    if there is not None:
        raise OutputError(f"{there} is there already; choose another folder")
    for path in paths:
        make_room(path)
    for path, write_one in paths.items():
        write_whole(path, write_one)
    return tuple(paths)


def _rows(events: Events, recording: str) -> list[Row]:
    table = events.table
    of = table["recording"] == recording
    columns = (table[name][of] for name in ("tier", "code", "onset", "offset"))
    return [(str(t), "" if c is None else str(c), float(a), float(b)) for t, c, a, b in zip(*columns, strict=True)]


def _elan(path: Path, tiers: Sequence[str], rows: Sequence[Row]) -> None:
    from pympi import Elan  # here, as few write such files

    book = Elan.Eaf(author="jointattn_mj")
    for tier in tiers:
        book.add_tier(tier)
    book.remove_tier("default")
    for tier, code, onset, offset in rows:
        start, stop = _ms(onset), _ms(offset)
        book.add_annotation(tier, start, max(stop, start + 1), code)  # ELAN knows no moments
    book.to_file(str(path))


def _datavyu(path: Path, tiers: Sequence[str], rows: Sequence[Row]) -> None:
    cells = {tier: [row[1:] for row in rows if row[0] == tier] for tier in tiers}
    header = [f"{tier}{end}" for tier in tiers for end in (".ordinal", ".onset", ".offset", "")]
    lines = []
    for i in range(max(map(len, cells.values()))):
        line: list[Any] = []
        for events in cells.values():
            line += [i + 1, _ms(events[i][1]), _ms(events[i][2]), events[i][0]] if i < len(events) else [""] * 4
        lines.append(line)
    _csv(path, header, lines)


def _boris(path: Path, events: Events) -> None:
    header = ("Observation id", "Subject", "Behavior", "Behavioral category", "Behavior type", "Start (s)", "Stop (s)",
              "Duration (s)")  # fmt: skip
    lines = [
        (recording, tier, code, "", "STATE" if b > a else "POINT", f"{a:.6f}", f"{b:.6f}", f"{b - a:.6f}")
        for recording in events.recordings
        for tier, code, a, b in _rows(events, recording)
    ]
    _csv(path, header, lines)


def _table(path: Path, events: Events) -> None:
    lines = [
        (recording, tier, code, f"{a:.6f}", f"{b:.6f}")
        for recording in events.recordings
        for tier, code, a, b in _rows(events, recording)
    ]
    _csv(path, ("recording", "tier", "code", "onset (s)", "offset (s)"), lines)


def _csv(path: Path, header: Sequence[str], lines: Iterable[Sequence[Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(lines)


def _ms(seconds: float) -> int:
    return round(seconds * 1000)


def _file_name(recording: str) -> str:
    """The recording's name without what file systems do not take."""
    return re.sub(r'[/\\:*?"<>|\x00-\x1f]', "_", recording).strip(". ") or "recording"
