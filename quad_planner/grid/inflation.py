"""
The safety boundary: where the robot's center may be (S0 section 3).

An obstacle is a whole cell, a square, not the point at its center. The map's outside is
no obstacle: what is not on the map takes no room from the robot, whose center has to
stay on the map all the same. Whoever wants a wall around the map draws one.

Two distances are used, and the first is never larger than the second:

- from a *cell* to the nearest blocked cell (`inflate`): one look-up tells it for every
  point of the cell, so it serves for thousands of segments;
- from a *point or segment* to the nearest blocked cell, exactly (`clearance`,
  `segment_clearance`): for the few that the robot's own place asks about.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import ParameterError
from quad_common.maps.occupancy_grid import FREE, OCCUPIED_THRESHOLD, OccupancyGrid
from quad_planner.grid.array_types import Mask
from quad_planner.grid.bit_grid import BitMask, packed_cells
from quad_planner.grid.dilation import dilated

_SLACK = 1e-6
"""Relative slack of the inflation radius, for a radius that is a whole number of cells."""


def blocked_cells(
    grid: OccupancyGrid,
    *,
    occupied_threshold: int = OCCUPIED_THRESHOLD,
    unknown_is_free: bool = False,
) -> BitMask:
    """Return where the robot must not be near: occupied cells, and by default unknown ones."""
    info = np.iinfo(np.int8)
    least = info.min if unknown_is_free else FREE
    most = min(max(occupied_threshold - 1, info.min), info.max)
    return BitMask(packed_cells(np.ascontiguousarray(grid.cells), least, most), grid.width)


def inflate(
    grid: OccupancyGrid,
    radius: float,
    *,
    occupied_threshold: int = OCCUPIED_THRESHOLD,
    unknown_is_free: bool = False,
) -> Mask:
    """
    Find the cells in which the robot's center could come too near to an obstacle.

    Two cells that lie (dx, dy) cells apart have squares that lie
    hypot(max(|dx| - 1, 0), max(|dy| - 1, 0)) apart: as far as the one center from the
    nearest of the other's 3 x 3 block of centers. So blocked cells forbid others by rows
    of known widths, 64 cells at a time.

    Parameters
    ----------
    grid : OccupancyGrid
        The map.
    radius : float
        Distance that the robot's center keeps from every blocked cell, >= 0 [m].
    occupied_threshold : int
        Cells of at least this value are blocked.
    unknown_is_free : bool
        Whether cells of which nothing is known are free.

    Returns
    -------
    ndarray of bool, shape (height, width)
        True where some point of the cell is nearer than `radius` to a blocked cell, and
        in the blocked cells themselves.

    Raises
    ------
    ParameterError
        If `radius` is negative or not finite.
    """
    if not (math.isfinite(radius) and radius >= 0.0):
        raise ParameterError('radius', radius, 'a finite distance of at least 0 m')
    blocked = blocked_cells(
        grid, occupied_threshold=occupied_threshold, unknown_is_free=unknown_is_free
    )
    return inflated(blocked, radius / grid.resolution).unpacked()


def inflated(blocked: BitMask, radius: float) -> BitMask:
    """
    Find the cells that are too near to blocked ones, as :func:`inflate` does.

    Parameters
    ----------
    blocked : BitMask
        The blocked cells.
    radius : float
        Least distance between squares, finite, >= 0 [cells].

    Returns
    -------
    BitMask
        The blocked cells, and those that are nearer.
    """
    reaches = _reaches(radius * (1.0 - _SLACK))
    if len(reaches) == 0:
        return blocked
    return BitMask(dilated(blocked.words, reaches), blocked.width)


def inflated_again(
    forbidden: BitMask, blocked: BitMask, radius: float, changed: tuple[int, int]
) -> tuple[BitMask, tuple[int, int]]:
    """
    Find them again where blocked cells have changed.

    Parameters
    ----------
    forbidden : BitMask
        Cells that :func:`inflated` made of those as they were.
    blocked : BitMask
        The blocked cells.
    radius : float
        As for :func:`inflated`.
    changed : tuple of int
        Rows in which cells have changed: from the first up to, but without, the second.

    Returns
    -------
    BitMask
        Cells that :func:`inflated` would make of the blocked ones.
    tuple of int
        The rows in which it may differ from what it was.
    """
    reaches = _reaches(radius * (1.0 - _SLACK))
    far = max(len(reaches) - 1, 0)
    first, last = max(changed[0] - far, 0), min(changed[1] + far, blocked.height)
    words = forbidden.words.copy()
    if len(reaches) == 0:
        words[first:last] = blocked.words[first:last]
    else:
        below = max(first - far, 0)
        near = dilated(blocked.words[below : min(last + far, blocked.height)], reaches)
        words[first:last] = near[first - below : last - below]
    return BitMask(words, forbidden.width), (first, last)


def _reaches(radius: float) -> NDArray[np.int64]:
    """
    List how far to either side cells are too near, by the number of rows off.

    Parameters
    ----------
    radius : float
        Squares nearer than this are too near [cells].

    Returns
    -------
    ndarray of int, shape (n,)
        Columns for 0, 1, ... n - 1 rows off.
    """
    between_rows = np.maximum(np.arange(math.ceil(radius) + 1) - 1, 0)
    between_rows = between_rows[between_rows < radius]
    if radius <= 0.0:
        return np.empty(0, dtype=np.int64)
    reaches: NDArray[np.int64] = np.ceil(np.sqrt(radius**2 - between_rows**2)).astype(np.int64)
    return reaches
