"""
The world around the robot: a flat ground and obstacles extruded from a map.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.occupancy_grid import OccupancyGrid

Array = NDArray[np.float64]


@dataclass(frozen=True)
class World:
    """Ground at z = 0, and boxes standing on it."""

    boxes: Array
    """Corner points of each box's base, counter-clockwise, shape (n, 4, 2) [m]."""
    obstacle_height: float = 0.5
    """[m]"""
    friction: float = 0.8
    """Coulomb friction between feet and ground."""


def world_from_map(
    grid: OccupancyGrid | None, obstacle_height: float = 0.5, friction: float = 0.8
) -> World:
    """
    Extrude a map's occupied cells.

    Parameters
    ----------
    grid : OccupancyGrid or None
        The map; None for an empty floor. Unknown cells become no obstacles.
    obstacle_height : float
        Height of the obstacles [m].
    friction : float
        Coulomb friction between feet and ground.

    Returns
    -------
    World
        With the occupied cells merged into as few boxes as rows of equal runs allow.
    """
    if grid is None:
        return World(np.empty((0, 4, 2)), obstacle_height, friction)
    cells = merge_cells(grid.occupied())
    x0, y0, x1, y1 = (cells[:, k].astype(float) for k in range(4))
    corners = np.stack(
        [np.stack(pair, axis=-1) for pair in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))], axis=1
    )
    return World(grid.map_to_world(corners), obstacle_height, friction)


def merge_cells(occupied: NDArray[np.bool_]) -> NDArray[np.int64]:
    """
    Cover the true cells of a grid exactly with rectangles.

    Runs of cells in a row are merged with equal runs in the row above.

    Parameters
    ----------
    occupied : ndarray of bool, shape (height, width)
        The cells to cover.

    Returns
    -------
    ndarray of int, shape (n, 4)
        First column, first row, and the column and row after the last, of each rectangle.
    """
    padded = np.pad(occupied.astype(np.int8), ((0, 0), (1, 1)))
    edges = np.diff(padded, axis=1)
    starts = np.argwhere(edges == 1)
    ends = np.argwhere(edges == -1)
    rectangles: list[tuple[int, int, int, int]] = []
    growing: dict[tuple[int, int], int] = {}
    previous = -1
    rows, offsets = np.unique(starts[:, 0], return_index=True)
    for row, runs in zip(rows, np.split(np.column_stack([starts[:, 1], ends[:, 1]]), offsets[1:])):
        if row != previous + 1:
            rectangles += [(x0, y0, x1, previous + 1) for (x0, x1), y0 in growing.items()]
            growing = {}
        here = {(int(x0), int(x1)) for x0, x1 in runs}
        for run in [run for run in growing if run not in here]:
            rectangles.append((run[0], growing.pop(run), run[1], previous + 1))
        for run in here:
            growing.setdefault(run, int(row))
        previous = int(row)
    rectangles += [(x0, y0, x1, previous + 1) for (x0, x1), y0 in growing.items()]
    return np.array(sorted(rectangles), dtype=np.int64).reshape(-1, 4)
