"""
Where a robot can stand and turn on a height map, for each class of headings, as bits.

A stance counts as possible if each foot has a foothold by the gait's own criterion within reach of
its place, and if the legs reach them at some posture of the body that the gait tries. How feet
come there is not looked at.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from quad_common.footing.foothold_criterion import FootholdCriterion
from quad_common.footing.leg_room import LegRoom
from quad_common.footing.postures import LOWERINGS, TILTS
from quad_common.maps.height_map import HeightMap
from quad_common.maps.height_map_parts import part_within
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_planner.footing.foothold_lattice import (
    footholds,
    lattice_shape,
    lattice_side,
    shins_of,
)
from quad_planner.footing.stances import Footholds, Legs, find_unfit
from quad_planner.grid.bit_grid import BitMask, Bits
from quad_planner.outline.heading_kernels import CLASSES, STEP

Array = NDArray[np.float64]
Bounds = tuple[float, float, float, float]
_Cells = tuple[int, int, float, Pose2D]
"""Width and height of a map [cells], side of a cell [m], and its origin."""

LARGEST = 2**22
"""Cells of the largest map of which it is known, by 9 bytes a cell."""

LARGEST_LATTICE = 2**20
"""Places of the largest height map on which it is, by 4 bytes a place, leg and bin of headings."""

STEPPING_REACH = 0.15
"""Reach of a foot where footsteps are planned, in place of that of strides [m, of TITAN-VIII]."""


@dataclass(frozen=True, eq=False)
class FootedRobot:
    """A robot, and what it takes for a foothold."""

    robot: Robot
    """The robot."""
    criterion: FootholdCriterion
    """Conditions of a foothold."""

    @classmethod
    def of(cls, robot: Robot, plans_footsteps: bool = False) -> FootedRobot:
        """Take a robot, by strides or from foothold to foothold."""
        if plans_footsteps:
            return cls(robot, FootholdCriterion(reach=STEPPING_REACH))
        return cls(robot, FootholdCriterion())

    @cached_property
    def legs(self) -> Legs:
        """Return what its legs reach."""
        room, scale = LegRoom.of(self.robot), self.robot.relative_size
        lowest, highest = scale * min(LOWERINGS), scale * max(LOWERINGS)
        reach = room.lowest, room.highest, room.side
        # With the ground's own tilt first: legs bear most ground with it, and one is enough.
        return Legs(room.neutral, *reach, lowest, highest, np.array(TILTS[::-1]))

    @cached_property
    def shins(self) -> list[list[Array]]:
        """Return points of its shins at some headings [m]."""
        return shins_of(self.robot)

    @cached_property
    def harmless_step(self) -> float:
        """
        Return the difference of four footholds' heights at which legs reach them for sure [m].

        None of four numbers is off their mean by more than three fourths of their range.
        """
        legs, scale = self.legs, self.robot.relative_size
        # The corners of a cell count, and its middle lies half a cell off.
        near = scale * self.criterion.reach + 2.0 * legs.side
        at = (np.arange(legs.lowest.shape[1]) + 0.5) * legs.side
        x, y = np.meshgrid(at - at.mean(), at - at.mean())
        within = np.hypot(x, y) <= near
        above, below = (
            float((table[:, within] - legs.neutral[:, 2:]).min())
            for table in (legs.highest, -legs.lowest + 2.0 * legs.neutral[:, 2, None, None])
        )
        # The body may be lower, which brings feet nearer to it.
        return max(0.0, min(below + legs.lowered, (above + below) / 2.0)) / 0.75

    def on(self, heights: HeightMap, before: Footing | None = None) -> Footing:
        """
        Find where it can stand.

        Parameters
        ----------
        heights : HeightMap
            Of the ground.
        before : Footing, optional
            The same on the map that was before: only what has changed is looked at again.

        Returns
        -------
        Footing
        """
        return Footing(self, heights, before)


class Footing:
    """
    Tells at which cells and headings a robot finds footholds; found out when first asked.

    Parameters
    ----------
    footed : FootedRobot
        The robot.
    heights : HeightMap
        Of the ground.
    before : Footing, optional
        The same on the map that was before: only what has changed is looked at again.
    """

    def __init__(
        self, footed: FootedRobot, heights: HeightMap, before: Footing | None = None
    ) -> None:
        self._footed, self._heights = footed, heights
        self._lattice: Footholds | None = None
        self._layers: dict[_Cells, Bits] = {}
        self._before: Footing | None = None
        if before is not None and before._lattice is None:
            before = before._before
        if before is not None and before._has_cells_of(self):
            self._before = before
        # A plan may be asked for while another one is searched in another thread.
        self._lock = Lock()

    @property
    def _side(self) -> float:
        return lattice_side(self._footed.robot, self._heights)

    @property
    def _reach(self) -> float:
        """Distance from the body's center at which the ground counts [m]."""
        robot = self._footed.robot
        scale = robot.relative_size
        away = float(np.hypot(*robot.neutral_feet[:, :2].T).max())
        return away + scale * self._footed.criterion.reach + 2.0 * self._side

    def layers(self, grid: OccupancyGrid) -> Bits | None:
        """
        Return where the robot cannot stand.

        Parameters
        ----------
        grid : OccupancyGrid
            A map; only where its cells lie counts.

        Returns
        -------
        ndarray of uint64, shape (72, height, n), or None
            A bit is set where the robot, its center in the middle of the cell, finds no footholds
            at the class of headings, seen from the map's frame; bits beyond the width mean nothing.
            None for maps, and height maps, that are too large.
        """
        rows, columns = lattice_shape(self._footed.robot, self._heights)
        if grid.width * grid.height > LARGEST or rows * columns > LARGEST_LATTICE:
            return None
        key = _cells_of(grid)
        # Without the lock, which is kept while that is found out for another map.
        known = self._layers.get(key) if self._before is None else None
        if known is not None:
            return known
        with self._lock:
            if self._before is not None:
                self._take_over(self._before)
                self._before = None
            if key not in self._layers:
                words = (grid.width + 63) // 64
                layers = np.zeros((CLASSES, grid.height, words), dtype=np.uint64)
                self._fill(layers, key, None)
                self._layers = {key: layers}
            return self._layers[key]

    def is_known(self, grid: OccupancyGrid) -> bool:
        """Return whether :meth:`layers` of a map are known, so that they are returned at once."""
        return self._before is None and _cells_of(grid) in self._layers

    def _has_cells_of(self, other: Footing) -> bool:
        """Return whether another map has the same cells, so that parts can be kept."""
        mine, theirs = self._heights, other._heights
        return (
            other._footed is self._footed
            and theirs.heights.shape == mine.heights.shape
            and theirs.resolution == mine.resolution
            and theirs.origin == mine.origin
        )

    def _take_over(self, before: Footing) -> None:
        """Keep what is the same as on the map before."""
        old, new = before._heights.heights, self._heights.heights
        changed = (old != new) & ~(np.isnan(old) & np.isnan(new))
        rows, columns = (np.flatnonzero(changed.any(axis=axis)) for axis in (1, 0))
        if not len(rows):
            self._lattice, self._layers = before._lattice, before._layers
            return
        side, (x, y) = self._heights.resolution, self._heights.origin
        left, bottom = x + columns[0] * side, y + rows[0] * side
        right, top = x + (columns[-1] + 1) * side, y + (rows[-1] + 1) * side
        bounds = left, bottom, right, top
        assert before._lattice is not None
        beside = self._beside
        self._lattice = self._lattice_changed(before._lattice, bounds, beside)
        for key, layers in before._layers.items():
            fresh = layers.copy()
            self._fill(fresh, key, _widened(bounds, self._reach + 2.0 * beside))
            self._layers[key] = fresh

    def _footholds_on(self, heights: HeightMap) -> Footholds:
        footed = self._footed
        return footholds(footed.robot, footed.criterion, heights, footed.shins)

    @property
    def _beside(self) -> float:
        """Distance from a change within which footholds may be others [m]."""
        robot, criterion = self._footed.robot, self._footed.criterion
        leg = robot.legs[0]
        # No shin is farther aside than it is long; the lattice is as coarse as it is.
        most = criterion.reach + criterion.radius + criterion.shin_clearance
        return robot.relative_size * most + float(leg.calf_length) + 4.0 * self._side

    def _lattice_changed(self, old: Footholds, bounds: Bounds, beside: float) -> Footholds:
        """Return a lattice on the map, which has changed within bounds."""
        columns = old.heights.shape[1]
        near, far = (_widened(bounds, k * beside) for k in (1.0, 2.0))
        inner, outer = (_places(old, box) for box in (near, far))
        (left, right), (bottom, top) = outer
        x, y = old.x + left * old.side, old.y + bottom * old.side
        # Whole places, and a little less so that rounding takes no cell more.
        tiny = 1e-6 * self._heights.resolution
        end = old.x + right * old.side - tiny, old.y + top * old.side - tiny
        part = part_within(self._heights, (x + tiny, y + tiny, *end))
        found = self._footholds_on(part)
        (i0, i1), (j0, j1) = inner
        window = np.s_[j0 - bottom : j1 - bottom, i0 - left : i1 - left]
        values, nearest = old.heights.copy(), old.nearest.copy()
        values[j0:j1, i0:i1] = found.heights[window]
        fresh = found.nearest[(..., *window)]
        width = found.heights.shape[1]
        moved = (fresh // width + bottom) * columns + fresh % width + left
        nearest[..., j0:j1, i0:i1] = np.where(fresh < 0, np.int32(-1), moved)
        return old._replace(nearest=nearest, heights=values)

    def _fill(self, layers: Bits, key: _Cells, bounds: Bounds | None) -> None:
        """Find where the robot cannot stand; within bounds alone, if there are any."""
        footed = self._footed
        if self._lattice is None:
            self._lattice = self._footholds_on(self._heights)
        width, height, resolution, origin = key
        grid = OccupancyGrid(np.zeros((height, width), dtype=np.int8), resolution, origin)
        rows, columns = (a.ravel() for a in np.indices((height, width)))
        centers = grid.map_to_world(np.column_stack((columns, rows)) + 0.5)
        chosen, is_uneven = self._doubts(self._lattice, centers)
        if bounds is not None:
            inside = (centers >= bounds[:2]).all(axis=1) & (centers <= bounds[2:]).all(axis=1)
            layers &= ~BitMask.of(inside.reshape(height, width)).words
            chosen &= inside
        if not chosen.any():
            return
        cells = np.column_stack((rows, columns, is_uneven))[chosen].astype(np.int64)
        headings: Array = STEP * np.arange(CLASSES, dtype=np.float64) + origin.yaw
        find_unfit(self._lattice, footed.legs, headings, cells, centers[chosen], layers)

    def _doubts(
        self, old: Footholds, centers: Array
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Tell at which places, (n, 2), the ground around is not plainly good, and uneven."""
        # Imported late, as only a height map needs it: it takes a good part of a node's start.
        import cv2

        size = 2 * math.ceil(self._reach / old.side) + 1
        around = np.ones((size, size), dtype=np.uint8)
        bad = (old.nearest.min(axis=(0, 1)) < 0).astype(np.uint8)
        lowest, highest = (
            np.where(np.isnan(old.heights), fill, old.heights).astype(np.float32)
            for fill in (1e9, -1e9)
        )
        step = cv2.dilate(highest, around) - cv2.erode(lowest, around)
        uneven = step > self._footed.harmless_step
        doubtful = uneven | (cv2.dilate(bad, around) > 0)
        at = np.floor((centers - (old.x, old.y)) / old.side).astype(int)
        rows, columns = old.heights.shape
        reach = math.ceil(self._reach / old.side)
        near = ((at >= -reach) & (at < (columns + reach, rows + reach))).all(axis=1)
        column, row = np.clip(at, 0, (columns - 1, rows - 1)).T
        return near & doubtful[row, column], uneven[row, column]


def _cells_of(grid: OccupancyGrid) -> _Cells:
    return grid.width, grid.height, grid.resolution, grid.origin


def _widened(bounds: Bounds, distance: float) -> Bounds:
    return (
        bounds[0] - distance,
        bounds[1] - distance,
        bounds[2] + distance,
        bounds[3] + distance,
    )


def _places(lattice: Footholds, bounds: Bounds) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the first and the end of the columns, and of the rows, that share area with bounds."""
    rows, columns = lattice.heights.shape
    ends = []
    for low, high, zero, count in (
        (bounds[0], bounds[2], lattice.x, columns),
        (bounds[1], bounds[3], lattice.y, rows),
    ):
        first = min(max(math.floor((low - zero) / lattice.side), 0), count - 1)
        end = min(max(math.ceil((high - zero) / lattice.side), first + 1), count)
        ends.append((first, end))
    return ends[0], ends[1]
