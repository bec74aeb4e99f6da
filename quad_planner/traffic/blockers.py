"""
Which robots leave no path to a goal, where the map alone leaves one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from quad_common.errors import PlannerError
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distance_to_polyline
from quad_planner.session.planning_map import PlanningMap
from quad_planner.session.session_ports import Requests
from quad_planner.traffic.robot_on_map import RobotOnMap

_MOVED = 0.15
"""Distance by which the robot has to move for the path to be planned again [m]."""

_BESIDE = 0.05
"""Distance by which a body on the map may lie beside the robot: it is moved seldom [m]."""


class Blockers:
    """
    Tells the robots that block a goal from those that stand elsewhere.

    Parameters
    ----------
    planning_map : PlanningMap
        What is planned on, with the bodies of robots that stay.
    requests : Requests
        The part that works on searches which are not for the robot.
    """

    def __init__(self, planning_map: PlanningMap, requests: Requests) -> None:
        self._map = planning_map
        self._requests = requests
        self._found: tuple[Plan | None] | None = None
        self._planned: tuple[object, Pose2D, Pose2D] | None = None

    def names(self, start: Pose2D, goal: Pose2D, robots: Iterable[RobotOnMap]) -> list[str] | None:
        """
        Return the names of robots on the path that there would be without any.

        Parameters
        ----------
        start, goal : Pose2D
            In the map; with the bodies there is no path between them.
        robots : iterable of RobotOnMap
            Those that stay where they are.

        Returns
        -------
        list of str, or None
            Empty if the map leaves no path without them either; None while that is searched.
        """
        robots = list(robots)
        if not robots:
            return []
        found = self._free_plan(start, goal)
        if found is None:
            return None
        (plan,) = found
        if plan is None:
            return []
        prepared = self._map.planner.prepared
        assert prepared is not None
        cell = prepared.grid.resolution
        beyond = self._map.planner.clearance_radius + _BESIDE + math.sqrt(2.0) * cell
        return sorted(
            robot.name
            for robot in robots
            if distance_to_polyline((robot.pose.x, robot.pose.y), plan.corners)
            < beyond + robot.radius
        )

    def _free_plan(self, start: Pose2D, goal: Pose2D) -> tuple[Plan | None] | None:
        """
        Return the plan without bodies, if there is one, searched once for a map and a place.

        While it is searched anew, for another map, it is the one from before; None at first.
        """
        on = self._map.planner.prepared
        if self._planned is not None:
            before, planned_from, planned_to = self._planned
            if planned_to != goal:
                self._found = None
            elif before is on and start.distance_to(planned_from) <= _MOVED:
                return self._found
        if not self._requests.is_busy:
            # One at a time: of a map that changes all the time none would ever be answered.
            self._planned = on, start, goal
            self._requests.submit(self._map.search_without_bodies(start, goal), self._receive)
        return self._found

    def _receive(self, result: Callable[[], Plan]) -> None:
        try:
            self._found = (result(),)
        except PlannerError:
            self._found = (None,)
