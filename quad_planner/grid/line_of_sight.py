"""
Whether one point of a map sees another: a segment against the forbidden cells.
"""

from __future__ import annotations

import math

from quad_common.compiled import compiled_loop
from quad_planner.grid.bit_grid import Bits, is_set

_EPSILON = 1e-9
"""Segments that come so near to a cell only touch it [cells]."""


@compiled_loop
def sees(forbidden: Bits, width: int, x0: float, y0: float, x1: float, y1: float) -> bool:
    """
    Return whether a segment stays within allowed cells and their edges.

    Parameters
    ----------
    forbidden : ndarray of uint64, shape (height, n)
        The words of a `BitMask`: the forbidden cells.
    width : int
        Width of the map [cells].
    x0, y0, x1, y1 : float
        Ends of the segment, on the map [cells].

    Returns
    -------
    bool
        Whether every point of it is in an allowed cell or on the edge of one.
    """
    height = len(forbidden)
    if y1 < y0:
        x0, y0, x1, y1 = x1, y1, x0, y0
    slope = (x1 - x0) / (y1 - y0) if y1 > y0 else 0.0
    first = min(math.floor(y0 + _EPSILON), height - 1)
    last = max(math.ceil(y1 - _EPSILON) - 1, first)
    for row in range(first, last + 1):
        # The part of the segment in this row of cells.
        if y1 - y0 > _EPSILON:
            begin = x0 + (max(y0, float(row)) - y0) * slope
            end = x0 + (min(y1, row + 1.0) - y0) * slope
        else:
            begin, end = x0, x1
        low, high = min(begin, end), max(begin, end)
        left = math.floor(low + _EPSILON)
        right = max(math.ceil(high - _EPSILON) - 1, left)
        for column in range(left, right + 1):
            if column < width and not is_set(forbidden, row, column):
                continue
            # Along the line between two cells either of them will do.
            beside = False
            line = math.floor(low + 0.5)
            if high - low <= _EPSILON and abs(low - line) <= _EPSILON:
                other = line - 1 if column == line else column
                beside = 0 <= other < width and not is_set(forbidden, row, other)
            line = math.floor(y0 + 0.5)
            # Not on the map's upper edge: below that is the row itself.
            if y1 - y0 <= _EPSILON and abs(y0 - line) <= _EPSILON and 0 < line <= row:
                beside = beside or (column < width and not is_set(forbidden, row - 1, column))
            if not beside:
                return False
    return True
