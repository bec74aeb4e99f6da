"""
What is asked of a search over the cells: how start and goal join them, and leave them again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from quad_common.errors import NoPathFound
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_planner.grid.array_types import Points
from quad_planner.grid.inflated_map import SAME_PLACE, InflatedMap

Cell = tuple[int, int]


@dataclass(frozen=True, eq=False)
class CellRequest:
    """A start and a goal on a map; `CellRequest.of` checks them."""

    safety: InflatedMap
    """The map."""
    start: Pose2D
    """Pose of the start in the world [m, m, rad]."""
    goal: Pose2D
    """Pose of the goal in the world [m, m, rad]."""
    s: Points
    """Place of the start [cells]."""
    g: Points
    """Place of the goal [cells]."""
    leave_at: float
    """The clearance to keep on leaving the start [cells]."""
    check: Callable[[], None]
    """Called again and again; raises to end the search."""

    @classmethod
    def of(
        cls,
        safety: InflatedMap,
        start: Pose2D,
        goal: Pose2D,
        start_tolerance: float,
        check: Callable[[], None],
    ) -> CellRequest:
        """
        Check the ends of a request.

        Parameters
        ----------
        safety : InflatedMap
            The map.
        start, goal, start_tolerance
            As for :meth:`InflatedMap.check_ends`.
        check : callable
            Called again and again; raises to end the search.

        Returns
        -------
        CellRequest
            The request.

        Raises
        ------
        InvalidPose, StartOutsideMap, GoalOutsideMap, StartOccupied, GoalOccupied
            As :meth:`InflatedMap.check_ends`.
        """
        (s, g), leave_at = safety.check_ends(start, goal, start_tolerance)
        return cls(safety, start, goal, s, g, leave_at, check)

    @property
    def is_turn(self) -> bool:
        """Whether start and goal are in one place."""
        return self.start.distance_to(self.goal) < SAME_PLACE

    @property
    def arrive_at(self) -> float:
        """The clearance to keep on arriving at the goal [cells]."""
        return self.safety.clearance_radius / self.safety.grid.resolution

    @cached_property
    def ends(self) -> tuple[Cell, Cell]:
        """
        Return the allowed cells by which start and goal join the cells.

        Raises
        ------
        NoPathFound
            If there are none.
        """
        first = self.safety.joints(self.s, self.leave_at)
        last = self.safety.joints(self.g, self.arrive_at)
        if not (first and last):
            raise self.no_path()
        return first[0], last[0]

    @cached_property
    def tips(self) -> tuple[Points, Points]:
        """Return where a path at any angle begins and ends, both in allowed cells [cells]."""
        top, bottom = (
            point if self.safety.is_allowed(point) else np.array(cell) + 0.5
            for point, cell in zip((self.s, self.g), self.ends)
        )
        return top, bottom

    def no_path(self) -> NoPathFound:
        """Return the error that says why no path leads to the goal."""
        why = self.safety.not_connected(self.s, self.g)
        why = why or 'the start or the goal has no free cell nearby'
        return NoPathFound((self.start.x, self.start.y), (self.goal.x, self.goal.y), why)

    def joined(self, between: Points) -> Points:
        """
        Join start and goal to a path, past its first and last point where there is room.

        Parameters
        ----------
        between : ndarray, shape (n, 2)
            The path [cells].

        Returns
        -------
        ndarray, shape (m, 2)
            From the start to the goal [cells].
        """
        points = [self.s, *between, self.g]
        for at, keep in ((1, self.leave_at), (-2, self.arrive_at)):
            if len(points) > 2 and self.safety.is_reachable_straight(
                points[at - 1], points[at + 1], keep
            ):
                del points[at]
        return np.array(points)

    def plan(self, points: Points) -> Plan:
        """Make a plan of a line from the start to the goal, shape (n, 2), n >= 2 [cells]."""
        inner = self.safety.grid.map_to_world(points[1:-1]).tolist()
        ends = ((self.start.x, self.start.y), (self.goal.x, self.goal.y))
        return Plan.through([ends[0], *inner, ends[1]], self.goal.yaw)
