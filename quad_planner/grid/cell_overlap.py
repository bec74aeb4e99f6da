"""
Cells of one grid that share some area with cells of another, which may lie at an angle.
"""

from __future__ import annotations

import math

import numpy as np

from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_planner.grid.array_types import Mask, Points

EPSILON = 1e-6
"""Squares that overlap by less only touch [cells]."""


_AT_ONCE = 2**18
"""Number of cells that are laid on the grid at a time."""


def cells_touched(heights: HeightMap, marked: Mask, grid: OccupancyGrid) -> Mask:
    """
    Lay cells of a height map on an occupancy grid, which may lie at any angle.

    Parameters
    ----------
    heights : HeightMap
        Says where its cells are.
    marked : ndarray of bool, shape (rows, columns)
        Cells that are marked.
    grid : OccupancyGrid
        The grid.

    Returns
    -------
    ndarray of bool, shape (height, width)
        True in the cells of the grid that share some area with a marked one, exactly.
    """
    touched = np.zeros(grid.cells.shape, dtype=bool)
    rows, columns = np.nonzero(marked)
    for first in range(0, len(rows), _AT_ONCE):
        part = slice(first, first + _AT_ONCE)
        cells = np.column_stack((columns[part], rows[part])).astype(np.float64) + 0.5
        centers = grid.world_to_map(cells * heights.resolution + heights.origin)
        _touch(touched, centers, heights.resolution / grid.resolution, grid.origin.yaw)
    return touched


def _touch(touched: Mask, centers: Points, side: float, yaw: float) -> None:
    """
    Mark the cells that squares share an area with.

    Two squares are apart if they are along one of the axes of either.

    Parameters
    ----------
    touched : ndarray of bool, shape (height, width)
        Grid in which they are marked.
    centers : ndarray, shape (n, 2)
        Centers of the squares [cells].
    side : float
        Side of the squares [cells].
    yaw : float
        Angle by which the cells are turned from the squares [rad].
    """
    cosine, sine = math.cos(yaw), math.sin(yaw)
    spread = abs(cosine) + abs(sine)
    reach = side * spread / 2.0
    apart = 0.5 + reach - EPSILON
    apart_in_world = side / 2.0 + spread / 2.0 - EPSILON
    size = np.array([touched.shape[1], touched.shape[0]])
    centers = centers[np.all((centers > -reach) & (centers < size + reach), axis=1)]
    low = np.floor(centers - reach).astype(np.int64)
    count = math.ceil(2.0 * reach) + 1
    for row in range(count):
        for column in range(count):
            cells = low + (column, row)
            x, y = (cells + 0.5 - centers).T
            is_shared = (np.abs(x) < apart) & (np.abs(y) < apart)
            is_shared &= np.abs(cosine * x - sine * y) < apart_in_world
            is_shared &= np.abs(sine * x + cosine * y) < apart_in_world
            is_shared &= np.all((cells >= 0) & (cells < size), axis=1)
            shared = cells[is_shared]
            touched[shared[:, 1], shared[:, 0]] = True
