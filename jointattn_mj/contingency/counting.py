"""Counts of surrogates that move the source as a whole: how often each value of it meets each value of the rest.

A surrogate is given by pieces: transition of the rest, transition of the source, length. Two ways of counting give the
same: run by run, whose time goes with how often values change; and 64 transitions at a time, whose time goes with the
numbers of values and is a third to a sixth of the other for few of them. The quicker one is taken.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from jointattn_mj.io.compiled import njit

PER_RUN, PER_WORD, PER_LOOKUP = 5.4, 0.4, 1.6
"""Nanoseconds: of a run, of 64 transitions of one value each, and of one transition looked up alone, as measured."""
WORTH = 2**14
"""Transitions from which on counting by words is thought of."""
BLOCK = 512
"""Words that are counted at a time, so that they stay in the fastest memory."""


class Counter(Protocol):
    """Counts one surrogate."""

    def table(self, pieces: np.ndarray) -> np.ndarray:
        """Counts (values of the rest, values of the source), int64, of pieces (m, 3) that cover the rest once."""
        ...


@dataclass(frozen=True)
class Runs:
    """Counts run by run."""

    rest: tuple[np.ndarray, np.ndarray, np.ndarray]
    """Runs of equal values: values, ends, and the run of each transition."""
    source: tuple[np.ndarray, np.ndarray, np.ndarray]
    """The same of the source."""
    sizes: tuple[int, int]

    def table(self, pieces: np.ndarray) -> np.ndarray:
        """See ``Counter``."""
        table: np.ndarray = _by_runs(pieces, *self.rest, *self.source, *self.sizes)
        return table


@dataclass(frozen=True)
class Words:
    """Counts 64 transitions at a time; values of the rest that are rare are looked up one by one."""

    often: np.ndarray
    """int64 (d,): frequent values of the rest."""
    bits: np.ndarray
    """uint64 (d, words): where each is."""
    positions: np.ndarray
    """int32 (k,): transitions with other values, ascending."""
    others: np.ndarray
    """int32 (k,): these values."""
    source: np.ndarray
    """uint8 (n,): values of the source."""
    source_bits: np.ndarray
    """uint64 (values less the last one, words + 3): where each value of the source is, from bit 64 on."""
    counts: np.ndarray
    """int64: how often each value of the rest comes. What the last value of the source meets follows from it."""

    def table(self, pieces: np.ndarray) -> np.ndarray:
        """See ``Counter``."""
        table = np.zeros((len(self.counts), len(self.source_bits) + 1), np.int64)
        _by_words(pieces, self.often, self.bits, self.source_bits, table)
        _by_position(pieces, self.positions, self.others, self.source, table)
        table[self.often, -1] = self.counts[self.often] - table[self.often, :-1].sum(1)
        return table


def counter(rest: np.ndarray, source: np.ndarray, rests: int, sources: int) -> Counter:
    """Choose the quicker way.

    Args:
        rest: int32 (n,), values of all that stays, 0 to below ``rests``.
        source: int32 (n,), values of the source, 0 to below ``sources``.
        rests: Number of values.
        sources: Number of values of the source.
    """
    counts = np.bincount(rest, minlength=rests)
    words = len(rest) / 64 * (sources - 1)
    often = np.flatnonzero(counts * PER_LOOKUP > words * PER_WORD)
    rare = len(rest) - int(counts[often].sum())
    changes = sum(1 + np.count_nonzero(codes[1:] != codes[:-1]) for codes in (rest, source))
    if len(rest) < WORTH or sources > 256 or len(rest) >= 2**31:
        return Runs(_runs(rest), _runs(source), (rests, sources))
    if len(often) * words * PER_WORD + rare * PER_LOOKUP > changes * PER_RUN:
        return Runs(_runs(rest), _runs(source), (rests, sources))
    small = source.astype(np.uint8)
    is_rare = np.ones(rests, bool)
    is_rare[often] = False
    positions = np.flatnonzero(is_rare[rest]).astype(np.int32)
    bits = np.stack([_packed(rest == value, 0, 0) for value in often]) if len(often) else np.zeros((0, 0), np.uint64)
    of_source = [_packed(small == value, 64, 128) for value in range(sources - 1)]
    return Words(
        often, bits, positions, rest[positions], small,
        np.stack(of_source) if of_source else np.zeros((0, 0), np.uint64), counts,
    )  # fmt: skip


def _packed(which: np.ndarray, before: int, after: int) -> np.ndarray:
    """A mask (n,) as words, its first transition in the lowest bit, with so many bits of nothing around it."""
    padded = np.concatenate([np.zeros(before, bool), which, np.zeros(after + -len(which) % 64, bool)])
    words: np.ndarray = np.packbits(padded, bitorder="little").view("<u8").astype(np.uint64)
    return words


def _runs(codes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    change = np.flatnonzero(codes[1:] != codes[:-1]) + 1
    starts, ends = np.append(0, change), np.append(change, len(codes))
    return codes[starts], ends.astype(np.int64), np.repeat(np.arange(len(starts), dtype=np.int32), ends - starts)


@njit(cache=True, nogil=True)
def _by_runs(
    pieces: np.ndarray,
    rest_codes: np.ndarray, rest_ends: np.ndarray, rest_at: np.ndarray,
    source_codes: np.ndarray, source_ends: np.ndarray, source_at: np.ndarray,
    rests: int, sources: int,
) -> np.ndarray:  # fmt: skip
    """How often each value of the rest comes with each of the source."""
    table = np.zeros((rests, sources), np.int64)
    for piece in range(len(pieces)):
        t, u, stop = pieces[piece, 0], pieces[piece, 1], pieces[piece, 0] + pieces[piece, 2]
        i, j = rest_at[t], source_at[u]
        while t < stop:
            step = min(rest_ends[i] - t, source_ends[j] - u, stop - t)
            table[rest_codes[i], source_codes[j]] += step
            t += step
            u += step
            if rest_ends[i] == t:
                i += 1
            if source_ends[j] == u:
                j += 1
    return table


@njit(cache=True)
def _ones(word: np.uint64) -> np.uint64:
    """Number of bits that are set. The compiler knows this form and counts several words at once."""
    word = word - ((word >> np.uint64(1)) & np.uint64(0x5555555555555555))
    word = (word & np.uint64(0x3333333333333333)) + ((word >> np.uint64(2)) & np.uint64(0x3333333333333333))
    word = (word + (word >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    ones: np.uint64 = (word * np.uint64(0x0101010101010101)) >> np.uint64(56)
    return ones


@njit(cache=True, nogil=True)
def _by_words(
    pieces: np.ndarray, often: np.ndarray, bits: np.ndarray, source_bits: np.ndarray, table: np.ndarray
) -> None:
    """Add what the frequent values of the rest meet, for all values of the source but the last."""
    full, moved = np.uint64(0xFFFFFFFFFFFFFFFF), np.empty(BLOCK, np.uint64)
    for piece in range(len(pieces)):
        t, u, length = pieces[piece, 0], pieces[piece, 1], pieces[piece, 2]
        first, last = t // 64, (t + length - 1) // 64
        begin = 64 + u - t  # the source's bit for the rest's bit 0
        low = np.uint64(begin % 64)
        high = np.uint64(64) - low
        head, tail = full << np.uint64(t % 64), full >> np.uint64(63 - (t + length - 1) % 64)
        for start in range(first, last + 1, BLOCK):
            count = min(last + 1 - start, BLOCK)
            at = start + begin // 64
            for s in range(len(source_bits)):
                if low == 0:
                    for i in range(count):
                        moved[i] = source_bits[s, at + i]
                else:
                    for i in range(count):
                        moved[i] = (source_bits[s, at + i] >> low) | (source_bits[s, at + i + 1] << high)
                if start == first:
                    moved[0] &= head
                if start + count > last:
                    moved[count - 1] &= tail
                for d in range(len(often)):
                    together = np.uint64(0)
                    row = bits[d, start : start + count]
                    for i in range(count):
                        together += _ones(moved[i] & row[i])
                    table[often[d], s] += np.int64(together)


@njit(cache=True, nogil=True)
def _by_position(
    pieces: np.ndarray, positions: np.ndarray, others: np.ndarray, source: np.ndarray, table: np.ndarray
) -> None:
    """Add what the other values of the rest meet."""
    for piece in range(len(pieces)):
        t, length = pieces[piece, 0], pieces[piece, 2]
        ahead = pieces[piece, 1] - t
        for i in range(np.searchsorted(positions, t), np.searchsorted(positions, t + length)):
            table[others[i], source[positions[i] + ahead]] += 1
