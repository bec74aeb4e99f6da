"""
New values of a rectangle of a map's cells.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import InvalidMessage
from quad_common.maps.occupancy_grid import OccupancyGrid


@dataclass(frozen=True, eq=False)
class GridUpdate:
    """A rectangle of cells, and their new values."""

    column: int
    """Column of its first cell."""
    row: int
    """Row of its first cell."""
    values: NDArray[np.int8]
    """Occupancies, shape (height, width), row 0 at the bottom, as those of a map."""

    def applied_to(self, grid: OccupancyGrid) -> OccupancyGrid:
        """
        Return a map with these values.

        Parameters
        ----------
        grid : OccupancyGrid
            The map; it stays as it is.

        Returns
        -------
        OccupancyGrid
            The map after the update.

        Raises
        ------
        InvalidMessage
            If the rectangle is not within the map.
        MapError
            If a value is none of a map.
        """
        height, width = self.values.shape
        right, top = self.column + width, self.row + height
        if self.column < 0 or self.row < 0 or right > grid.width or top > grid.height:
            raise InvalidMessage(
                'map update',
                f'it spans columns {self.column} to {right - 1} and rows {self.row} to {top - 1}; '
                f'the map has {grid.width} columns and {grid.height} rows',
            )
        cells = grid.cells.copy()
        cells[self.row : top, self.column : right] = self.values
        return replace(grid, cells=cells)
