"""From coded events to equal steps: what is coded in each, where coding began and ended, and what is left out."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np

from jointattn_mj.errors import SeriesError
from jointattn_mj.io.progress import count
from jointattn_mj.options import Checked, Real, check_argument
from jointattn_mj.recordings.labels import sorted_names
from jointattn_mj.recordings.steps import Recordings, pieces
from jointattn_mj.recordings.tier_codes import NOTHING, UNKNOWN, Overlaps, TierCodes, TierLine, microseconds

if TYPE_CHECKING:
    from jointattn_mj.recordings.events import Events

ValueAt = Literal["middle", "most"]
Nothing = Literal["none", "missing"]
Span = Literal["coded", "all", "common"]
Absent = Literal["error", "nothing", "leave_out"]
Missing = Literal["error", "break"]
"""What a missing value does: it is an ``error``, or it ends the recording there, and the next row begins another."""

NONE = "(none)"
"""Label of steps in which nothing is coded."""
GAPLESS_EVENTS, GAPLESS_SHARE = 3, 0.25
"""A tier is coded throughout if so many events follow one another without a gap, for so much of the recording."""
MOST_STEPS = 200_000_000
"""More steps than this need a longer step."""


@dataclass(frozen=True, kw_only=True)
class SampleOptions(Checked):
    """How events become steps."""

    value_at: ValueAt = "middle"
    """What a step's value is: what is coded at its middle, or for most of it. Point events always count."""
    nothing: Nothing = "none"
    """What a step is in which nothing is coded: a value of its own, or missing, which cuts the recording there."""
    overlaps: Overlaps = "error"
    """What overlaps on one tier are: an error that names them, or a combined value such as "look & smile"."""
    span: Span = "coded"
    """From when to when there are steps. all: from the first onset to the last offset in a recording, or as its file
    says; coded: the same, but no longer than each tier that is coded without gaps; common: as long as all tiers have
    events."""
    coded: str | None = None
    """Tier whose events say when there was coding: there are steps during these only."""
    absent: Absent = "error"
    """What a recording is that lacks a tier: an error, one in which nothing happened on it, or one to leave out."""
    missing: Missing = "error"
    """What a missing value does: an error, or a break in the recording."""
    slack: Annotated[float, Real("[0, 60]")] | None = None
    """Overlaps and gaps between two events of a tier up to so many seconds are closed, as they come from how offsets
    are written; by default one millisecond, or one frame where times are frames."""

    ADVANCED: ClassVar[Sequence[str]] = ("span", "coded", "absent", "missing", "slack")


def sample(events: "Events", step: float, tiers: Sequence[str], options: SampleOptions) -> Recordings:
    """Sample events to equal steps (see :meth:`Events.steps`).

    Args:
        events: What is coded.
        step: Length of a step in seconds, from 1e-6 to 1e6.
        tiers: Names of the tiers.
        options: How.

    Raises:
        SeriesError: Overlaps, missing codes, a tier that is not there, or no two steps that follow each other.
        ConfigError: ``step`` is out of its range.
    """
    check_argument("step", step, Annotated[float, Real("[1e-6, 1e6]")])
    if not tiers:
        raise SeriesError("there is no tier to sample")
    if options.coded is not None and options.coded not in events.tier_names:
        raise SeriesError(f"there is no tier {options.coded!r} that says when there was coding")
    slack = events.resolution if options.slack is None else options.slack
    codes = TierCodes(events, int(microseconds(np.array(slack))), options.overlaps)
    lacking = _lacking(events, tiers, options)
    sampled: list[_Sampled] = []
    for recording in events.recordings:
        if recording not in lacking:
            room = MOST_STEPS - sum(len(sample.absent) for sample in sampled)
            sampled.append(_sample_one(codes, recording, step, tiers, options, room))
    stretches = [(i, stretch) for i, sample in enumerate(sampled) for stretch in pieces(sample.absent)]
    long = [(i, stretch) for i, stretch in stretches if len(stretch) > 1]
    if not long:
        raise SeriesError(f"no two coded steps of {step:g} s follow each other in one recording; take a shorter step")
    columns, labels = {}, {}
    for tier in tiers:
        columns[tier], labels[tier] = _numbered([sampled[i].codes[tier][stretch] for i, stretch in long], codes.names)
    return Recordings(
        columns,
        labels,
        [i for i, _ in long],
        sum(len(sample.absent) for sample in sampled),
        sum(int(sample.absent.sum()) for sample in sampled),
        len(stretches) - len(long),
        tuple(sample.recording for sample in sampled),
        float(step),
        (*events.remarks, *_remarks(sampled, lacking, {sampled[i].recording for i, _ in long}, step)),
    )


