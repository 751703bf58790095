"""Looks of a robot and its caregiver as coded events, from the tables that runs leave.

A robot's events have the same two tiers as those of an infant, so that both go through the same measures.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from jointattn_mj.errors import ConfigError, OutputError
from jointattn_mj.io.former_names import present_file, present_name
from jointattn_mj.io.table import Table
from jointattn_mj.options import Checked, Real
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.export import ExportFormat, write_events
from jointattn_mj.recordings.reader import read

FACE = "face"
"""Code of a look at the partner's face."""
VIDEO_EVENTS = "events.csv"
"""What perceive leaves."""
ROBOT_LOOKS, PERSON_LOOKS = "robot looks at", "looks at"
"""Tiers of looks in it."""
PEOPLE = "person"
"""Tier in it on which several codes may hold at once: coding programs get a tier for each person."""
COLUMNS = ("tier", "code", "onset", "offset")
ROBOT, CAREGIVER = "robot", "caregiver"
"""What the table of a development calls its two partners."""


@dataclass(frozen=True)
class LooksOptions(Checked):
    """Which run's looks are written, and how."""

    run: tyro.conf.Positional[Path]
    """Folder of a session, of a development run or of perceive."""
    out: Path
    """Folder for the files."""
    form: ExportFormat = "elan"
    """elan: one file .eaf; boris: aggregated events; datavyu: side by side; table: onset and offset in seconds."""
    robot: str = "robot"
    """Tier of the robot's looks; "infant" puts it beside infants."""
    caregiver: str = "caregiver"
    """Tier of the caregiver's looks."""
    step_s: Annotated[float, Real("[1e-3, 3600]")] = 1.0
    """Seconds that a step of a development is written as: the dissertation gives it none."""
    name: str | None = None
    """Name of the recording; by default that of the folder."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.robot == self.caregiver:
            raise ConfigError(f"robot and caregiver need tiers of their own; both are {self.robot!r}")


def export_looks(options: LooksOptions) -> tuple[Path, ...]:
    """Write the looks of a run for a coding program.

    Returns:
        The files.

    Raises:
        OutputError: The folder holds no such run, or a file cannot be written.
        SeriesError: A video has no events.
    """
    return write_events(looks_of(options), options.out, options.form)


def looks_of(options: LooksOptions) -> Events:
    """Looks of a run as events.

    A session: what the robot fixates, and what the caregiver is occupied with and looks at. A development: where the
    robot's gaze goes, step by step, and where the caregiver looks. A video: what the robot attends to, where the person
    looks if that was coded, who is there, cuts, and motion of the camera.

    Raises:
        OutputError: The folder holds no such run, or a table that lacks a column.
    """
    for file, reader in _READERS.items():
        if (path := present_file(options.run, file)).exists():
            return reader(Table.read(path, present_name), options)
    raise OutputError(
        f"{options.run} holds no looks: expected {', '.join(_READERS)}; give the folder of a finished session, "
        "development or perceive run"
    )


def of_steps(tier: str, labels: Sequence[str | None] | np.ndarray, times: np.ndarray, recording: str) -> Events:
    """Events of labels that are known step by step: equal neighbours are one event.

    Args:
        tier: Name of the tier.
        labels: One for each step (n,); None where nothing is coded.
        times: When each step begins, and when the last one ends (n + 1,), in seconds.
        recording: Name of the recording.
    """
    labels = np.asarray(labels, object)
    known = np.array(["" if label is None else str(label) for label in labels])
    first = np.flatnonzero(np.concatenate([[True], known[1:] != known[:-1]])) if len(known) else np.zeros(0, int)
    last = np.append(first[1:], len(known))
    kept = [i for i, start in enumerate(first) if labels[start] is not None]
    return Events.of(
        [tier] * len(kept),
        [str(labels[first[i]]) for i in kept],
        times[first[kept]],
        times[last[kept]],
        recording,
        tiers={recording: (tier,)},
        spans={recording: (float(times[0]), float(times[-1]))},
    )


def _both(robot: np.ndarray, caregiver: np.ndarray, times: np.ndarray, options: LooksOptions) -> Events:
    name = options.name or options.run.resolve().name
    mine = of_steps(options.robot, robot, times, name)
    return mine.joined(of_steps(options.caregiver, caregiver, times, name))


def _session(table: Table, options: LooksOptions) -> Events:
    """A frame lasts until the next one."""
    _has(table, ("time_s", "attended", "target"), options.run)
    return _both(table["attended"], table["target"], _frames(table), options)


def _development(table: Table, options: LooksOptions) -> Events:
    _has(table, ("shift gaze", "caregiver looks at"), options.run)
    times = np.arange(len(table) + 1) * options.step_s
    robot, caregiver = (_as_codes(table[name]) for name in ("shift gaze", "caregiver looks at"))
    return _both(robot, caregiver, times, options)


def _video(table: Table, options: LooksOptions) -> Events:
    """All events of a video; of earlier versions, which left no events, what the robot attends to."""
    file = options.run / VIDEO_EVENTS
    if file.exists():
        events = read(file).events
        names = {ROBOT_LOOKS: options.robot, PERSON_LOOKS: options.caregiver}
        rows = [
            (code, "there", *times) if tier == PEOPLE else (names.get(tier, tier), code, *times)
            for tier, code, *times in zip(*(events.table[name] for name in COLUMNS), strict=True)
        ]
        tiers, codes, onsets, offsets = zip(*rows, strict=True) if rows else ((), (), (), ())
        return Events.of(tiers, codes, onsets, offsets, options.name or options.run.resolve().name)
    _has(table, ("time_s", "attended"), options.run)
    return of_steps(options.robot, table["attended"], _frames(table), options.name or options.run.resolve().name)


def _frames(table: Table) -> np.ndarray:
    """When frames begin, and when the last one ends (s); in whole milliseconds, as coding programs have them."""
    times = np.asarray(table["time_s"], float)
    length = float(np.median(np.diff(times))) if len(times) > 1 else 1 / 30
    return np.round(np.append(times, times[-1:] + length), 3)


def _as_codes(labels: np.ndarray) -> np.ndarray:
    """Looks at each other are looks at the face, whoever looks."""
    return np.array([FACE if label in (ROBOT, CAREGIVER) else label for label in labels], object)


def _has(table: Table, columns: Sequence[str], folder: Path) -> None:
    missing = [name for name in columns if name not in table]
    if missing:
        raise OutputError(f"the table in {folder} has no column {missing[0]!r}; give the folder of a finished run")


_READERS: dict[str, Callable[[Table, LooksOptions], Events]] = {
    "frames.parquet": _session,
    "steps.parquet": _development,
    "percepts.parquet": _video,
}
