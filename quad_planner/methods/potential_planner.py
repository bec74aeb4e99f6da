"""
Plan by potential functions (S1): down the paper's, or down one without local minima.

The paper's descent comes to rest where attraction and repulsion are equal
(:mod:`quad_planner.potential.map_potential`); a navigation function has no such place
(:mod:`quad_planner.potential.navigation_field`). Either descent is a smooth path, of which as few
turning points are kept as its deviation allows (:mod:`quad_planner.search.simplification`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from quad_common.errors import DescentStuck, NoPathFound, ParameterError
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_planner.costs.cell_costs import cell_costs
from quad_planner.grid.array_types import Points
from quad_planner.grid.inflated_map import InflatedMap
from quad_planner.methods.cell_request import CellRequest
from quad_planner.methods.planner_options import PlannerOptions
from quad_planner.potential.map_potential import (
    Floats,
    Gains,
    MapPotential,
    boundary_distances,
    boundary_distances_anew,
)
from quad_planner.potential.navigation_field import (
    descend_times,
    slowness_near_obstacles,
    travel_times,
)
from quad_planner.potential.path_steps import steps_along
from quad_planner.search.simplification import all_seen, fewest_corners

POTENTIALS = ('paper', 'navigation', 'either')
"""Values of the option `potential`."""

_BY_PAPER = "S1's potential leads to the goal"
_BY_NAVIGATION = 'a navigation function leads to the goal'

_STEP = 1.0
"""Length of the steps into which a descent is cut before it is simplified [cells]."""


@dataclass(frozen=True, eq=False)
class PreparedPotential(InflatedMap):
    """A map made ready for any number of descents; `PotentialPlanner.prepare` makes it."""

    distances: Floats
    """Distances of the cells from the safety boundary, shape (height, width) [m]."""
    costs: Floats | None = None
    """Factors by which a path through each cell is slower; None if no cell is."""


@dataclass(frozen=True)
class PotentialPlanner(PlannerOptions):
    """
    Plan down a potential.

    Raises
    ------
    ParameterError
        If `potential` is none of :data:`POTENTIALS`, the deviation is negative or not
        finite, or a gain is not positive and finite.
    """

    potential: str = 'either'
    """The paper's, a navigation function, or that where the paper's descent sticks."""
    path_deviation: float = 0.05
    """Distance by which the plan may be off the descent, >= 0 [m]."""
    influence: float = Gains().influence
    """
    Distance from the safety boundary beyond which obstacles neither repel nor slow down, Q* [m].
    """
    repulsion: float = Gains().repulsion
    """eta, of the paper's potential."""
    attraction: float = Gains().attraction
    """zeta, of the paper's potential."""
    goal_distance: float = Gains().goal_distance
    """d*_goal, of the paper's potential [m]."""

    knows_costs: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Check the options."""
        super().__post_init__()
        if self.potential not in POTENTIALS:
            raise ParameterError('potential', self.potential, f'one of {", ".join(POTENTIALS)}')
        if self.costs and self.potential != 'navigation':
            raise ParameterError('potential', self.potential, "'navigation' where there are costs")
        deviation = self.path_deviation
        if not (math.isfinite(deviation) and deviation >= 0.0):
            raise ParameterError('path_deviation', deviation, 'a finite length of at least 0 m')
        self.gains.check()

    @property
    def gains(self) -> Gains:
        """Return the constants of the paper's potential."""
        return Gains(self.repulsion, self.attraction, self.influence, self.goal_distance)

    def prepare(self, grid: OccupancyGrid) -> PreparedPotential:
        """
        Inflate a map, and measure how far it is to the safety boundary.

        Parameters
        ----------
        grid : OccupancyGrid
            The map.

        Returns
        -------
        PreparedPotential
            What `plan` needs of the map, for any number of plans.
        """
        safety = self.inflated_map(grid)
        distances = boundary_distances(
            safety.blocked_bits, *self._distance_options(grid.resolution)
        )
        return PreparedPotential(
            grid,
            self.clearance_radius,
            safety.blocked_bits,
            safety.forbidden_bits,
            distances,
            cell_costs(self.costs, safety),
        )

    def update(
        self, prepared: PreparedPotential, grid: OccupancyGrid, changed: tuple[int, int]
    ) -> PreparedPotential:
        """Make a map ready of which only some rows have changed: `PlanningMethod.update`."""
        blocked, forbidden, _ = self.zones_changed_to(prepared, grid, changed)
        options = self._distance_options(grid.resolution)
        distances = boundary_distances_anew(prepared.distances, blocked, *options, changed)
        safety = InflatedMap(grid, self.clearance_radius, blocked, forbidden)
        costs = cell_costs(self.costs, safety)
        return PreparedPotential(grid, self.clearance_radius, blocked, forbidden, distances, costs)

    def _distance_options(self, resolution: float) -> tuple[float, float, float]:
        """Return what distances to the boundary are measured by; beyond Q* nothing matters."""
        return self.clearance_radius, resolution, self.influence + 3.0 * resolution

    def plan(self, prepared: PreparedPotential, start: Pose2D, goal: Pose2D) -> Plan:
        """
        Descend, and keep the turning points.

        A start that is inside the safety boundary by no more than `start_tolerance` is
        left on a segment that comes no nearer to an obstacle than the start is.

        Parameters
        ----------
        prepared : PreparedPotential
            The map, from `prepare`.
        start, goal : Pose2D
            In the world [m, m, rad].

        Returns
        -------
        Plan
            The turning points; its remark says which potential led there.

        Raises
        ------
        InvalidPose, StartOutsideMap, GoalOutsideMap, StartOccupied, GoalOccupied
            As :meth:`InflatedMap.check_ends`.
        DescentStuck
            If the paper's descent comes to rest elsewhere, and no other is allowed.
        NoPathFound
            If no path leads to the goal.
        PlannerTimedOut
            If it took longer than `time_limit`.
        """
        request = CellRequest.of(prepared, start, goal, self.start_tolerance, self.timer())
        if request.is_turn:
            return Plan((goal,))
        first, last = (int(prepared.areas[y, x]) for x, y in request.ends)
        if first != last:
            raise request.no_path()
        path, remark = self._descent(prepared, request)
        corners = self._corners(prepared, path, request.check)
        return replace(request.plan(request.joined(corners)), remark=remark)

    def _descent(self, prepared: PreparedPotential, request: CellRequest) -> tuple[Points, str]:
        """Descend from the start to the goal, and say by what; points in cells."""
        if self.potential == 'navigation':
            return self._navigate(prepared, request), _BY_NAVIGATION
        top, bottom = request.tips
        field = MapPotential(
            prepared.forbidden_bits,
            prepared.distances,
            prepared.grid.resolution,
            bottom,
            self.gains,
        )
        path, has_arrived = field.descend(top, request.check)
        if has_arrived:
            return path, _BY_PAPER
        place = prepared.grid.map_to_world(path[-1])
        start, goal = ((pose.x, pose.y) for pose in (request.start, request.goal))
        stuck = DescentStuck(start, goal, place.tolist(), *field.critical_point(path[-1]))
        if self.potential == 'paper':
            raise stuck
        x, y = stuck.place
        remark = f"{_BY_NAVIGATION}; S1's comes to rest at ({x:.2f}, {y:.2f}) m, {stuck.kind}"
        return self._navigate(prepared, request), remark

    def _navigate(self, prepared: PreparedPotential, request: CellRequest) -> Points:
        """Descend a navigation function from the start to the goal, in cells."""
        slowness = slowness_near_obstacles(prepared.distances, prepared.forbidden, self.influence)
        if prepared.costs is not None:
            slowness *= prepared.costs
        top, bottom = request.tips
        first, last = (_cell_of(point, slowness) for point in (top, bottom))
        times = travel_times(slowness, last, first, request.check)
        if not np.isfinite(times[first[1], first[0]]):
            start, goal = ((pose.x, pose.y) for pose in (request.start, request.goal))
            raise NoPathFound(start, goal, 'the only passage is as wide as the corner of a cell')
        path = descend_times(times, prepared.forbidden_bits, top, last, request.check)
        return np.vstack((path, bottom))

    def _corners(
        self, prepared: PreparedPotential, path: Points, check_time: Callable[[], None]
    ) -> Points:
        """Keep the turning points of a descent, in cells."""
        forbidden, deviation = prepared.forbidden_bits, self.path_deviation
        steps = steps_along(path, _STEP)[0]
        if not all_seen(steps, forbidden):
            # A step across a bend would cut a forbidden corner.
            steps = path
        return fewest_corners(steps, deviation / prepared.grid.resolution, forbidden, check_time)


def _cell_of(point: Points, cells: Floats) -> tuple[int, int]:
    """Return x and y of the cell that holds a point on the map."""
    height, width = cells.shape
    return min(math.floor(point[0]), width - 1), min(math.floor(point[1]), height - 1)
