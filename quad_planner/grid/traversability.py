"""
Which ground a robot cannot walk on: steps that are too high for it, and slopes too steep.

The height map says where; on the occupancy grid such ground becomes obstacles like any other,
so that every planning method walks around it, and walks over what is lower.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.height_map import HeightMap
from quad_common.maps.height_map_parts import are_alike
from quad_common.maps.occupancy_grid import FREE, OCCUPIED, OCCUPIED_THRESHOLD, OccupancyGrid
from quad_planner.grid.array_types import Mask
from quad_planner.grid.bridged_ground import bridged
from quad_planner.grid.cell_overlap import EPSILON, cells_touched
from quad_planner.grid.ground_limits import GroundLimits
from quad_planner.grid.ground_shape import high_steps, steep_slopes_beside

Floats = NDArray[np.float64]


_AROUND = np.ones((3, 3), dtype=bool)
"""A cell and its eight neighbours."""


@dataclass(frozen=True, eq=False)
class Ground:
    """The ground, and what of it a robot cannot walk on."""

    heights: HeightMap
    """Heights of the ground."""
    limits: GroundLimits
    """Limits of what the robot can walk on."""
    obstacles: Mask = field(init=False)
    """Cells of the height map with steps that are too high, or slopes too steep."""

    def __post_init__(self) -> None:
        """Find the obstacles."""
        heights = bridged(self.heights, self.limits.largest_gap)
        steps = high_steps(heights, self.limits)
        obstacles = steps | steep_slopes_beside(heights, self.limits, steps)
        object.__setattr__(self, 'obstacles', obstacles)

    def is_like(self, heights: HeightMap) -> bool:
        """Return whether another height map says the same."""
        return are_alike(self.heights, heights)

    def added_to(
        self,
        grid: OccupancyGrid,
        occupied_threshold: int = OCCUPIED_THRESHOLD,
        steps_over_low: bool = False,
    ) -> OccupancyGrid:
        """
        Add the obstacles of the ground to a map.

        Parameters
        ----------
        grid : OccupancyGrid
            The map.
        occupied_threshold : int
            Its cells of at least this value are obstacles.
        steps_over_low : bool
            Whether obstacles of the map vanish where the heights show that they are low: all of
            their connected cells, and the cells around them, are known and without an obstacle.
            Only for height maps that show everything that stands on the ground.

        Returns
        -------
        OccupancyGrid
            Occupied where a cell shares some area with an obstacle of the ground, else as the
            map says; the map itself if that changes nothing.
        """
        high = cells_touched(self.heights, self.obstacles, grid)
        low = self._low(grid, occupied_threshold, high) if steps_over_low else None
        if not high.any() and (low is None or not low.any()):
            return grid
        cells = np.where(high, np.int8(OCCUPIED), grid.cells)
        if low is not None:
            cells[low] = FREE
        return OccupancyGrid(cells, grid.resolution, grid.origin)

    def _low(self, grid: OccupancyGrid, occupied_threshold: int, high: Mask) -> Mask:
        """Find obstacles of the map that are low."""
        # Imported late, as only a height map needs it: it takes a good part of a node's start.
        from scipy import ndimage

        occupied = grid.occupied(occupied_threshold)
        doubtful = high | cells_touched(self.heights, np.isnan(self.heights.heights), grid)
        rows, columns = np.nonzero(occupied)
        centers = np.column_stack((columns, rows)).astype(np.float64) + 0.5
        x, y = grid.map_to_world(centers).T
        # The box around a cell and the cells around it.
        yaw = grid.origin.yaw
        reach = (1.5 - EPSILON) * grid.resolution * (abs(math.cos(yaw)) + abs(math.sin(yaw)))
        x_min, y_min, x_max, y_max = self.heights.bounds
        beyond = (x - reach < x_min) | (x + reach > x_max)
        beyond |= (y - reach < y_min) | (y + reach > y_max)
        doubtful = np.asarray(ndimage.binary_dilation(doubtful, _AROUND))
        doubtful[rows[beyond], columns[beyond]] = True
        labels, count = ndimage.label(occupied, _AROUND)
        is_low = np.ones(count + 1, dtype=bool)
        is_low[0] = False
        is_low[labels[doubtful]] = False
        return np.asarray(is_low[labels])
