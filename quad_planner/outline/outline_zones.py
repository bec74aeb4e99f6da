"""
Whether the robot fits in a cell at a class of headings.

It does wherever its circle fits, at any heading, as for every planning method; and where the
outline keeps its distance. That is looked at when a search asks, and remembered.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from quad_planner.grid.bit_grid import Bits, is_set
from quad_planner.grid.compiled import compiled, compiled_part
from quad_planner.outline.heading_kernels import CLASSES, Integers, Kernels

_ONE = np.uint64(1)
_ALL = ~np.uint64(0)
_LARGEST = 2**24
"""Cells of the largest map of which is remembered what fits."""


class Zones(NamedTuple):
    """A map as compiled code is given it."""

    width: int
    """Width of the map [cells]."""
    height: int
    """Height of the map [cells]."""
    blocked: Bits
    """Cells of obstacles, shape (height, n)."""
    circle: Bits
    """Cells in which the circle does not fit, shape (height, n)."""
    inner: Bits
    """Cells in which no heading fits, shape (height, n)."""
    narrow: Bits
    """Cells that a move leads to from where the circle does not fit, shape (height, n)."""
    low: Integers
    """As of :class:`~quad_planner.outline.heading_kernels.Kernels`."""
    high: Integers
    """As of :class:`~quad_planner.outline.heading_kernels.Kernels`."""
    low_at_start: Integers
    """The same with what a start may be nearer."""
    high_at_start: Integers
    """The same with what a start may be nearer."""
    around_start: Integers
    """Cells where those count: least and largest x, least and largest y; often none."""
    known: Bits
    """Bits of what fits, 2 words a cell, and of what is known, 2 words; or empty."""


def new_memory(cells: int) -> Bits:
    """Return the memory of what fits, for a map of so many cells."""
    # Zeros cost nothing until they are touched.
    return np.zeros(4 * cells if cells <= _LARGEST else 0, dtype=np.uint64)


def at_start(zones: Zones, kernels: Kernels, x: int, y: int) -> Zones:
    """Return zones with other kernels around a start's cell."""
    reach = 2 * kernels.rows
    around = np.array([x - reach, x + reach, y - reach, y + reach])
    return zones._replace(
        low_at_start=kernels.low, high_at_start=kernels.high, around_start=around
    )


@compiled_part
def is_room(zones: Zones, x: int, y: int) -> bool:
    """Return whether the circle fits in a cell."""
    if x < 0 or y < 0 or x >= zones.width or y >= zones.height:
        return False
    return not is_set(zones.circle, y, x)


@compiled_part
def _is_clear(
    zones: Zones, low: Integers, high: Integers, x: int, y: int
) -> bool:
    """Return whether no obstacle is in the rows of a kernel."""
    rows = len(low) // 2
    for row in range(max(0, y - rows), min(zones.height, y + rows + 1)):
        first = max(0, x + low[row - y + rows])
        last = min(zones.width - 1, x + high[row - y + rows])
        if first > last or high[row - y + rows] < low[row - y + rows]:
            continue
        for at in range(first >> 6, (last >> 6) + 1):
            word = zones.blocked[row, at]
            if at == first >> 6:
                word &= _ALL << np.uint64(first & 63)
            if at == last >> 6:
                word &= _ALL >> np.uint64(63 - (last & 63))
            if word:
                return False
    return True


@compiled_part
def fits(zones: Zones, x: int, y: int, heading_class: int) -> bool:
    """Return whether the robot fits in a cell at a class of headings."""
    if x < 0 or y < 0 or x >= zones.width or y >= zones.height:
        return False
    if not is_set(zones.circle, y, x):
        return True
    around = zones.around_start
    if around[0] <= x <= around[1] and around[2] <= y <= around[3]:
        return _is_clear(
            zones, zones.low_at_start[heading_class], zones.high_at_start[heading_class], x, y
        )
    if is_set(zones.inner, y, x):
        return False
    if len(zones.known) == 0:
        return _is_clear(zones, zones.low[heading_class], zones.high[heading_class], x, y)
    at = 4 * (y * zones.width + x) + (heading_class >> 6)
    bit = _ONE << np.uint64(heading_class & 63)
    if zones.known[at + 2] & bit:
        return bool(zones.known[at] & bit)
    clear = _is_clear(zones, zones.low[heading_class], zones.high[heading_class], x, y)
    if clear:
        zones.known[at] |= bit
    zones.known[at + 2] |= bit
    return clear


@compiled
def fits_in(zones: Zones, x: int, y: int, heading_class: int) -> bool:
    """Return whether the robot fits in a cell at a class of headings."""
    return fits(zones, x, y, heading_class)


@compiled_part
def leg_fits(
    zones: Zones, x0: float, y0: float, x1: float, y1: float, heading_class: int
) -> bool:
    """Return whether the robot fits in all cells that a segment touches, at a class [cells]."""
    if y1 < y0:
        x0, y0, x1, y1 = x1, y1, x0, y0
    slope = (x1 - x0) / (y1 - y0) if y1 - y0 > 1e-9 else 0.0
    for row in range(math.floor(y0 - 1e-9), math.floor(y1 + 1e-9) + 1):
        if y1 - y0 > 1e-9:
            begin = x0 + (min(max(y0, row - 1e-9), y1) - y0) * slope
            end = x0 + (max(min(y1, row + 1.0 + 1e-9), y0) - y0) * slope
        else:
            begin, end = x0, x1
        first = math.floor(min(begin, end) - 1e-9)
        for column in range(first, math.floor(max(begin, end) + 1e-9) + 1):
            if not fits(zones, column, row, heading_class):
                return False
    return True


@compiled
def fitting_classes(zones: Zones, x: int, y: int, result: Integers) -> int:
    """Fill an array of 72 with 1 where a class fits in a cell; return how many do."""
    count = 0
    for k in range(CLASSES):
        result[k] = fits(zones, x, y, k)
        count += result[k]
    return count
