"""
The map: square cells that are free, occupied, or unknown.

Three frames meet here. *World*: the frame of the plan and the poses [m]. *Map*: the
frame of the grid's origin, at the lower left corner of cell (row 0, column 0), with
its x axis along the columns [m]. *Cells*: the map frame counted in cells, so that the
cell (row r, column c) is the square from (c, r) to (c + 1, r + 1). Row 0 is at the
bottom, as in ``nav_msgs/OccupancyGrid``; an image's first row is its top.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import (
    CellCountOutOfRange,
    CellValuesOutOfRange,
    MapArrayInvalid,
    MapValueOutOfRange,
    OutOfRange,
)
from quad_common.planar_pose import Pose2D
from quad_common.quantity import ANGLE, CELL_SIZE, COORDINATE

UNKNOWN = -1
FREE = 0
OCCUPIED = 100

OCCUPIED_THRESHOLD = 65
"""Cells of at least this value are obstacles, by ROS custom."""

MAX_CELLS = 2**28
"""The largest grid that is taken: a quarter of a gigabyte, 800 m square at 0.05 m."""


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """
    An occupancy grid and its place in the world.

    Raises
    ------
    MapError
        If a field is not what its description says.
    """

    cells: NDArray[np.int8]
    """
    Occupancies, shape (height, width), row 0 at the bottom: 0 (free) to 100 (occupied), -1 unknown.
    """
    resolution: float
    """Side of a cell, in the range of :data:`quantity.CELL_SIZE` [m]."""
    origin: Pose2D
    """Pose of the lower left corner of cell (0, 0) in the world [m, m, rad]."""

    def __post_init__(self) -> None:
        """Refuse what is not a map, and make the cells read-only."""
        self.check()
        cells = self.cells.view()
        # Prepared maps outlive the call that made them: they must not change below.
        cells.flags.writeable = False
        object.__setattr__(self, 'cells', cells)

    def check(self) -> None:
        """Raise `MapError` if a field is not what its description says."""
        cells = self.cells
        if not isinstance(cells, np.ndarray) or cells.ndim != 2 or cells.dtype != np.int8:
            raise MapArrayInvalid.of('the cells of a map', 'int8', cells)
        height, width = cells.shape
        if not 0 < cells.size <= MAX_CELLS:
            raise CellCountOutOfRange('the map', width, height, MAX_CELLS)
        try:
            CELL_SIZE.check('resolution', self.resolution)
            COORDINATE.check('origin.x', self.origin.x)
            COORDINATE.check('origin.y', self.origin.y)
            ANGLE.check('origin.yaw', self.origin.yaw)
        except OutOfRange as error:
            raise error.at('the map cannot be used: ', MapValueOutOfRange) from error
        lowest, highest = int(cells.min()), int(cells.max())
        if lowest < UNKNOWN or highest > OCCUPIED:
            raise CellValuesOutOfRange(lowest, highest)

    def is_aligned_with(self, other: OccupancyGrid) -> bool:
        """Return whether another grid has the same cells in the same place."""
        return (
            self.cells.shape == other.cells.shape
            and self.resolution == other.resolution
            and self.origin == other.origin
        )

    @property
    def width(self) -> int:
        """Number of columns."""
        return int(self.cells.shape[1])

    @property
    def height(self) -> int:
        """Number of rows."""
        return int(self.cells.shape[0])

    def world_to_map(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """
        Bring points of the world into cell coordinates.

        Parameters
        ----------
        points : ndarray, shape (..., 2)
            x and y in the world [m].

        Returns
        -------
        ndarray, shape (..., 2)
            Column and row, with fractions [cells]; their floor is the cell's index.
        """
        return self.origin.inverse().transform(points) / self.resolution

    def map_to_world(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """
        Bring cell coordinates into the world.

        Parameters
        ----------
        points : ndarray, shape (..., 2)
            Column and row [cells]; add one half to an index for the cell's center.

        Returns
        -------
        ndarray, shape (..., 2)
            x and y in the world [m].
        """
        return self.origin.transform(np.asarray(points, dtype=float) * self.resolution)

    def contains(self, x: float, y: float) -> bool:
        """Return whether a point of the world [m] lies on the map; its border does."""
        column, row = self.world_to_map(np.array([x, y]))
        return bool(0.0 <= column <= self.width and 0.0 <= row <= self.height)

    def bounds(self) -> tuple[float, float, float, float]:
        """
        Return the box, upright in the world, that the map just fits in.

        Returns
        -------
        x_min, y_min, x_max, y_max : float
            In the world [m].
        """
        w, h = self.width, self.height
        corners = self.map_to_world(np.array([[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]]))
        (x_min, y_min), (x_max, y_max) = corners.min(axis=0), corners.max(axis=0)
        return float(x_min), float(y_min), float(x_max), float(y_max)

    def occupied(self, threshold: int = OCCUPIED_THRESHOLD) -> NDArray[np.bool_]:
        """Return where the cells hold at least `threshold`, shape (height, width)."""
        mask: NDArray[np.bool_] = self.cells >= threshold
        return mask

    def unknown(self) -> NDArray[np.bool_]:
        """Return where nothing is known, shape (height, width)."""
        mask: NDArray[np.bool_] = self.cells == UNKNOWN
        return mask
