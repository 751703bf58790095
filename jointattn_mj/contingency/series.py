"""Series of codes: what the measures take, how it is checked, and several variables taken as one.

A series is an integer array (T,), or a list or tuple of such arrays, or ``Stacked``: separate recordings, so that no
transition crosses from one into the next. Series that belong together are aligned such that ``r[t + 1]`` answers
``s[t]`` and ``a[t]``.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from operator import attrgetter
from typing import Any, overload

import numpy as np

from jointattn_mj.errors import SeriesError
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import shown

Series = np.ndarray | Sequence[Any]
"""An array-like of codes (T,), a sequence of them, or ``Stacked``."""

MOST_COUNTED = 2**20
"""Possible keys up to which they are counted instead of sorted."""
SMALL = 1024
"""Codes below this are taken as they are; larger ones are numbered anew where there are fewer steps than codes."""


class Stacked(Sequence[np.ndarray]):
    """Recordings of equal length, the rows of an array; quicker than a list of them.

    A bare array of two dimensions is no series: it could as well hold several variables.

    Attributes:
        array: (k, T) integer codes, k recordings of T steps.

    Examples:
        >>> from jointattn_mj.contingency import transfer_entropy
        >>> trials = np.array([[0, 0, 1, 1, 0, 1], [1, 0, 1, 1, 0, 0]])
        >>> transfer_entropy(Stacked(trials), Stacked(1 - trials)) == transfer_entropy(list(trials), list(1 - trials))
        True
    """

    def __init__(self, array: Any):
        """Take the rows of an array-like of two dimensions.

        Raises:
            SeriesError: It has another number of dimensions, or masked values.
        """
        masked = sum(map(np.ma.count_masked, filter(np.ma.is_masked, _recordings(array))))
        if masked:
            raise SeriesError(
                f"Stacked takes recordings of equal length; got {masked} masked values. Cut the recordings there, and "
                "give what is left as a list of arrays"
            )
        try:
            self.array = np.asarray(array)
        except (ValueError, TypeError) as error:
            raise SeriesError(f"Stacked takes an array (k, T) of whole numbers: {error}") from error
        if self.array.ndim != 2:
            raise SeriesError(f"Stacked takes an array (k, T), a recording a row; got shape {self.array.shape}")

    def __repr__(self) -> str:
        return f"Stacked({len(self)} recordings of {self.array.shape[1]} steps)"

    def __len__(self) -> int:
        """Number of recordings."""
        return len(self.array)

    @overload
    def __getitem__(self, index: int) -> np.ndarray: ...
    @overload
    def __getitem__(self, index: slice) -> "Stacked": ...
    def __getitem__(self, index: int | slice) -> "np.ndarray | Stacked":
        """A recording (T,), or some of them."""
        return Stacked(self.array[index]) if isinstance(index, slice) else self.array[index]


@dataclass(frozen=True)
class Coded:
    """A checked series: all recordings one after the other."""

    codes: np.ndarray
    """int64 or int32 (T,), each in 0..size-1."""
    bounds: np.ndarray
    """int64 (k + 1,): recording i is ``codes[bounds[i]:bounds[i + 1]]``."""
    size: int
    """One more than the highest code."""
    values: np.ndarray | None = None
    """The codes that the caller used, int64 (size,), where they were numbered anew; otherwise code i stands for i."""

    def split(self, codes: np.ndarray | None = None) -> list[np.ndarray]:
        """``codes`` (T,), or these, recording by recording."""
        return np.split(self.codes if codes is None else codes, self.bounds[1:-1])

    def compact(self) -> "Coded":
        """The same series with codes 0, 1, ... for the values that occur, in their order."""
        values, codes = np.unique(self.codes, return_inverse=True)
        if len(values) == self.size:
            return self
        return Coded(codes, self.bounds, len(values), values if self.values is None else self.values[values])


def code(series: Series, name: str = "series") -> Coded:
    """Check a series; ``name`` is what messages call it.

    Raises:
        SeriesError: Missing values, negative codes, numbers that are not whole, text, another dimension than one, or a
            recording of fewer than two steps.
    """
    return _coded(series, name, _joined({name: series}))


def aligned(**series: Series | None) -> list[Coded | None]:
    """Check series that belong together, by name; those that are None stay None.

    Their codes are of one type, so that what is compiled for them has two variants at most.

    Raises:
        SeriesError: As ``code``, or the lengths of their recordings differ.
    """
    joined = _joined(series)
    coded = [None if given is None else _coded(given, name, joined) for name, given in series.items()]
    first, *others = [column for column in coded if column is not None]
    alike = True
    for other in others:
        alike &= other.codes.dtype == first.codes.dtype
        if not _as_long(first, other):
            names = [name for name, column in zip(series, coded, strict=True) if column is first or column is other]
            raise SeriesError(
                f"{' and '.join(names)} must be equally long; got {_lengths(first)} and {_lengths(other)} steps"
            )
    if alike:
        return coded
    return [column and replace(column, codes=column.codes.astype(np.int64)) for column in coded]


def joint(*series: Series) -> np.ndarray | list[np.ndarray]:
    """Take several variables as one.

    Args:
        series: Variables of equal lengths, each (T,) integer codes, or a list of such arrays, one a recording.

    Returns:
        A code for every combination that occurs, in lexicographic order: (T,), or a list of such arrays.

    Raises:
        SeriesError: Series that cannot be measured, different lengths, or no series at all.

    Examples:
        >>> joint([0, 0, 1, 1], [0, 5, 0, 5]).tolist()
        [0, 1, 2, 3]
    """
    if not series or any(single is None for single in series):
        raise SeriesError("joint needs at least one series, and no None among them")
    named = {f"series {i + 1}": values for i, values in enumerate(series)}
    coded = [column for column in aligned(**named) if column is not None]
    codes = distinct(*combined([column.codes for column in coded], [column.size for column in coded])).which
    return coded[0].split(codes) if len(coded[0].bounds) > 2 else codes


def recode(series: Series) -> tuple[np.ndarray | list[np.ndarray], np.ndarray]:
    """Number the codes of a series anew, without gaps.

    Args:
        series: (T,) integer codes, or a list of such arrays, one a recording.

    Returns:
        The series with codes 0..k-1, and the k codes that they stand for, ascending.

    Raises:
        SeriesError: The series cannot be measured.

    Examples:
        >>> codes, values = recode([7, 3, 7])
        >>> codes.tolist(), values.tolist()
        ([1, 0, 1], [3, 7])
    """
    coded = code(series).compact()
    values = np.arange(coded.size) if coded.values is None else coded.values
    return (coded.split() if len(coded.bounds) > 2 else coded.codes), values


def combined(columns: Sequence[np.ndarray], sizes: Sequence[int]) -> tuple[np.ndarray, int]:
    """One key for each row of ``columns``, each (n,) in 0..size-1, in lexicographic order, and a bound for the keys.

    Rows are equal where keys are. Keys are numbered anew on the way wherever they would leave 62 bits.
    """
    keys, bound = columns[0].astype(np.int64, copy=False), int(sizes[0])
    for column, size in zip(columns[1:], sizes[1:], strict=True):
        if size == 1:
            continue  # its one code is 0
        if bound * int(size) >= 2**62:
            occupied, keys = np.unique(keys, return_inverse=True)
            bound = len(occupied)
        if bound * int(size) >= 2**62:
            occupied, column = np.unique(column, return_inverse=True)
            size = len(occupied)
        keys, bound = keys * size, bound * int(size)
        keys += column
    return keys, bound


@dataclass(frozen=True)
class Distinct:
    """The different ones of some keys, ascending; as ``numpy.unique`` finds them."""

    keys: np.ndarray
    first: np.ndarray
    """Where each comes first."""
    which: np.ndarray
    """Number of each of the given keys (n,)."""
    counts: np.ndarray


def distinct(keys: np.ndarray, bound: int) -> Distinct:
    """Find the different ones of keys (n,) from 0 to below ``bound``.

    Where there are few possible keys they are counted instead of sorted: 0.1 s instead of 1.5 for ten million.
    """
    if bound > MOST_COUNTED or len(keys) < SMALL:
        return Distinct(*np.unique(keys, return_index=True, return_inverse=True, return_counts=True))
    counts, first = np.zeros(bound, np.int64), np.empty(bound, np.int64)
    _count_keys(keys, counts, first)
    used = np.flatnonzero(counts)
    number = np.zeros(bound, np.int64)
    number[used] = np.arange(len(used))
    return Distinct(used, first[used], number[keys], counts[used])


def check_base(base: float) -> float:
    """The natural logarithm of ``base``, by which nats are divided.

    Raises:
        SeriesError: It is no number above 1, or an absurd one.
    """
    try:
        number = float(base) if 1 < base <= 1e6 else None
    except (TypeError, ValueError):
        number = None
    if number is None:
        raise SeriesError(
            f"base of the logarithm must be above 1 and at most 1e6, such as 2 for bits; got {shown(base)}"
        )
    return _logarithm(number)


@lru_cache(maxsize=8)
def _logarithm(base: float) -> float:
    return float(np.log(base))


def _recordings(series: Series) -> Sequence[Any]:
    """The recordings; a flat list of numbers is one recording."""
    if isinstance(series, Stacked):
        return series
    if isinstance(series, (list, tuple)) and (not series or hasattr(series[0], "__len__")):
        return [series] if series and isinstance(series[0], str) else series
    return [series]


def _coded(series: Series, name: str, joined: Mapping[str, tuple[np.ndarray, np.ndarray]]) -> Coded:
    """See ``code``; ``joined`` has codes and bounds by name where they are known already."""
    codes, bounds = joined.get(name) or _plain(series) or _looked_at(series, name)
    lowest, highest = _range(codes)
    if lowest < 0:
        at = int(np.argmax(codes < 0))
        recording = int(np.searchsorted(bounds, at, "right")) - 1
        which = name if len(bounds) == 2 else f"recording {recording} of {name}"
        raise SeriesError(f"codes of {which} must be 0 or more; got {codes[at]} at step {at - bounds[recording]}")
    coded = Coded(codes, bounds, highest + 1)
    return coded.compact() if highest >= SMALL and highest >= len(codes) else coded


def _plain(series: Series) -> tuple[np.ndarray, np.ndarray] | None:
    """Codes and bounds of an array of whole numbers, or of rows of it; None for anything else."""
    if type(series) is np.ndarray:
        plain = series.ndim == 1 and len(series) >= 2 and series.dtype in _PLAIN
        return (_as_codes(series), np.array([0, len(series)])) if plain else None
    if type(series) is not Stacked or type(series.array) is not np.ndarray or series.array.dtype not in _PLAIN:
        return None
    rows, steps = series.array.shape
    return (_as_codes(series.array.ravel()), np.arange(rows + 1) * steps) if rows and steps >= 2 else None


def _joined(series: Mapping[str, Series | None]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Codes and bounds, by name, of lists of arrays of whole numbers, which need no look one by one.

    Empty where any series is something else. All arrays are joined at once: memory for each series apart is given back
    to the system after every call, which then clears it again page by page.
    """
    arrays: list[Any] = []
    for given in series.values():
        if given is None:
            continue
        if not isinstance(given, (list, tuple)) or not given or type(given[0]) is not np.ndarray:
            return {}
        arrays += given
    n = len(arrays)
    if not n or list(map(type, arrays)).count(np.ndarray) < n or list(map(_DIMENSIONS, arrays)).count(1) < n:
        return {}
    lengths = np.fromiter(map(len, arrays), np.int64, n)
    codes = _one_after_the_other(arrays)
    if codes is None or lengths.min() < 2:
        return {}
    parts, first, start = {}, 0, 0
    for name, given in series.items():
        if given is not None:
            bounds = np.append(0, lengths[first : first + len(given)].cumsum())
            stop = start + int(bounds[-1])
            parts[name] = _as_codes(codes[start:stop]), bounds
            first, start = first + len(given), stop
    return parts


