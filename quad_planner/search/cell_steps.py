"""
Steps from cell to cell: their directions, their lengths, and where shortest paths go on.

Lengths are whole numbers, 2378 for a straight step and 3363 for a diagonal one, a ratio that
is sqrt 2 within 1e-7: so equal lengths are equal.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

STRAIGHT = 2378


DIAGONAL = 3363


# Direction k points at k times 45 degrees.
DX = np.array([1, 1, 0, -1, -1, -1, 0, 1])


DY = np.array([0, 1, 1, 1, 0, -1, -1, -1])


def _pruned_directions() -> NDArray[np.uint8]:
    """
    Tabulate where to go on, by the directions of arrival and the free neighbours.

    Straight on, and where a wall beside the last cell ends, also to that side: only
    through this cell the shortest path leads there. A diagonal goes on along both its
    parts too. From the start, everywhere.

    Returns
    -------
    ndarray, shape (256, 256)
        Bit k of each index and entry stands for direction k.
    """
    around = np.arange(256)
    free = [(around >> k & 1) > 0 for k in range(8)]
    legal = np.zeros(256, dtype=np.uint8)
    for k in range(8):
        may = free[k] if k % 2 == 0 else free[k] & free[k - 1] & free[(k + 1) % 8]
        legal |= np.where(may, 1 << k, 0).astype(np.uint8)
    table = np.zeros((256, 256), dtype=np.uint8)
    table[0] = legal
    for k in range(8):
        wanted = np.full(256, 1 << k)
        for side in (1, -1):
            beside = 1 << (k + side) % 8
            if k % 2:
                wanted |= beside
            else:
                opens = ~free[(k + 3 * side) % 8] & free[(k + 2 * side) % 8]
                wanted |= np.where(opens, beside | 1 << (k + 2 * side) % 8, 0)
        table[1 << k] = wanted & legal
    for arrivals in range(1, 256):
        for k in range(8):
            if arrivals >> k & 1:
                table[arrivals] |= table[1 << k]
    return table


ONWARD = _pruned_directions()
"""Where a shortest path goes on, by arrivals and free neighbours; shape (256, 256)."""
