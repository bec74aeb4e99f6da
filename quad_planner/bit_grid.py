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
        return cls(width, height, _packed(free), _packed(free.T))


def _packed(free: Mask) -> Bits:
    height, width = free.shape
    padded = np.zeros((height + 2, (width + 2 + 63) // 64 * 64), dtype=np.uint8)
    padded[1:-1, 1 : width + 1] = free
    return np.packbits(padded, axis=1, bitorder='little').view(np.uint64)


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
