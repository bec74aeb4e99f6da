"""
The obstacles of a map and of its inflation, for people to see.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_planner.grid.array_types import Mask, Points


@dataclass(frozen=True, eq=False)
class CombinedObstacles:
    """Obstacles with their boundaries; those too near each other have become one (S0)."""

    count: int
    """Number of combined obstacles."""
    labels: NDArray[np.int32]
    """
    Numbers of the obstacles, shape (height, width): 1 to `count` in a combined obstacle, 0 in the
    allowed zone.
    """
    outlines: tuple[Points, ...]
    """
    Closed lines, each of shape (n, 2), in the world [m], through the centers of the
    outermost forbidden cells: around each obstacle, and along each hole in it.
    """


def combined_obstacles(grid: OccupancyGrid, forbidden: Mask) -> CombinedObstacles:
    """
    Join the obstacles between which the robot does not fit.

    Parameters
    ----------
    grid : OccupancyGrid
        The map.
    forbidden : ndarray of bool, shape (height, width)
        The forbidden zone, from `inflate`.

    Returns
    -------
    CombinedObstacles
        The connected parts of the forbidden zone and the lines around them.
    """
    # Imported late: plans can do without.
    import cv2

    image = forbidden.astype(np.uint8)
    count, labels = cv2.connectedComponents(image, connectivity=8)
    contours, _ = cv2.findContours(image, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    outlines = tuple(
        grid.map_to_world(contour.reshape(-1, 2).astype(float) + 0.5) for contour in contours
    )
    return CombinedObstacles(int(count) - 1, labels.astype(np.int32), outlines)
