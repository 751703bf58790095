"""Coded events: who or what (tier), which code, from when to when; and the way from them to equal steps."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from jointattn_mj.errors import SeriesError
from jointattn_mj.io.progress import count
from jointattn_mj.io.table import Table
from jointattn_mj.options import meant, shown
from jointattn_mj.recordings.sampling import Nothing, SampleOptions, Span, ValueAt, sample
from jointattn_mj.recordings.steps import Recordings
from jointattn_mj.recordings.texts import Texts
from jointattn_mj.recordings.tier_codes import Overlaps, dictionary

LATEST_S = 1e9
"""Times are from -1e9 to 1e9 s, so that microseconds are exact."""


@dataclass(frozen=True, eq=False, repr=False)
class Events:
    """Events of one or more recordings. An event of no length is a moment: a point event.

    Attributes:
        table: Columns ``recording``, ``tier`` and ``code`` (text; code is missing where it is not known), ``onset`` and
            ``offset`` (float, seconds). Rows are in order of recording, tier and onset.
        tiers: Names of the tiers of each recording, also of those on which nothing happened.
        spans: When coding began and ended in a recording (seconds), for recordings of which that is known.
        resolution: Seconds between two times that can be told apart.
        remarks: What a reader should know: what was left out when the events were read, and why.
    about: By column, what is true of each recording as a whole, such as an age.

    Examples:
        >>> from jointattn_mj.recordings.events import Events
        >>> gaze = Events.of(["infant", "infant", "mother"], ["toy", "face", "toy"], [0, 0.5, 0.1], [0.5, 1, 1])
        >>> gaze
        Events(3 events, 2 tiers, 1 recording)
        >>> steps = gaze.steps(0.2)
        >>> steps.columns["infant"], steps.labels["infant"]
        ([array([1, 1, 0, 0, 0], dtype=int32)], ('face', 'toy'))
    """

    table: Table
    tiers: Mapping[str, tuple[str, ...]]
    spans: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    resolution: float = 0.001
    remarks: tuple[str, ...] = ()
    about: Mapping[str, Mapping[str, str]] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        tier: Sequence[str] | Texts,
        code: Sequence[str | None] | Texts,
        onset: Sequence[float] | np.ndarray,
        offset: Sequence[float] | np.ndarray,
        recording: Sequence[str] | str | Texts = "1",
        **more: Any,
    ) -> "Events":
        """Events from columns of equal length.

        Args:
            tier: What each event belongs to, such as ``"infant gaze"``.
            code: What each event is, such as ``"toy"``; None where that is not known.
            onset: When each begins, in seconds.
            offset: When each ends, in seconds; equal to ``onset`` for a point event.
            recording: Which recording each is of, or one name for all.
            more: Further attributes. ``tiers`` needs only those on which nothing happened.

        Returns:
            The events, in order of recording, tier (both as first met) and onset.

        Raises:
            SeriesError: Columns of different lengths, times that are no numbers, or an offset before its onset.

        Examples:
            >>> from jointattn_mj.recordings.events import Events
            >>> Events.of(["infant", "infant"], ["toy", "face"], [0, 0.5], [0.5, 1]).table["code"].tolist()
            ['toy', 'face']
        """
        import pyarrow as pa  # here, so that measures of arrays do without it

        recordings = Texts(np.zeros(len(tier), np.int64), [recording]) if isinstance(recording, str) else recording
        texts = Texts.of(recordings), Texts.of(tier), Texts.of(code)
        times = _times(onset, "onset"), _times(offset, "offset")
        lengths = [len(column) for column in (*texts, *times)]
        if len(set(lengths)) > 1:
            raise SeriesError(f"columns of events must be equally long; got {', '.join(map(str, lengths))} rows")
        backward = times[1] < times[0]
        if backward.any():
            at = int(np.argmax(backward))
            raise SeriesError(
                f"event {at + 1} ({shown(texts[2].at(at))} on {texts[1].at(at)!r}) ends at {times[1][at]:g} s, before "
                f"it begins at {times[0][at]:g} s"
            )
        if min((text.numbers.min(initial=0) for text in texts[:2]), default=0) < 0:
            raise SeriesError("each event needs a recording and a tier")
        pairs = texts[0].numbers * (len(texts[1].names) + 1) + texts[1].numbers
        names = _tiers(
            ((texts[0].at(row), texts[1].at(row)) for row in first_met(pairs, rows=True)), more.pop("tiers", {})
        )
        every = list(dict.fromkeys(tier for tiers in names.values() for tier in tiers))
        numbers = [texts[0].among(list(names)), texts[1].among(every), texts[2].numbers]
        order = np.lexsort((times[1], times[0], *reversed(numbers[:2])))
        columns = [
            pa.DictionaryArray.from_arrays(
                pa.array(column[order].astype(np.int32), mask=column[order] < 0), pa.array(known, pa.string())
            )
            for column, known in zip(numbers, (list(names), every, texts[2].names), strict=True)
        ]
        columns += [pa.array(column[order]) for column in times]
        table = pa.table(dict(zip(("recording", "tier", "code", "onset", "offset"), columns, strict=True)))
        return cls(Table(table), names, **more)

    @property
    def recordings(self) -> tuple[str, ...]:
        """Names of the recordings."""
        return tuple(self.tiers)

    @property
    def tier_names(self) -> tuple[str, ...]:
        """Names of all tiers, in the order in which they are first met."""
        return tuple(dict.fromkeys(name for names in self.tiers.values() for name in names))

    def __len__(self) -> int:
        return len(self.table)

    def __repr__(self) -> str:
        counts = count(len(self), "event"), count(len(self.tier_names), "tier"), count(len(self.tiers), "recording")
        return f"Events({', '.join(counts)})"

    def select(self, tiers: Iterable[str] | None = None, recordings: Iterable[str] | None = None) -> "Events":
        """Take the events of some tiers and recordings.

        Args:
            tiers: Names of tiers; None: all.
            recordings: Names of recordings; None: all.

        Returns:
            Their events.

        Raises:
            SeriesError: There is no such tier or recording.

        Examples:
            >>> from jointattn_mj.recordings.events import Events
            >>> gaze = Events.of(["infant", "mother"], ["toy", "face"], [0, 0.1], [0.5, 1])
            >>> gaze.select(["infant"])
            Events(1 event, 1 tier, 1 recording)
        """
        kept = self._known(tiers, self.tier_names, "tier"), self._known(recordings, self.recordings, "recording")
        rows = np.isin(self.table["tier"], kept[0]) & np.isin(self.table["recording"], kept[1])
        names = {recording: tuple(name for name in self.tiers[recording] if name in kept[0]) for recording in kept[1]}
        spans = {recording: span for recording, span in self.spans.items() if recording in kept[1]}
        return replace(self, table=Table(self.table.arrow.filter(rows)), tiers=names, spans=spans)

    def joined(self, *others: "Events") -> "Events":
        """Put events together.

        Args:
            others: Further recordings, or further tiers of the same ones.

        Returns:
            These events and all of ``others``.

        Examples:
            >>> from jointattn_mj.recordings.events import Events
            >>> gaze = Events.of(["infant", "mother"], ["toy", "face"], [0, 0.1], [0.5, 1])
            >>> gaze.joined(Events.of(["infant"], ["toy"], [0], [2], "second visit"))
            Events(3 events, 2 tiers, 2 recordings)
        """
        every = (self, *others)
        texts = [
            Texts.stacked([Texts(*dictionary(part.table.arrow[name])) for part in every])
            for name in ("tier", "code", "recording")
        ]
        onset, offset = (np.concatenate([part.table[name] for part in every]) for name in ("onset", "offset"))
        return Events.of(
            texts[0],
            texts[1],
            onset,
            offset,
            texts[2],
            tiers=_tiers([], *(part.tiers for part in every)),
            spans={recording: span for part in every for recording, span in part.spans.items()},
            resolution=max(part.resolution for part in every),
            remarks=tuple(dict.fromkeys(remark for part in every for remark in part.remarks)),
            about=_merged(part.about for part in every),
        )

    def steps(
        self,
        step: float,
        tiers: Iterable[str] | None = None,
        *,
        value_at: ValueAt = "middle",
        nothing: Nothing = "none",
        overlaps: Overlaps = "error",
        span: Span = "coded",
        **more: Any,
    ) -> Recordings:
        """Sample the events to steps of equal length, the same for all tiers of a recording.

        Args:
            step: Length of a step in seconds.
            tiers: Names of the tiers to sample; None: all.
            value_at: A step has the code at its ``"middle"``, or the one that lasts for ``"most"`` of it.
            nothing: What a step is in which nothing is coded: a value of its own, ``"none"``, or ``"missing"``, which
                cuts the recording there.
            overlaps: Events that overlap on one tier are an ``"error"``, or ``"combine"`` to a value of their own.
            span: From when to when steps go, see :class:`SampleOptions`.
            more: Further fields of :class:`SampleOptions`.

        Returns:
            A variable for each tier, recording by recording.

        Raises:
            SeriesError: No such tier, overlaps, missing codes, or no two steps that follow each other.
            ConfigError: An option that cannot work.

        Examples:
            >>> from jointattn_mj.recordings.events import Events
            >>> gaze = Events.of(["infant", "mother"], ["toy", "face"], [0, 0.1], [0.5, 1])
            >>> gaze.steps(0.25)
            Recordings(4 rows, 1 recording, 2 columns: infant, mother)
        """
        options = SampleOptions(value_at=value_at, nothing=nothing, overlaps=overlaps, span=span, **more)
        return sample(self, step, self._known(tiers, self.tier_names, "tier"), options)

    def to_pandas(self) -> Any:
        """Give the table as ``pandas.DataFrame``.

        Returns:
            The data frame, with the same columns.

        Raises:
            ExtraError: The package pandas is not installed.

        Examples:
            >>> from jointattn_mj.recordings.events import Events
            >>> Events.of(["infant"], ["toy"], [0], [0.5]).to_pandas()["offset"].tolist()
            [0.5]
        """
        return self.table.to_pandas()

    @staticmethod
    def _known(asked: Iterable[str] | None, known: Sequence[str], kind: str) -> list[str]:
        names = list(known) if asked is None else list(dict.fromkeys([asked] if isinstance(asked, str) else asked))
        for name in names:
            if name not in known:
                there = ", ".join(known[:20]) + (" ..." if len(known) > 20 else "")
                raise SeriesError(f"there is no {kind} {name!r}{meant(name, known)}; there are {there or 'none'}")
        return names


def _times(values: Sequence[float] | np.ndarray, name: str) -> np.ndarray:
    try:
        times = np.asarray(values, float)
    except (TypeError, ValueError) as error:
        raise SeriesError(f"{name} must be numbers, in seconds: {error}") from error
    wrong = ~(np.abs(times) <= LATEST_S)
    if wrong.any():
        raise SeriesError(
            f"{name} must lie within {LATEST_S:g} s; event {int(np.argmax(wrong)) + 1} has {times[wrong][0]}"
        )
    return times


def _tiers(rows: Iterable[tuple[str, str]], *given: Mapping[str, Sequence[str]]) -> dict[str, tuple[str, ...]]:
    """Tiers by recording: those that are given, then those of the rows."""
    names: dict[str, dict[str, None]] = {}
    for part in given:
        for recording, tiers in part.items():
            names.setdefault(recording, {}).update(dict.fromkeys(tiers))
    for recording, tier in rows:
        names.setdefault(recording, {}).setdefault(tier)
    return {recording: tuple(tiers) for recording, tiers in names.items()}


def _merged(every: Iterable[Mapping[str, Mapping[str, str]]]) -> dict[str, dict[str, str]]:
    """What is true of recordings, from several parts."""
    about: dict[str, dict[str, str]] = {}
    for part in every:
        for column, values in part.items():
            about.setdefault(column, {}).update(values)
    return about


def first_met(numbers: np.ndarray, rows: bool = False) -> list[int]:
    """Different numbers in the order in which they are first met, or their first rows."""
    values, first = np.unique(numbers, return_index=True)
    order = np.argsort(first)
    return [int(number) for number in (first if rows else values)[order]]
