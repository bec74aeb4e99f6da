"""
A path that somebody asks for, from pose to pose, while the robot does what it does.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

from quad_common.errors import InvalidPlanner, NoGoals, NoRobotPose
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_planner.session.planning_session import PlanningSession

NAV2_PLANNER = 'GridBased'
"""What Nav2's configurations and behavior trees call the planner."""


def path_work(
    session: PlanningSession,
    start: tuple[str, Pose2D] | None,
    goals: Sequence[tuple[str, Pose2D]],
) -> Callable[[], Plan]:
    """
    Make the work of planning through poses, for whichever thread does it.

    Parameters
    ----------
    session : PlanningSession
        It knows the map, and where the robot is.
    start : tuple of str and Pose2D, or None
        With its frame; None: the robot.
    goals : sequence of tuple of str and Pose2D
        Each with its frame; without a name it is the map's.

    Returns
    -------
    callable
        Returns the plan, or raises a PlannerError.

    Raises
    ------
    NoGoals
        If there are none.
    NoRobotPose
        If the plan is to begin where the robot is, and that is not known.
    WrongFrame
        If nothing relates a frame to the map's.
    """
    planning_map, name = session.map, session.map.frame.name
    if not goals:
        raise NoGoals()
    if start is not None:
        begin = planning_map.pose_on_map(start[0] or name, start[1], 'start')
    elif session.pose is None or session.silence:
        raise NoRobotPose()
    else:
        begin = session.pose
    poses = [begin]
    for frame, goal in goals:
        poses.append(planning_map.pose_on_map(frame or name, goal, 'goal'))
    robot = None if session.silence else session.pose
    legs = [planning_map.search(a, b, robot) for a, b in pairwise(poses)]
    return lambda: plan_through(legs)


def check_planner(name: str, method: str) -> None:
    """
    Check which planner is asked for.

    Parameters
    ----------
    name : str
        A goal's ``planner_id``: empty, that of Nav2, or the planning method in force.
    method : str
        Planning method in force.

    Raises
    ------
    InvalidPlanner
        If it is another one.
    """
    if name not in ('', NAV2_PLANNER, method):
        raise InvalidPlanner(name, (NAV2_PLANNER, method))


def plan_through(searches: Sequence[Callable[[], Plan]]) -> Plan:
    """
    Plan from pose to pose.

    Parameters
    ----------
    searches : sequence of callable
        Search from each pose to the next; the headings between are not kept.

    Returns
    -------
    Plan
        The turning points; those poses are among them.

    Raises
    ------
    PlannerError
        If there is no plan from one to the next.
    """
    legs = [search() for search in searches]
    before = [pose for leg in legs[:-1] for pose in leg.poses[:-1]]
    return Plan((*before, *legs[-1].poses), legs[-1].remark)
