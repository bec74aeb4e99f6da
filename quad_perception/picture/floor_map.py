"""
The map of the floor: occupied where obstacles stand, free where the floor is seen.

What is not seen is unknown: behind obstacles, outside the picture, and under things of a
color that is neither an obstacle's nor the floor's. Where the robot may cover the floor
the map keeps what was known before; of the rest of it, what is seen as floor is free.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from quad_perception.picture.floor_view import FloorView, Mask
from quad_perception.picture.footprints import Footprint

_MOST = 0.5
"""Fraction of a cell that must show something for the cell to be it."""
_STILL = 0.3
"""Fraction of a cell that keeps it what it was."""


def floor_map(
    view: FloorView,
    floor: Mask,
    footprints: Sequence[Footprint],
    robot: Mask | None = None,
    previous: OccupancyGrid | None = None,
) -> OccupancyGrid:
    """
    Put a map together.

    Parameters
    ----------
    view : FloorView
        Camera and plan.
    floor : ndarray of uint8, shape of the plan
        255 where the floor is seen.
    footprints : sequence of Footprint
        The obstacles.
    robot : ndarray of uint8, shape of the plan, optional
        255 where the robot may cover the floor.
    previous : OccupancyGrid, optional
        What was known before; used if it has the same cells.

    Returns
    -------
    OccupancyGrid
        0, 100 or -1 in each cell.
    """
    occupied = np.zeros(view.seen.shape, np.uint8)
    for footprint in footprints:
        column, row = footprint.corner
        height, width = footprint.mask.shape
        part = occupied[row : row + height, column : column + width]
        np.maximum(part, footprint.mask, out=part)
    cells = np.full(view.shape, UNKNOWN, np.int8)
    before: NDArray[np.int8] = cells.copy()
    if previous is not None and previous.is_aligned_with(
        OccupancyGrid(cells, view.resolution, view.origin)
    ):
        before = previous.cells
    # Noise makes fractions near one half go to and fro, and each change is a new plan.
    cells[view.fraction_of_cells(floor) >= np.where(before == FREE, _STILL, _MOST)] = FREE
    if robot is not None:
        # A part of the robot that has the floor's color makes no obstacle vanish.
        kept = (view.fraction_of_cells(robot) > 0.0) & (before != UNKNOWN)
        cells[kept] = before[kept]
    stands = view.fraction_of_cells(occupied) >= np.where(before == OCCUPIED, _STILL, _MOST)
    cells[stands] = OCCUPIED
    return OccupancyGrid(cells, view.resolution, view.origin)