@dataclass(frozen=True)
class _Sampled:
    """A recording that has been sampled: for every tier a code a step."""

    recording: str
    codes: dict[str, np.ndarray]
    absent: np.ndarray
    """Steps that have no values, or were not coded."""
    outside_s: float
    """Seconds with events before and after the steps."""
    missed: dict[str, int]
    """Events by tier that are in no step."""


def _lacking(events: "Events", tiers: Sequence[str], options: SampleOptions) -> dict[str, list[str]]:
    """Recordings to leave out, and the tiers that they lack."""
    wanted = [*tiers, *([] if options.coded is None else [options.coded])]
    without = {
        recording: [tier for tier in wanted if tier not in events.tiers[recording]] for recording in events.recordings
    }
    without = {recording: tiers for recording, tiers in without.items() if tiers}
    if without and options.absent == "error":
        recording, (tier, *_) = next(iter(without.items()))
        raise SeriesError(
            f"recording {recording!r} has no tier {tier!r}"
            + (f", and {len(without) - 1} more lack one" if len(without) > 1 else "")
            + "; say `absent='nothing'` if nothing happened on it, or `absent='leave_out'` if it was not coded"
        )
    if options.absent == "nothing":
        return {recording: tiers for recording, tiers in without.items() if options.coded in tiers}
    return without


def _sample_one(
    codes: TierCodes, recording: str, step: float, tiers: Sequence[str], options: SampleOptions, room: int
) -> _Sampled:
    lines = {tier: codes.line(recording, tier) for tier in tiers}
    whole = codes.span(recording)
    start, end = _span(whole, list(lines.values()), step, options.span)
    length = (end - start) / (step * 1e6)
    if length > room:
        raise SeriesError(
            f"recording {recording!r} has {length:,.0f} steps of {step:g} s, and no more than {MOST_STEPS:,} can be "
            "held; take a longer step, or look whether its times are right"
        )
    n = max(int(length + 1e-6), 0)
    edges = start + np.rint(np.arange(n + 1) * (step * 1e6)).astype(np.int64)
    values, missed = {}, {}
    for tier, line in lines.items():
        taken = _at_middles(line, start, n, step) if options.value_at == "middle" else _for_most(line, edges)
        _put_moments(taken, line, edges, codes, recording, tier, options)
        values[tier], missed[tier] = taken, _missed(taken, line, edges)
    absent = np.zeros(n, bool)
    for tier, taken in values.items():
        unknown = taken == UNKNOWN
        if unknown.any() and options.missing == "error":
            raise SeriesError(
                f"tier {tier!r} of recording {recording!r} has missing codes in {count(int(unknown.sum()), 'step')}, "
                f"the first at {edges[np.argmax(unknown)] / 1e6:g} s; fill them in, or cut recordings there with "
                "`missing='break'`"
            )
        absent |= unknown if options.nothing == "none" else taken < 0
    if options.coded is not None:
        coding = codes.line(recording, options.coded)
        absent |= ~_inside(coding, edges)
    outside = max(start - whole[0], 0) + max(whole[1] - int(edges[-1]), 0)
    return _Sampled(recording, values, absent, outside / 1e6, missed)


def _span(whole: tuple[int, int], lines: list[TierLine], step: float, span: Span) -> tuple[int, int]:
    """From when to when there are steps, in microseconds."""
    ends = [_ends(line) for line in lines]
    if span == "common":
        if any(end is None for end in ends):
            return whole[0], whole[0]
        limits = [end for end in ends if end is not None]
    elif span == "coded":
        least = (whole[1] - whole[0]) * GAPLESS_SHARE
        limits = [end for line, end in zip(lines, ends, strict=True) if end is not None and _gapless(line, step, least)]
    else:
        limits = []
    return max([whole[0], *(limit[0] for limit in limits)]), min([whole[1], *(limit[1] for limit in limits)])


