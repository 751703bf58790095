"""Any table with columns of onset, and offset or duration: tiers below one another, or side by side.

ELAN's tab-delimited text and Datavyu's spreadsheet are of this kind.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from jointattn_mj.recordings.event_layout import EventLayout, EventTrack
from jointattn_mj.recordings.times import is_time, seconds, unit_of

ONSET, OFFSET, DURATION = {"onset", "begin", "start"}, {"offset", "end", "stop"}, {"duration", "dur"}
TIER = (
    "tier", "tier name", "tiername", "track", "channel", "subject", "actor", "agent", "person", "individual", "speaker",
    "who", "role", "participant",
)  # fmt: skip
"""Names of a column that says which tier an event is on; the first that is there counts."""
CODE = (
    "annotation", "annotations", "code", "codes", "label", "labels", "value", "behavior", "behaviour", "event",
    "category", "state", "text",
)  # fmt: skip
"""Names of a column of codes, where another one names the tier."""
RECORDING = ("recording", "recording id", "observation id", "observation", "dyad", "file", "filename", "file name")
"""Names of a column that tells recordings apart."""
NO_CODE = {
    "ordinal", "index", "row", "no", "nr", "number", "comment", "comments", "note", "notes", "memo", "file path", "fps",
    "media file", "media file name", "participant", "",
}  # fmt: skip
"""Names of columns that hold no codes."""
_UNIT_RANK = {"ms": 0, "s": 1, "auto": 2, "frames": 3}
_UNITS = {"hh", "mm", "ss", "ff", "hms", "hmsf", "ms", "msec", "msecs", "milliseconds", "s", "sec", "secs", "seconds",
          "frames", "frame", "time", "times"}  # fmt: skip


_ANY_RATE, _ROUNDING_S = 1000, 0.0015


@dataclass(frozen=True)
class _Role:
    role: str
    block: str
    """What stands beside the role in the column's name, such as ``infant``."""


def layout(names: Sequence[str]) -> EventLayout | None:
    """Which columns say what; None where no two columns say when an event begins and ends."""
    roles = {i: role for i, name in enumerate(names) if (role := _role(name)) is not None}
    blocks: dict[str, dict[str, int]] = {}
    for i, role in sorted(roles.items(), key=lambda item: (_UNIT_RANK[unit_of(names[item[0]])], item[0])):
        blocks.setdefault(role.block, {}).setdefault(role.role, i)
    blocks = {
        block: columns
        for block, columns in blocks.items()
        if "onset" in columns and {"offset", "duration"} & set(columns)
    }
    if not blocks:
        return None
    used = {i for i, role in roles.items() if role.block in blocks}
    spelt = {_spelt(name): i for i, name in reversed(list(enumerate(names)))}
    recording = next(((spelt[name],) for name in RECORDING if name in spelt), ())
    labels = [i for i, name in enumerate(names) if i not in used and (i,) != recording and not _is_no_code(name)]
    if len(blocks) == 1:
        (times,) = blocks.values()
        tracks = _one_block(names, spelt, labels, times)
    else:
        tracks = _side_by_side(names, labels, blocks)
    ordinals = any(_words(name)[-1:] == ["ordinal"] for name in names)
    return EventLayout(tuple(tracks), recording, "ms" if ordinals else "auto") if tracks else None


def names_without_header(rows: Sequence[Sequence[str]]) -> list[str] | None:
    """Names for the columns of a table that has none, such as ELAN's tab-delimited text; None where they are not clear.

    Two columns of times, of which the second is never before the first, are onset and offset; a third one is their
    difference. Each may be written in several formats. The first column of text after them is the code, one of ELAN's
    files behind it the recording; of those before them the first is the tier, and so it is if none is after them.
    """
    width = max(map(len, rows), default=0)
    rows = [row for row in rows if len(row) == width]
    filled = [i for i in range(width) if any(row[i].strip() for row in rows)]
    times = [i for i in filled if all(is_time(row[i]) for row in rows)]
    files = [i for i in filled if all(row[i].strip().casefold().endswith(".eaf") for row in rows)]
    texts = [i for i in filled if i not in (*times, *files)]
    if len(rows) < 2 or len(times) < 2:
        return None
    before, after = [i for i in texts if i < times[0]], [i for i in texts if i > times[0]]
    if len(after) != 1 or len(before) > (2 if files or len(times) > 3 else 1):
        if len(texts) not in (1, 2):
            return None
        before, after = texts[:-1], texts[-1:]
    chosen = _onset_and_offset({i: seconds([row[i] for row in rows], "s", _ANY_RATE, "") for i in times})
    if chosen is None:
        return None
    names = ["-"] * width
    for i, name in [*zip(chosen, ("onset", "offset"), strict=True), *((i, "recording") for i in files[:1])]:
        names[i] = name
    for columns, name in ((before, "tier"), (after, "code")):
        for i in columns[:1]:
            names[i] = name
    return names