def _one_after_the_other(arrays: list[Any]) -> np.ndarray | None:
    """Arrays (T,) as one, or None if they are not of whole numbers."""
    kind = arrays[0].dtype
    if kind in _PLAIN and list(map(_KIND, arrays)).count(kind) == len(arrays):
        with suppress(TypeError):  # not contiguous
            return np.frombuffer(bytearray().join(arrays), kind)  # a third of the time of numpy.concatenate
    try:
        joined = np.concatenate(arrays)
    except TypeError:  # of types that have none in common
        return None
    return joined if joined.dtype in _PLAIN else None


def _looked_at(series: Series, name: str) -> tuple[np.ndarray, np.ndarray]:
    """The same of whatever can be read as codes."""
    given = _recordings(series)
    parts = [_whole(part, name if len(given) == 1 else f"recording {i} of {name}") for i, part in enumerate(given)]
    if not parts:
        raise SeriesError(f"{name} is empty; at least 2 steps are needed")
    codes = parts[0] if len(parts) == 1 else np.concatenate(parts)
    return _as_codes(codes), np.array([0, *map(len, parts)]).cumsum()


def _as_codes(array: np.ndarray) -> np.ndarray:
    """Codes as int32 where they are that or less, otherwise int64; those in uint64 are known to be small enough."""
    if array.dtype in _COUNTED and array.flags.c_contiguous:
        return array
    if array.dtype == np.uint64:
        return np.ascontiguousarray(array).view(np.int64)
    if array.dtype == np.uint32 and array.max() < 2**31:
        return np.ascontiguousarray(array).view(np.int32)
    return np.ascontiguousarray(array, np.int32 if np.can_cast(array.dtype, np.int32) else np.int64)


