"""
Where the outline does not fit, for all cells and classes of headings at once, as bits.

A row of obstacles is spread to the widths of the kernels' rows once, 64 cells at a time; each class
then adds up the rows that its kernel has.
"""

from __future__ import annotations

import numpy as np

from quad_common.compiled import compiled_loop
from quad_planner.grid.bit_grid import BitMask, Bits
from quad_planner.outline.heading_kernels import CLASSES, Integers, Kernels

_LARGEST = 2**22
"""Cells of the largest map of which all classes are known in advance, by 9 bytes a cell."""

_MOST_ROWS = 63
"""Rows of a kernel to either side, at most: bits are moved by less than a word."""


def class_layers(blocked: Bits, width: int, kernels: Kernels) -> Bits | None:
    """
    Find the cells in which each class does not fit.

    Parameters
    ----------
    blocked : ndarray of uint64, shape (height, n)
        Bits of the cells with obstacles; what is beyond the width does not count.
    width : int
        Width of the map [cells].
    kernels : Kernels
        Cells that the outline reaches.

    Returns
    -------
    ndarray of uint64, shape (72, height, n), or None
        A bit is set where the kernel of the class holds an obstacle; bits beyond the width mean
        nothing. None for maps, or kernels, that are too large.
    """
    height, words = blocked.shape
    if width * height > _LARGEST or kernels.rows > _MOST_ROWS:
        return None
    inside = BitMask.of(np.ones((1, width), dtype=np.bool_)).words
    blocked = blocked & inside
    widest = int((kernels.high - kernels.low).max()) + 1
    spread = np.zeros((height, max(widest, 1), words + 2), dtype=np.uint64)
    _spread(blocked, spread)
    layers = np.zeros((CLASSES, height, words), dtype=np.uint64)
    _lay(spread, kernels.low, kernels.high, layers)
    return layers


@compiled_loop
def _spread(blocked: Bits, spread: Bits) -> None:
    """
    Mark from where an obstacle is at most so many cells ahead along the row, for each number.

    There is a word before and one after each row.
    """
    height, words = blocked.shape
    for y in range(height):
        for at in range(words):
            spread[y, 0, at + 1] = blocked[y, at]
        for far in range(1, spread.shape[1]):
            for at in range(words + 1):
                # One cell nearer, or here.
                before, after = spread[y, far - 1, at], spread[y, far - 1, at + 1]
                moved = before >> np.uint64(1) | after << np.uint64(63)
                spread[y, far, at] = spread[y, 0, at] | moved


@compiled_loop
def _lay(spread: Bits, low: Integers, high: Integers, layers: Bits) -> None:
    """Add up what the rows of each class's kernel hold."""
    height, words = layers.shape[1], layers.shape[2]
    rows = low.shape[1] // 2
    for k in range(layers.shape[0]):
        for y in range(height):
            for row in range(max(0, y - rows), min(height, y + rows + 1)):
                first, last = low[k, row - y + rows], high[k, row - y + rows]
                if first > last:
                    continue
                if first >= 0:
                    # Shifts by a whole word are not defined.
                    down, up = np.uint64(first), np.uint64(63 - first)
                    for at in range(words):
                        word = spread[row, last - first, at + 1]
                        after = spread[row, last - first, at + 2]
                        layers[k, y, at] |= word >> down | (after << np.uint64(1)) << up
                else:
                    up, down = np.uint64(-first), np.uint64(63 + first)
                    for at in range(words):
                        before = spread[row, last - first, at]
                        word = spread[row, last - first, at + 1]
                        layers[k, y, at] |= word << up | (before >> np.uint64(1)) >> down
