"""
Shortest paths at any angle: taut, from corner to corner of the forbidden zone.

A shortest path turns only where the forbidden zone has a convex corner. A* over these
corners, from which the others are seen, finds it.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from quad_planner.grid.array_types import Mask, Points
from quad_planner.grid.bit_grid import BitMask, Bits
from quad_planner.grid.compiled import compiled
from quad_planner.grid.line_of_sight import sees
from quad_planner.search.search_loop import path_back

Floats = NDArray[np.float64]


def convex_corners(forbidden: BitMask) -> Points:
    """
    Find where the forbidden zone has convex corners, within the map.

    Parameters
    ----------
    forbidden : BitMask
        The forbidden cells.

    Returns
    -------
    ndarray, shape (n, 2)
        Corners of cells, x and y in cell coordinates.
    """
    one, last = np.uint64(1), np.uint64(63)
    left = forbidden.words
    # Each cell's bit moves to the place of the cell to its left.
    right = left >> one
    right[:, :-1] |= left[:, 1:] << last
    a, b, c, d = left[:-1], right[:-1], left[1:], right[1:]
    single = (a ^ b ^ c ^ d) & ~((a & b) | (c & d))
    # Two cells that touch in this corner only are two corners in one.
    double = (a & d & ~b & ~c) | (b & c & ~a & ~d)
    # In the last column there is nothing to the right.
    corners = BitMask(single | double, forbidden.width - 1)
    return corners.places()[:, ::-1] + np.float64(1.0)


def any_angle_path(
    forbidden: BitMask,
    corners: Points,
    start: Points,
    goal: Points,
    bound: float,
    check_time: Callable[[], None] = lambda: None,
) -> Points | None:
    """
    Find a shortest path at any angle.

    Parameters
    ----------
    forbidden : BitMask
        The forbidden cells; their edges are allowed.
    corners : ndarray, shape (n, 2)
        Corners that :func:`convex_corners` found.
    start, goal : ndarray, shape (2,)
        Points in allowed cells [cells].
    bound : float
        Length of a path that is known: longer ones are not looked at [cells].
    check_time : callable
        Called again and again; raises to end the search.

    Returns
    -------
    ndarray, shape (m, 2) or None
        The start, the corners where it turns, and the goal; None if there is none
        within the bound.
    """
    bound = bound * (1.0 + 1e-9) + 1e-9
    # No corner outside this ellipse is on a path that is short enough.
    left = np.hypot(*(corners - goal).T)
    near = np.hypot(*(corners - start).T) + left <= bound
    points = np.vstack((start, goal, corners[near]))
    left = np.concatenate(([np.hypot(*(goal - start)), 0.0], left[near]))
    lengths = np.full(len(points), np.inf)
    lengths[0] = 0.0
    parents = np.zeros(len(points), dtype=np.int64)
    is_done = np.zeros(len(points), dtype=np.bool_)
    heap = [(float(left[0]), 0)]
    while heap:
        _, at = heapq.heappop(heap)
        if is_done[at]:
            continue
        is_done[at] = True
        if at == 1:
            return points[path_back(parents.__getitem__, 1, 0)]
        check_time()
        seen = _expand(
            forbidden.words, forbidden.width, points, left, lengths, parents, is_done, at, bound
        )
        for k in seen.tolist():
            heapq.heappush(heap, (float(lengths[k] + left[k]), k))
    return None


@compiled
def _expand(
    forbidden: Bits,
    width: int,
    points: Floats,
    left: Floats,
    lengths: Floats,
    parents: NDArray[np.int64],
    is_done: Mask,
    at: int,
    bound: float,
) -> NDArray[np.int64]:
    """Go on from a point to all that it sees; return those that are now nearer."""
    nearer = np.empty(len(points), dtype=np.int64)
    count = 0
    x, y = points[at, 0], points[at, 1]
    for k in range(1, len(points)):
        if is_done[k]:
            continue
        length = lengths[at] + math.hypot(points[k, 0] - x, points[k, 1] - y)
        if length >= lengths[k] or length + left[k] > bound:
            continue
        if sees(forbidden, width, x, y, points[k, 0], points[k, 1]):
            lengths[k] = length
            parents[k] = at
            nearer[count] = k
            count += 1
    return nearer[:count]
