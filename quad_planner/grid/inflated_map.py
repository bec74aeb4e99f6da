"""
Where the robot's center may be on a map, and whether a start and a goal will do.

What every planning method begins with.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import (
    GoalOccupied,
    GoalOutsideMap,
    InvalidPose,
    StartOccupied,
    StartOutsideMap,
)
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_planner.grid.array_types import Mask, Points
from quad_planner.grid.bit_grid import BitMask
from quad_planner.grid.clearance import segment_clearance
from quad_planner.grid.inflation import blocked_cells, inflated, inflated_again
from quad_planner.grid.line_of_sight import sees

SAME_PLACE = 1e-3
"""Start and goal nearer than this are one place: the robot only turns [m]."""

_FAR = 50.0
"""Largest distance from which a robot that has strayed joins a path [cells]."""

_NEARBY = 12.0
"""Largest distance from start and goal at which a free cell is looked for [cells]."""


@dataclass(frozen=True, eq=False)
class InflatedMap:
    """
    A map with the zone that the robot's center must keep out of.

    The zones are kept as bits; as masks they are made when they are first needed.
    """

    grid: OccupancyGrid
    """The map."""
    clearance_radius: float
    """Distance that the robot's center keeps from every obstacle [m]."""
    blocked_bits: BitMask
    """Cells of the obstacles."""
    forbidden_bits: BitMask
    """Cells where the robot's center must not be."""

    @classmethod
    def of(
        cls,
        grid: OccupancyGrid,
        clearance_radius: float,
        occupied_threshold: int,
        unknown_is_free: bool,
    ) -> InflatedMap:
        """
        Inflate a map.

        Parameters
        ----------
        grid, clearance_radius, occupied_threshold, unknown_is_free
            As for :func:`quad_planner.grid.inflation.inflate`.

        Returns
        -------
        InflatedMap
            The map and its zones.
        """
        blocked = blocked_cells(
            grid, occupied_threshold=occupied_threshold, unknown_is_free=unknown_is_free
        )
        forbidden = inflated(blocked, clearance_radius / grid.resolution)
        return cls(grid, clearance_radius, blocked, forbidden)

    def zones_changed_to(
        self,
        grid: OccupancyGrid,
        occupied_threshold: int,
        unknown_is_free: bool,
        changed: tuple[int, int],
    ) -> tuple[BitMask, BitMask, tuple[int, int]]:
        """
        Inflate a map of which some rows have changed.

        Parameters
        ----------
        grid : OccupancyGrid
            The map as it is now, of the same size.
        occupied_threshold, unknown_is_free
            As for :func:`quad_planner.grid.inflation.inflate`.
        changed : tuple of int
            The rows, from the first up to, but without, the second.

        Returns
        -------
        tuple
            Blocked and forbidden cells, and the rows in which the forbidden ones changed.
        """
        first, last = changed
        band = OccupancyGrid(grid.cells[first:last], grid.resolution, grid.origin)
        words = self.blocked_bits.words.copy()
        words[first:last] = blocked_cells(
            band, occupied_threshold=occupied_threshold, unknown_is_free=unknown_is_free
        ).words
        blocked = BitMask(words, grid.width)
        radius = self.clearance_radius / grid.resolution
        forbidden, rows = inflated_again(self.forbidden_bits, blocked, radius, changed)
        return blocked, forbidden, rows

    @cached_property
    def blocked(self) -> Mask:
        """Return where the obstacles are, shape (height, width)."""
        return self.blocked_bits.unpacked()

    @cached_property
    def forbidden(self) -> Mask:
        """Return where the robot's center must not be, shape (height, width)."""
        return self.forbidden_bits.unpacked()

    @cached_property
    def allowed(self) -> Mask:
        """Return where the robot's center may be, shape (height, width)."""
        return ~self.forbidden

    @cached_property
    def areas(self) -> NDArray[np.int32]:
        """Return the number of the connected free area of each cell, 0 if forbidden."""
        # Imported late: only where there is no path it is asked why.
        import cv2

        image = self.allowed.astype(np.uint8)
        return np.asarray(cv2.connectedComponents(image, connectivity=8)[1], dtype=np.int32)

    def area_of(self, point: Points) -> int:
        """Return the number of the free area nearest to a point in cell coordinates."""
        area = int(self.areas[self._cell_of(point)])
        reach, farthest = _NEARBY, float(self.grid.width + self.grid.height)
        while area == 0 and reach < 4.0 * farthest:
            left, bottom, right, top = self._box(point - reach, point + reach)
            rows, columns = np.nonzero(self.areas[bottom:top, left:right])
            rows, columns = rows + bottom, columns + left
            apart = np.hypot(columns + 0.5 - point[0], rows + 0.5 - point[1])
            if len(apart) and (apart.min() <= reach or reach > farthest):
                nearest = np.argmin(apart)
                area = int(self.areas[rows[nearest], columns[nearest]])
            reach *= 4.0
        return area

    def _cell_of(self, point: Points) -> tuple[int, int]:
        """Return the row and column of the cell of the map that is nearest to a point."""
        # As Python's numbers, which are faster one by one.
        x, y = point.tolist()
        height, width = self.grid.cells.shape
        return min(max(math.floor(y), 0), height - 1), min(max(math.floor(x), 0), width - 1)

    def _box(self, lowest: Points, highest: Points) -> tuple[int, int, int, int]:
        """Return the window of the map between two points: left, bottom, right, top."""
        size = (self.grid.width, self.grid.height)
        left, bottom = (min(max(math.floor(v), 0), n) for v, n in zip(lowest, size))
        right, top = (min(max(math.ceil(v), 0), n) for v, n in zip(highest, size))
        return left, bottom, right, top

    def fits(self, a: Points, b: Points, keep: float) -> bool:
        """Return whether a segment stays `keep` away from every blocked cell, all in cells."""
        return segment_clearance(self.blocked_bits, a, b, keep) >= keep * (1.0 - 1e-9)

    def is_allowed(self, point: Points) -> bool:
        """Return whether a point on the map lies in an allowed cell [cells]."""
        return not self.forbidden_bits[self._cell_of(point)]

    def is_reachable_straight(self, a: Points, b: Points, keep: float) -> bool:
        """Return whether one may go straight from one point to another, all in cells."""
        if self.is_allowed(a) and self.is_allowed(b):
            return sees(self.forbidden_bits.words, self.grid.width, *a, *b)
        # A robot that strayed: an exact look, which takes its time, at what is near.
        return float(np.hypot(*(b - a))) <= _FAR and self.fits(a, b, keep)

    def joints(self, point: Points, keep: float) -> list[tuple[int, int]]:
        """
        List the allowed cells by which a point may join the cells, the nearest first.

        Parameters
        ----------
        point : ndarray, shape (2,)
            [cells]
        keep : float
            Clearance between the robot and a cell's center [cells].

        Returns
        -------
        list of tuple of int
            x and y; the point's own cell alone if it is allowed.
        """
        row, column = self._cell_of(point)
        if not self.forbidden_bits[row, column]:
            return [(column, row)]
        left, bottom, right, top = self._box(point - _NEARBY, point + _NEARBY)
        rows, columns = np.nonzero(~self.forbidden_bits.window(left, bottom, right, top))
        cells = np.column_stack((columns + left, rows + bottom))
        apart = np.hypot(*(cells + 0.5 - point).T)
        for k in np.argsort(apart, kind='stable'):
            if apart[k] > _NEARBY:
                break
            if self.fits(point, cells[k] + 0.5, keep):
                return [(int(cells[k, 0]), int(cells[k, 1]))]
        return []

    def check_ends(
        self, start: Pose2D, goal: Pose2D, start_tolerance: float
    ) -> tuple[Points, float]:
        """
        Check both poses.

        Parameters
        ----------
        start, goal : Pose2D
            In the world [m, m, rad].
        start_tolerance : float
            How far the start may be inside the safety boundary [m].

        Returns
        -------
        points : ndarray, shape (2, 2)
            Where start and goal are [cells].
        leave_at : float
            The clearance to keep on leaving the start [cells].

        Raises
        ------
        InvalidPose
            If a pose holds a number that is not finite.
        StartOutsideMap, GoalOutsideMap
            If a pose is not on the map.
        StartOccupied, GoalOccupied
            If a pose is too near to a blocked cell.
        """
        grid = self.grid
        for what, pose in (('start', start), ('goal', goal)):
            if not pose.is_finite():
                reason = f'({pose.x}, {pose.y}, {pose.yaw}) must be three finite numbers'
                raise InvalidPose(what, reason)
        points = grid.world_to_map(np.array([[start.x, start.y], [goal.x, goal.y]]))
        for pose, point, outside in zip((start, goal), points, (StartOutsideMap, GoalOutsideMap)):
            if not (0.0 <= point[0] <= grid.width and 0.0 <= point[1] <= grid.height):
                raise outside(pose.x, pose.y, grid.bounds())
        radius = self.clearance_radius / grid.resolution
        keeps = []
        for pose, point, tolerance, error in (
            (start, points[0], start_tolerance / grid.resolution, StartOccupied),
            (goal, points[1], 0.0, GoalOccupied),
        ):
            keep = min(segment_clearance(self.blocked_bits, point, point, radius), radius)
            # However large the tolerance, no path starts inside an obstacle.
            required = radius - tolerance if tolerance < radius else radius
            if keep <= 0.0 or keep < (radius - tolerance) * (1.0 - 1e-9):
                clearances = (length * grid.resolution for length in (keep, required))
                raise error(pose.x, pose.y, *clearances)
            keeps.append(keep)
        return points, keeps[0]

    def not_connected(self, s: Points, g: Points) -> str | None:
        """Say that two points [cells] lie in different free areas; None if they do not."""
        if self.area_of(s) == self.area_of(g):
            return None
        return (
            "the start's free area and the goal's are not connected for a robot that "
            f'needs {self.clearance_radius:.2f} m'
        )
