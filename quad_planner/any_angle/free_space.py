"""
Free cells made ready for searches at any angle.
"""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.compiled import compiled_loop
from quad_planner.any_angle.blocks import Blocks, between, blocks_of
from quad_planner.any_angle.intervals import holds
from quad_planner.any_angle.rectangles import Rectangles, rectangles_of
from quad_planner.grid.array_types import Mask, Points
from quad_planner.grid.bit_grid import BitMask


@dataclass(frozen=True)
class FreeSpace:
    """The free cells of a map, as rectangles; to make them again takes no longer than a look."""

    rectangles: Rectangles
    """The rectangles, and which touch."""
    blocks: Blocks
    """Parts of the map that are joined by one rectangle only."""
    width: int
    """Width of the map [cells]."""

    @classmethod
    def outside(cls, forbidden: BitMask) -> FreeSpace:
        """Take the cells that are not forbidden."""
        rectangles = rectangles_of(forbidden)
        return cls(rectangles, blocks_of(rectangles), forbidden.width)

    def between(self, start: Points, goal: Points) -> Mask | None:
        """
        Mark the rectangles that may be on a shortest path.

        Parameters
        ----------
        start, goal : ndarray, shape (2,)
            Points in free cells, or on their edges [cells].

        Returns
        -------
        ndarray of bool, shape (n,) or None
            The rectangles; None if no path connects the two.
        """
        first, last = (self.rectangle_at(point) for point in (start, goal))
        if first < 0 or last < 0:
            return None
        return between(self.blocks, first, last)

    def rectangle_at(self, point: Points) -> int:
        """Return a rectangle that holds a point [cells], or has it on its edge; -1 if none does."""
        return int(_rectangle_at(self.rectangles, float(point[0]), float(point[1])))


@compiled_loop
def _rectangle_at(rectangles: Rectangles, x: float, y: float) -> int:
    """Do what :meth:`FreeSpace.rectangle_at` says."""
    for here in range(len(rectangles.bounds)):
        if holds(rectangles, here, x, y):
            return here
    return -1