def _ends(line: TierLine) -> tuple[int, int] | None:
    """When the first event of a tier begins, and when the last one ends."""
    times = np.concatenate([line.onset, line.offset, line.moments])
    return (int(times.min()), int(times.max())) if len(times) else None


def _gapless(line: TierLine, step: float, least: float) -> bool:
    """Whether intervals follow one another without a gap of a step, and last for ``least`` microseconds in all."""
    if len(line.onset) < GAPLESS_EVENTS:
        return False
    gaps = line.onset[1:] - line.offset[:-1]
    return bool(gaps.max() <= step * 1e6 and (line.offset - line.onset).sum() >= least)


def _at_middles(line: TierLine, start: int, n: int, step: float) -> np.ndarray:
    """What is coded at the middle of each step."""
    middles = start + np.rint((np.arange(n) + 0.5) * (step * 1e6)).astype(np.int64)
    first, last = np.searchsorted(middles, line.onset), np.searchsorted(middles, line.offset)
    return _filled(first, last, line.code, n)


def _filled(first: np.ndarray, last: np.ndarray, code: np.ndarray, n: int) -> np.ndarray:
    """Codes of the steps ``first`` to before ``last`` of each interval, NOTHING elsewhere."""
    bounds = np.zeros(2 * len(first) + 2, np.int64)
    bounds[1:-1:2], bounds[2:-1:2], bounds[-1] = first, last, n
    values = np.full(2 * len(first) + 1, NOTHING, np.int32)
    values[1::2] = code
    return np.repeat(values, np.diff(bounds))


def _for_most(line: TierLine, edges: np.ndarray) -> np.ndarray:
    """What is coded for most of each step, or that nothing is; of two that last equally long, the earlier."""
    n = len(edges) - 1
    times = np.empty(2 * len(line.onset) + 2, np.int64)
    times[0], times[1:-1:2], times[2:-1:2], times[-1] = edges[0], line.onset, line.offset, edges[-1]
    times = np.clip(times, edges[0], edges[-1])
    codes = np.full(2 * len(line.onset) + 1, NOTHING, np.int64)
    codes[1::2] = line.code
    lasts = np.diff(times) > 0
    onset, offset, codes = times[:-1][lasts], times[1:][lasts], codes[lasts]
    first, last = np.searchsorted(edges, onset), np.searchsorted(edges, offset, "right") - 1
    taken = np.full(n, NOTHING, np.int32)
    whole = last > first
    filled = _filled(first[whole], last[whole], codes[whole], n)
    taken[:] = filled
    within, ahead = last < first, (last >= first) & (edges[first] > onset)
    behind = (last >= first) & (offset > edges[last])
    step = np.concatenate([last[within], first[ahead] - 1, last[behind]])
    length = np.concatenate(
        [(offset - onset)[within], edges[first[ahead]] - onset[ahead], offset[behind] - edges[last[behind]]]
    )
    code, began = (np.concatenate([values[within], values[ahead], values[behind]]) for values in (codes, onset))
    if len(step):
        order = np.lexsort((began, code, step))
        step, length, code, began = step[order], length[order], code[order], began[order]
        new = np.flatnonzero(np.r_[True, (np.diff(step) != 0) | (np.diff(code) != 0)])
        length = np.add.reduceat(length, new)
        step, code, began = step[new], code[new], began[new]
        order = np.lexsort((began, -length, step))
        best = order[np.r_[True, np.diff(step[order]) != 0]]
        taken[step[best]] = code[best]
    return taken