def _whole(given: Any, name: str) -> np.ndarray:
    """One recording as int32 (T,) where it was that or less, otherwise int64."""
    if isinstance(given, np.ma.MaskedArray) and np.ma.is_masked(given):
        raise SeriesError(f"{name} has {int(np.ma.getmaskarray(given).sum())} masked values; cut the series there")
    try:
        array = np.asarray(given)
    except (ValueError, TypeError) as error:
        raise SeriesError(f"{name} must be an array of whole numbers (T,): {error}") from error
    if array.ndim != 1:
        raise SeriesError(
            f"{name} must have one dimension; got shape {array.shape}. Give separate recordings as a list of arrays "
            "or as Stacked(array), and take several variables together with joint()"
        )
    if len(array) < 2:
        raise SeriesError(f"{name} needs at least 2 steps, so that something can follow something; got {len(array)}")
    if array.dtype.kind == "f":
        return _from_floats(array, name)
    if array.dtype.kind not in "iub":
        raise SeriesError(
            f"{name} must hold whole numbers; got {array.dtype}, such as {array[0]!r}. Number the values first, for "
            "example with numpy.unique(values, return_inverse=True)"
        )
    if array.dtype == np.uint64 and array.max() >= 2**62:
        raise SeriesError(f"codes of {name} must be below 2**62; got {array.max()}")
    return _as_codes(array)


