"""
The shortest path over the cells of the map, or at any angle.

Over cells: straight and diagonal steps from centre to centre, no corner cut, exact
(:mod:`quad_planner.jump_points`). At any angle: taut around the safety boundary
(:mod:`quad_planner.any_angle`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import NoPathFound
from quad_common.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_planner.any_angle import convex_corners, taut_path
from quad_planner.bit_grid import BitGrid
from quad_planner.compiled import compiled
from quad_planner.inflation import Mask, Points
from quad_planner.jump_points import CellPath, JumpPointSearch
from quad_planner.planner_options import PlannerOptions
from quad_planner.safety_map import SAME_PLACE, SafetyMap


@dataclass(frozen=True, eq=False)
class PreparedCells(SafetyMap):
    """A map made ready for any number of searches; `ShortestPlanner.prepare` makes it."""

    search: JumpPointSearch
    """Over the allowed cells."""

    @cached_property
    def corners(self) -> Points:
        """Where a path at any angle may turn, shape (n, 2) [cells]."""
        return convex_corners(self.allowed)


@dataclass(frozen=True)
class ShortestPlanner(PlannerOptions):
    """Plan the shortest way, whatever turns it takes."""

    any_angle: bool = False
    """Whether the path may have any direction, not only those of the cells."""

    def prepare(self, grid: OccupancyGrid) -> PreparedCells:
        """
        Inflate a map and make its cells ready.

        Parameters
        ----------
        grid : OccupancyGrid
            The map.

        Returns
        -------
        PreparedCells
            What `plan` needs of the map, for any number of plans.
        """
        safety = self.safety_map(grid)
        search = JumpPointSearch(BitGrid.outside(safety.forbidden_bits))
        return PreparedCells(
            grid, self.clearance_radius, safety.blocked_bits, safety.forbidden_bits, search
        )

    def plan(self, prepared: PreparedCells, start: Pose2D, goal: Pose2D) -> Plan:
        """
        Find the shortest plan.

        A start that is inside the safety boundary by no more than `start_tolerance` may
        be left on a segment that comes no nearer to an obstacle than the start is.

        Parameters
        ----------
        prepared : PreparedCells
            The map, from `prepare`.
        start, goal : Pose2D
            In the world [m, m, rad].

        Returns
        -------
        Plan
            The turning points; a single pose, the goal's, where start and goal are less
            than `SAME_PLACE` apart.

        Raises
        ------
        InvalidPose, StartOutsideMap, GoalOutsideMap, StartOccupied, GoalOccupied
            As :meth:`SafetyMap.check_ends`.
        NoPathFound
            If no way over the cells connects them.
        PlannerTimedOut
            If the search took longer than `time_limit`.
        """
        grid = prepared.grid
        leave_at = prepared.check_ends(start, goal, self.start_tolerance)
        if start.distance_to(goal) < SAME_PLACE:
            return Plan((goal,))
        check_time = self.timer()
        s, g = (grid.world_to_map(np.array([p.x, p.y])) for p in (start, goal))
        radius = self.clearance_radius / grid.resolution
        first, last = prepared.joints(s, leave_at), prepared.joints(g, radius)
        path = prepared.search.path(first[0], last[0]) if first and last else None
        if path is None:
            why = prepared.not_connected(s, g) or 'no allowed cell is near to one of them'
            raise NoPathFound((start.x, start.y), (goal.x, goal.y), why)
        check_time()
        between = self._between(prepared, path, s, g, leave_at, check_time)
        inner = grid.map_to_world(np.reshape(between, (-1, 2))).tolist()
        return Plan.through([(start.x, start.y), *inner, (goal.x, goal.y)], goal.yaw)

    def _between(
        self,
        prepared: PreparedCells,
        path: CellPath,
        s: Points,
        g: Points,
        leave_at: float,
        check_time: Callable[[], None],
    ) -> Points:
        """Return the turning points between start and goal, shape (n, 2) [cells]."""
        allowed = prepared.allowed
        centres: Points = turns_saved(path.cells, allowed) + np.float64(0.5)
        over_cells = self._joined(prepared, s, centres, g, leave_at)
        if not self.any_angle:
            return over_cells[1:-1]
        first = s if prepared.is_allowed(s) else centres[0]
        last = g if prepared.is_allowed(g) else centres[-1]
        bound = _length(np.vstack((first, centres, last)))
        taut = taut_path(allowed, prepared.corners, first, last, bound, check_time)
        if taut is None:
            return over_cells[1:-1]
        straight = self._joined(prepared, s, taut, g, leave_at)
        # Only where start or goal is not in an allowed cell the other may be shorter.
        return min(straight, over_cells, key=_length)[1:-1]

    def _joined(
        self, prepared: PreparedCells, s: Points, between: Points, g: Points, leave_at: float
    ) -> Points:
        """Join start and goal to a way, past its first and last point where there is room."""
        points = [s, *between, g]
        for at, keep in ((1, leave_at), (-2, self.clearance_radius / prepared.grid.resolution)):
            if len(points) > 2 and prepared.leads(points[at - 1], points[at + 1], keep):
                del points[at]
        return np.array(points)


def _length(points: Points) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def turns_saved(cells: NDArray[np.int64], allowed: Mask) -> NDArray[np.int64]:
    """
    Walk each leg of a path straight or diagonal first, so that there are few turns.

    Parameters
    ----------
    cells : ndarray, shape (n, 2)
        Where a shortest path begins, turns and ends.
    allowed : ndarray of bool, shape (height, width)
        The allowed cells.

    Returns
    -------
    ndarray, shape (m, 2)
        As short, with no more turns.
    """
    kept: list[tuple[int, int]] = [(x, y) for x, y in cells.tolist()]
    at = 0
    # Three pieces a, b, a become two: the middle one is moved to the end, or to the front.
    while at + 3 < len(kept):
        (x0, y0), (x1, y1), (x2, y2), (x3, y3) = kept[at : at + 4]
        if _direction(x1 - x0, y1 - y0) == _direction(x3 - x2, y3 - y2):
            for x, y in ((x0 + x2 - x1, y0 + y2 - y1), (x1 + x3 - x2, y1 + y3 - y2)):
                if _is_free(x0, y0, x, y, allowed) and _is_free(x, y, x3, y3, allowed):
                    kept[at + 1 : at + 3] = [(x, y)]
                    at = max(at - 2, -1)
                    break
        at += 1
    return _without_straights(np.array(kept))


def _direction(x: int, y: int) -> tuple[int, int]:
    return (x > 0) - (x < 0), (y > 0) - (y < 0)


@compiled
def _is_free(x: int, y: int, to_x: int, to_y: int, allowed: Mask) -> bool:
    """Return whether one may step from cell to cell along a straight or a diagonal."""
    dx, dy = np.sign(to_x - x), np.sign(to_y - y)
    if not allowed[y, x]:
        return False
    while x != to_x or y != to_y:
        if not (allowed[y + dy, x + dx] and allowed[y, x + dx] and allowed[y + dy, x]):
            return False
        x += dx
        y += dy
    return True


def _without_straights(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """Leave out places where the path goes straight on."""
    if len(cells) < 3:
        return cells
    directions = np.sign(np.diff(cells, axis=0))
    turns = (directions[1:] != directions[:-1]).any(axis=1)
    return cells[np.concatenate(([True], turns, [True]))]
