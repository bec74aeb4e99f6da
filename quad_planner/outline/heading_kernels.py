"""
Where a polygon reaches at each class of headings, as cells of the map.

A class holds the headings within half a step of a multiple of it. Its polygon holds the
outline at all of them, so what fits by a class fits at every heading of it, and a turn through
neighbouring classes that fit touches nothing.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import CellsTooSmall
from quad_planner.outline.robot_outline import convex_hull

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

CLASSES = 72
"""Number of classes of headings, of 5 degrees each."""

STEP = 2.0 * math.pi / CLASSES
"""Difference of the headings of two neighbouring classes [rad]."""

_SLACK = 1e-6
"""Relative slack of the distance, as of the inflation by circles."""


_MOST_ROWS = 128
"""Cells over which the robot may reach from its center: the time for kernels grows by the square of
their number, and maps are taken where goals and heartbeats wait."""


class Kernels(NamedTuple):
    """Cells that the robot reaches from one cell, row by row."""

    rows: int
    """Number of rows to either side of the cell."""
    low: Integers
    """First column, seen from the cell, of each class and row, shape (72, 2 rows + 1)."""
    high: Integers
    """Last column; below the first where there is none."""


def class_of(heading: float) -> int:
    """Return the class of a heading [rad]."""
    return round(heading / STEP) % CLASSES


def class_polygon(outline: Array, heading_class: int) -> Array:
    """
    Hold an outline at all headings of a class.

    Parameters
    ----------
    outline : ndarray, shape (n, 2)
        In the body frame [m].
    heading_class : int
        The class.

    Returns
    -------
    ndarray, shape (m, 2)
        Convex polygon in the axes of the map: between its two extremes each corner describes an
        arc, which lies within the triangle of its ends and of the tangents there [m].
    """
    half = STEP / 2.0
    points = []
    for turn, factor in ((-half, 1.0), (0.0, 1.0 / math.cos(half)), (half, 1.0)):
        angle = heading_class * STEP + turn
        cos, sin = factor * math.cos(angle), factor * math.sin(angle)
        points.append(outline @ np.array([[cos, sin], [-sin, cos]]))
    return convex_hull(np.vstack(points))


def kernels_of(outline: Array, distance: float, resolution: float) -> Kernels:
    """
    Find the cells that must not be blocked, for each class.

    Parameters
    ----------
    outline : ndarray, shape (n, 2)
        Convex, counter-clockwise, in the body frame [m].
    distance : float
        Distance that it keeps from obstacles, >= 0 [m].
    resolution : float
        Side of a cell [m].

    Returns
    -------
    Kernels
        All cells, some point of which is nearer than the distance to the outline of a robot
        whose center is at some point of a cell, at some heading of the class.

    Raises
    ------
    CellsTooSmall
        If the robot reaches over too many of them.
    """
    reach = np.linalg.norm(outline, axis=1).max() / math.cos(STEP / 2.0) + distance
    rows = math.ceil(reach / resolution) + 1
    if rows > _MOST_ROWS:
        raise CellsTooSmall(resolution, rows, _MOST_ROWS)
    offsets = np.arange(-rows, rows + 1, dtype=float)
    x, y = np.meshgrid(offsets, offsets)
    low = np.ones((CLASSES, len(offsets)), dtype=np.int64)
    high = np.zeros_like(low)
    for k in range(CLASSES):
        polygon = class_polygon(outline, k) / resolution
        # Two squares of side 1 are as far from one another as a point from one of side 2.
        wide = (polygon[:, None] + [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]).reshape(
            -1, 2
        )
        apart = _distances(convex_hull(wide), x, y)
        near = apart < distance / resolution * (1.0 - _SLACK) - _SLACK
        hit = near.any(axis=1)
        low[k, hit] = near[hit].argmax(axis=1) - rows
        high[k, hit] = rows - near[hit, ::-1].argmax(axis=1)
    return Kernels(rows, low, high)


def _distances(polygon: Array, x: Array, y: Array) -> Array:
    """Return how far points are from a convex polygon; negative inside."""
    inside = np.full(x.shape, -np.inf)
    outside = np.full(x.shape, np.inf)
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, axis=0)):
        length = math.hypot(bx - ax, by - ay)
        ux, uy = (bx - ax) / length, (by - ay) / length
        along = (x - ax) * ux + (y - ay) * uy
        across = (x - ax) * uy - (y - ay) * ux
        inside = np.maximum(inside, across)
        outside = np.minimum(outside, np.hypot(along - np.clip(along, 0.0, length), across))
    return np.where(inside <= 0.0, inside, outside)
