"""
The quickest path: the fewest gait cycles, of walking straight and of turning on the spot.

S0 (sec. 3) says that a path should cost the least time, and minimises distance. Here it
is the time: over cells and eight headings (:mod:`quad_planner.lattice_search`), or at any
angle over corners (:mod:`quad_planner.corner_search`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from quad_common.pace import Pace
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_planner.corner_search import quickest_corners
from quad_planner.inflation import Points
from quad_planner.lattice_search import quickest_path
from quad_planner.shortest_planner import PreparedCells, ShortestPlanner

_ROUNDING = 2
"""By so many cycles a way from a cell's centre may be slower than one from beside it."""


@dataclass(frozen=True, kw_only=True)
class QuickestPlanner(ShortestPlanner):
    """Plan the way that takes the least time; prepares maps as `ShortestPlanner` does."""

    pace: Pace
    """How far the cycles of the robot's gait go."""

    knows_costs: ClassVar[bool] = False

    def plan(self, prepared: PreparedCells, start: Pose2D, goal: Pose2D) -> Plan:
        """
        Find the quickest plan.

        Over cells it is exact for a start and a goal in the centres of cells; elsewhere
        the first and the last stretch lead there. At any angle it is exact for all paths
        that turn at corners of the safety boundary, or where the path over cells turns,
        and never slower than that.

        Parameters
        ----------
        prepared, start, goal
            As for :meth:`ShortestPlanner.plan`.

        Returns
        -------
        Plan
            The turning points.

        Raises
        ------
        PlannerError
            As :meth:`ShortestPlanner.plan`.
        """
        check = self.timer()
        shortest = super().plan(prepared, start, goal)
        if len(shortest.poses) == 1:
            return shortest
        bound = self.cycles(start, shortest) + _ROUNDING
        over_cells = self._over_cells(prepared, start, goal, bound, check)
        best = min(over_cells or shortest, shortest, key=lambda plan: self._cost(start, plan))
        if not self.any_angle:
            return best
        at_any_angle = self._at_any_angle(prepared, start, goal, best, check)
        return min(at_any_angle or best, best, key=lambda plan: self._cost(start, plan))

    def cycles(self, start: Pose2D, plan: Plan) -> int:
        """Return how many gait cycles a plan takes, see :meth:`Pace.cycles`."""
        return self.pace.cycles(start, plan)

    def _cost(self, start: Pose2D, plan: Plan) -> tuple[int, float]:
        """Of two plans that take as many cycles, the shorter one is better."""
        return self.cycles(start, plan), plan.length

    def _over_cells(
        self,
        prepared: PreparedCells,
        start: Pose2D,
        goal: Pose2D,
        bound: int,
        check: Callable[[], None],
    ) -> Plan | None:
        """Return the quickest plan over the cells, None if it takes no fewer cycles."""
        grid = prepared.grid
        s, g = _in_cells(prepared, start), _in_cells(prepared, goal)
        leave_at = prepared.check_ends(start, goal, self.start_tolerance)
        keeps = (leave_at, self.clearance_radius / grid.resolution)
        first, last = (prepared.joints(p, keep)[0] for p, keep in zip((s, g), keeps))
        if first == last:
            return None
        path = quickest_path(
            prepared.search.grid,
            first,
            last,
            start.yaw - grid.origin.yaw,
            goal.yaw - grid.origin.yaw,
            self.pace,
            grid.resolution,
            bound,
            check,
        )
        if path is None:
            return None
        centres = path.cells + np.float64(0.5)
        return _plan(prepared, self._joined(prepared, s, centres, g, leave_at), goal)

    def _at_any_angle(
        self,
        prepared: PreparedCells,
        start: Pose2D,
        goal: Pose2D,
        known: Plan,
        check: Callable[[], None],
    ) -> Plan | None:
        """Return a plan over corners and a known plan's points that is quicker than it."""
        grid = prepared.grid
        points = grid.world_to_map(known.corners)
        # A robot that strayed leaves as the known plan does.
        first = 0 if prepared.is_allowed(points[0]) else 1
        last = len(points) - (1 if prepared.is_allowed(points[-1]) else 2)
        if first >= last:
            return None
        ends = points[[first, last]]
        way = quickest_corners(
            prepared.forbidden_bits,
            np.vstack((ends, points[first + 1 : last], prepared.corners)),
            start.yaw - grid.origin.yaw,
            goal.yaw - grid.origin.yaw,
            self.pace,
            grid.resolution,
            self.cycles(start, known),
            check,
        )
        if way is None:
            return None
        return _plan(prepared, np.vstack((points[:first], way, points[last + 1 :])), goal)


def _in_cells(prepared: PreparedCells, pose: Pose2D) -> Points:
    return prepared.grid.world_to_map(np.array([pose.x, pose.y]))


def _plan(prepared: PreparedCells, points: Points, goal: Pose2D) -> Plan:
    """Make a plan of points [cells], the first and the last of them start and goal."""
    return Plan.through(prepared.grid.map_to_world(points), goal.yaw)
