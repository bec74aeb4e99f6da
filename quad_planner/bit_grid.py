"""
Free cells as bits: 64 cells in one word, by rows and by columns.

A wall one cell wide surrounds the map, so that a scan along a row or a column always
meets its end. Cell (x, y) of the map is bit x + 1 of row y + 1, and bit y + 1 of column
x + 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_planner.compiled import compiled

Bits = NDArray[np.uint64]
Mask = NDArray[np.bool_]

_ONE = np.uint64(1)
_LAST = np.uint64(63)
_ALL = ~np.uint64(0)

# A word with a single bit, times this, has the bit's place in its upper six bits.
_DE_BRUIJN = np.uint64(0x03F79D71B4CB0A89)
_PLACES = np.zeros(64, dtype=np.int64)
for _place in range(64):
    _PLACES[((0x03F79D71B4CB0A89 << _place) & (2**64 - 1)) >> 58] = _place


@dataclass(frozen=True, eq=False)
class BitGrid:
    """The free cells of a map, n words of 64 cells to a line."""

    width: int
    """Of the map [cells]."""
    height: int
    """Of the map [cells]."""
    rows: Bits
    """Shape (height + 2, n)."""
    columns: Bits
    """Shape (width + 2, n)."""

    @classmethod
    def of(cls, free: Mask) -> BitGrid:
        """
        Pack a mask.

        Parameters
        ----------
        free : ndarray of bool, shape (height, width)
            Where one may be.

        Returns
        -------
        BitGrid
            The same as bits.
        """
        height, width = free.shape
        rows = _walled(packed(free), width)
        return cls(width, height, rows, _transposed(rows, width + 2))


def packed(mask: Mask) -> Bits:
    """
    Pack a mask.

    Parameters
    ----------
    mask : ndarray of bool, shape (m, n)
        What is set.

    Returns
    -------
    ndarray of uint64, shape (m, ceil(n / 64))
        Bit x of row y is cell (x, y).
    """
    height, width = mask.shape
    words = np.zeros((height, (width + 63) // 64), dtype=np.uint64)
    words.view(np.uint8)[:, : (width + 7) // 8] = np.packbits(mask, axis=1, bitorder='little')
    return words


def unpacked(rows: Bits, width: int) -> Mask:
    """Unpack rows, shape (m, n), into a mask of shape (m, width)."""
    bytes_ = np.ascontiguousarray(rows).view(np.uint8)
    return np.unpackbits(bytes_, axis=1, count=width, bitorder='little').view(np.bool_)


@compiled
def _walled(rows: Bits, width: int) -> Bits:
    """Move rows of a width one cell up and right, into a wall."""
    walled = np.zeros((rows.shape[0] + 2, (width + 2 + 63) // 64), dtype=np.uint64)
    for y in range(rows.shape[0]):
        before = np.uint64(0)
        for at in range(walled.shape[1]):
            word = rows[y, at] if at < rows.shape[1] else np.uint64(0)
            walled[y + 1, at] = (word << _ONE) | (before >> _LAST)
            before = word
    return walled


@compiled
def _transposed(rows: Bits, width: int) -> Bits:
    """Return the columns as lines, in blocks of 64 by 64 (Hacker's Delight, sec. 7-3)."""
    columns = np.zeros((width, (rows.shape[0] + 63) // 64), dtype=np.uint64)
    block = np.empty(64, dtype=np.uint64)
    for down in range(columns.shape[1]):
        for across in range(rows.shape[1]):
            seen = np.uint64(0)
            for k in range(64):
                y = 64 * down + k
                block[k] = rows[y, across] if y < rows.shape[0] else np.uint64(0)
                seen |= block[k]
            if seen == 0:
                continue
            step = 32
            mask = np.uint64(0x00000000FFFFFFFF)
            while step > 0:
                k = 0
                while k < 64:
                    swap = ((block[k] >> np.uint64(step)) ^ block[k + step]) & mask
                    block[k] ^= swap << np.uint64(step)
                    block[k + step] ^= swap
                    k = (k + step + 1) & ~step
                step >>= 1
                mask ^= mask << np.uint64(step)
            for k in range(min(64, width - 64 * across)):
                columns[64 * across + k, down] = block[k]
    return columns


@compiled
def dilated(rows: Bits, reaches: NDArray[np.int64]) -> Bits:
    """
    Set every cell that is near one that is set.

    Parameters
    ----------
    rows : ndarray of uint64, shape (m, n)
        What is set.
    reaches : ndarray of int, shape (k,)
        How far to either side, in a row that is 0, 1, ... k - 1 rows off, falling [cells].

    Returns
    -------
    ndarray of uint64, shape (m, n)
        The same and what is near. Bits beyond the width may be set.
    """
    height, words = rows.shape
    result = np.zeros_like(rows)
    wide = np.empty(words, dtype=np.uint64)
    for y in range(height):
        is_empty = True
        for at in range(words):
            is_empty = is_empty and rows[y, at] == 0
        if is_empty:
            continue
        # From the narrowest to the widest: each goes on from the one before.
        wide[:] = rows[y]
        reached = 0
        for off in range(len(reaches) - 1, -1, -1):
            while reached < reaches[off]:
                step = min(reached + 1, reaches[off] - reached, 63)
                _spread(wide, step)
                reached += step
            for row in (y - off, y + off):
                if 0 <= row < height:
                    for at in range(words):
                        result[row, at] |= wide[at]
    return result


@compiled
def _spread(line: Bits, step: int) -> None:
    """Set each bit that is a step to either side of one that is set, step < 64."""
    up, down = np.uint64(step), np.uint64(64 - step)
    before = np.uint64(0)
    for at in range(len(line)):
        word = line[at]
        after = line[at + 1] if at + 1 < len(line) else np.uint64(0)
        line[at] = word | (word << up) | (before >> down) | (word >> up) | (after << down)
        before = word


@compiled
def first_bit(word: np.uint64) -> int:
    """Return the place of the lowest bit that is set, of a word that is not 0."""
    return int(_PLACES[((word & (~word + _ONE)) * _DE_BRUIJN) >> np.uint64(58)])


@compiled
def last_bit(word: np.uint64) -> int:
    """Return the place of the highest bit that is set, of a word that is not 0."""
    for shift in (1, 2, 4, 8, 16, 32):
        word |= word >> np.uint64(shift)
    return int(_PLACES[((word - (word >> _ONE)) * _DE_BRUIJN) >> np.uint64(58)])


@compiled
def is_set(lines: Bits, line: int, place: int) -> bool:
    """Return whether a bit is set."""
    return bool((lines[line, place >> 6] >> np.uint64(place & 63)) & _ONE)


@compiled
def next_set(lines: Bits, line: int, place: int) -> int:
    """Return the first place after this one that is set; there must be one."""
    place += 1
    at = place >> 6
    word = lines[line, at] & (_ALL << np.uint64(place & 63))
    while word == 0:
        at += 1
        word = lines[line, at]
    return (at << 6) + first_bit(word)


@compiled
def previous_set(lines: Bits, line: int, place: int) -> int:
    """Return the last place before this one that is set; there must be one."""
    place -= 1
    at = place >> 6
    word = lines[line, at] & (_ALL >> np.uint64(63 - (place & 63)))
    while word == 0:
        at -= 1
        word = lines[line, at]
    return (at << 6) + last_bit(word)
