"""
A map that changes only where several pictures in a row agree.

One picture's noise makes cells flicker, and every change makes a planner plan again.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import ParameterError
from quad_common.maps.occupancy_grid import OccupancyGrid


class SteadyMap:
    """
    What the last pictures agree on.

    Parameters
    ----------
    confirmations : int
        A cell changes when so many pictures in a row show it as the same other thing, >= 1.
    """

    def __init__(self, confirmations: int) -> None:
        if confirmations < 1:
            raise ParameterError('confirmations', confirmations, 'at least 1')
        self._confirmations = confirmations
        self._grid: OccupancyGrid | None = None
        self._wanted: NDArray[np.int8] | None = None
        self._counts: NDArray[np.int32] | None = None

    @property
    def grid(self) -> OccupancyGrid | None:
        """The map; None before the first picture."""
        return self._grid

    def add(self, seen: OccupancyGrid) -> bool:
        """
        Take what a picture shows.

        Parameters
        ----------
        seen : OccupancyGrid
            Of the picture. One of another size or place starts over.

        Returns
        -------
        bool
            Whether the map has changed.
        """
        grid, wanted, counts = self._grid, self._wanted, self._counts
        if grid is None or wanted is None or counts is None or not seen.is_aligned_with(grid):
            self._grid = seen
            self._wanted = seen.cells.copy()
            self._counts = np.zeros(seen.cells.shape, dtype=np.int32)
            return True
        counts[seen.cells != wanted] = 0
        np.copyto(wanted, seen.cells)
        counts += 1
        changed = (wanted != grid.cells) & (counts >= self._confirmations)
        if not changed.any():
            return False
        cells = np.where(changed, wanted, grid.cells).astype(np.int8)
        self._grid = OccupancyGrid(cells, grid.resolution, grid.origin)
        return True
