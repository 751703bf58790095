"""The events of tiers as numbers: whole microseconds, numbered codes, and no two intervals at one time."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from jointattn_mj.errors import SeriesError
from jointattn_mj.options import shown

if TYPE_CHECKING:
    from jointattn_mj.recordings.events import Events

Overlaps = Literal["error", "combine"]

UNKNOWN, NOTHING = -1, -2
"""Stand for a code that is missing, and for no event."""
JOINED = " & "
"""Stands between codes that are combined."""
_LISTED = 3


@dataclass(frozen=True)
class TierLine:
    """What is coded on one tier of one recording; times in microseconds."""

    onset: np.ndarray
    """int64 (n,), ascending."""
    offset: np.ndarray
    """int64 (n,), each after its onset and not after the next one."""
    code: np.ndarray
    """int64 (n,): numbers of codes, or UNKNOWN."""
    moments: np.ndarray
    """int64 (k,): times of point events, ascending."""
    moment_codes: np.ndarray
    """int64 (k,)."""

    def at(self, times: np.ndarray) -> np.ndarray:
        """Code of the interval at each time, NOTHING between intervals."""
        before = np.searchsorted(self.onset, times, "right") - 1
        inside = before >= 0
        inside[inside] = times[inside] < self.offset[before[inside]]
        return np.where(inside, self.code[before] if len(self.code) else NOTHING, NOTHING)


class TierCodes:
    """Looks up what is coded on a tier of a recording.

    Args:
        events: The events.
        slack: Overlaps and gaps up to so many microseconds are closed.
        overlaps: What happens to longer overlaps on one tier.

    Attributes:
        names: Names of codes by their numbers; combinations are appended as they are met.
    """

    def __init__(self, events: "Events", slack: int, overlaps: Overlaps):
        table = events.table.arrow
        self._slack, self._overlaps, self._spans = slack, overlaps, events.spans
        recording, recordings = dictionary(table["recording"])
        self._tier, self._tiers = dictionary(table["tier"])
        self._code, self.names = dictionary(table["code"])
        self._number = {name: i for i, name in enumerate(self.names)}
        self._parts: dict[int, tuple[int, ...]] = {}
        self._onset, self._offset = (microseconds(table[name].to_numpy()) for name in ("onset", "offset"))
        bounds = np.searchsorted(recording, np.arange(len(recordings) + 1))
        self._rows = {name: slice(bounds[i], bounds[i + 1]) for i, name in enumerate(recordings)}

    def span(self, recording: str) -> tuple[int, int]:
        """From when to when a recording was coded, in microseconds: as is known, or by its events."""
        if recording in self._spans:
            start, end = microseconds(np.array(self._spans[recording], float))
            return int(start), int(end)
        rows = self._rows.get(recording, slice(0, 0))
        if rows.start == rows.stop:
            return 0, 0
        return int(self._onset[rows].min()), int(self._offset[rows].max())

    def line(self, recording: str, tier: str) -> TierLine:
        """What is coded on a tier of a recording.

        Raises:
            SeriesError: Intervals overlap, unless they are to be combined.
        """
        rows = self._rows.get(recording, slice(0, 0))
        here = np.flatnonzero(self._tier[rows] == (self._tiers.index(tier) if tier in self._tiers else -1))
        onset, offset, code = (column[rows][here] for column in (self._onset, self._offset, self._code))
        lasts = offset > onset
        moments, moment_codes = onset[~lasts], code[~lasts]
        onset, offset, code = onset[lasts], offset[lasts], code[lasts]
        follows = (onset[1:] > onset[:-1]) & (offset[1:] >= offset[:-1])
        close = follows & (np.abs(onset[1:] - offset[:-1]) <= self._slack)
        offset[:-1][close] = onset[1:][close]
        overlap = np.flatnonzero(onset[1:] < np.maximum.accumulate(offset)[:-1]) + 1
        if len(overlap):
            if self._overlaps == "error":
                raise SeriesError(self._overlapping(recording, tier, overlap, onset, offset, code))
            onset, offset, code = self._parted(onset, offset, code)
        return TierLine(onset, offset, code, moments, moment_codes)

    def combined(self, codes: Iterable[int]) -> int:
        """Number of the value that several codes make together: UNKNOWN if one is.

        Raises:
            SeriesError: A code has the name of the combination.
        """
        single = {part for code in codes for part in self._parts.get(code, (code,))}
        parts = tuple(sorted(single - {NOTHING}, key=self.name))
        if UNKNOWN in parts or len(parts) == 1:
            return UNKNOWN if UNKNOWN in parts else parts[0]
        name = JOINED.join(map(self.name, parts))
        number = self._number.setdefault(name, len(self.names))
        if number == len(self.names):
            self.names.append(name)
            self._parts[number] = parts
        if self._parts.get(number) != parts:
            raise SeriesError(f"{name!r} is a code, and a combination of other codes; give the code another name")
        return number

    def name(self, code: int) -> str:
        """What a code is called in a message."""
        return self.names[code] if code >= 0 else "unknown"

    def _parted(self, onset: np.ndarray, offset: np.ndarray, code: np.ndarray) -> tuple[np.ndarray, ...]:
        """Intervals between any two changes, with what is coded in each."""
        edges = np.unique(np.concatenate([onset, offset]))
        first, last = np.searchsorted(edges, onset), np.searchsorted(edges, offset)
        sets: list[set[int]] = [set() for _ in edges[1:]]
        for number, start, end in zip(code.tolist(), first.tolist(), last.tolist(), strict=True):
            for i in range(start, end):
                sets[i].add(number)
        kept = [i for i, codes in enumerate(sets) if codes]
        return edges[kept], edges[[i + 1 for i in kept]], np.array([self.combined(sets[i]) for i in kept], np.int64)

    def _overlapping(
        self,
        recording: str,
        tier: str,
        overlap: np.ndarray,
        onset: np.ndarray,
        offset: np.ndarray,
        code: np.ndarray,
    ) -> str:
        """What to say of intervals that begin before an earlier one has ended."""

        def words(i: int) -> str:
            return f"{shown(self.name(int(code[i])))} {onset[i] / 1e6:g} to {offset[i] / 1e6:g} s"

        pairs = [f"{words(int(np.argmax(offset[:i] > onset[i])))} and {words(int(i))}" for i in overlap[:_LISTED]]
        more = f", and {len(overlap) - len(pairs)} more" if len(overlap) > len(pairs) else ""
        return (
            f"events overlap on the tier {tier!r} of recording {recording!r}: {'; '.join(pairs)}{more}. Mend them, "
            "part them into tiers, combine them into values of their own with `overlaps='combine'`, or, if they are of "
            "several recordings, name the column that says so with `recording`"
        )


def microseconds(seconds: np.ndarray) -> np.ndarray:
    """Times as whole numbers, so that what is written alike is equal."""
    return np.rint(np.asarray(seconds, float) * 1e6).astype(np.int64)


def dictionary(column: Any) -> tuple[np.ndarray, list[str]]:
    """Numbers (rows,) of a dictionary-encoded Arrow column, -1 where missing, and what they stand for."""
    array = column.unify_dictionaries().combine_chunks()
    if hasattr(array, "num_chunks"):  # some versions keep the wrapper
        array = array.chunk(0)
    numbers = array.indices.fill_null(-1).to_numpy(zero_copy_only=False).astype(np.int64)
    return numbers, array.dictionary.to_pylist()
