"""
Distances from points and segments to obstacles.
"""

from __future__ import annotations

import math

import numpy as np

from quad_common.compiled import compiled_loop, compiled_part
from quad_common.maps.occupancy_grid import OCCUPIED_THRESHOLD, OccupancyGrid
from quad_planner.grid.array_types import Mask, Points
from quad_planner.grid.bit_grid import BitMask, Bits, is_set
from quad_planner.grid.inflation import blocked_cells

_LOOK_FIRST = 32.0
"""The nearest obstacle is looked for so far off first, then farther [cells]."""


def clearance(
    grid: OccupancyGrid,
    x: float,
    y: float,
    *,
    occupied_threshold: int = OCCUPIED_THRESHOLD,
    unknown_is_free: bool = False,
) -> float:
    """
    Measure how far a point is from the nearest blocked cell.

    Parameters
    ----------
    grid : OccupancyGrid
        The map.
    x, y : float
        The point in the world [m].
    occupied_threshold : int
        Cells of at least this value are blocked.
    unknown_is_free : bool
        Whether cells of which nothing is known are free.

    Returns
    -------
    float
        Distance to the cell's square, 0 inside; infinite if nothing is blocked [m].
    """
    blocked = blocked_cells(
        grid, occupied_threshold=occupied_threshold, unknown_is_free=unknown_is_free
    )
    point = grid.world_to_map(np.array([x, y]))
    return segment_clearance(blocked, point, point) * grid.resolution


def segment_clearance(
    blocked: Mask | BitMask, start: Points, end: Points, within: float = math.inf
) -> float:
    """
    Measure how far a segment is from the nearest blocked cell, in cells.

    Parameters
    ----------
    blocked : ndarray of bool, shape (height, width), or BitMask
        The blocked cells.
    start, end : ndarray, shape (2,)
        Ends of the segment in cell coordinates; equal for a point.
    within : float
        Look no further than this; what is farther off may be reported as infinite [cells].

    Returns
    -------
    float
        Least distance between the segment and a blocked cell's square, 0 if they touch;
        infinite if there is no blocked cell in reach [cells].
    """
    mask = blocked if isinstance(blocked, BitMask) else BitMask.of(blocked)
    (ax, ay), (bx, by) = ((float(x), float(y)) for x, y in (start, end))
    farthest = min(within, mask.width + mask.height + abs(ax) + abs(ay))
    reach = min(_LOOK_FIRST, farthest)
    while True:
        apart = _least_distance(mask.words, mask.width, ax, ay, bx, by, reach)
        if apart <= reach or reach >= farthest:
            return apart
        reach = min(4.0 * reach, farthest)


@compiled_loop
def _least_distance(
    blocked: Bits, width: int, ax: float, ay: float, bx: float, by: float, reach: float
) -> float:
    """Return how far a segment is from blocked squares, at least of those in reach of it."""
    left, right = _span(min(ax, bx) - reach, max(ax, bx) + reach, width)
    bottom, top = _span(min(ay, by) - reach, max(ay, by) + reach, len(blocked))
    squared = np.inf
    for row in range(bottom, top):
        for column in range(left, right):
            if is_set(blocked, row, column):
                x, y = column + 0.5, row + 0.5
                squared = min(squared, _squared_distance(x, y, ax, ay, bx, by))
    return math.sqrt(squared)


@compiled_part
def _span(low: float, high: float, size: int) -> tuple[int, int]:
    """Return the range of cells of a map, as wide as this, between two places."""
    return (
        math.floor(min(max(low, 0.0), float(size))),
        math.ceil(min(max(high, 0.0), float(size))),
    )


@compiled_part
def _squared_distance(x: float, y: float, ax: float, ay: float, bx: float, by: float) -> float:
    """Return the squared distance between a square of side 1 and a segment."""
    abx, aby = bx - ax, by - ay
    # They are apart if an axis separates them: x, y, or the normal of the segment.
    if (
        abs(x - 0.5 * (ax + bx)) <= 0.5 * abs(abx) + 0.5
        and abs(y - 0.5 * (ay + by)) <= 0.5 * abs(aby) + 0.5
        and abs(abx * (y - ay) - aby * (x - ax)) <= 0.5 * (abs(abx) + abs(aby))
    ):
        return 0.0
    # Apart, they are nearest at an end of the segment or at a corner of the square.
    squared = np.inf
    for px, py in ((ax, ay), (bx, by)):
        dx, dy = max(abs(x - px) - 0.5, 0.0), max(abs(y - py) - 0.5, 0.0)
        squared = min(squared, dx * dx + dy * dy)
    for corner_x, corner_y in ((-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)):
        acx, acy = x + corner_x - ax, y + corner_y - ay
        t = (acx * abx + acy * aby) / max(abx * abx + aby * aby, 1e-30)
        t = min(max(t, 0.0), 1.0)
        dx, dy = acx - t * abx, acy - t * aby
        squared = min(squared, dx * dx + dy * dy)
    return squared
