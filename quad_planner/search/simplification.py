"""
As few turning points as possible for a path that need not be followed exactly.

Among the lines whose corners are points of the path, which deviate from it no more than
is allowed, and on which the robot fits, one with the fewest corners is found: the
shortest path in the graph of permitted segments (Imai and Iri: Polygonal Approximations
of a Curve, 1988).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, compiled_part
from quad_common.errors import ParameterError
from quad_planner.grid.array_types import Points
from quad_planner.grid.bit_grid import BitMask, Bits
from quad_planner.grid.line_of_sight import sees
from quad_planner.search.search_loop import path_back

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_AT_ONCE = 32
"""Number of points that are expanded between two calls of `check`."""

_SLACK = 1e-9
"""Excess of a deviation that counts as allowed still: rounding [cells]."""


def fewest_corners(
    points: Points,
    deviation: float,
    forbidden: BitMask,
    check: Callable[[], None] = lambda: None,
) -> Points:
    """
    Simplify a path.

    Parameters
    ----------
    points : ndarray, shape (n, 2), n >= 1
        The path; from each point to the next it enters no forbidden cell [cells].
    deviation : float
        Largest distance of a point of the path from the segment that takes its place, >= 0
        [cells].
    forbidden : BitMask
        Cells that the simplified path does not enter.
    check : callable
        Called again and again; raises to end the search.

    Returns
    -------
    ndarray, shape (m, 2)
        Points of the path in their order, from its first to its last: as few as can be, and
        the shortest of those paths.

    Raises
    ------
    ParameterError
        If the deviation is negative or no number.
    """
    if not deviation >= 0.0:
        raise ParameterError('deviation', deviation, 'at least 0')
    count = len(points)
    corners = np.full(count, count, dtype=np.int64)
    lengths = np.full(count, np.inf)
    parents = np.zeros(count, dtype=np.int64)
    corners[0], lengths[0] = 0, 0.0
    for first in range(0, count - 1, _AT_ONCE):
        last = min(first + _AT_ONCE, count - 1)
        _go_on(
            points,
            deviation,
            forbidden.words,
            forbidden.width,
            first,
            last,
            corners,
            lengths,
            parents,
        )
        check()
    return points[path_back(parents.__getitem__, count - 1, 0)]


def all_seen(points: Points, forbidden: BitMask) -> bool:
    """Return whether a line through points, shape (n, 2) [cells], enters no forbidden cell."""
    return bool(_all_seen(points, forbidden.words, forbidden.width))


@compiled_loop
def _all_seen(points: Points, forbidden: Bits, width: int) -> bool:
    for k in range(len(points) - 1):
        if not sees(
            forbidden, width, points[k, 0], points[k, 1], points[k + 1, 0], points[k + 1, 1]
        ):
            return False
    return True


@compiled_loop
def _go_on(
    points: Points,
    deviation: float,
    forbidden: Bits,
    width: int,
    first: int,
    last: int,
    corners: Integers,
    lengths: Floats,
    parents: Integers,
) -> None:
    """Find what the points from the first up to the last may be joined to."""
    count = len(points)
    for i in range(first, last):
        if corners[i] + 1 > corners[count - 1]:
            # The last point has been reached by fewer.
            continue
        x, y = points[i]
        # Directions, from that of (axis_x, axis_y), in which no point between is too far off.
        axis_x = axis_y = farthest = 0.0
        low, high = -np.pi, np.pi
        for j in range(i + 1, count):
            along, across = points[j, 0] - x, points[j, 1] - y
            apart = np.hypot(along, across)
            angle = 0.0
            if axis_x != 0.0 or axis_y != 0.0:
                angle = np.arctan2(
                    axis_x * across - axis_y * along, axis_x * along + axis_y * across
                )
            length = lengths[i] + apart
            is_better = corners[i] + 1 < corners[j] or (
                corners[i] + 1 == corners[j] and length < lengths[j]
            )
            # Near to the ray, and none of them beyond its end: near to the segment.
            is_near = low <= angle <= high and (
                farthest <= apart or (is_better and _is_near(points, i, j, deviation))
            )
            if is_better and (
                j == i + 1 or (is_near and sees(forbidden, width, x, y, points[j, 0], points[j, 1]))
            ):
                corners[j] = corners[i] + 1
                lengths[j] = length
                parents[j] = i
            farthest = max(farthest, apart)
            if apart > deviation + _SLACK:
                if axis_x == 0.0 and axis_y == 0.0:
                    axis_x, axis_y = along, across
                half = np.arcsin((deviation + _SLACK) / apart)
                low, high = max(low, angle - half), min(high, angle + half)
                if low > high:
                    break


@compiled_part
def _is_near(points: Points, i: int, j: int, deviation: float) -> bool:
    """Return whether the points between two are near to the segment that joins these."""
    x, y = points[i]
    along, across = points[j, 0] - x, points[j, 1] - y
    square = max(along * along + across * across, 1e-300)
    for k in range(i + 1, j):
        u, v = points[k, 0] - x, points[k, 1] - y
        t = min(max((u * along + v * across) / square, 0.0), 1.0)
        if np.hypot(u - t * along, v - t * across) > deviation + _SLACK:
            return False
    return True