_COUNTED = frozenset(map(np.dtype, (np.int32, np.int64)))
_PLAIN = frozenset(map(np.dtype, (np.int8, np.uint8, np.int16, np.uint16, np.int32, np.uint32, np.int64)))
"""Whole numbers that can be codes whatever their values; in uint64 some are too large."""
_DIMENSIONS, _KIND = attrgetter("ndim"), attrgetter("dtype")


def _from_floats(array: np.ndarray, name: str) -> np.ndarray:
    missing = np.isnan(array)
    if missing.any():
        raise SeriesError(f"{name} has {missing.sum()} missing values, the first at step {np.argmax(missing)}")
    fractions = ~((array == np.trunc(array)) & (np.abs(array.astype(float, copy=False)) < 2**53))
    if fractions.any():
        at = int(np.argmax(fractions))
        raise SeriesError(f"{name} must hold whole numbers; got {array[at]} at step {at}: sort values into bins first")
    return array.astype(np.int64)


def _as_long(first: Coded, other: Coded) -> bool:
    same = len(first.codes) == len(other.codes) and len(first.bounds) == len(other.bounds)
    return same and (len(first.bounds) == 2 or np.array_equal(first.bounds, other.bounds))


def _lengths(coded: Coded) -> str:
    lengths = np.diff(coded.bounds).tolist()
    return str(lengths[0]) if len(lengths) == 1 else f"{lengths[:8]}{' and so on' if len(lengths) > 8 else ''}"


@njit(cache=True)
def _count_keys(keys: np.ndarray, counts: np.ndarray, first: np.ndarray) -> None:
    for i in range(len(keys)):
        if counts[keys[i]] == 0:
            first[keys[i]] = i
        counts[keys[i]] += 1


@njit(cache=True)
def _range(codes: np.ndarray) -> tuple[int, int]:
    """The lowest and the highest code (T,) in one pass, written such that the compiler takes several at once."""
    lowest = highest = codes[0]
    for i in range(len(codes)):
        code = codes[i]
        if code > highest:
            highest = code
        if code < lowest:
            lowest = code
    return lowest, highest