def _put_moments(
    taken: np.ndarray,
    line: TierLine,
    edges: np.ndarray,
    codes: TierCodes,
    recording: str,
    tier: str,
    options: SampleOptions,
) -> None:
    """Give each step with a point event its code."""
    within = (line.moments >= edges[0]) & (line.moments <= edges[-1])
    times, moment = line.moments[within], line.moment_codes[within]
    if not len(times) or not len(taken):
        return
    at = np.minimum(np.searchsorted(edges, times, "right") - 1, len(taken) - 1)
    around = line.at(times)
    for i in range(len(at)):
        together = {int(moment[i]), int(around[i])} - {NOTHING}
        if i and at[i - 1] == at[i]:
            together.add(int(taken[at[i]]))
        if len(together) > 1 and options.overlaps == "error":
            names = " and ".join(sorted(repr(codes.name(code)) for code in together))
            raise SeriesError(
                f"events overlap on the tier {tier!r} of recording {recording!r}: {names} are both in the step at "
                f"{edges[at[i]] / 1e6:g} s, as one is a point event. Take a shorter step, part them into tiers, or "
                "combine them into values of their own with `overlaps='combine'`"
            )
        taken[at[i]] = codes.combined(together)


def _missed(taken: np.ndarray, line: TierLine, edges: np.ndarray) -> int:
    """Intervals between the edges that no step has got."""
    n = len(taken)
    if not n:
        return 0
    middle = (line.onset + line.offset) // 2
    short = (line.onset >= edges[0]) & (line.offset <= edges[-1])
    first = np.clip(np.searchsorted(edges, line.onset, "right") - 1, 0, n - 1)
    last = np.clip(np.searchsorted(edges, line.offset) - 1, 0, n - 1)
    between = np.clip(np.searchsorted(edges, middle, "right") - 1, 0, n - 1)
    got = (taken[first] == line.code) | (taken[last] == line.code) | (taken[between] == line.code)
    return int((short & ~got).sum())


def _inside(line: TierLine, edges: np.ndarray) -> np.ndarray:
    """Which steps lie as a whole within an interval, or within several that adjoin."""
    parted = line.onset[1:] > line.offset[:-1]
    onset = np.concatenate([line.onset[:1], line.onset[1:][parted]])
    offset = np.concatenate([line.offset[:-1][parted], line.offset[-1:]])
    first, last = np.searchsorted(edges, onset), np.searchsorted(edges, offset, "right") - 1
    n = len(edges) - 1
    not_empty = last > first
    kept: np.ndarray = _filled(first[not_empty], last[not_empty], np.zeros(int(not_empty.sum()), np.int64), n) == 0
    return kept


def _numbered(parts: list[np.ndarray], names: Sequence[str]) -> tuple[list[np.ndarray], tuple[str, ...]]:
    """Codes from 0 on in the order of their labels, and the labels."""
    used = np.zeros(len(names) + 2, bool)
    for part in parts:
        used |= np.bincount(part + 2, minlength=len(used)).astype(bool)
    numbers = np.flatnonzero(used) - 2
    label = {number: NONE if number == NOTHING else names[number] for number in numbers.tolist()}
    labels = sorted_names(set(label.values()))
    code_of = np.zeros(len(used), np.int32)
    for number, name in label.items():
        code_of[number + 2] = labels.index(name)
    return [code_of[part + 2] for part in parts], tuple(labels)


def _remarks(sampled: list[_Sampled], lacking: Collection[str], used: set[str], step: float) -> list[str]:
    """What was left out, and why."""
    remarks = []
    if lacking:
        remarks.append(f"{_some(lacking)} left out, for want of a tier")
    short = [recording.recording for recording in sampled if recording.recording not in used]
    if short:
        remarks.append(f"{_some(short)} left out, for want of two coded steps that follow each other")
    outside = {recording.recording: recording.outside_s for recording in sampled if recording.outside_s >= step}
    if outside:
        remarks.append(
            f"{_some(outside)} cut at the ends, by {sum(outside.values()):.4g} s in all, where a tier was not coded; "
            "the span 'all' keeps them"
        )
    missed = {
        tier: sum(recording.missed[tier] for recording in sampled) for tier in (sampled[0].missed if sampled else ())
    }
    for tier, number in missed.items():
        if number:
            are, them = ("is", "it") if number == 1 else ("are", "them")
            remarks.append(
                f"{count(number, 'event')} of {tier!r} {are} in no step of {step:g} s; a shorter step has {them}"
            )
    return remarks


def _some(names: Collection[str]) -> str:
    listed = ", ".join(list(names)[:3]) + (" ..." if len(names) > 3 else "")
    return f"{count(len(names), 'recording')} ({listed}) {'is' if len(names) == 1 else 'are'}"
