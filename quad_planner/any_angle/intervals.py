"""
Intervals of the openings between rectangles, and what is seen through them from a root.

A root is the start, or a corner of a rectangle (`Rectangles`), around which a taut path turns.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import inlined_part
from quad_planner.any_angle.rectangles import BOTTOM, LEFT, RIGHT, TOP, Rectangles, ends_of_opening

Records = NDArray[np.void]

TINY = 1e-9
"""Difference of places and lengths that is rounding [cells]."""

INTERVAL = np.dtype(
    [
        ('left', np.float64),  # ends of the interval [cells]
        ('right', np.float64),
        ('length', np.float64),  # of the path to the root [cells]
        ('root', np.int64),  # number of a corner; as many as there are corners: the start
        ('left_corner', np.int64),  # corner at the end, or -1
        ('right_corner', np.int64),
        ('rectangle', np.int64),  # which lies beyond the interval
        ('is_up', np.int64),  # whether it is entered from below
    ],
    align=True,
)


@inlined_part
def place_of(
    rectangles: Rectangles, root: int, start_x: float, start_y: float
) -> tuple[float, float]:
    """Return where a root is [cells]."""
    bounds = rectangles.bounds
    if root >= 4 * len(bounds):
        return start_x, start_y
    k = root >> 2
    x = bounds[k, RIGHT] if root & 1 else bounds[k, LEFT]
    y = bounds[k, TOP] if root & 2 else bounds[k, BOTTOM]
    return float(x), float(y)


@inlined_part
def holds(rectangles: Rectangles, k: int, x: float, y: float) -> bool:
    """Return whether a point is in a rectangle or on its edge."""
    bounds = rectangles.bounds
    return bool(
        bounds[k, LEFT] - TINY <= x <= bounds[k, RIGHT] + TINY
        and bounds[k, BOTTOM] - TINY <= y <= bounds[k, TOP] + TINY
    )


@inlined_part
def neighbours(rectangles: Rectangles, here: int, is_up: bool) -> tuple[int, int]:
    """Return the range of a rectangle's neighbours on one side, for :func:`neighbour`."""
    sides = rectangles.above if is_up else rectangles.below
    return int(sides[here, 0]), int(sides[here, 1])


@inlined_part
def neighbour(rectangles: Rectangles, at: int, is_up: bool) -> int:
    """Return the rectangle at a place of that range."""
    return at if is_up else int(rectangles.by_top[at])


@inlined_part
def opening_part(
    rectangles: Rectangles, here: int, there: int, is_up: bool, low: float, high: float
) -> tuple[float, float, int, int]:
    """
    Return the part of an opening between two places: its ends, and corners there or -1.

    There is none if the right end is before the left one.
    """
    bounds = rectangles.bounds
    left = float(max(bounds[here, LEFT], bounds[there, LEFT]))
    right = float(min(bounds[here, RIGHT], bounds[there, RIGHT]))
    left_corner, right_corner = ends_of_opening(bounds, here, there, is_up)
    if left == right:
        if left < low - TINY or left > high + TINY:
            return 1.0, 0.0, -1, -1
        return left, right, left_corner, right_corner
    if low > left + TINY:
        left, left_corner = low, -1
    if high < right - TINY:
        right, right_corner = high, -1
    # What is seen of an opening in a point only is seen from the corner there, too.
    if right - left <= TINY:
        return 1.0, 0.0, -1, -1
    return left, right, left_corner, right_corner


@inlined_part
def distance(x0: float, y0: float, x1: float, y1: float) -> float:
    """Return the distance between two points; NumPy's takes several times as long."""
    return math.sqrt((x1 - x0) * (x1 - x0) + (y1 - y0) * (y1 - y0))


@inlined_part
def crossing(x0: float, y0: float, x1: float, y1: float, y: float) -> float:
    """Return where the line through two points, not of one height, has a height [cells]."""
    return x0 + (x1 - x0) * ((y - y0) / (y1 - y0))


@inlined_part
def least_through(
    x0: float, y0: float, left: float, right: float, y: float, is_up: bool, x1: float, y1: float
) -> float:
    """
    Return the length of the shortest path between two points through an interval.

    A goal before the interval is as far as its mirror image beyond it.
    """
    ahead = 1.0 if is_up else -1.0
    if ahead * (y1 - y) < 0.0:
        y1 = 2.0 * y - y1
    x = x0 if y1 == y0 else crossing(x0, y0, x1, y1, y)
    x = min(max(x, left), right)
    return distance(x0, y0, x, y) + distance(x, y, x1, y1)
