"""
Any planning method, with footholds for the robot's feet along its plans.

The method plans as ever. Where the robot would find no footing somewhere along its plan, by the
height map, another one is searched over cells and headings at which it does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GoalWithoutFooting
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_planner.costs.cell_costs import CostLayer
from quad_planner.costs.ground_difficulty import GridOverGround
from quad_planner.footing.footing import FootedRobot, Footing
from quad_planner.grid.bit_grid import BitMask, Bits
from quad_planner.grid.inflated_map import InflatedMap
from quad_planner.methods.outline_planner import OutlineOptions, OutlinePlanner, PreparedOutline
from quad_planner.methods.planner_options import is_hurried
from quad_planner.outline.heading_kernels import STEP, class_of

Array = NDArray[np.float64]

BY_FOOTING = 'planned around ground without footholds'
"""Remark on a plan that the method alone would not have made."""

WITHOUT_FOOTING = (
    'near ({x:.2f}, {y:.2f}) m the plan leads over ground without footholds for all feet; '
    'no other plan was found'
)
"""Remark on a plan that could not be made better."""

_DISTANCE = 0.06
"""Distance from the goal at which the gait has arrived if it gets no nearer [m, of TITAN-VIII]."""

_APART = 0.5
"""Distance between poses along a plan at which footholds are looked for [cells]."""


@dataclass(frozen=True)
class FootingOptions:
    """The robot, and how it follows a plan."""

    footed: FootedRobot
    """The robot, and what it takes for a foothold."""
    outline: OutlineOptions
    """Its outline, which holds where it begins nearer to obstacles than its circle may be."""


@dataclass(frozen=True, eq=False)
class PreparedFooting(InflatedMap):
    """A map made ready by a method, and for plans over footholds as soon as that is asked for."""

    by_method: Any
    """The map as the planning method prepared it."""
    footing: Footing
    """Where the robot can stand on the ground there."""
    searched: OutlinePlanner[Any]
    """Search over cells and headings."""
    fits_by_outline: bool
    """Whether the outline counts where the circle does not fit."""

    @cached_property
    def unfit(self) -> Bits | None:
        """Return the cells in which each class of headings finds no footholds, where known."""
        return self.footing.layers(self.grid)

    @property
    def is_ready(self) -> bool:
        """Whether nothing takes long any more of what a plan over footholds needs."""
        return self.footing.is_known(self.grid) and 'by_heading' in self.__dict__

    @cached_property
    def by_heading(self) -> PreparedOutline:
        """Return the map for the search over cells and headings."""
        assert self.unfit is not None
        if self.fits_by_outline:
            by_outline = self.by_method
            classes = by_outline.classes
        else:
            by_outline = self.searched.around(self.by_method)
            classes = self.forbidden_bits.words[None]
        forbidden = self.forbidden_bits.words | np.bitwise_or.reduce(self.unfit, axis=0)
        # What is cached of the outline's map must not stay: it is made again of these.
        prepared: PreparedOutline = replace(
            by_outline, forbidden_bits=BitMask(forbidden, self.grid.width)
        )
        prepared.__dict__['classes'] = None if classes is None else classes | self.unfit
        return prepared

    def is_unfit(self, pose: Pose2D) -> bool:
        """Return whether the robot finds no footholds at a pose in the world; not off the map."""
        grid = self.grid
        column, row = np.floor(grid.world_to_map(np.array([[pose.x, pose.y]]))[0]).astype(int)
        is_on_map = 0 <= column < grid.width and 0 <= row < grid.height
        if self.unfit is None or not is_on_map:
            return False
        layer = self.unfit[class_of(pose.yaw - grid.origin.yaw)]
        return BitMask(layer, grid.width)[int(row), int(column)]


class FootedPlanner:
    """
    Plans by a method, and over footholds where its plan lacks them.

    Parameters
    ----------
    method : PlanningMethod
        The planning method, or an :class:`OutlinePlanner` of it.
    options : FootingOptions
        The robot.
    """

    def __init__(self, method: Any, options: FootingOptions) -> None:
        self._method = method
        self._options = options
        self._by_outline = isinstance(method, OutlinePlanner)
        self._searched = method if self._by_outline else OutlinePlanner(method, options.outline)

    @property
    def footed(self) -> FootedRobot:
        """The robot, and what it takes for a foothold."""
        return self._options.footed

    @property
    def clearance_radius(self) -> float:
        """Distance that the robot's center keeps from every obstacle by the circle [m]."""
        return float(self._method.clearance_radius)

    @property
    def costs(self) -> tuple[CostLayer, ...]:
        """Reasons why paths of the method through some cells cost more."""
        return tuple(self._method.costs)

    def prepare(self, grid: OccupancyGrid) -> InflatedMap:
        """Make a map ready for any number of plans."""
        return self._of(self._method.prepare(grid))

    def update(
        self, prepared: InflatedMap, grid: OccupancyGrid, changed: tuple[int, int]
    ) -> InflatedMap:
        """Make a map ready of which only some rows have changed: `PlanningMethod.update`."""
        before = prepared.by_method if isinstance(prepared, PreparedFooting) else prepared
        return self._of(self._method.update(before, grid, changed))

    def _of(self, by_method: InflatedMap) -> InflatedMap:
        grid = by_method.grid
        if not isinstance(grid, GridOverGround) or grid.footing is None:
            return by_method
        return PreparedFooting(
            grid,
            by_method.clearance_radius,
            by_method.blocked_bits,
            by_method.forbidden_bits,
            by_method,
            grid.footing,
            self._searched,
            self._by_outline,
        )

    def plan(self, prepared: InflatedMap, start: Pose2D, goal: Pose2D) -> Plan:
        """
        Plan by the method, and over footholds where that plan lacks them.

        A search within a time (:func:`~quad_planner.methods.planner_options.within`) does not wait
        for what is not known of footholds yet: its plan is the method's own.

        Parameters
        ----------
        prepared : InflatedMap
            The map, from `prepare`.
        start, goal : Pose2D
            In the world [m, m, rad].

        Returns
        -------
        Plan
            The turning points. Its remark is :data:`BY_FOOTING` if it is not the method's own;
            or it says where there are no footholds, if no other plan was found.

        Raises
        ------
        GoalWithoutFooting
            If the robot could not stand at the goal, nor so near to it that it would have arrived.
        PlannerError
            As the planning method's.
        """
        if not isinstance(prepared, PreparedFooting):
            own: Plan = self._method.plan(prepared, start, goal)
            return own
        plan: Plan = self._method.plan(prepared.by_method, start, goal)
        if (is_hurried() and not prepared.is_ready) or prepared.unfit is None:
            return plan
        self._check_goal(prepared, goal)
        lacks = self._lack_on(prepared, start, plan)
        if lacks is None:
            return plan
        other = self._searched.plan_by_outline(prepared.by_heading, start, goal)
        if other is not None and self._lack_on(prepared, start, other) is None:
            return replace(other, remark=BY_FOOTING)
        return replace(plan, remark=WITHOUT_FOOTING.format(x=lacks.x, y=lacks.y))

    def _check_goal(self, prepared: PreparedFooting, goal: Pose2D) -> None:
        distance = self._tolerance
        around = [(0.0, 0.0)]
        around += [
            (distance * math.cos(a), distance * math.sin(a)) for a in np.arange(8) * (math.pi / 4.0)
        ]
        for dx, dy in around:
            for turn in (0.0, STEP, -STEP):
                if not prepared.is_unfit(Pose2D(goal.x + dx, goal.y + dy, goal.yaw + turn)):
                    return
        raise GoalWithoutFooting(goal.x, goal.y, goal.yaw, distance, STEP)

    def _lack_on(self, prepared: PreparedFooting, start: Pose2D, plan: Plan) -> Pose2D | None:
        """Return the first pose of a plan at which footholds are missing; None if there is none."""
        goal, near = plan.poses[-1], self._options.footed.robot.standing_radius
        for pose in self._poses(start, plan, _APART * prepared.grid.resolution):
            # It stands at the start, and near enough to the goal.
            is_end = pose.distance_to(start) < 0.5 * near or (
                pose.distance_to(goal) < self._tolerance
                and abs(wrap_angle(pose.yaw - goal.yaw)) < 1.5 * STEP
            )
            if not is_end and prepared.is_unfit(pose):
                return pose
        return None

    @property
    def _tolerance(self) -> float:
        """Distance from the goal within which the robot has arrived [m]."""
        return self._options.footed.robot.relative_size * _DISTANCE

    def _poses(self, start: Pose2D, plan: Plan, apart: float) -> list[Pose2D]:
        """Return poses along a plan: along its legs, and of its turns at their corners."""
        keeps, heading = self._options.outline.keeps_heading, start.yaw
        poses: list[Pose2D] = []
        for here, there in pairwise(plan.poses):
            towards = heading if keeps else here.heading_to(there)
            poses += _turn(here, heading, towards)
            way = np.linspace(0.0, 1.0, 2 + int(here.distance_to(there) / apart))
            x, y = here.x + way * (there.x - here.x), here.y + way * (there.y - here.y)
            poses += [Pose2D(u, v, towards) for u, v in zip(x.tolist(), y.tolist())]
            heading = towards
        goal = plan.poses[-1]
        return poses + _turn(goal, heading, goal.yaw)


def _turn(place: Pose2D, before: float, after: float) -> list[Pose2D]:
    """Return poses of a turn on the spot by the short side, from a heading to another [rad]."""
    turn = wrap_angle(after - before)
    way = np.linspace(0.0, 1.0, 2 + int(abs(turn) / STEP))
    return [Pose2D(place.x, place.y, before + part * turn) for part in way.tolist()]
