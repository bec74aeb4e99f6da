"""
Cells as bits: 64 of them in one word.

A `BitMask` is any mask. A `BitGrid` holds where one may be, by rows and by columns: a wall
one cell wide surrounds the map, so that whoever looks along a row or a column always meets
its end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, compiled_part
from quad_planner.grid.array_types import Mask

Bits = NDArray[np.uint64]

_ONE = np.uint64(1)
_LAST = np.uint64(63)
_ALL = ~np.uint64(0)
_GATHER = np.uint64(0x0102040810204080)
_LOW_HALF = np.uint64(0x00000000FFFFFFFF)

# A word with a single bit, times this, has the bit's place in its upper six bits.
_DE_BRUIJN = np.uint64(0x03F79D71B4CB0A89)
_PLACES = np.zeros(64, dtype=np.int64)
for _place in range(64):
    _PLACES[((0x03F79D71B4CB0A89 << _place) & (2**64 - 1)) >> 58] = _place


@dataclass(frozen=True, eq=False)
class BitMask:
    """A mask, n words of 64 cells to a row."""

    words: Bits
    """
    Words of 64 cells, shape (height, n): bit x of row y is cell (x, y); beyond the width anything
    may be.
    """
    width: int
    """Width of the mask [cells]."""

    @classmethod
    def of(cls, mask: Mask) -> BitMask:
        """Pack a mask of shape (height, width)."""
        height, width = mask.shape
        words = np.zeros((height, (width + 63) // 64), dtype=np.uint64)
        words.view(np.uint8)[:, : (width + 7) // 8] = np.packbits(mask, axis=1, bitorder='little')
        return cls(words, width)

    @property
    def height(self) -> int:
        """Number of rows."""
        return len(self.words)

    def unpacked(self) -> Mask:
        """Return the mask, shape (height, width)."""
        return self.window(0, 0, self.width, self.height)

    def window(self, left: int, bottom: int, right: int, top: int) -> Mask:
        """
        Return a part of the mask.

        Parameters
        ----------
        left, bottom, right, top : int
            From column `left` up to, but without, column `right`; rows in the same manner. Within
            the mask.

        Returns
        -------
        ndarray of bool, shape (top - bottom, right - left)
            The part.
        """
        first = left // 64
        words = np.ascontiguousarray(self.words[bottom:top, first : (right + 63) // 64])
        bits = np.unpackbits(words.view(np.uint8), axis=1, bitorder='little')
        return bits[:, left - 64 * first : right - 64 * first].view(np.bool_)

    def places(self) -> NDArray[np.int64]:
        """Return the row and the column of each cell that is set, shape (k, 2)."""
        # Of few words that are not 0 the bits are looked at.
        rows, at = np.nonzero(self.words)
        bits = np.unpackbits(self.words[rows, at].view(np.uint8), bitorder='little')
        which, place = np.nonzero(bits.reshape(-1, 64))
        columns = 64 * at[which] + place
        inside = columns < self.width
        return np.column_stack((rows[which], columns))[inside]

    def __getitem__(self, cell: tuple[int, int]) -> bool:
        """Return whether the cell of a row and a column is set."""
        row, column = cell
        return bool(int(self.words[row, column >> 6]) >> (column & 63) & 1)


@dataclass(frozen=True, eq=False)
class BitGrid:
    """
    The free cells of a map, n words of 64 cells to a line.

    Cell (x, y) is bit x + 1 of row y + 1, and bit y + 1 of column x + 1.
    """

    width: int
    """Width of the map [cells]."""
    height: int
    """Height of the map [cells]."""
    rows: Bits
    """Free cells by rows, shape (height + 2, n)."""
    columns: Bits
    """Free cells by columns, shape (width + 2, n)."""

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
        return cls.outside(BitMask.of(~free))

    @classmethod
    def outside(cls, forbidden: BitMask) -> BitGrid:
        """
        Take what is not forbidden.

        Parameters
        ----------
        forbidden : BitMask
            Where one may not be.

        Returns
        -------
        BitGrid
            The other cells.
        """
        rows = _free_rows(forbidden.words, forbidden.width)
        columns = _transposed(rows, forbidden.width + 2)
        return cls(forbidden.width, forbidden.height, rows, columns)

    def is_free(self, x: int, y: int) -> bool:
        """Return whether a cell is on the map and free."""
        if not (0 <= x < self.width and 0 <= y < self.height):
            return False
        return is_set(self.rows, y + 1, x + 1)

    def changed_to(self, forbidden: BitMask, changed: tuple[int, int]) -> BitGrid:
        """
        Take what is not forbidden, where some rows have changed.

        Parameters
        ----------
        forbidden : BitMask
            Where one may not be now.
        changed : tuple of int
            Rows of the map, from the first up to, but without, the second.

        Returns
        -------
        BitGrid
            What :meth:`outside` makes of it.
        """
        first, last = changed
        rows, columns = self.rows.copy(), self.columns.copy()
        rows[first + 1 : last + 1] = _free_rows(forbidden.words[first:last], self.width)[1:-1]
        # Columns change by whole words: 64 rows at a time.
        low, high = (first + 1) // 64, last // 64 + 1
        columns[:, low:high] = _transposed(rows[64 * low : 64 * high], self.width + 2)
        return BitGrid(self.width, self.height, rows, columns)


def changed_rows(before: NDArray[np.int8], after: NDArray[np.int8]) -> tuple[int, int] | None:
    """
    Find the rows in which two maps differ.

    Parameters
    ----------
    before, after : ndarray of int8, shape (height, width)
        Any values.

    Returns
    -------
    tuple of int or None
        Rows from the first up to, but without, the second; None if the maps are equal.
    """
    rows = np.flatnonzero((before != after).any(axis=1))
    return (int(rows[0]), int(rows[-1]) + 1) if rows.size else None


def packed_cells(cells: NDArray[np.int8], least: int, most: int) -> Bits:
    """
    Set the bits of the cells whose value is outside of a range.

    Parameters
    ----------
    cells : ndarray of int8, shape (m, n)
        Any values.
    least, most : int
        The range, both ends included.

    Returns
    -------
    ndarray of uint64, shape (m, ceil(n / 64))
        Bit x of row y is cell (x, y).
    """
    height, width = cells.shape
    words = np.empty((height, (width + 63) // 64), dtype=np.uint64)
    row = np.zeros(64 * words.shape[1], dtype=np.uint8)
    _pack(cells, np.int8(least), np.int8(most), row, row.view(np.uint64), words.view(np.uint8))
    return words


@compiled_loop
def _pack(
    cells: NDArray[np.int8],
    least: np.int8,
    most: np.int8,
    row: NDArray[np.uint8],
    eights: Bits,
    packed: NDArray[np.uint8],
) -> None:
    """Pack cells into bytes, through a row that is seen as bytes and as words."""
    height, width = cells.shape
    for y in range(height):
        # Bytes 0 and 1, which the compiler makes and takes many at a time.
        for x in range(width):
            row[x] = (cells[y, x] < least) | (cells[y, x] > most)
        for at in range(len(eights)):
            # The product has the lowest bits of eight bytes side by side at its top.
            packed[y, at] = np.uint8((eights[at] * _GATHER) >> np.uint64(56))


def _free_rows(forbidden: Bits, width: int) -> Bits:
    """Return the cells of a width that are not set, one cell up and right, in a wall."""
    rows = np.zeros((len(forbidden) + 2, (width + 2 + 63) // 64), dtype=np.uint64)
    _invert(forbidden, width, rows)
    return rows


@compiled_loop
def _invert(forbidden: Bits, width: int, rows: Bits) -> None:
    """Fill the rows of a grid."""
    height, words = forbidden.shape
    in_last = _ALL >> np.uint64(64 * words - width)
    for y in range(height):
        before = np.uint64(0)
        for at in range(words):
            free = ~forbidden[y, at]
            if at == words - 1:
                free &= in_last
            rows[y + 1, at] = (free << _ONE) | (before >> _LAST)
            before = free
        if words < rows.shape[1]:
            rows[y + 1, words] = before >> _LAST


def _transposed(rows: Bits, width: int) -> Bits:
    """Return the columns as lines."""
    columns = np.zeros((width, (len(rows) + 63) // 64), dtype=np.uint64)
    _transpose(rows, columns, np.empty(64, dtype=np.uint64), np.empty(64, dtype=np.uint64))
    return columns


@compiled_loop
def _transpose(rows: Bits, columns: Bits, block: Bits, other: Bits) -> None:
    """Fill columns, in blocks of 64 by 64; `block` and `other` are 64 words for notes."""
    height, width = len(rows), len(columns)
    for across in range(rows.shape[1]):
        for down in range(columns.shape[1]):
            some, every = np.uint64(0), _ALL
            for k in range(64):
                y = 64 * down + k
                block[k] = rows[y, across] if y < height else np.uint64(0)
                some |= block[k]
                every &= block[k]
            if some == 0:
                continue
            if every != _ALL:
                _transpose_block(block, other)
            for k in range(min(64, width - 64 * across)):
                columns[64 * across + k, down] = block[k]


@compiled_part
def _transpose_block(block: Bits, other: Bits) -> None:
    """
    Swap the rows and columns of 64 words; the other 64 are for notes.

    Six times the first and the last 32 are interleaved, and bits of each two swapped: the first
    bit of a word's number, counted from above, becomes its last one, and changes places with a bit
    of the column's number.
    """
    step, low = 32, _LOW_HALF
    while step > 0:
        shift = np.uint64(step)
        for k in range(32):
            first, second = block[k], block[k + 32]
            other[2 * k] = (first & low) | ((second & low) << shift)
            other[2 * k + 1] = ((first >> shift) & low) | (second & ~low)
        block, other = other, block
        step >>= 1
        # Half as wide, twice as many.
        low ^= low << np.uint64(step)


@compiled_loop
def first_bit(word: np.uint64) -> int:
    """Return the place of the lowest bit that is set, of a word that is not 0."""
    return int(_PLACES[((word & (~word + _ONE)) * _DE_BRUIJN) >> np.uint64(58)])


@compiled_loop
def last_bit(word: np.uint64) -> int:
    """Return the place of the highest bit that is set, of a word that is not 0."""
    for shift in (1, 2, 4, 8, 16, 32):
        word |= word >> np.uint64(shift)
    return int(_PLACES[((word - (word >> _ONE)) * _DE_BRUIJN) >> np.uint64(58)])


@compiled_part
def is_set(lines: Bits, line: int, place: int) -> bool:
    """Return whether a bit is set."""
    return bool((lines[line, place >> 6] >> np.uint64(place & 63)) & _ONE)
