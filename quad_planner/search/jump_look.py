"""
Looks along the lines of a map, 64 cells at a time, for places where shortest paths may turn.
"""

from __future__ import annotations

import numpy as np

from quad_common.compiled import compiled_part
from quad_planner.grid.bit_grid import Bits, first_bit, is_set, last_bit

_ONE = np.uint64(1)


_LAST = np.uint64(63)


_ALL = ~np.uint64(0)


@compiled_part
def look_along(lines: Bits, line: int, place: int, step: int, goal: int) -> int:
    """
    Look along a line for the next place of interest.

    Returns it, or -1 if there is a wall first. ``goal`` is the goal's place if it is in this
    line, else -1.
    """
    if step > 0:
        end = _stop_ahead(lines, line, place + 1)
        if place < goal < end:
            return goal
    else:
        end = _stop_behind(lines, line, place - 1)
        if end < goal < place:
            return goal
    return end if is_set(lines, line, end) else -1


@compiled_part
def _stop_ahead(lines: Bits, line: int, place: int) -> int:
    """Return the first place from this one on where a wall is, or one beside it has ended."""
    at = place >> 6
    mask = _ALL << np.uint64(place & 63)
    while True:
        # What comes from beyond the ends of a line meets the wall.
        before = max(at - 1, 0)
        above, below = lines[line + 1, at], lines[line - 1, at]
        closed = ~((above << _ONE) | (lines[line + 1, before] >> _LAST))
        stops = ~lines[line, at] | (above & closed)
        closed = ~((below << _ONE) | (lines[line - 1, before] >> _LAST))
        stops = (stops | (below & closed)) & mask
        if stops != 0:
            return (at << 6) + first_bit(stops)
        mask = _ALL
        at += 1


@compiled_part
def _stop_behind(lines: Bits, line: int, place: int) -> int:
    """Return the last place up to this one where a wall is, or one beside it has ended."""
    last = lines.shape[1] - 1
    at = place >> 6
    mask = _ALL >> np.uint64(63 - (place & 63))
    while True:
        after = min(at + 1, last)
        above, below = lines[line + 1, at], lines[line - 1, at]
        closed = ~((above >> _ONE) | (lines[line + 1, after] << _LAST))
        stops = ~lines[line, at] | (above & closed)
        closed = ~((below >> _ONE) | (lines[line - 1, after] << _LAST))
        stops = (stops | (below & closed)) & mask
        if stops != 0:
            return (at << 6) + last_bit(stops)
        mask = _ALL
        at -= 1
