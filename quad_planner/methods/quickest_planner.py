"""
The quickest path: the fewest gait cycles, of walking straight and of turning on the spot.

S0 (sec. 3) says that a path should cost the least time, and minimises distance. Here it
is the time: over cells and eight headings (:mod:`quad_planner.wave.wave_search`), or at any
angle over corners (:mod:`quad_planner.any_angle.corner_search`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_planner.any_angle.corner_search import quickest_corners
from quad_planner.grid.array_types import Points
from quad_planner.methods.cell_request import CellRequest
from quad_planner.methods.shortest_planner import PreparedCells, ShortestPlanner
from quad_planner.search.walk_terms import WalkTerms
from quad_planner.search.weighted_search import PARTS, line_cost, straightened
from quad_planner.wave.wave_search import quickest_path

_ROUNDING = 2
"""Cycles by which a path from a cell's center may be slower than one from beside it."""


@dataclass(frozen=True, kw_only=True)
class QuickestPlanner(ShortestPlanner):
    """Plans the path that takes the least time; prepares maps as `ShortestPlanner` does."""

    pace: WalkingTimeModel
    """Distances and turns of the gait's cycles."""

    knows_costs: ClassVar[bool] = True

    def prepare(self, grid: OccupancyGrid) -> PreparedCells:
        """Make a map ready: :meth:`ShortestPlanner.prepare`."""
        return _in_parts(super().prepare(grid))

    def update(
        self, prepared: PreparedCells, grid: OccupancyGrid, changed: tuple[int, int]
    ) -> PreparedCells:
        """Make a map ready of which only some rows have changed: `PlanningMethod.update`."""
        return _in_parts(super().update(prepared, grid, changed))

    def plan(self, prepared: PreparedCells, start: Pose2D, goal: Pose2D) -> Plan:
        """
        Find the quickest plan.

        Over cells it is exact for a start and a goal in the centers of cells; elsewhere
        the first and the last stretch lead there. At any angle it is exact for all paths
        that turn at corners of the safety boundary, or where the path over cells turns,
        and never slower than that. Where cells cost more, walking through them takes longer by
        their factor; at any angle the path over cells is straightened then.

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
        request = CellRequest.of(prepared, start, goal, self.start_tolerance, self.timer())
        if request.is_turn:
            return Plan((goal,))

        def cost(plan: Plan) -> tuple[int, float]:
            """Return gait cycles, and the length that decides among equals."""
            return walking_cycles(self.pace, prepared, start, plan), plan.length

        best = request.plan(self._line(prepared, request))
        centers = self._over_cells(prepared, request, cost(best)[0] + _ROUNDING)
        if centers is not None:
            best = min(request.plan(request.joined(centers)), best, key=cost)
        if not self.any_angle:
            return best
        if prepared.costs is None:
            other = self._at_any_angle(prepared, request, best, cost(best)[0])
        elif centers is not None:
            forbidden = prepared.forbidden_bits
            line = straightened(centers, prepared.costs, forbidden, request.check)
            other = request.plan(request.joined(line))
        else:
            other = None
        return min(other or best, best, key=cost)

    def _over_cells(
        self, prepared: PreparedCells, request: CellRequest, bound: int
    ) -> Points | None:
        """Return where the quickest path over the cells turns; None if it takes no fewer cycles."""
        first, last = request.ends
        if first == last:
            return None
        terms = self._terms(prepared, request, bound)
        path = quickest_path(prepared.search.grid, first, last, terms, request.check)
        return None if path is None else path.cells + np.float64(0.5)

    def _at_any_angle(
        self, prepared: PreparedCells, request: CellRequest, known: Plan, bound: int
    ) -> Plan | None:
        """Return the quickest plan over corners and a known plan's turning points."""
        between = prepared.grid.world_to_map(known.corners[1:-1])
        path = quickest_corners(
            prepared.space,
            prepared.forbidden_bits,
            np.vstack((*request.tips, between)),
            self._terms(prepared, request, bound),
            request.check,
        )
        return None if path is None else request.plan(request.joined(path))

    def _terms(self, prepared: PreparedCells, request: CellRequest, bound: int) -> WalkTerms:
        """Return what cycles are counted by; headings are in the frame of the cells."""
        yaw = request.safety.grid.origin.yaw
        return WalkTerms(
            self.pace,
            prepared.grid.resolution,
            request.start.yaw - yaw,
            request.goal.yaw - yaw,
            bound,
            prepared.weights,
        )


def _in_parts(prepared: PreparedCells) -> PreparedCells:
    """Round factors to those that searches count with, so that both count the same."""
    if prepared.costs is None:
        return prepared
    return replace(prepared, costs=np.rint(PARTS * prepared.costs) / PARTS)


def walking_cycles(
    pace: WalkingTimeModel, prepared: PreparedCells, start: Pose2D, plan: Plan
) -> int:
    """
    Count the gait cycles of a plan on a map, some of whose cells may take longer to walk through.

    Parameters
    ----------
    pace : WalkingTimeModel
        Distances and turns of the gait's cycles.
    prepared : PreparedCells
        The map.
    start : Pose2D
        Where the robot is, at the plan's first point [m, m, rad].
    plan : Plan
        The turning points.

    Returns
    -------
    int
        Cycles of straight walking and of turning.
    """
    if prepared.costs is None:
        return pace.cycles(start, plan)
    corners = prepared.grid.world_to_map(plan.corners)
    ends = np.hstack((corners[:-1], corners[1:])).tolist()
    side = prepared.grid.resolution
    return pace.cycles(start, plan, [side * line_cost(prepared.costs, *end) for end in ends])
