"""Groups of recordings, such as ages: what is true of a recording as a whole."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from jointattn_mj.errors import ConfigError, SeriesError
from jointattn_mj.options import Checked, meant
from jointattn_mj.recordings.formats.plain import RECORDING
from jointattn_mj.recordings.steps import Recordings
from jointattn_mj.recordings.table_files import TableOptions, open_table, read_bytes
from jointattn_mj.recordings.tier_codes import dictionary

if TYPE_CHECKING:
    from jointattn_mj.recordings.events import Events
    from jointattn_mj.recordings.reader import Coding


@dataclass(frozen=True, kw_only=True)
class GroupOptions(Checked):
    """By what recordings are compared."""

    by: str | None = None
    """Column or tier with one value in each recording, such as age: recordings are compared by it. A table of its own
    may have it (--groups)."""
    groups: Path | None = None
    """Table with a row for each recording, and the column that --by names: for files that do not say it themselves. Its
    column recording, or its first one, has the names of the recordings or of their files."""

    ADVANCED: ClassVar[Sequence[str]] = ("groups",)

    @property
    def group_columns(self) -> tuple[str, ...]:
        """Columns that say what each recording is, and are no codes."""
        return () if self.by is None else (self.by,)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.groups is not None and self.by is None:
            raise ConfigError(f"`groups` needs `by`, the name of a column of {self.groups}, such as age")


def groups_of(options: GroupOptions, coding: "Coding") -> dict[str, str] | None:
    """Group of each recording by its name; None where none is asked for.

    Args:
        options: The column, and where it is.
        coding: The recordings.

    Raises:
        SeriesError: There is no such column, or it changes within a recording.
    """
    if options.by is None:
        return None
    return coding.about(options.by) if options.groups is None else read_groups(Path(options.groups), options.by)


def read_groups(path: Path, by: str) -> dict[str, str]:
    """Read groups from a table with a row for each recording.

    Args:
        path: The table. Names of recordings may be those of their files.
        by: Name of the column that has the groups.

    Raises:
        SeriesError: It cannot be read, lacks the column, or has two values for a recording.
    """
    table = open_table(read_bytes(path), path, TableOptions(), lambda names: by in names)
    (at,) = table.locations([by])
    named = next((i for i, name in enumerate(table.header) if name.casefold() in RECORDING and i != at), None)
    first = next((i for i in range(len(table.header)) if i != at), None) if named is None else named
    if first is None:
        raise SeriesError(f"{path} has a column {by!r} and none with the names of recordings")
    columns = [dictionary(column) for column in table.columns([first, at]).columns]
    recordings, values = ([names[number].strip() for number in numbers] for numbers, names in columns)
    of: dict[str, str] = {}
    for recording, value in zip(recordings, values, strict=True):
        if value and of.setdefault(recording, value) != value:
            raise SeriesError(f"{path} has two values of {by!r} for {recording!r}: {of[recording]} and {value}")
    of |= {Path(name).stem: value for name, value in of.items() if Path(name).suffix and Path(name).stem not in of}
    return of


def of_tier(events: "Events", tier: str) -> dict[str, str]:
    """What a tier says of each recording.

    Args:
        events: Have the tier.
        tier: With the same code in all of a recording.

    Raises:
        SeriesError: There is no such tier, or it has two codes in a recording.
    """
    if tier not in events.tier_names:
        known = [*events.about, *events.tier_names]
        raise SeriesError(
            f"there is no column or tier {tier!r}{meant(tier, known)} that says what each recording is; there are "
            f"{', '.join(known)}. A table with a row for each recording can say it: name it with `groups`"
        )
    rows = events.table["tier"] == tier
    pairs = zip(events.table["recording"][rows], events.table["code"][rows], strict=True)
    return one_value(tier, [(str(recording), str(code)) for recording, code in pairs if code is not None])


def of_column(coded: Recordings, column: str) -> dict[str, str]:
    """What a column of steps says of each recording; arguments and errors as of ``of_tier``."""
    pairs = [
        (coded.names[group] if coded.names else str(group), coded.labels[column][code])
        for group, part in zip(coded.groups, coded.columns[column], strict=True)
        for code in np.unique(part)
    ]
    return one_value(column, pairs)


def one_value(name: str, pairs: Iterable[tuple[str, str]]) -> dict[str, str]:
    """The value of each recording.

    Args:
        name: Of the column or tier, for messages.
        pairs: Recording and value, as often as they come.

    Raises:
        SeriesError: A recording has two values.
    """
    values: dict[str, dict[str, None]] = {}
    for recording, value in pairs:
        values.setdefault(recording, {})[value] = None
    for recording, groups in values.items():
        if len(groups) > 1:
            there = ", ".join(sorted(groups)[:5])
            raise SeriesError(
                f"{name!r} changes within recording {recording!r}: {there}; it must have one value in each. "
                "`recording` names a column that tells recordings apart"
            )
    return {recording: next(iter(groups)) for recording, groups in values.items()}
