"""
Where the robot's centre may be on a map, and whether a start and a goal will do.

What every planning method begins with.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from quad_common.errors import (
    GoalOccupied,
    GoalOutsideMap,
    InvalidPose,
    StartOccupied,
    StartOutsideMap,
)
from quad_common.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_planner.bit_grid import BitMask
from quad_planner.inflation import Mask, Points, blocked_cells, grown, segment_clearance

SAME_PLACE = 1e-3
"""Start and goal nearer than this are one place: the robot only turns [m]."""


@dataclass(frozen=True, eq=False)
class SafetyMap:
    """
    A map with the zone that the robot's centre must keep out of.

    The zones are kept as bits; as masks they are made when they are asked for.
    """

    grid: OccupancyGrid
    """The map."""
    clearance_radius: float
    """Distance that the robot's centre keeps from every obstacle [m]."""
    blocked_bits: BitMask
    """Where the obstacles are."""
    forbidden_bits: BitMask
    """Where the robot's centre must not be."""

    @classmethod
    def of(
        cls,
        grid: OccupancyGrid,
        clearance_radius: float,
        occupied_threshold: int,
        unknown_is_free: bool,
    ) -> SafetyMap:
        """
        Inflate a map.

        Parameters
        ----------
        grid, clearance_radius, occupied_threshold, unknown_is_free
            As for :func:`quad_planner.inflation.inflate`.

        Returns
        -------
        SafetyMap
            The map and its zones.
        """
        blocked = blocked_cells(
            grid, occupied_threshold=occupied_threshold, unknown_is_free=unknown_is_free
        )
        forbidden = grown(blocked, clearance_radius / grid.resolution)
        return cls(grid, clearance_radius, blocked, forbidden)

    @cached_property
    def blocked(self) -> Mask:
        """Return where the obstacles are, shape (height, width)."""
        return self.blocked_bits.unpacked()

    @cached_property
    def forbidden(self) -> Mask:
        """Return where the robot's centre must not be, shape (height, width)."""
        return self.forbidden_bits.unpacked()

    @cached_property
    def allowed(self) -> Mask:
        """Return where the robot's centre may be, shape (height, width)."""
        return ~self.forbidden

    @cached_property
    def areas(self) -> NDArray[np.int32]:
        """Return the number of the connected free area of each cell, 0 if forbidden."""
        image = self.allowed.astype(np.uint8)
        return np.asarray(cv2.connectedComponents(image, connectivity=8)[1], dtype=np.int32)

    def area_of(self, point: Points) -> int:
        """Return the number of the free area nearest to a point in cell coordinates."""
        height, width = self.areas.shape
        x, y = (min(max(int(v), 0), n - 1) for v, n in zip(np.floor(point), (width, height)))
        if self.areas[y, x]:
            return int(self.areas[y, x])
        rows, columns = np.nonzero(self.areas)
        if rows.size == 0:
            return 0
        nearest = np.argmin((columns + 0.5 - point[0]) ** 2 + (rows + 0.5 - point[1]) ** 2)
        return int(self.areas[rows[nearest], columns[nearest]])

    def fits(self, a: Points, b: Points, keep: float) -> bool:
        """Return whether a segment stays `keep` away from every blocked cell, all in cells."""
        return segment_clearance(self.blocked_bits, a, b, keep) >= keep * (1.0 - 1e-9)

    def check_ends(self, start: Pose2D, goal: Pose2D, start_tolerance: float) -> float:
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
        float
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
        if not grid.contains(start.x, start.y):
            raise StartOutsideMap(start.x, start.y, grid.bounds())
        if not grid.contains(goal.x, goal.y):
            raise GoalOutsideMap(goal.x, goal.y, grid.bounds())
        radius = self.clearance_radius / grid.resolution
        keeps = []
        for pose, tolerance, error in (
            (start, start_tolerance / grid.resolution, StartOccupied),
            (goal, 0.0, GoalOccupied),
        ):
            point = grid.world_to_map(np.array([pose.x, pose.y]))
            keep = min(segment_clearance(self.blocked_bits, point, point, radius), radius)
            # However large the tolerance, nobody starts inside an obstacle.
            if keep <= 0.0 or keep < (radius - tolerance) * (1.0 - 1e-9):
                raise error(pose.x, pose.y, keep * grid.resolution, self.clearance_radius)
            keeps.append(keep)
        return keeps[0]

    def not_connected(self, s: Points, g: Points) -> str | None:
        """Say that two points [cells] lie in different free areas; None if they do not."""
        if self.area_of(s) == self.area_of(g):
            return None
        return (
            "the start's free area and the goal's are not connected for a robot that "
            f'needs {self.clearance_radius:.2f} m'
        )
