"""
Choice of one foothold of many.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled


@compiled
def keep_best(fit: NDArray[np.uint8], block: int, best: NDArray[np.uint8]) -> None:
    """
    Keep one cell of each square: that with the most others around it on which the foot may stand.

    Parameters
    ----------
    fit : ndarray, shape (4, rows, columns)
        Whether a leg's foot may stand on a cell.
    block : int
        Side of the squares [cells].
    best : ndarray, shape (4, rows, columns)
        Zeros; ones are filled in.
    """
    _, rows, columns = fit.shape
    for leg in range(4):
        for top in range(0, rows, block):
            for left in range(0, columns, block):
                most, row, column = -1.0, -1, -1
                for i in range(top, min(top + block, rows)):
                    for j in range(left, min(left + block, columns)):
                        if fit[leg, i, j] == 0:
                            continue
                        room = 0.0
                        for u in range(max(0, i - 2), min(rows, i + 3)):
                            for v in range(max(0, j - 2), min(columns, j + 3)):
                                room += fit[leg, u, v]
                        # Of equals that nearest to the middle of the square.
                        off = math.hypot(i - top - 0.5 * (block - 1), j - left - 0.5 * (block - 1))
                        room -= 0.01 * off
                        if room > most:
                            most, row, column = room, i, j
                if row >= 0:
                    best[leg, row, column] = 1
