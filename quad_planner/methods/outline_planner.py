"""
Any planning method, with the robot's outline where that is of use.

The method plans by the circle as ever. The outline's plan is taken where the method finds none,
or where it takes fewer gait cycles: so nothing is refused that was not, and nothing takes longer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import (
    GoalOccupied,
    NoPathFound,
    ParameterError,
    PlannerError,
    PlannerTimedOut,
    PlanSuperseded,
    StartOccupied,
)
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_planner.costs.cell_costs import CostLayer
from quad_planner.grid.array_types import Mask, Points
from quad_planner.grid.bit_grid import BitMask, Bits
from quad_planner.grid.dilation import dilated
from quad_planner.grid.inflated_map import SAME_PLACE, InflatedMap
from quad_planner.grid.inflation import inflated
from quad_planner.methods.potential_planner import PotentialPlanner
from quad_planner.outline.arcs import ArcTurns, with_short_arcs
from quad_planner.outline.class_layers import class_layers
from quad_planner.outline.heading_kernels import CLASSES, Kernels, class_of, kernels_of
from quad_planner.outline.heading_moves import LONGEST_MOVE, inside_cell, moves_from
from quad_planner.outline.leg_choice import LegCosts, LegEnds, chosen_legs, with_approaches
from quad_planner.outline.outline_search import Ends, free_for_smallest, outline_path
from quad_planner.outline.outline_zones import Zones, around_start, fits_in, zones_of
from quad_planner.outline.robot_outline import inner_radius, outer_radius
from quad_planner.outline.turn_rule import may_turn

Array = NDArray[np.float64]
Prepared = TypeVar('Prepared', bound=InflatedMap)

BY_OUTLINE = 'planned by the outline'
"""Remark on a plan that the circle alone would not allow, or not so soon."""


@dataclass(frozen=True)
class OutlineOptions:
    """
    The robot's outline, and how it follows a plan.

    Raises
    ------
    ParameterError
        If the distance is not a finite one of at least 0.
    """

    outline: Array
    """Corners of a convex polygon in the body frame, counter-clockwise, shape (n, 2) [m]."""
    safety_distance: float
    """Distance that it keeps from obstacles, >= 0 [m]."""
    start_tolerance: float = 0.0
    """Distance by which a start may be nearer [m]."""
    circle_radius: float = 0.0
    """Radius of the circle that holds it, where the robot's own does not [m]."""
    keeps_heading: bool = False
    """Whether the robot keeps its heading while it walks, as with turning ``crab``."""
    arcs: ArcTurns | None = None
    """Arcs by which corners are rounded, with turning ``arc``."""
    pace: WalkingTimeModel | None = None
    """Pace of the gait; lengths are compared without it."""

    def __post_init__(self) -> None:
        """Check the distance."""
        if not (math.isfinite(self.safety_distance) and self.safety_distance >= 0.0):
            raise ParameterError(
                'safety_distance', self.safety_distance, 'a finite length of at least 0 m'
            )


@dataclass(frozen=True, eq=False)
class PreparedOutline(InflatedMap):
    """A map made ready for the circle, and for the outline as soon as that is asked for."""

    by_circle: Any
    """The map as the planning method prepared it."""
    options: OutlineOptions
    """The outline."""
    kernels: tuple[Kernels, Kernels]
    """Cells that it reaches, and those around a start that may be nearer to obstacles."""

    @cached_property
    def inner_bits(self) -> BitMask:
        """Return the cells in which no heading fits."""
        options = self.options
        radius = inner_radius(options.outline) + options.safety_distance
        return inflated(self.blocked_bits, radius / self.grid.resolution)

    @cached_property
    def classes(self) -> Bits | None:
        """Return the cells in which each class of headings does not fit, where that is known."""
        return class_layers(self.blocked_bits.words, self.grid.width, self.kernels[0])

    @cached_property
    def small(self) -> Mask:
        """Return where some heading fits, or may fit, in squares of two by two cells."""
        if self.classes is None:
            return free_for_smallest(self.inner_bits.unpacked())
        words = np.bitwise_and.reduce(self.classes, axis=0) & self.forbidden_bits.words
        return free_for_smallest(BitMask(words, self.grid.width).unpacked())

    @cached_property
    def zones(self) -> Zones:
        """Return the map for compiled code."""
        narrow = dilated(self.forbidden_bits.words, np.full(LONGEST_MOVE + 1, LONGEST_MOVE))
        layers = (
            self.blocked_bits.words,
            self.forbidden_bits.words,
            self.inner_bits.words,
            narrow,
        )
        return zones_of(layers, self.grid.width, self.kernels, self.classes)


