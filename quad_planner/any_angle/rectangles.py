"""
The free cells of a map as rectangles, each as high as a run of cells stays the same.

A run is a row's free cells from one wall to the next. Rows whose run is the same make one
rectangle, so a room is a few of them, whatever its size. A rectangle is left through openings
in its upper and lower side only; the ends of an opening are the convex corners of the forbidden
zone. Rectangles that touch in a point have an opening of no width there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, compiled_part, inlined_part
from quad_planner.grid.array_types import Points
from quad_planner.grid.bit_grid import BitMask, Bits, first_bit

Integers = NDArray[np.int64]

LEFT, BOTTOM, RIGHT, TOP = range(4)
"""Columns of `Rectangles.bounds`."""

_ONE = np.uint64(1)
_ALL = ~np.uint64(0)


class Rectangles(NamedTuple):
    """
    Rectangles of free cells, numbered by their lower sides: from row to row, from left to right.

    Corner 4 n + k is that of rectangle n: k = 0 at the lower left, 1 at the lower right, 2 and 3
    above them.
    """

    bounds: Integers
    """Left, bottom, right and top, shape (n, 4) [cells]."""
    above: Integers
    """Rectangles beyond the upper side: from the first up to, but without, the second, (n, 2)."""
    below: Integers
    """The same beyond the lower side, as places in `by_top`, shape (n, 2)."""
    by_top: Integers
    """Rectangles in the order of their upper sides, shape (n,)."""


def rectangles_of(forbidden: BitMask) -> Rectangles:
    """
    Cut what is not forbidden into rectangles.

    Parameters
    ----------
    forbidden : BitMask
        The forbidden cells.

    Returns
    -------
    Rectangles
        They cover the other cells; none overlap.
    """
    words, width = forbidden.words, forbidden.width
    runs = np.zeros((2, width // 2 + 2, 3), dtype=np.int64)
    most = _most_rectangles(forbidden)
    bounds = np.empty((most, 4), dtype=np.int64)
    above, below = (np.zeros((most, 2), dtype=np.int64) for _ in range(2))
    by_top = np.empty(most, dtype=np.int64)
    count = _cut(words, width, runs, bounds, above, below, by_top)
    return Rectangles(bounds[:count], above[:count], below[:count], by_top[:count])


def _most_rectangles(forbidden: BitMask) -> int:
    """Return how many rectangles there are at most: runs of rows that are not as those before."""
    words = forbidden.words
    is_new = np.ones(len(words), dtype=np.bool_)
    np.any(words[1:] != words[:-1], axis=1, out=is_new[1:])
    rows = words[is_new]
    before = rows << _ONE
    before[:, 0] |= _ONE
    before[:, 1:] |= rows[:, :-1] >> np.uint64(63)
    begins = BitMask(before & ~rows, forbidden.width)
    return int(np.count_nonzero(begins.unpacked()))


def corners_of(rectangles: Rectangles) -> Points:
    """
    List the convex corners of the forbidden zone, within the map.

    Parameters
    ----------
    rectangles : Rectangles
        The free cells.

    Returns
    -------
    ndarray, shape (n, 2)
        x and y; two of them in one place where forbidden cells touch in this corner only [cells].
    """
    is_convex = np.zeros(4 * len(rectangles.bounds), dtype=np.bool_)
    _mark_convex(rectangles, is_convex)
    return corner_places(rectangles, np.flatnonzero(is_convex))


def corner_places(rectangles: Rectangles, corners: Integers) -> Points:
    """Return where corners of rectangles are, shape (n, 2) [cells]."""
    bounds = rectangles.bounds[corners >> 2]
    x = np.where(corners & 1, bounds[:, RIGHT], bounds[:, LEFT])
    y = np.where(corners & 2, bounds[:, TOP], bounds[:, BOTTOM])
    return np.column_stack((x, y)).astype(np.float64)


@compiled_loop
def _mark_convex(rectangles: Rectangles, is_convex: NDArray[np.bool_]) -> None:
    """Mark the corners of rectangles at which an opening ends."""
    for here in range(len(rectangles.bounds)):
        for there in range(rectangles.above[here, 0], rectangles.above[here, 1]):
            left, right = ends_of_opening(rectangles.bounds, here, there, True)
            if left >= 0:
                is_convex[left] = True
            if right >= 0:
                is_convex[right] = True


@inlined_part
def ends_of_opening(bounds: Integers, here: int, there: int, is_up: bool) -> tuple[int, int]:
    """
    Return the corners at the left and right end of the opening from one rectangle to another.

    Each is -1 where the wall goes straight on.
    """
    upper = 2 if is_up else 0
    left = right = -1
    if bounds[there, LEFT] > bounds[here, LEFT]:
        left = 4 * there + 2 - upper
    elif bounds[there, LEFT] < bounds[here, LEFT]:
        left = 4 * here + upper
    if bounds[there, RIGHT] < bounds[here, RIGHT]:
        right = 4 * there + 3 - upper
    elif bounds[there, RIGHT] > bounds[here, RIGHT]:
        right = 4 * here + 1 + upper
    return left, right


@compiled_part
def _runs(words: Bits, width: int, row: int, runs: Integers) -> int:
    """List the runs of free cells of a row, from and up to but without; return their number."""
    count, before = 0, _ONE
    is_open = False
    for at in range(words.shape[1]):
        # The map's end is a wall.
        word = words[row, at]
        if 64 * (at + 1) > width:
            word |= ~(_ALL >> np.uint64(64 * (at + 1) - width))
        changes = word ^ ((word << _ONE) | before)
        before = word >> np.uint64(63)
        while changes != 0:
            place = 64 * at + first_bit(changes)
            changes &= changes - _ONE
            if is_open:
                runs[count, 1] = place
                count += 1
            else:
                runs[count, 0] = place
            is_open = not is_open
    if is_open:
        runs[count, 1] = width
        count += 1
    return count


@compiled_part
def _is_as_before(words: Bits, row: int) -> bool:
    """Return whether a row is the same as the one before."""
    is_same, at = row > 0, 0
    while is_same and at < words.shape[1]:
        is_same = words[row, at] == words[row - 1, at]
        at += 1
    return is_same


@compiled_loop
def _cut(
    words: Bits,
    width: int,
    runs: Integers,
    bounds: Integers,
    above: Integers,
    below: Integers,
    by_top: Integers,
) -> int:
    """Fill the arrays of rectangles; return how many there are."""
    count = ended = open_runs = 0
    old, new = runs[0], runs[1]
    for row in range(len(words) + 1):
        if row < len(words) and _is_as_before(words, row):
            continue
        found = _runs(words, width, row, new) if row < len(words) else 0
        first_new, first_ended = count, ended
        at = 0
        for k in range(found):
            while at < open_runs and old[at, 1] <= new[k, 0]:
                at += 1
            if at < open_runs and old[at, 0] == new[k, 0] and old[at, 1] == new[k, 1]:
                new[k, 2] = old[at, 2]
                old[at, 2] = -1
                continue
            new[k, 2] = count
            bounds[count, LEFT], bounds[count, RIGHT] = new[k, 0], new[k, 1]
            bounds[count, BOTTOM] = row
            count += 1
        for k in range(open_runs):
            if old[k, 2] >= 0:
                bounds[old[k, 2], TOP] = row
                by_top[ended] = old[k, 2]
                ended += 1
        _join(bounds, above, below, by_top, first_new, count, first_ended, ended)
        old, new = new, old
        open_runs = found
    return count


@compiled_part
def _join(
    bounds: Integers,
    above: Integers,
    below: Integers,
    by_top: Integers,
    first_new: int,
    last_new: int,
    first_ended: int,
    last_ended: int,
) -> None:
    """Note which rectangles that begin in a line touch which that end there."""
    low = first_ended
    for new in range(first_new, last_new):
        while low < last_ended and bounds[by_top[low], RIGHT] < bounds[new, LEFT]:
            low += 1
        high = low
        while high < last_ended and bounds[by_top[high], LEFT] <= bounds[new, RIGHT]:
            old = by_top[high]
            if above[old, 0] == above[old, 1]:
                above[old, 0] = new
            above[old, 1] = new + 1
            high += 1
        below[new, 0], below[new, 1] = low, high
