"""
Paths over cells, by the places where they begin, turn and end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop

Cells = NDArray[np.int64]


@dataclass(frozen=True)
class CellPath:
    """A shortest path."""

    cells: Cells
    """Cells where it begins, turns and ends: x and y, shape (n, 2)."""
    straight_steps: int
    """Number of straight steps."""
    diagonal_steps: int
    """Number of diagonal steps."""

    @property
    def length(self) -> float:
        """Length of the path [cells]."""
        return float(self.straight_steps + np.sqrt(2.0) * self.diagonal_steps)


def without_straights(cells: Cells) -> Cells:
    """
    Leave out places where a path goes straight on, or stays.

    Parameters
    ----------
    cells : ndarray, shape (n, 2), n >= 1
        A path; it is changed.

    Returns
    -------
    ndarray, shape (m, 2)
        Places where it begins, turns and ends.
    """
    return cells[: _drop_straights(cells)]


@compiled_loop
def _drop_straights(cells: Cells) -> int:
    """Move the places that are kept to the front, and count them."""
    last = len(cells) - 1
    kept = 1
    for k in range(1, last):
        ax, ay = cells[k, 0] - cells[kept - 1, 0], cells[k, 1] - cells[kept - 1, 1]
        bx, by = cells[k + 1, 0] - cells[k, 0], cells[k + 1, 1] - cells[k, 1]
        if ax * by == ay * bx and ax * bx + ay * by >= 0:
            continue
        cells[kept, 0], cells[kept, 1] = cells[k, 0], cells[k, 1]
        kept += 1
    if last > 0:
        cells[kept, 0], cells[kept, 1] = cells[last, 0], cells[last, 1]
        kept += 1
    return kept
