"""
The height map: how high the ground is, cell by cell.

Its cells lie as those of an :class:`quad_common.maps.occupancy_grid.OccupancyGrid` that is not
turned: row 0 at the bottom, columns along the world's x axis. Each height is that of its
cell's center; between the centers it is interpolated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from quad_common.errors import (
    CellCountOutOfRange,
    MapArrayInvalid,
    MapBoundsUnusable,
    MapOriginInvalid,
    MapValueOutOfRange,
    OutOfRange,
    ParameterError,
)
from quad_common.maps.disc_filter import DiscExtremes
from quad_common.quantity import CELL_SIZE, COORDINATE, Quantity

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

MAX_CELLS = 2**22
"""The largest height map that is taken: 40 m square with cells of 0.02 m."""

MAX_REACH = 100
"""The largest radius of what is looked at around a point [cells]."""

HEIGHT = Quantity(-1e4, 1e4, 'm')
"""Range of the ground's height."""

_WHERE = 'the height map cannot be used: '


@dataclass(frozen=True, eq=False)
class HeightMap:
    """
    Heights of the ground and their place in the world.

    Raises
    ------
    MapError
        If a field is not what its description says.
    """

    heights: Array
    """Heights of the cells' centers, shape (rows, columns), row 0 lowest; NaN: unknown [m]."""
    resolution: float
    """Side of a cell, in the range of :data:`quantity.CELL_SIZE` [m]."""
    origin: tuple[float, float]
    """Lower left corner of cell (0, 0), x and y in the world [m]."""

    def __post_init__(self) -> None:
        """Refuse what is not a height map, and make the heights read-only."""
        heights = self.heights
        if (
            not isinstance(heights, np.ndarray)
            or heights.ndim != 2
            or not np.issubdtype(heights.dtype, np.floating)
        ):
            raise MapArrayInvalid.of('the heights of a height map', 'floats', heights)
        rows, columns = heights.shape
        if not 0 < heights.size <= MAX_CELLS:
            raise CellCountOutOfRange('the height map', columns, rows, MAX_CELLS)
        self._check_place()
        outside = np.abs(heights) > HEIGHT.upper
        if outside.any():
            worst = heights.flat[int(np.argmax(outside))]
            raise MapValueOutOfRange(
                'height', float(worst), HEIGHT.lower, HEIGHT.upper, HEIGHT.unit, _WHERE
            )
        heights = heights.astype(np.float64)
        heights.flags.writeable = False
        object.__setattr__(self, 'heights', heights)
        object.__setattr__(self, 'resolution', float(self.resolution))
        object.__setattr__(self, 'origin', (float(self.origin[0]), float(self.origin[1])))

    def _check_place(self) -> None:
        """Refuse cells of no sensible size, or an origin out of this world."""
        if len(self.origin) != 2:
            raise MapOriginInvalid(self.origin)
        try:
            CELL_SIZE.check('resolution', self.resolution)
            for name, value in zip(('origin.x', 'origin.y'), self.origin, strict=True):
                COORDINATE.check(name, value)
        except OutOfRange as error:
            raise error.at(_WHERE, MapValueOutOfRange) from error

    @classmethod
    def level(
        cls, bounds: tuple[float, float, float, float], resolution: float, height: float = 0.0
    ) -> HeightMap:
        """
        Make a level height map.

        Parameters
        ----------
        bounds : tuple of float
            What it spans at least: x_min, y_min, x_max, y_max [m].
        resolution : float
            Side of a cell [m].
        height : float
            Everywhere [m].

        Returns
        -------
        HeightMap
            With its lower left corner in that of the bounds.
        """
        x_min, y_min, x_max, y_max = bounds
        sides = [x_max - x_min, y_max - y_min]
        if not (resolution > 0.0 and all(0.0 < side < math.inf for side in sides)):
            raise MapBoundsUnusable('a height map', bounds, resolution, MAX_CELLS)
        columns, rows = (math.ceil(side / resolution - 1e-9) for side in sides)
        if columns * rows > MAX_CELLS:
            raise CellCountOutOfRange('the height map', columns, rows, MAX_CELLS)
        return cls(np.full((rows, columns), height), resolution, (x_min, y_min))

    def with_heights(self, heights: Array) -> HeightMap:
        """Return a height map of the same cells with other heights [m]."""
        return HeightMap(heights, self.resolution, self.origin)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return int(self.heights.shape[0])

    @property
    def columns(self) -> int:
        """Number of columns."""
        return int(self.heights.shape[1])

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """What it spans: x_min, y_min, x_max, y_max [m]."""
        x, y = self.origin
        return x, y, x + self.columns * self.resolution, y + self.rows * self.resolution

    @property
    def centers(self) -> Array:
        """Centers of the cells, x and y in the world, shape (rows, columns, 2) [m]."""
        x = self.origin[0] + (np.arange(self.columns) + 0.5) * self.resolution
        y = self.origin[1] + (np.arange(self.rows) + 0.5) * self.resolution
        return np.stack(np.meshgrid(x, y), axis=-1)

    def contains(self, points: ArrayLike) -> Mask:
        """
        Tell which points lie on the map; its border does.

        Parameters
        ----------
        points : array_like, shape (..., 2)
            x and y in the world [m].

        Returns
        -------
        ndarray of bool, shape (...)
        """
        return self._holds(self._cells(points))

    def height_at(self, points: ArrayLike, beyond: float = math.nan) -> Array:
        """
        Return how high the ground is.

        Parameters
        ----------
        points : array_like, shape (..., 2)
            x and y in the world [m].
        beyond : float
            What is returned off the map and in unknown cells [m].

        Returns
        -------
        ndarray, shape (...)
            Interpolated linearly in x and in y between the centers of the cells; of the nearest
            center in the outer half of a cell at the border. Where a neighbour is unknown, the
            known ones count alone [m].
        """
        heights = self._sample(self.heights, points)
        return np.where(np.isnan(heights), beyond, heights)

    def slope_at(self, points: ArrayLike) -> Array:
        """
        Return how steeply the ground rises.

        Parameters
        ----------
        points : array_like, shape (..., 2)
            x and y in the world [m].

        Returns
        -------
        ndarray, shape (..., 2)
            Slopes along x and along y [m/m]: differences over two cells, over one beside what is
            unknown; NaN off the map and where nothing is known.
        """
        return np.stack([self._sample(image, points) for image in self._gradient], axis=-1)

    def highest_within(self, points: ArrayLike, radius: float) -> Array:
        """
        Return the largest height near points, for example for a foot that sweeps over them.

        Parameters
        ----------
        points : array_like, shape (..., 2)
            x and y in the world [m].
        radius : float
            How near, to :data:`MAX_REACH` cells; the disc is around the center of a point's cell,
            and a cell counts if a part of it lies in the disc [m].

        Returns
        -------
        ndarray, shape (...)
            Unknown cells do not count; NaN off the map and where all are unknown [m].
        """
        return self._near(points, radius)[0]

    def lowest_within(self, points: ArrayLike, radius: float) -> Array:
        """Return the smallest height near points; see :meth:`highest_within`."""
        return self._near(points, radius)[1]

    def step_at(self, points: ArrayLike, radius: float) -> Array:
        """Return by how much heights differ near points [m]; see :meth:`highest_within`."""
        highest, lowest = self._near(points, radius)
        return highest - lowest

    def steps(self, radius: float) -> Array:
        """
        Return by how much heights differ within a radius of each cell.

        Parameters
        ----------
        radius : float
            [m]

        Returns
        -------
        ndarray, shape (rows, columns)
            Highest less lowest, as in :meth:`highest_within` [m].
        """
        highest, lowest = self.extremes(radius)
        return highest - lowest

    def _cells(self, points: ArrayLike) -> Array:
        """Column and row of points, with fractions, shape (..., 2)."""
        cells: Array = (np.asarray(points, dtype=float) - self.origin) / self.resolution
        return cells

    def _holds(self, cells: Array) -> Mask:
        """Tell which columns and rows, with fractions, are on the map."""
        size = self.columns, self.rows
        inside: Mask = np.all((cells >= 0.0) & (cells <= size), axis=-1)
        return inside

    def _near(self, points: ArrayLike, radius: float) -> tuple[Array, Array]:
        """Return the highest and the lowest near points, shape (...); NaN off the map [m]."""
        column, row, inside = self._indices(self._cells(points))
        highest, lowest = self._discs.at(row, column, self._reach(radius))
        return np.where(inside, highest, math.nan), np.where(inside, lowest, math.nan)

    def _indices(self, cells: Array) -> tuple[Indices, Indices, Mask]:
        """Whole columns and rows of places in cells, and whether there is such a cell."""
        inside = self._holds(cells)
        floor = np.floor(np.where(inside[..., None], cells, 0.0)).astype(np.int64)
        column = np.minimum(floor[..., 0], self.columns - 1)
        row = np.minimum(floor[..., 1], self.rows - 1)
        return column, row, inside

    def _sample(self, image: Array, points: ArrayLike) -> Array:
        """Interpolate an image; NaN off the map and in cells where the image is NaN."""
        cells = self._cells(points)
        own_column, own_row, inside = self._indices(cells)
        last = np.array([self.columns - 1, self.rows - 1])
        at = np.where(inside[..., None], cells, 0.5) - 0.5
        at = np.clip(at, 0.0, last)
        low = np.minimum(np.floor(at).astype(np.int64), np.maximum(last - 1, 0))
        high = np.minimum(low + 1, last)
        part = at - low
        total = np.zeros(inside.shape)
        weights = np.zeros(inside.shape)
        for column, u in ((low[..., 0], 1.0 - part[..., 0]), (high[..., 0], part[..., 0])):
            for row, v in ((low[..., 1], 1.0 - part[..., 1]), (high[..., 1], part[..., 1])):
                value = image[row, column]
                is_known = ~np.isnan(value)
                weight = np.where(is_known, u * v, 0.0)
                total += weight * np.where(is_known, value, 0.0)
                weights += weight
        is_known = inside & ~np.isnan(image[own_row, own_column]) & (weights > 0.0)
        return np.where(is_known, total / np.where(is_known, weights, 1.0), math.nan)

    @cached_property
    def _gradient(self) -> tuple[Array, Array]:
        """Rise along x and along y at the cells' centers, shape (rows, columns) each."""
        along_x = _differences(self.heights) / self.resolution
        along_y = _differences(self.heights.T).T / self.resolution
        return along_x, along_y

    def extremes(self, radius: float) -> tuple[Array, Array]:
        """
        Return the highest and the lowest height within a radius of each cell.

        Parameters
        ----------
        radius : float
            [m]

        Returns
        -------
        tuple of ndarray, shape (rows, columns)
            As :meth:`highest_within` and :meth:`lowest_within` at their centers [m].
        """
        return self._discs.whole(self._reach(radius))

    def _reach(self, radius: float) -> float:
        """Return a radius in cells; ParameterError if it is not from 0 to the largest."""
        reach = float(radius) / self.resolution
        if not 0.0 <= reach <= MAX_REACH:
            raise ParameterError(
                'radius', radius, f'from 0 to {MAX_REACH * self.resolution:g} m, {MAX_REACH} cells'
            )
        return reach

    @cached_property
    def _discs(self) -> DiscExtremes:
        """Highest and lowest within a radius of each cell, as far as they have been needed."""
        return DiscExtremes(self.heights)


def _differences(heights: Array) -> Array:
    """Rise from column to column: over two of them, over one at an edge; NaN if there is none."""
    steps = np.pad(np.diff(heights, axis=1), ((0, 0), (1, 1)), constant_values=math.nan)
    before, after = steps[:, :-1], steps[:, 1:]
    rise: Array = np.where(
        np.isnan(before), after, np.where(np.isnan(after), before, (before + after) / 2.0)
    )
    return rise
