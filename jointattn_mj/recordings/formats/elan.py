"""ELAN's annotation files (.eaf): pympi reads them, and the times of annotations that have none follow from others."""

import warnings
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

from jointattn_mj.errors import SeriesError
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.labels import missing_labels

ROOT = b"<ANNOTATION_DOCUMENT"
"""Stands near the start of every such file."""
_LONGEST_CHAIN = 100

Times = tuple[float, float]
"""Onset and offset in milliseconds."""


def is_elan(data: bytes) -> bool:
    """Whether a file is one of ELAN's."""
    return ROOT in data[:4096]


def read_elan(data: bytes, path: Path, missing: Collection[str] = ()) -> Events:
    """Read all tiers of an annotation file.

    Args:
        data: The whole file.
        path: The file; without its suffix it names the recording.
        missing: Values that stand for no code, beside the usual ones.

    Raises:
        SeriesError: The file cannot be read, two annotations have one name, one has no time, or there is none.
    """
    from pympi import Elan  # here, as few read such files

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of versions that pympi does not know
            book = Elan.Eaf(path.resolve())
        annotations = _Annotations(book)
        rows = [row for tier in book.tiers for row in annotations.of(tier)]
    except (SeriesError, ImportError, MemoryError):
        raise
    except Exception as error:  # pympi says what is wrong with a damaged file by any of Python's errors
        trouble = " ".join(str(error).split())[:200]
        raise SeriesError(f"{path} is no ELAN file that can be read: {type(error).__name__} {trouble}") from error
    written = data.count(b"<ALIGNABLE_ANNOTATION") + data.count(b"<REF_ANNOTATION")
    if written != len(rows) or data.count(b"<TIME_SLOT ") != len(book.timeslots):
        raise SeriesError(f"{path} has annotations, times or tiers with the same name; save it with ELAN again")
    if not rows:
        raise SeriesError(f"{path} has no annotations")
    tiers, values, times = zip(*rows, strict=True)
    codes = [value.strip() for value in values]
    none = missing_labels(set(codes), missing)
    try:
        return Events.of(
            tiers,
            [None if code in none else code for code in codes],
            [onset / 1000 for onset, _ in times],
            [offset / 1000 for _, offset in times],
            path.stem,
            tiers={path.stem: tuple(book.tiers)},
        )
    except SeriesError as error:
        raise SeriesError(f"{path}: {error}") from error


class _Annotations:
    """Finds when annotations begin and end."""

    def __init__(self, book: Any):
        self._book = book
        self._known: dict[str, Times] = {}
        for tier in book.tiers:
            self._align(tier)

    def of(self, tier: str) -> Iterator[tuple[str, str, Times]]:
        """Tier, value and times of each annotation."""
        aligned, dependent = self._book.tiers[tier][:2]
        for name, (_, _, value, _) in aligned.items():
            yield tier, value, self._times(name)
        for name, (_, value, _, _) in dependent.items():
            yield tier, value, self._times(name)

    def _align(self, tier: str) -> None:
        """Times of annotations with time slots; slots without a time part what lies between those that have one."""
        slots = self._book.timeslots
        open_: list[str] = []
        start, before = 0.0, ""
        for name, (first, last, _, _) in self._book.tiers[tier][0].items():
            if open_ and first != before:
                break
            before = last
            if not open_:
                if slots[first] is None:
                    raise SeriesError(
                        f"annotation {name} on the tier {tier!r} has no time; align it in ELAN, or remove it"
                    )
                start = slots[first]
            open_.append(name)
            if slots[last] is not None:
                length = (slots[last] - start) / len(open_)
                for i, annotation in enumerate(open_):
                    self._known[annotation] = start + i * length, start + (i + 1) * length
                open_ = []
        if open_:
            raise SeriesError(f"annotation {open_[0]} on the tier {tier!r} has no end; align it in ELAN, or remove it")

    def _times(self, name: str, depth: int = 0) -> Times:
        """Times of an annotation: its own, or an equal part of what it and its neighbours depend on."""
        if name in self._known:
            return self._known[name]
        dependent = self._book.tiers[self._book.annotations[name]][1]
        if depth > _LONGEST_CHAIN:
            raise SeriesError(f"annotation {name} depends on itself")
        parent = dependent[name][0]
        onset, offset = self._times(parent, depth + 1)
        row = _in_order({annotation: slots[2] for annotation, slots in dependent.items() if slots[0] == parent})
        for i, annotation in enumerate(row):
            self._known[annotation] = (
                onset + i * (offset - onset) / len(row),
                onset + (i + 1) * (offset - onset) / len(row),
            )
        return self._known[name]


def _in_order(previous: dict[str, str | None]) -> list[str]:
    """Names of annotations, each after its previous one; those without stand as in the file."""
    after: dict[str | None, list[str]] = {}
    for name, before in previous.items():
        after.setdefault(before if before in previous else None, []).append(name)
    row: list[str] = []
    waiting = list(reversed(after.get(None, [])))
    while waiting:
        name = waiting.pop()
        row.append(name)
        waiting += reversed(after.get(name, []))
    return row if len(row) == len(previous) else list(previous)
