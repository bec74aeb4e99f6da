"""
The quickest path: the fewest gait cycles, of walking straight and of turning on the spot.

S0 (sec. 3) says that a path should cost the least time, and minimises distance. Here it
is the time: over cells and eight headings (:mod:`quad_planner.wave.wave_search`), or at any
angle over corners (:mod:`quad_planner.any_angle.corner_search`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_planner.any_angle.corner_search import quickest_corners
from quad_planner.methods.cell_request import CellRequest
from quad_planner.methods.shortest_planner import PreparedCells, ShortestPlanner
from quad_planner.search.walk_terms import WalkTerms
from quad_planner.wave.wave_search import quickest_path

_ROUNDING = 2
"""Cycles by which a path from a cell's center may be slower than one from beside it."""


@dataclass(frozen=True, kw_only=True)
class QuickestPlanner(ShortestPlanner):
    """Plans the path that takes the least time; prepares maps as `ShortestPlanner` does."""

    pace: WalkingTimeModel
    """Distances and turns of the gait's cycles."""

    knows_costs: ClassVar[bool] = False

    def plan(self, prepared: PreparedCells, start: Pose2D, goal: Pose2D) -> Plan:
        """
        Find the quickest plan.

        Over cells it is exact for a start and a goal in the centers of cells; elsewhere
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
        request = CellRequest.of(prepared, start, goal, self.start_tolerance, self.timer())
        if request.is_turn:
            return Plan((goal,))

        def cost(plan: Plan) -> tuple[int, float]:
            """Return gait cycles, and the length that decides among equals."""
            return self.pace.cycles(start, plan), plan.length

        best = request.plan(self._line(prepared, request))
        over_cells = self._over_cells(prepared, request, cost(best)[0] + _ROUNDING)
        best = min(over_cells or best, best, key=cost)
        if self.any_angle:
            at_any_angle = self._at_any_angle(prepared, request, best, cost(best)[0])
            best = min(at_any_angle or best, best, key=cost)
        return best

    def _over_cells(self, prepared: PreparedCells, request: CellRequest, bound: int) -> Plan | None:
        """Return the quickest plan over the cells, None if it takes no fewer cycles."""
        first, last = request.ends
        if first == last:
            return None
        terms = self._terms(prepared, request, bound)
        path = quickest_path(prepared.search.grid, first, last, terms, request.check)
        if path is None:
            return None
        return request.plan(request.joined(path.cells + np.float64(0.5)))

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
        )
