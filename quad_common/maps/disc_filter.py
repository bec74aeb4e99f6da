"""
The highest and the lowest value within a radius of each cell of an image.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_SMALL = 2**18
"""An image of so many cells is looked at as a whole."""

_TILE = 128
"""Side of a part of a larger one [cells]."""


def disc_extremes(image: Array, reach: float) -> tuple[Array, Array]:
    """
    Return the highest and the lowest value within a radius of each cell.

    A disc is made of runs of cells, one in each row: extremes of runs of one length are found for
    all cells at once, and the time grows with the radius, not with the disc's area.

    Parameters
    ----------
    image : ndarray, shape (rows, columns)
        NaN where nothing is known.
    reach : float
        Radius of the disc around a cell's center; a cell counts if a part of it lies in the
        disc [cells].

    Returns
    -------
    tuple of ndarray, shape (rows, columns)
        Unknown cells do not count; NaN where all are unknown.
    """
    # Imported late: it takes longer than all else that a node imports, and few need it.
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    unknown = np.isnan(image)
    runs = _runs(reach)
    images = []
    for extreme, filtered, nothing in (
        (np.maximum, maximum_filter1d, -math.inf),
        (np.minimum, minimum_filter1d, math.inf),
    ):
        known = np.where(unknown, nothing, image)
        found = np.full(image.shape, nothing)
        for length in sorted(set(runs)):
            along = filtered(known, 2 * length + 1, axis=1, mode='constant', cval=nothing)
            for away in (row for row, run in enumerate(runs) if run == length):
                if away >= len(image):
                    break
                for to, of in ((away, 0), (0, away)):
                    rows = found[to : len(image) - of]
                    extreme(rows, along[of : len(image) - to], out=rows)
        found[np.isinf(found)] = math.nan
        images.append(found)
    return images[0], images[1]


def _runs(reach: float) -> list[int]:
    """Return how far the disc reaches to each side in its rows, from the middle one on."""
    side = np.arange(math.ceil(reach) + 1)
    apart = np.maximum(side - 0.5, 0.0)
    disc = np.hypot(apart[:, None], apart) <= reach
    return [int(count) - 1 for count in disc.sum(axis=1) if count]


class DiscExtremes:
    """
    The highest and the lowest value around cells of an image, each found once it is needed.

    Parameters
    ----------
    image : ndarray, shape (rows, columns)
        NaN where nothing is known.
    """

    def __init__(self, image: Array) -> None:
        self._image = image
        self._whole: dict[float, tuple[Array, Array]] = {}
        self._tiles: dict[tuple[float, int, int], tuple[Array, Array]] = {}

    def whole(self, reach: float) -> tuple[Array, Array]:
        """Return them for all cells, shape (rows, columns); see :func:`disc_extremes`."""
        if reach not in self._whole:
            self._whole[reach] = disc_extremes(self._image, reach)
        return self._whole[reach]

    def at(self, rows: Indices, columns: Indices, reach: float) -> tuple[Array, Array]:
        """
        Return them for some cells.

        A robot asks for what is around its feet: of a large image only the tiles are looked at in
        which those cells lie.

        Parameters
        ----------
        rows, columns : ndarray of int, shape (...)
            The cells.
        reach : float
            Radius [cells].

        Returns
        -------
        tuple of ndarray, shape (...)
            As of :func:`disc_extremes`.
        """
        if self._image.size <= _SMALL or reach in self._whole:
            highest, lowest = self.whole(reach)
            return highest[rows, columns], lowest[rows, columns]
        tile_rows, tile_columns = rows // _TILE, columns // _TILE
        found = np.empty(rows.shape), np.empty(rows.shape)
        across = 1 + self._image.shape[1] // _TILE
        for tile in np.unique(tile_rows * across + tile_columns).tolist():
            row, column = divmod(tile, across)
            inside = (tile_rows == row) & (tile_columns == column)
            place = rows[inside] - row * _TILE, columns[inside] - column * _TILE
            for values, image in zip(found, self._tile(row, column, reach), strict=True):
                values[inside] = image[place]
        return found

    def _tile(self, row: int, column: int, reach: float) -> tuple[Array, Array]:
        key = reach, row, column
        if key not in self._tiles:
            margin = math.ceil(reach)
            first, left = (max(0, index * _TILE - margin) for index in (row, column))
            last, right = ((index + 1) * _TILE + margin for index in (row, column))
            around = disc_extremes(self._image[first:last, left:right], reach)
            top, side = row * _TILE - first, column * _TILE - left
            highest, lowest = (
                image[top : top + _TILE, side : side + _TILE].copy() for image in around
            )
            self._tiles[key] = highest, lowest
        return self._tiles[key]
