"""
Loops over places where feet may stand.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled

Array = NDArray[np.float64]


@compiled
def find_fit(
    cells: Array, images: Array, shin: Array, largest_step: float, fit: NDArray[np.uint8]
) -> None:
    """
    Tell on which places a foot may stand.

    Around it heights differ by little; nothing beside foot and shin is higher than they are, and
    nothing near the foot so much deeper that it would slip off.

    Parameters
    ----------
    cells : ndarray, shape (n, 2)
        Column and row of the places, with fractions.
    images : ndarray, shape (4, rows, columns)
        Heights, differences of heights around a foot, and the highest and the lowest ground near a
        point of a shin; NaN where nothing is known [m].
    shin : ndarray, shape (m, 3)
        Points of foot and shin, from the place: columns, rows, and height [m].
    largest_step : float
        Differences of heights that do not matter [m].
    fit : ndarray, shape (n,)
        Is filled.
    """
    rows, columns = images.shape[1:]
    lowest_point = math.inf
    for k in range(len(shin)):
        lowest_point = min(lowest_point, shin[k, 2])
    for index in range(len(cells)):
        fit[index] = 0
        column, row = math.floor(cells[index, 0]), math.floor(cells[index, 1])
        if column < 0 or row < 0 or column >= columns or row >= rows:
            continue
        own = images[0, row, column]
        if not images[1, row, column] <= largest_step or math.isnan(own):
            continue
        if own - images[3, row, column] > lowest_point:
            continue
        is_free = True
        for k in range(len(shin)):
            u = math.floor(cells[index, 0] + shin[k, 0])
            v = math.floor(cells[index, 1] + shin[k, 1])
            if u < 0 or v < 0 or u >= columns or v >= rows:
                continue
            # What is not known is in nobody's way.
            if images[2, v, u] > own + shin[k, 2]:
                is_free = False
                break
        if is_free:
            fit[index] = 1
