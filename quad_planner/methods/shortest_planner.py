"""
The shortest path over the cells of the map, or at any angle.

Over cells: straight and diagonal steps from center to center, no corner cut, exact
(:mod:`quad_planner.search.jump_points`). At any angle: taut around the safety boundary
(:mod:`quad_planner.any_angle.interval_search`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, compiled_part
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_planner.any_angle.free_space import FreeSpace
from quad_planner.any_angle.interval_search import any_angle_path
from quad_planner.costs.cell_costs import Floats, cell_costs
from quad_planner.grid.array_types import Points
from quad_planner.grid.bit_grid import BitGrid, Bits, is_set
from quad_planner.grid.inflated_map import InflatedMap
from quad_planner.methods.cell_request import CellRequest
from quad_planner.methods.planner_options import PlannerOptions
from quad_planner.search.cell_path import without_straights
from quad_planner.search.jump_points import JumpPointSearch
from quad_planner.search.lattice_search import fewest_turns
from quad_planner.search.weighted_search import PARTS, cheapest_path, straightened


@dataclass(frozen=True, eq=False)
class PreparedCells(InflatedMap):
    """A map made ready for any number of searches; `ShortestPlanner.prepare` makes it."""

    search: JumpPointSearch
    """Search over the allowed cells."""
    costs: Floats | None = None
    """Factors by which a path through each cell costs more; None if no cell does."""

    @cached_property
    def weights(self) -> NDArray[np.int32] | None:
        """Those factors in sixteenths, as whole numbers."""
        return None if self.costs is None else np.rint(PARTS * self.costs).astype(np.int32)

    @cached_property
    def space(self) -> FreeSpace:
        """Allowed cells as searches at any angle want them, made when they are first needed."""
        return FreeSpace.outside(self.forbidden_bits)


@dataclass(frozen=True)
class ShortestPlanner(PlannerOptions):
    """Plans the shortest path, whatever turns it takes; or, with costs, the cheapest."""

    any_angle: bool = False
    """
    Whether the path may have any direction, not only those of the cells. With costs it is
    the cheapest path over the cells, straightened where that costs no more.
    """
    fewest_turns: bool = False
    """
    Whether the path over the cells is proven to have the fewest turns of all that are as
    short; that takes longer than the path itself.
    """

    knows_costs: ClassVar[bool] = True

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
        safety = self.inflated_map(grid)
        search = JumpPointSearch(BitGrid.outside(safety.forbidden_bits))
        return PreparedCells(
            grid,
            self.clearance_radius,
            safety.blocked_bits,
            safety.forbidden_bits,
            search,
            cell_costs(self.costs, safety),
        )

    def update(
        self, prepared: PreparedCells, grid: OccupancyGrid, changed: tuple[int, int]
    ) -> PreparedCells:
        """Make a map ready of which only some rows have changed: `PlanningMethod.update`."""
        blocked, forbidden, rows = self.zones_changed_to(prepared, grid, changed)
        cells = prepared.search.grid.changed_to(forbidden, rows)
        safety = InflatedMap(grid, self.clearance_radius, blocked, forbidden)
        return PreparedCells(
            grid,
            self.clearance_radius,
            blocked,
            forbidden,
            JumpPointSearch(cells),
            cell_costs(self.costs, safety),
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
            As :meth:`InflatedMap.check_ends`.
        NoPathFound
            If no path over the cells connects them.
        PlannerTimedOut, PlanSuperseded
            As :meth:`PlannerOptions.timer`.
        """
        request = CellRequest.of(prepared, start, goal, self.start_tolerance, self.timer())
        if request.is_turn:
            return Plan((goal,))
        return request.plan(self._line(prepared, request))

    def _line(self, prepared: PreparedCells, request: CellRequest) -> Points:
        """Return start, turning points and goal, shape (n, 2) [cells]."""
        if self.any_angle and prepared.costs is None:
            return self._taut(prepared, request)
        centers = self._centers(prepared, request)
        if self.any_angle and prepared.costs is not None:
            forbidden = prepared.forbidden_bits
            centers = straightened(centers, prepared.costs, forbidden, request.check)
        return request.joined(centers)

    def _taut(self, prepared: PreparedCells, request: CellRequest) -> Points:
        """Return the same of the shortest path at any angle."""
        taut = any_angle_path(prepared.space, *request.tips, check=request.check)
        if taut is None:
            raise request.no_path()
        taut = request.joined(taut)
        if prepared.is_allowed(request.s) and prepared.is_allowed(request.g):
            return taut
        # A start or goal beside the allowed cells may join the path over cells at less length.
        return min(taut, request.joined(self._centers(prepared, request)), key=_length)

    def _centers(self, prepared: PreparedCells, request: CellRequest) -> Points:
        """Return where the path over the cells turns, shape (n, 2) [cells]."""
        check = request.check
        cells: NDArray[np.int64] | None = None
        if prepared.costs is not None:
            cells = cheapest_path(prepared.search.grid, prepared.costs, *request.ends, check)
        else:
            path = prepared.search.path(*request.ends, check)
            if path is not None:
                cells = turns_saved(path.cells, prepared.forbidden_bits.words)
                if len(cells) > 2 and self.fewest_turns and not self.any_angle:
                    cells = fewest_turns(prepared.search.grid, cells, check)
        if cells is None:
            raise request.no_path()
        return cells + np.float64(0.5)