def _onset_and_offset(times: Mapping[int, np.ndarray]) -> tuple[int, int] | None:
    """Columns of onset and offset among columns of times: each once, or in several formats, with a duration or not."""
    columns = list(times)
    for formats in range(1, len(columns) // 2 + 1):
        kinds = [columns[i : i + formats] for i in range(0, len(columns), formats)]
        if len(columns) % formats or len(kinds) > 3:
            continue
        onset, offset, *duration = (times[kind[0]] for kind in kinds)
        fits = [abs(offset - onset - length) <= _ROUNDING_S for length in duration]
        same = all(_same(times[first], times[other]) for first, *others in kinds for other in others)
        if same and (offset >= onset).all() and all(map(np.all, fits)):
            return kinds[0][0], kinds[1][0]
    return None


def _same(first: np.ndarray, second: np.ndarray) -> bool:
    """Whether two columns are the same times, the second in seconds or milliseconds."""
    return any(bool((abs(first - second / unit) <= _ROUNDING_S).all()) for unit in (1, 1000))


def _role(name: str) -> _Role | None:
    words = [word for word in _words(name) if word not in _UNITS]
    for role, known in (("onset", ONSET), ("offset", OFFSET), ("duration", DURATION)):
        at = [i for i, word in enumerate(words) if word in known]
        if len(at) == 1:
            return _Role(role, " ".join(words[: at[0]] + words[at[0] + 1 :]))
    return None


def _one_block(
    names: Sequence[str], spelt: dict[str, int], labels: list[int], times: dict[str, int]
) -> list[EventTrack]:
    """Tiers below one another, or one column for each."""
    when = times["onset"], times.get("offset"), times.get("duration")
    tier = next((spelt[name] for name in TIER if name in spelt and spelt[name] not in times.values()), None)
    labels = [i for i in labels if i != tier]
    if tier is not None:
        named = [spelt[name] for name in CODE if spelt.get(name) in labels]
        codes = named[:1] or labels
        if len(codes) == 1:
            return [EventTrack(*when, (codes[0],), (tier,))]
        return [EventTrack(*when, (i,), (tier,), f".{names[i]}", alone=False) for i in codes]
    return [EventTrack(*when, (i,), name=names[i], alone=len(labels) == 1) for i in labels]


def _side_by_side(names: Sequence[str], labels: list[int], blocks: dict[str, dict[str, int]]) -> list[EventTrack]:
    """Tiers side by side, each with its own times."""
    first = {block: min(times.values()) for block, times in blocks.items()}
    own: dict[str, list[int]] = {block: [] for block in blocks}
    for i in labels:
        words = " ".join(_words(names[i]))
        by_name = [block for block in blocks if block and f"{words} ".startswith(f"{block} ")]
        before = [block for block in blocks if first[block] <= i] or [min(first, key=first.__getitem__)]
        own[max(by_name, key=len) if by_name else max(before, key=first.__getitem__)].append(i)
    return [
        EventTrack(
            times["onset"], times.get("offset"), times.get("duration"), (i,), name=names[i], alone=len(own[block]) == 1
        )
        for block, times in blocks.items()
        for i in own[block]
    ]


def _is_no_code(name: str) -> bool:
    return _spelt(name) in NO_CODE or _words(name)[-1:] == ["ordinal"]


def _words(name: str) -> list[str]:
    return [word for word in re.split(r"[\W_]+", name.casefold()) if word]


def _spelt(name: str) -> str:
    return " ".join(_words(name))
