"""
Conversions between ROS messages and the planner's values.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, PoseStamped
from nav_msgs.msg import Path
from nav_msgs.srv import GetPlan
from numpy.typing import NDArray
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from quad_common.errors import InvalidMessage, NoGoals
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import pose_from_message, pose_message
from quad_planner.grid.grid_update import GridUpdate

_MOST_POSES = 1000
"""Poses that a goal of an action may have."""


def ends_from_request(request: GetPlan.Request) -> tuple[tuple[str, Pose2D], tuple[str, Pose2D]]:
    """Return start and goal of a request for a plan, each with its frame; InvalidPose if not so."""
    return placed_pose(request.start, 'start'), placed_pose(request.goal, 'goal')


def goals_of(request: Any) -> list[tuple[str, Pose2D]]:
    """
    Return the goals of an action's goal, each with its frame.

    Parameters
    ----------
    request : Goal
        Of any of the planner's actions.

    Returns
    -------
    list of tuple of str and Pose2D
        One at least.

    Raises
    ------
    NoGoals
        If there are none.
    InvalidMessage
        If there are too many.
    InvalidPose
        If one is no pose.
    """
    several = getattr(request, 'poses', None) or getattr(request, 'goals', None)
    single = getattr(request, 'pose', None) or getattr(request, 'goal', None)
    poses = several or ([single] if single is not None else [])
    if not poses:
        raise NoGoals()
    if len(poses) > _MOST_POSES:
        raise InvalidMessage('goal', f'it has {len(poses)} poses; {_MOST_POSES} are the most')
    return [placed_pose(stamped, 'goal') for stamped in poses]


def placed_pose(stamped: PoseStamped, what: str) -> tuple[str, Pose2D]:
    """Return a pose with its frame; InvalidPose if it is none."""
    return stamped.header.frame_id, pose_from_message(stamped.pose, what)


def update_from_message(message: Any) -> GridUpdate:
    """
    Read an update of a map.

    Parameters
    ----------
    message : map_msgs/OccupancyGridUpdate
        The update.

    Returns
    -------
    GridUpdate
        The same update.

    Raises
    ------
    InvalidMessage
        If it has no cells, or not as many as its sizes say.
    """
    cells = np.frombuffer(message.data, dtype=np.int8)
    if not cells.size or cells.size != message.width * message.height:
        raise InvalidMessage(
            'map update',
            f'it has {cells.size} cells, and is {message.width} x {message.height} cells in size',
        )
    return GridUpdate(message.x, message.y, cells.reshape(message.height, message.width))


def path_message(plan: Plan | None, frame: str, stamp: Time) -> Path:
    """
    Write a plan as a path of its turning points.

    Parameters
    ----------
    plan : Plan or None
        None makes an empty path, which takes the last plan back.
    frame : str
        Frame of the plan.
    stamp : Time
        Time at which it was made.

    Returns
    -------
    nav_msgs/Path
        Pose k faces along segment k, the last has the goal's heading.
    """
    path = Path()
    path.header.frame_id = frame
    path.header.stamp = stamp
    for pose in plan.poses if plan is not None else ():
        path.poses.append(PoseStamped(header=path.header, pose=pose_message(pose)))
    return path


def plan_markers(
    plan: Plan | None, outlines: tuple[NDArray[np.float64], ...], frame: str, stamp: Time
) -> MarkerArray:
    """Draw the plan, its turning points and the lines around combined obstacles."""
    markers = [Marker(action=Marker.DELETEALL)]
    if plan is not None:
        corners = plan.corners
        markers.append(_line('plan', 0, corners, 0.03, (0.1, 0.4, 1.0)))
        dots = _line('turning_points', 0, corners, 0.12, (1.0, 0.5, 0.0))
        dots.type = Marker.SPHERE_LIST
        markers.append(dots)
    for index, outline in enumerate(outlines):
        closed = np.vstack([outline, outline[:1]])
        markers.append(_line('safety_boundary', index, closed, 0.02, (0.8, 0.1, 0.1)))
    for marker in markers:
        marker.header.frame_id = frame
        marker.header.stamp = stamp
    return MarkerArray(markers=markers)


def _line(
    namespace: str,
    number: int,
    points: NDArray[np.float64],
    width: float,
    color: tuple[float, float, float],
) -> Marker:
    marker = Marker(ns=namespace, id=number, type=Marker.LINE_STRIP, action=Marker.ADD)
    marker.pose.orientation.w = 1.0
    marker.scale.x = marker.scale.y = marker.scale.z = width
    marker.color = ColorRGBA(r=color[0], g=color[1], b=color[2], a=1.0)
    marker.points = [Point(x=float(x), y=float(y), z=0.02) for x, y in points]
    return marker
