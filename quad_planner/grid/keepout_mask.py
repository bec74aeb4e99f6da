"""
Zones that a robot has to keep out of, or had better avoid, whatever the map says.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid

_ROWS = 256
"""Rows of a map that are looked up at a time."""


class KeepoutMask:
    """
    A mask over maps; it may have another resolution and lie elsewhere than they.

    Parameters
    ----------
    mask : OccupancyGrid
        Cells above 0 raise the map's to their value; those that are free or unknown, and what lies
        outside of the mask, leave the map as it is.
    """

    def __init__(self, mask: OccupancyGrid) -> None:
        self.mask = mask
        """The mask as it was received."""
        self._looked_up: tuple[OccupancyGrid, NDArray[np.int8]] | None = None

    def added_to(self, grid: OccupancyGrid) -> OccupancyGrid:
        """Return a map with each cell raised to the mask's value at its center."""
        if self._looked_up is None or not grid.is_aligned_with(self._looked_up[0]):
            self._looked_up = grid, self._values_on(grid)
        return replace(grid, cells=np.maximum(grid.cells, self._looked_up[1]))

    def _values_on(self, grid: OccupancyGrid) -> NDArray[np.int8]:
        cells = np.where(self.mask.cells > FREE, self.mask.cells, np.int8(UNKNOWN))
        if grid.is_aligned_with(self.mask):
            return cells
        values = np.full(grid.cells.shape, UNKNOWN, dtype=np.int8)
        columns = np.arange(grid.width) + 0.5
        for first in range(0, grid.height, _ROWS):
            rows = np.arange(first, min(first + _ROWS, grid.height)) + 0.5
            centers = np.stack(np.meshgrid(columns, rows), axis=-1)
            places = np.floor(self.mask.world_to_map(grid.map_to_world(centers))).astype(np.int64)
            x, y = places[..., 0], places[..., 1]
            is_on = (x >= 0) & (x < self.mask.width) & (y >= 0) & (y < self.mask.height)
            values[first : first + len(rows)][is_on] = cells[y[is_on], x[is_on]]
        return values


def with_discs(grid: OccupancyGrid, discs: Iterable[tuple[float, float, float]]) -> OccupancyGrid:
    """
    Occupy discs of a map.

    Parameters
    ----------
    grid : OccupancyGrid
        The map.
    discs : iterable of tuple
        x, y and radius of each in the world [m].

    Returns
    -------
    OccupancyGrid
        The map in which every cell whose center is in a disc is occupied.
    """
    cells = grid.cells.copy()
    for x, y, radius in discs:
        middle = grid.world_to_map(np.array([x, y]))
        reach = radius / grid.resolution
        low = np.maximum(np.floor(middle - reach), 0.0).astype(int)
        high = np.minimum(np.ceil(middle + reach) + 1.0, (grid.width, grid.height)).astype(int)
        columns, rows = (np.arange(a, b) for a, b in zip(low, high))
        if columns.size and rows.size:
            apart = np.hypot(columns[None] + 0.5 - middle[0], rows[:, None] + 0.5 - middle[1])
            window = cells[low[1] : high[1], low[0] : high[0]]
            window[apart <= reach] = OCCUPIED
    return OccupancyGrid(cells, grid.resolution, grid.origin)
