"""
How rough and how steep the ground is that a robot can walk on, for costs of walking there.

Around each place a plane is fitted to the heights, by least squares over the same square as for
:func:`quad_planner.grid.ground_shape.steep_slopes`. Its rise is the slope. What the heights are
off it, root mean square, times the square root of 12, is the roughness [m]: so rough is ground
beside a single step of that height. Both are counted as fractions of what the robot
can walk on; beyond that the ground is an obstacle anyway.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_planner.footing.footing import Footing
from quad_planner.grid.ground_shape import Floats, fitted_planes
from quad_planner.grid.traversability import Ground

Singles = NDArray[np.float32]

_STEP_OVER_RMS = math.sqrt(12.0)
"""
A step of height h that divides a square in the ratio p to 1 - p is off the plane that fits it by
h sqrt(q - 3 q^2), root mean square, with q = p (1 - p): that is h / sqrt(12) at most.
"""


_BAND = 64
"""Rows of a map that are looked up at a time."""


class Difficulty(NamedTuple):
    """How difficult the ground is, of each cell of a map, shape (height, width) each."""

    roughness: Singles
    """Roughness over the robot's step height, from 0 to 1; 0 where the ground is not known."""
    slope: Singles
    """Slope over the largest one, from 0 to 1; 0 where the ground is not known."""


@dataclass(frozen=True, eq=False)
class GridOverGround(OccupancyGrid):
    """A map, and the ground that the robot walks on there."""

    ground: Ground
    """Ground that the robot walks on."""
    footing: Footing | None = None
    """Where it can stand on that ground; None where that is not looked at."""

    @classmethod
    def of(
        cls, grid: OccupancyGrid, ground: Ground, footing: Footing | None = None
    ) -> GridOverGround:
        """Lay a map over the ground."""
        return cls(grid.cells, grid.resolution, grid.origin, ground, footing)


def ground_of(grid: OccupancyGrid) -> Ground | None:
    """Return the ground under a map, None where nothing is known of it."""
    return grid.ground if isinstance(grid, GridOverGround) else None


def difficulty(grid: OccupancyGrid) -> Difficulty | None:
    """
    Say how difficult the ground under a map is.

    Parameters
    ----------
    grid : OccupancyGrid
        The map.

    Returns
    -------
    Difficulty or None
        At the middle of each cell; None where nothing is known of the ground.
    """
    ground = ground_of(grid)
    if ground is None:
        return None
    return _difficulty(ground, grid.cells.shape, grid.resolution, grid.origin)


@lru_cache(maxsize=2)
def _difficulty(
    ground: Ground, shape: tuple[int, int], resolution: float, origin: Pose2D
) -> Difficulty:
    """Say how difficult the ground is in the cells of a map: once, whatever else changes there."""
    grid = OccupancyGrid(np.zeros(shape, dtype=np.int8), resolution, origin)
    heights, limits = ground.heights, ground.limits
    slopes, off_plane = (
        _to_the_border(values, heights, limits.slope_length)
        for values in fitted_planes(heights, limits.slope_length)
    )
    rough = np.clip(_STEP_OVER_RMS * off_plane / limits.step_height, 0.0, 1.0)
    steep = np.clip(np.arctan(slopes) / limits.largest_slope, 0.0, 1.0)
    found = Difficulty(*(np.zeros(shape, dtype=np.float32) for _ in range(2)))
    # A band of rows at a time: the places of all cells take many times the memory of what is found.
    for row in range(0, shape[0], _BAND):
        band = slice(row, row + _BAND)
        rows, columns = np.indices(found.slope[band].shape)
        middles = np.stack((columns, rows + row), axis=-1) + 0.5
        places = (grid.map_to_world(middles) - heights.origin) / heights.resolution
        at = np.floor(places).astype(np.int64)
        inside = np.all((at >= 0) & (at < (heights.columns, heights.rows)), axis=-1)
        x, y = at[inside].T
        found.roughness[band][inside] = rough[y, x]
        found.slope[band][inside] = steep[y, x]
    return found


def _to_the_border(values: Floats, heights: HeightMap, length: float) -> Floats:
    """Give known cells around which too little is known the largest value nearby, others 0."""
    # Imported late, as only a height map needs it: it takes a good part of a node's start.
    from scipy import ndimage

    known = np.nan_to_num(values, nan=0.0)
    around = ndimage.maximum_filter(
        known, size=math.ceil(length / heights.resolution), mode='constant'
    )
    at_border = np.isnan(values) & ~np.isnan(heights.heights)
    return np.where(at_border, around, known)
