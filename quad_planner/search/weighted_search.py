"""
Cheapest paths from cell to cell, where some cells cost more than others.

A* over straight and diagonal steps, no corner cut. A step costs its length times the
mean factor of the two cells; costs are whole numbers, so equal costs are equal.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled, compiled_loop, compiled_part
from quad_planner.grid.array_types import Points
from quad_planner.grid.bit_grid import BitGrid, BitMask, Bits, is_set
from quad_planner.grid.bucket_queue import (
    BucketQueue,
    bucket_queue,
    has_room,
    is_empty,
    next_bucket,
    pop,
    push,
)
from quad_planner.grid.line_of_sight import sees
from quad_planner.search.cell_path import without_straights
from quad_planner.search.cell_steps import DIAGONAL, DX, DY, STRAIGHT
from quad_planner.search.search_loop import DONE, FULL, PAUSED, path_back, run_search

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Cells = NDArray[np.int64]

PARTS = 16
"""Number of parts of 1 in which factors are counted."""
TWO_PARTS = 2 * PARTS
"""That number for the sum of two factors."""

_LEAST_BUCKET = TWO_PARTS * STRAIGHT
_MOST_BUCKETS = 1 << 14

_EXPANSIONS = 65536
"""Number of expansions between two calls of `check`."""


_AT_THE_START = np.uint8(8)


def cheapest_path(
    grid: BitGrid,
    factors: Floats,
    start: tuple[int, int],
    goal: tuple[int, int],
    check: Callable[[], None] = lambda: None,
) -> Cells | None:
    """
    Find a path that costs least.

    Parameters
    ----------
    grid : BitGrid
        The free cells.
    factors : ndarray, shape (height, width)
        Factor by which a path through each cell costs more than its length, from 1 to
        `quad_planner.costs.cell_costs.LARGEST_FACTOR`; counted in sixteenths.
    start, goal : tuple of int
        x and y of cells of the map.
    check : callable
        Called again and again; raises to end the search.

    Returns
    -------
    ndarray of int, shape (n, 2) or None
        Places where the path begins, turns and ends; None if there is none, or an end is not free.
    """
    if not (grid.is_free(*start) and grid.is_free(*goal)):
        return None
    width = grid.width + 2
    weights = np.ones((grid.height + 2, width), dtype=np.int64)
    weights[1:-1, 1:-1] = np.rint(PARTS * factors)
    least = int(weights[1:-1, 1:-1].min())
    # A step may raise cost and bound together by twice its cost.
    longest = 4 * DIAGONAL * int(weights.max())
    bucket_width = max(_LEAST_BUCKET, longest // _MOST_BUCKETS)
    queue = bucket_queue(longest // bucket_width + 2)
    costs = np.full(weights.size, -1, dtype=np.int64)
    by = np.zeros(weights.size, dtype=np.uint8)
    first, last = ((y + 1) * width + x + 1 for x, y in (start, goal))
    costs[first] = 0
    by[first] = _AT_THE_START
    ahead = 2 * least * _octile(first, last, width)
    queue.state[0] = ahead // bucket_width
    push(*queue, first, 0, ahead // bucket_width)
    flat = weights.reshape(-1)

    def expand(queue: BucketQueue) -> int:
        return _search(
            grid.rows, width, flat, least, last, bucket_width, costs, by, queue, _EXPANSIONS
        )

    run_search(expand, queue, 8, check)
    if costs[last] < 0:
        return None
    return without_straights(_cells_back(by, width, last))


def straightened(
    points: Points, factors: Floats, forbidden: BitMask, check: Callable[[], None] = lambda: None
) -> Points:
    """
    Leave out points of a path where it costs no more without them.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        The path [cells].
    factors : ndarray, shape (height, width)
        Factor by which a path through each cell costs more than its length.
    forbidden : BitMask
        Cells that the path does not enter.
    check : callable
        Called again and again; raises to end it.

    Returns
    -------
    ndarray, shape (m, 2)
        The cheapest line over some of the points, from the first to the last.
    """
    count = len(points)
    costs = np.full(count, np.inf)
    costs[0] = 0.0
    before = np.zeros(count, dtype=np.int64)
    for at in range(count):
        check()
        _straighten(points, factors, forbidden.words, forbidden.width, at, costs, before)
    return points[path_back(before.__getitem__, count - 1, 0)]


@compiled_loop
def line_cost(factors: Floats, x0: float, y0: float, x1: float, y1: float) -> float:
    """
    Integrate the factor along a segment.

    Parameters
    ----------
    factors : ndarray, shape (height, width)
        Factor of each cell.
    x0, y0, x1, y1 : float
        Ends of the segment, on the map [cells].

    Returns
    -------
    float
        Length times mean factor [cells]; along an edge, of the cell above or to the right.
    """
    height, width = factors.shape
    length = np.hypot(x1 - x0, y1 - y0)
    if length == 0.0:
        return 0.0
    dx, dy = x1 - x0, y1 - y0
    total, done = 0.0, 0.0
    while done < 1.0:
        # To where the segment next crosses a line between cells.
        after = 1.0
        for at, change in ((x0 + done * dx, dx), (y0 + done * dy, dy)):
            if change != 0.0:
                line = np.floor(at + 1e-9) + 1.0 if change > 0.0 else np.ceil(at - 1e-9) - 1.0
                after = min(after, done + (line - at) / change)
        middle = (done + after) / 2.0
        x = min(max(int(np.floor(x0 + middle * dx)), 0), width - 1)
        y = min(max(int(np.floor(y0 + middle * dy)), 0), height - 1)
        total += (after - done) * factors[y, x]
        done = after
    return float(total * length)


@compiled_loop
def _straighten(
    points: Floats,
    factors: Floats,
    forbidden: Bits,
    width: int,
    at: int,
    costs: Floats,
    before: Integers,
) -> None:
    """Go straight on from a point to all that come later."""
    x, y = points[at, 0], points[at, 1]
    for other in range(at + 1, len(points)):
        to_x, to_y = points[other, 0], points[other, 1]
        if other > at + 1 and not sees(forbidden, width, x, y, to_x, to_y):
            continue
        cost = costs[at] + line_cost(factors, x, y, to_x, to_y)
        # Of two lines that cost the same, the one with fewer corners.
        if cost < costs[other] - 1e-9:
            costs[other] = cost
            before[other] = at


@compiled_part
def _octile(cell: int, goal: int, width: int) -> int:
    along, across = abs(cell % width - goal % width), abs(cell // width - goal // width)
    return STRAIGHT * max(along, across) + (DIAGONAL - STRAIGHT) * min(along, across)


@compiled_loop
def _search(
    rows: Bits,
    width: int,
    weights: Integers,
    least: int,
    goal: int,
    bucket_width: int,
    costs: Integers,
    by: NDArray[np.uint8],
    queue: BucketQueue,
    most: int,
) -> int:
    """
    Go on from cells that wait, the one with the least cost and bound first.

    Pauses after `most` cells.
    """
    heads, entries, state = queue.heads, queue.entries, queue.state
    for _ in range(most):
        if is_empty(state):
            return DONE
        if not has_room(entries, state, 8):
            return FULL
        bucket = next_bucket(heads, state)
        if 0 <= costs[goal] < bucket * bucket_width:
            return DONE
        cell, key = pop(heads, entries, state)
        if costs[cell] != key:
            # A cheaper path was found: that one waits too.
            continue
        y, x = cell // width, cell % width
        for k in range(8):
            dx, dy = int(DX[k]), int(DY[k])
            if not is_set(rows, y + dy, x + dx):
                continue
            if k & 1 and not (is_set(rows, y, x + dx) and is_set(rows, y + dy, x)):
                continue
            beside = cell + dy * width + dx
            step = DIAGONAL if k & 1 else STRAIGHT
            cost = key + step * (weights[cell] + weights[beside])
            if costs[beside] < 0 or cost < costs[beside]:
                costs[beside] = cost
                by[beside] = k
                total = cost + 2 * least * _octile(beside, goal, width)
                push(heads, entries, state, beside, cost, total // bucket_width)
    return PAUSED


@compiled
def _cells_back(by: NDArray[np.uint8], width: int, goal: int) -> Cells:
    """Go back from the goal to the start; list every cell of the path, in cells of the map."""
    count, cell = 1, goal
    while by[cell] != _AT_THE_START:
        cell -= int(DY[by[cell]]) * width + int(DX[by[cell]])
        count += 1
    cells = np.empty((count, 2), dtype=np.int64)
    cell = goal
    for at in range(count - 1, -1, -1):
        cells[at, 0], cells[at, 1] = cell % width - 1, cell // width - 1
        if at:
            cell -= int(DY[by[cell]]) * width + int(DX[by[cell]])
    return cells
