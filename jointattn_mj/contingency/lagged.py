"""Delays and histories: what the source was several steps before, or over several steps, and what the target was."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from jointattn_mj.contingency.series import Coded, combined
from jointattn_mj.contingency.table import Steps
from jointattn_mj.errors import SeriesError
from jointattn_mj.options import Checked, Count


@dataclass(frozen=True)
class Timing(Checked):
    """From when source, condition and target are taken, in steps before the result.

    Examples:
        >>> Timing(lag=3, source_history=2).reach
        4
    """

    lag: Count = 1
    """Steps from source and condition to the result; 1: the step before it."""
    source_history: Count = 1
    """Values of the source taken as one: the one at the lag, and those before it."""
    target_history: Count = 1
    """Past values of the target that are known anyway. More than one takes off what an old look of its own explains."""

    @property
    def reach(self) -> int:
        """Steps before the result that are needed."""
        return max(self.lag + self.source_history - 1, self.target_history)


def timed(given: Steps, timing: Timing, reach: int | None = None) -> Steps:
    """The transitions of ``given``, with other delays and histories.

    Args:
        given: Series, aligned as always: ``r[t + 1]`` answers ``s[t]``.
        timing: Delays and histories.
        reach: Leave out the first steps of each recording as if so many were needed, so that several lags are
            measured on the same results; None: as many as are needed.

    Raises:
        SeriesError: No recording is long enough.
    """
    lost = max(timing.reach, reach or 1) - 1
    if lost == 0:
        return given
    bounds = given.target.bounds
    lengths = np.diff(bounds) - lost
    kept = lengths >= 2
    if not kept.any():
        raise SeriesError(
            f"lag, scan or histories reach back {lost + 1} steps; the longest recording has "
            f"{int(np.diff(bounds).max())}. Choose shorter ones"
        )
    pieces = list(zip(bounds[:-1][kept].tolist(), bounds[1:][kept].tolist(), strict=True))
    ends = np.concatenate([[0], np.cumsum(lengths[kept])])

    def back_by(codes: np.ndarray, back: int) -> np.ndarray:
        parts = [codes[start + lost - back : stop - back] for start, stop in pieces]
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def taken(coded: Coded, back: int, history: int) -> Coded:
        columns = [back_by(coded.codes, back + further) for further in range(history)]
        if history == 1:
            return replace(coded, codes=columns[0], bounds=ends)
        codes, bound = combined(columns, [coded.size] * history)
        if bound > max(1024, len(codes)):
            values, codes = np.unique(codes, return_inverse=True)
            bound = len(values)
        return Coded(codes, ends, bound)

    return Steps(
        source=taken(given.source, timing.lag - 1, timing.source_history),
        target=taken(given.target, 0, 1),
        condition=None if given.condition is None else taken(given.condition, timing.lag - 1, 1),
        groups=None if given.groups is None else given.groups[kept],
        history=None if timing.target_history == 1 else taken(given.target, 0, timing.target_history),
    )


def at_lags(lags: Sequence[int], timing: Timing) -> list[Timing]:
    """``timing`` with each of several lags in place of its own; its histories hold for all."""
    return [replace(timing, lag=int(lag)) for lag in lags]