class OutlinePlanner(Generic[Prepared]):
    """
    Plans by a method and its circle, and by the outline.

    Parameters
    ----------
    method : PlannerOptions
        The planning method; its circle holds the outline, or is the robot's own.
    options : OutlineOptions
        The outline.
    """

    def __init__(self, method: Any, options: OutlineOptions) -> None:
        self._method = method
        self._options = options
        # What it compares is not the time.
        self._prefers_circle = bool(method.costs) or isinstance(method, PotentialPlanner)
        self._kernels: tuple[float, tuple[Kernels, Kernels]] | None = None

    @property
    def clearance_radius(self) -> float:
        """Distance that the robot's center keeps from every obstacle by the circle [m]."""
        return float(self._method.clearance_radius)

    @property
    def costs(self) -> tuple[CostLayer, ...]:
        """Reasons why paths by the circle through some cells cost more."""
        return tuple(self._method.costs)

    def prepare(self, grid: OccupancyGrid) -> PreparedOutline:
        """Make a map ready for any number of plans."""
        return self.around(self._method.prepare(grid))

    def update(
        self, prepared: PreparedOutline, grid: OccupancyGrid, changed: tuple[int, int]
    ) -> PreparedOutline:
        """Make a map ready of which only some rows have changed: `PlanningMethod.update`."""
        return self.around(self._method.update(prepared.by_circle, grid, changed))

    def around(self, by_circle: InflatedMap) -> PreparedOutline:
        """Take a map that the method has made ready for the circle."""
        return PreparedOutline(
            by_circle.grid,
            by_circle.clearance_radius,
            by_circle.blocked_bits,
            by_circle.forbidden_bits,
            by_circle,
            self._options,
            self._kernels_for(by_circle.grid.resolution),
        )

    def _kernels_for(self, resolution: float) -> tuple[Kernels, Kernels]:
        """Return the cells that the robot reaches, and those with the start's tolerance."""
        if self._kernels is None or self._kernels[0] != resolution:
            options = self._options
            nearer = max(0.0, options.safety_distance - options.start_tolerance)
            self._kernels = (
                resolution,
                (
                    kernels_of(options.outline, options.safety_distance, resolution),
                    kernels_of(options.outline, nearer, resolution),
                ),
            )
        return self._kernels[1]

    def plan(self, prepared: PreparedOutline, start: Pose2D, goal: Pose2D) -> Plan:
        """
        Plan by the circle and by the outline, and return what takes less time.

        Parameters
        ----------
        prepared : PreparedOutline
            The map, from `prepare`.
        start, goal : Pose2D
            In the world [m, m, rad].

        Returns
        -------
        Plan
            The turning points. Its remark is :data:`BY_OUTLINE` if the circle's plan takes more
            gait cycles, or is longer where the gait's pace is not known, or there is none.

        Raises
        ------
        PlannerError
            As the planning method's, if the outline finds no path either.
        """
        by_circle: Plan | None = None
        problem: PlannerError | None = None
        try:
            by_circle = self._method.plan(prepared.by_circle, start, goal)
        except (PlannerTimedOut, PlanSuperseded):
            raise
        except PlannerError as error:
            if not isinstance(error, (NoPathFound, StartOccupied, GoalOccupied)):
                raise
            problem = error
        if by_circle is not None and (
            self._prefers_circle or self._cost(start, by_circle) <= self._least_cost(start, goal)
        ):
            return by_circle
        by_outline = self.plan_by_outline(prepared, start, goal)
        if by_outline is None:
            if by_circle is None:
                assert problem is not None
                raise problem
            return by_circle
        if by_circle is None or self._cost(start, by_outline) < self._cost(start, by_circle):
            return by_outline
        return by_circle

    def _cost(self, start: Pose2D, plan: Plan) -> float:
        pace = self._options.pace
        return plan.length if pace is None else float(pace.cycles(start, plan))

    def _least_cost(self, start: Pose2D, goal: Pose2D) -> float:
        """Return a cost that no plan is below: straight on."""
        distance, pace = start.distance_to(goal), self._options.pace
        return distance if pace is None else float(pace.straight_cycles(distance))

    def plan_by_outline(
        self, prepared: PreparedOutline, start: Pose2D, goal: Pose2D
    ) -> Plan | None:
        """Plan by the outline alone; None if it does not fit, or finds no path."""
        options, grid = self._options, prepared.grid
        s, g = (
            np.array(inside_cell(*grid.world_to_map(np.array([[p.x, p.y]]))[0]))
            for p in (start, goal)
        )
        yaw = grid.origin.yaw
        start_class, goal_class = (class_of(pose.yaw - yaw) for pose in (start, goal))
        zones, small = prepared.zones, prepared.small
        x, y, goal_x, goal_y = (math.floor(v) for v in (*s, *g))
        if not fits_in(zones, goal_x, goal_y, goal_class):
            return None
        if not fits_in(zones, x, y, start_class):
            zones = around_start(zones, x, y)
            if not fits_in(zones, x, y, start_class):
                return None
            left, bottom = max(zones.left, 0) // 2, max(zones.bottom, 0) // 2
            small = small.copy()
            small[bottom : zones.top // 2 + 1, left : zones.right // 2 + 1] = True
        check = self._method.timer()
        ends = Ends(x, y, start_class, goal_x, goal_y, goal_class, options.keeps_heading)
        if start.distance_to(goal) < SAME_PLACE:
            return Plan((goal,)) if may_turn_at(zones, ends) else None
        cells = outline_path(zones, moves_from(*s), ends, small, check)
        if cells is None:
            return None
        path = cells[:, :2] + (s - np.floor(s))
        reach = outer_radius(options.outline) / grid.resolution + 1.0
        if len(path) == 1:
            path = np.vstack((s, s))
        fixed = start_class if options.keeps_heading else -1
        leg_ends = LegEnds(s, start.yaw - yaw, g, goal.yaw - yaw, fixed)
        costs = LegCosts.of(options.pace, grid.resolution)
        # Few legs first, for then places to turn may be added to each.
        few = chosen_legs(zones, path, leg_ends, costs, 8)
        if few is None:
            return None
        points = chosen_legs(zones, with_approaches(few, reach), leg_ends, costs, 40)
        if points is None:
            points = few
        if options.arcs is not None:
            points = with_short_arcs(zones, points, options.arcs, grid.resolution)
        return self._plan(grid, points, start, goal)

    def _plan(self, grid: OccupancyGrid, points: Points, start: Pose2D, goal: Pose2D) -> Plan:
        """Make a plan of points [cells]; those that only make arcs smaller are kept."""
        inner = grid.map_to_world(points[1:-1]).tolist()
        corners = [(start.x, start.y), *inner, (goal.x, goal.y)]
        if self._options.arcs is None:
            return replace(Plan.through(corners, goal.yaw), remark=BY_OUTLINE)
        places = [Pose2D(px, py, goal.yaw) for px, py in corners]
        poses = [Pose2D(here.x, here.y, here.heading_to(there)) for here, there in pairwise(places)]
        return Plan((*poses, goal), remark=BY_OUTLINE)


def may_turn_at(zones: Zones, ends: Ends) -> bool:
    """Return whether the robot may turn from its heading to the goal's where it stands."""
    fitting = np.array([fits_in(zones, ends.x, ends.y, k) for k in range(CLASSES)], dtype=np.int64)
    return bool(may_turn(fitting, int(fitting.sum()), ends.heading_class, ends.goal_class, True))
