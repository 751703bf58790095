"""Intervals of one tier of one recording, and what is coded at a time: what derived tiers and agreement are made of."""

from dataclasses import dataclass

import numpy as np

from jointattn_mj.errors import SeriesError
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.sampling import NONE

MISSING = ""
"""Code of an interval whose code is not known."""


@dataclass(frozen=True)
class Intervals:
    """Intervals (n,) in order of their onsets; none overlaps the next."""

    onset: np.ndarray
    offset: np.ndarray
    code: np.ndarray
    """Labels, an array of objects."""

    def __len__(self) -> int:
        return len(self.onset)

    def coded(self, *codes: str) -> "Intervals":
        """Those with one of these codes."""
        return self.kept(np.isin(self.code.astype(str), codes))

    def kept(self, which: np.ndarray) -> "Intervals":
        """Those of a mask (n,)."""
        return Intervals(self.onset[which], self.offset[which], self.code[which])


def intervals_of(events: Events, recording: str, tier: str) -> Intervals:
    """The intervals of one tier; moments, which have no length, are left out, and equal neighbours joined.

    Args:
        events: What is coded.
        recording: Name of the recording.
        tier: Name of the tier.

    Raises:
        SeriesError: Intervals overlap by more than the times' resolution.
    """
    table = events.table
    rows = (table["recording"] == recording) & (table["tier"] == tier) & (table["offset"] > table["onset"])
    onset, offset, code = (table[name][rows] for name in ("onset", "offset", "code"))
    code = np.array([MISSING if label is None else str(label) for label in code], object)
    if len(onset) > 1:
        over = offset[:-1] - onset[1:]
        if over.max() > events.resolution + 1e-9:
            at = int(np.argmax(over))
            raise SeriesError(
                f"events overlap on the tier {tier!r} of recording {recording!r}: {code[at]!r} until {offset[at]:g} s "
                f"and {code[at + 1]!r} from {onset[at + 1]:g} s; part them into tiers"
            )
        offset = np.append(np.minimum(offset[:-1], onset[1:]), offset[-1])
        gap = onset[1:] - offset[:-1] > events.resolution + 1e-9
        new = np.concatenate([[True], gap | (code[1:] != code[:-1])])
        last = np.append(np.flatnonzero(new)[1:] - 1, len(onset) - 1)
        onset, offset, code = onset[new], offset[last], code[new]
    return Intervals(onset.astype(float), offset.astype(float), code)


def at_times(intervals: Intervals, times: np.ndarray) -> np.ndarray:
    """Labels (n,) of what is coded at some times; ``(none)`` where nothing is.

    Args:
        intervals: In order.
        times: Seconds (n,).
    """
    if not len(intervals):
        return np.full(len(times), NONE, object)
    at = np.searchsorted(intervals.onset, times, "right") - 1
    inside = (at >= 0) & (times < intervals.offset[np.maximum(at, 0)])
    return np.where(inside, intervals.code[np.maximum(at, 0)], NONE)


def overlaps(first: Intervals, second: Intervals) -> list[tuple[float, float, int, int]]:
    """Times that an interval of each has in common: onset, offset, and the numbers of the two."""
    common, i, j = [], 0, 0
    while i < len(first) and j < len(second):
        onset = max(first.onset[i], second.onset[j])
        offset = min(first.offset[i], second.offset[j])
        if offset > onset:
            common.append((float(onset), float(offset), i, j))
        if first.offset[i] <= second.offset[j]:
            i += 1
        else:
            j += 1
    return common
