"""
Plans that somebody asks for, beside those for the robot.
"""

from __future__ import annotations

import math

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_planner.methods.planner_options import within
from quad_planner.session.planning_map import PlanningMap


def plan_between(
    planning_map: PlanningMap,
    start: tuple[str, Pose2D],
    goal: tuple[str, Pose2D],
    longest: float = math.inf,
) -> Plan:
    """
    Plan once, beside what is planned for the robot.

    Parameters
    ----------
    planning_map : PlanningMap
        What is planned on.
    start, goal : tuple of str and Pose2D
        Each with its frame; without a name it is the map's.
    longest : float
        Time that the search may take, if its time limit is not shorter [s].

    Returns
    -------
    Plan
        The turning points.

    Raises
    ------
    PlannerError
        If there is no map or no plan, or nothing relates a frame to the map's.
    """
    # Unlike a topic, a request is meant for this planner: its map goes without saying.
    name = planning_map.frame.name
    ends = (
        planning_map.pose_on_map(frame or name, pose, what)
        for (frame, pose), what in ((start, 'start'), (goal, 'goal'))
    )
    with within(longest):
        return planning_map.planner.plan(*ends)
