"""Times as coding programs write them, in seconds: seconds, milliseconds, frames, or a clock such as 00:01:02.500."""

import re
from collections.abc import Sequence
from typing import Literal

import numpy as np

from jointattn_mj.errors import SeriesError
from jointattn_mj.options import shown

TimeUnit = Literal["auto", "s", "ms", "frames"]
"""Unit of times that are plain numbers; auto: as the header says, or seconds if some have fractions."""

_NUMBER = re.compile(r"[+-]?(\d{1,15}([.,]\d{0,30})?|[.,]\d{1,30})([eE][+-]?\d{1,2})?")
_CLOCK = re.compile(r"(-?)(?:(\d{1,4}):)?(\d{1,4}):(\d{1,2})(?:[.,](\d{1,9})|:(\d{3})|[:;](\d{1,2}))?")
_WORDS: dict[str, TimeUnit] = {
    "ms": "ms", "msec": "ms", "msecs": "ms", "millisecond": "ms", "milliseconds": "ms", "f": "frames",
    "frame": "frames", "frames": "frames", "s": "s", "sec": "s", "secs": "s", "second": "s", "seconds": "s", "sf": "s",
}  # fmt: skip
"""What a word in a column's name says about its unit."""


def unit_of(name: str) -> TimeUnit:
    """Unit that a column's name tells, such as ``Begin Time - msec``; ``auto`` where it tells none."""
    words = re.split(r"[^a-z]+", name.casefold())
    if {"hh", "mm", "hms", "hmsf"} & set(words):
        return "auto"
    if {"ss", "msec"} <= set(words):  # ELAN's seconds with a fraction
        return "s"
    return next((_WORDS[word] for word in reversed(words) if word in _WORDS), "auto")


def is_time(text: str) -> bool:
    """Whether text is a number or a clock's time."""
    text = text.strip()
    return bool(_NUMBER.fullmatch(text) or _CLOCK.fullmatch(text))


def has_fraction(text: str) -> bool:
    """Whether text is a number that is not whole."""
    text = text.strip()
    return _NUMBER.fullmatch(text) is not None and not float(text.replace(",", ".")).is_integer()


def seconds(texts: Sequence[str], unit: TimeUnit, rate: float | None, where: str) -> np.ndarray:
    """What times mean, in seconds.

    Args:
        texts: Times as written, none of them empty.
        unit: Unit of those that are plain numbers.
        rate: Frames a second; needed where frames occur.
        where: What a message calls the column.

    Returns:
        Seconds (texts,).

    Raises:
        SeriesError: A text is no time, frames without a rate, or numbers of which the unit cannot be known.
    """
    values, plain = _plain(texts)
    for i in np.flatnonzero(~plain).tolist():
        text = texts[i].strip()
        plain[i] = _NUMBER.fullmatch(text) is not None
        values[i] = float(text.replace(",", ".")) if plain[i] else _clock(text, rate, where)
    numbers = values[plain]
    if unit == "auto" and (numbers == np.floor(numbers)).all() and numbers.any():
        raise SeriesError(
            f"{where} holds whole numbers without a unit, such as {numbers.max():g}; say `time_unit='s'`, "
            "`time_unit='ms'` or `time_unit='frames'`"
        )
    if len(numbers) and unit == "frames" and rate is None:
        raise SeriesError(f"{where} holds frames; say how many there are in a second, such as `rate=25`")
    values[plain] = numbers / {"auto": 1, "s": 1, "ms": 1000, "frames": rate or 1}[unit]
    return values


def _plain(texts: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Numbers that are written plainly, by compiled code, and which texts these are."""
    import pyarrow as pa  # here, so that measures of arrays do without it
    from pyarrow import compute

    column = compute.utf8_trim_whitespace(pa.array(texts, pa.string()))
    plain = compute.match_substring_regex(column, r"^-?\d{1,15}(\.\d{1,30})?$").to_numpy(zero_copy_only=False)
    values = np.full(len(texts), np.nan)
    values[plain] = column.filter(pa.array(plain, pa.bool_())).cast(pa.float64()).to_numpy()
    return values, np.array(plain, bool)


def _clock(text: str, rate: float | None, where: str) -> float:
    match = _CLOCK.fullmatch(text)
    if match is None:
        raise SeriesError(
            f"{where} holds {shown(text)}, which is no time; expected a number, or a clock such as 00:01:02.500"
        )
    sign, hours, minutes, whole, fraction, thousandths, frames = match.groups()
    if int(whole) > 59 or (hours is not None and int(minutes) > 59):
        raise SeriesError(f"{where} holds {shown(text)}, which is no time: minutes and seconds go to 59")
    value = 3600.0 * int(hours or 0) + 60 * int(minutes) + int(whole)
    if fraction is not None:
        value += float(f"0.{fraction}")
    if thousandths is not None:
        value += int(thousandths) / 1000
    if frames is not None:
        if rate is None:
            raise SeriesError(
                f"{where} holds {shown(text)}, which ends in frames; say how many there are in a second, such as "
                "`rate=25`"
            )
        if int(frames) >= rate:
            raise SeriesError(
                f"{where} holds {shown(text)}, but at {rate:g} frames a second they go to {int(rate - 1e-9)}"
            )
        value += int(frames) / rate
    return -value if sign else value
