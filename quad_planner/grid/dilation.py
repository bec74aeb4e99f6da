"""
Dilation of masks whose cells are bits, 64 in a word.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, compiled_part

Bits = NDArray[np.uint64]


def dilated(rows: Bits, reaches: NDArray[np.int64]) -> Bits:
    """
    Set every cell that is near one that is set.

    Parameters
    ----------
    rows : ndarray of uint64, shape (m, n)
        Bits that are set.
    reaches : ndarray of int, shape (k,)
        Distance to either side, in a row that is 0, 1, ... k - 1 rows off, falling [cells].

    Returns
    -------
    ndarray of uint64, shape (m, n)
        The same and what is near. Bits beyond the width may be set.
    """
    result = np.zeros_like(rows)
    _dilate(rows, reaches, np.empty(rows.shape[1], dtype=np.uint64), result)
    return result


@compiled_loop
def _dilate(rows: Bits, reaches: NDArray[np.int64], wide: Bits, result: Bits) -> None:
    """Add what is near to a result; `wide` is a row for notes."""
    height, words = rows.shape
    went_up = False
    for y in range(height):
        # What is set in the next row as well reaches farther from there.
        goes_down = y > 0 and _has_more(rows, y, y - 1)
        goes_up = y + 1 < height and _has_more(rows, y, y + 1)
        is_as_before = y > 0 and not (goes_down or goes_up or went_up)
        went_up = goes_up
        # From the narrowest to the widest: each goes on from the one before. A row that is the same
        # once more is wide already.
        if not is_as_before:
            for at in range(words):
                wide[at] = rows[y, at]
        reached = 0
        for off in range(len(reaches) - 1 if goes_down or goes_up else 0, -1, -1):
            while reached < reaches[off] and not is_as_before:
                # No gap opens, even where the edge of the map cuts off one side.
                step = min(reached + 1, reaches[off] - reached, 63)
                _spread(wide, step)
                reached += step
            for side in (-1, 1):
                to = y + side * off
                goes = goes_up if side > 0 else goes_down or off == 0
                if goes and 0 <= to < height:
                    for at in range(words):
                        result[to, at] |= wide[at]


@compiled_part
def _has_more(rows: Bits, y: int, other: int) -> bool:
    """Return whether anything is set in a row that is not in another one."""
    more = np.uint64(0)
    for at in range(rows.shape[1]):
        more |= rows[y, at] & ~rows[other, at]
    return bool(more != 0)


@compiled_part
def _spread(line: Bits, step: int) -> None:
    """Set each bit that is a step to either side of one that is set, step < 64."""
    up, down = np.uint64(step), np.uint64(64 - step)
    before = np.uint64(0)
    for at in range(len(line)):
        word = line[at]
        after = line[at + 1] if at + 1 < len(line) else np.uint64(0)
        line[at] = word | (word << up) | (before >> down) | (word >> up) | (after << down)
        before = word