def _length(points: Points) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def turns_saved(cells: NDArray[np.int64], forbidden: Bits) -> NDArray[np.int64]:
    """
    Walk each leg of a path straight or diagonal first, so that there are few turns.

    Parameters
    ----------
    cells : ndarray, shape (n, 2)
        Places where a shortest path begins, turns and ends.
    forbidden : ndarray of uint64, shape (height, k)
        The words of a `BitMask`: the forbidden cells.

    Returns
    -------
    ndarray, shape (m, 2)
        Places of a path that is as short, with no more turns.
    """
    kept = cells.copy()
    return without_straights(kept[: _save_turns(kept, forbidden)])


@compiled_loop
def _save_turns(cells: NDArray[np.int64], forbidden: Bits) -> int:
    """Change a path; return how many of its places are left."""
    count, at = len(cells), 0
    while at + 3 < count:
        x, y = _moved_corner(cells, at, forbidden)
        if x >= 0:
            # Two corners become one.
            cells[at + 1, 0], cells[at + 1, 1] = x, y
            count -= 1
            for k in range(at + 2, count):
                cells[k, 0], cells[k, 1] = cells[k + 1, 0], cells[k + 1, 1]
            at = max(at - 2, -1)
        at += 1
    return count


@compiled_part
def _moved_corner(cells: NDArray[np.int64], at: int, forbidden: Bits) -> tuple[int, int]:
    """
    Find one corner in the place of two: three pieces a, b, a from a place become b, a or a, b.

    Returns x and y, or -1, -1 if the pieces are others, or there is no room.
    """
    x0, y0 = cells[at, 0], cells[at, 1]
    x1, y1 = cells[at + 1, 0], cells[at + 1, 1]
    x2, y2 = cells[at + 2, 0], cells[at + 2, 1]
    x3, y3 = cells[at + 3, 0], cells[at + 3, 1]
    if _direction(x0, y0, x1, y1) == _direction(x2, y2, x3, y3):
        for x, y in ((x0 + x2 - x1, y0 + y2 - y1), (x1 + x3 - x2, y1 + y3 - y2)):
            if _is_free(x0, y0, x, y, forbidden) and _is_free(x, y, x3, y3, forbidden):
                return x, y
    return -1, -1


@compiled_part
def _direction(x: int, y: int, to_x: int, to_y: int) -> tuple[int, int]:
    return int(to_x > x) - int(to_x < x), int(to_y > y) - int(to_y < y)


@compiled_part
def _is_free(x: int, y: int, to_x: int, to_y: int, forbidden: Bits) -> bool:
    """Return whether one may step from cell to cell along a straight or a diagonal."""
    dx, dy = _direction(x, y, to_x, to_y)
    if is_set(forbidden, y, x):
        return False
    while x != to_x or y != to_y:
        for cell_x, cell_y in ((x + dx, y), (x, y + dy), (x + dx, y + dy)):
            if is_set(forbidden, cell_y, cell_x):
                return False
        x += dx
        y += dy
    return True
