"""
Loops over the places of a lattice: how high they are, and where the nearest foothold is.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop

Array = NDArray[np.float64]
Bits = NDArray[np.uint64]
Integers = NDArray[np.int64]

_ONE = np.uint64(1)


@compiled_loop
def sample_heights(image: Array, columns: Array, rows: Array, heights: Array) -> None:
    """
    Interpolate the heights of places, as :meth:`HeightMap.height_at` does, and bit for bit so.

    Parameters
    ----------
    image : ndarray, shape (n, m)
        Heights of the cells' centers, NaN where they are not known [m].
    columns, rows : ndarray, shape (k,) and (l,)
        Columns and rows of the places, with fractions; on the map.
    heights : ndarray, shape (l, k)
        Is filled; NaN where the place's own cell is not known [m].
    """
    last_row, last_column = image.shape[0] - 1, image.shape[1] - 1
    for j in range(len(rows)):
        own_row = min(math.floor(rows[j]), last_row)
        y = min(max(rows[j] - 0.5, 0.0), float(last_row))
        bottom = min(math.floor(y), max(last_row - 1, 0))
        top = min(bottom + 1, last_row)
        v = y - bottom
        for i in range(len(columns)):
            own_column = min(math.floor(columns[i]), last_column)
            x = min(max(columns[i] - 0.5, 0.0), float(last_column))
            left = min(math.floor(x), max(last_column - 1, 0))
            right = min(left + 1, last_column)
            u = x - left
            total = weights = 0.0
            for k in range(4):
                row, column = (bottom, left) if k == 0 else (top, left)
                weight = (1.0 - u) * (1.0 - v) if k == 0 else (1.0 - u) * v
                if k >= 2:
                    row, column = (bottom, right) if k == 2 else (top, right)
                    weight = u * (1.0 - v) if k == 2 else u * v
                value = image[row, column]
                if not math.isnan(value):
                    total += weight * value
                    weights += weight
            is_known = weights > 0.0 and not math.isnan(image[own_row, own_column])
            heights[j, i] = total / weights if is_known else math.nan


@compiled_loop
def find_free(cells: Array, highest: Array, images: Array, shins: Array, free: Bits) -> None:
    """
    Tell on which even places nothing beside foot and shin is higher than they are.

    It is :func:`quad_common.footing.fit_places.find_fit` for all legs and headings, and looks only
    at points of shins that are lower than the highest ground around.

    Parameters
    ----------
    cells : ndarray, shape (n, 2)
        Column and row of the places, with fractions.
    highest : ndarray, shape (n,)
        Height that no ground within reach of any shin exceeds [m].
    images : ndarray, shape (4, rows, columns)
        As for `find_fit` [m].
    shins : ndarray, shape (k, m, 3)
        Points of foot and shin of each leg at each heading, 64 at most, the lowest point first,
        infinitely high ones at the end: columns, rows, and height [m].
    free : ndarray of uint64, shape (n,)
        Bit k of each place is filled in.
    """
    rows, columns = images.shape[1:]
    for n in range(len(cells)):
        x, y = cells[n, 0], cells[n, 1]
        row, column = math.floor(y), math.floor(x)
        own, drop = images[0, row, column], images[0, row, column] - images[3, row, column]
        bits = np.uint64(0)
        for k in range(len(shins)):
            is_free = drop <= shins[k, 0, 2]
            for m in range(shins.shape[1]):
                height = own + shins[k, m, 2]
                if not is_free or height > highest[n]:
                    break
                u, v = math.floor(x + shins[k, m, 0]), math.floor(y + shins[k, m, 1])
                is_on_map = u >= 0 and v >= 0 and u < columns and v < rows
                # What is not known is in nobody's way.
                is_free = not (is_on_map and images[2, v, u] > height)
            if is_free:
                bits |= _ONE << np.uint64(k)
        free[n] = bits


@compiled_loop
def find_nearest(
    fit: Bits, places: Integers, offsets: Integers, nearest: NDArray[np.int32]
) -> None:
    """
    Find the nearest foothold to some places, for all legs and headings.

    Parameters
    ----------
    fit : ndarray of uint64, shape (rows, columns)
        Bit k tells whether a leg may stand at a place with a heading.
    places : ndarray, shape (n,)
        Indices of the places to look at.
    offsets : ndarray, shape (m, 2)
        Rows and columns to the places within reach, the nearest first, (0, 0) to begin with.
    nearest : ndarray, shape (k, rows, columns)
        Index of the foothold is filled in, -1 where there is none within reach.
    """
    rows, columns = fit.shape
    count = len(nearest)
    for n in range(len(places)):
        row, column = places[n] // columns, places[n] % columns
        left = (_ONE << np.uint64(count)) - _ONE
        for m in range(len(offsets)):
            i, j = row + offsets[m, 0], column + offsets[m, 1]
            if i < 0 or j < 0 or i >= rows or j >= columns:
                continue
            found = left & fit[i, j]
            if found == 0:
                continue
            left &= ~found
            for k in range(count):
                if (found >> np.uint64(k)) & _ONE:
                    nearest[k, row, column] = i * columns + j
            if left == 0:
                break
        for k in range(count):
            if (left >> np.uint64(k)) & _ONE:
                nearest[k, row, column] = -1
