"""
Valid messages to begin with: of any type, with something in every sequence.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import PoseStamped, Twist, Vector3
from nav_msgs.srv import GetPlan
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from visualization_msgs.msg import Marker, MarkerArray

from quad_common.maps.height_map import HeightMap
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.ros.height_map_conversions import height_map_message
from quad_common.ros.pose_conversions import pose_message
from quad_lab.attacks.stage.graph import class_of
from quad_planner.ros_conversions import path_message
from quad_sim.ros_conversions import push_message

OBSTACLE_NAMESPACE = 'faults'
"""Of the obstacles that an attack puts up."""

_AHEAD = 0.2
"""From the robot to a goal that is easily reached [m]."""


def example_of(kind: Any) -> Any:
    """
    Make a message in which every field can be reached.

    Parameters
    ----------
    kind : type
        A message class, or the request of a service.

    Returns
    -------
    message
        Default values; sequences have one element each.
    """
    message = kind()
    for name, type_name in kind.get_fields_and_field_types().items():
        value = getattr(message, name)
        if hasattr(value, 'get_fields_and_field_types'):
            setattr(message, name, example_of(type(value)))
        elif type_name.startswith('sequence<'):
            setattr(message, name, _one_element(value, type_name[len('sequence<') : -1]))
    return message


def goal_message(goal: Pose2D) -> PoseStamped:
    """Write a goal on the map."""
    message = PoseStamped(pose=pose_message(goal))
    message.header.frame_id = 'map'
    return message


def obstacle_message(x: float, y: float) -> MarkerArray:
    """Write a box of 0.3 m at a place on the map."""
    marker = Marker(ns=OBSTACLE_NAMESPACE, type=Marker.CUBE, action=Marker.ADD)
    marker.header.frame_id = 'map'
    marker.pose = pose_message(Pose2D(x, y, 0.0))
    marker.scale.x = marker.scale.y = marker.scale.z = 0.3
    return MarkerArray(markers=[marker])


def plan_request(pose: Pose2D) -> GetPlan.Request:
    """Ask for a plan from a pose to one nearby."""
    return GetPlan.Request(start=goal_message(pose), goal=goal_message(ahead_of(pose)))


def ahead_of(pose: Pose2D) -> Pose2D:
    """Return a pose one step to the right on the map, where there is free ground."""
    return Pose2D(pose.x + _AHEAD, pose.y, pose.yaw)


def made_up(topic: str, pose: Pose2D, joints: JointState | None) -> Any:
    """
    Make a valid message of a topic on which nothing was published yet.

    Parameters
    ----------
    topic : str
        Full name.
    pose : Pose2D
        Of the robot on the map.
    joints : sensor_msgs/JointState, optional
        Of the robot as it stands.

    Returns
    -------
    message or None
        None if nothing is known of such a topic.
    """
    makers: dict[str, Callable[[], Any]] = {
        '/goal_pose': lambda: goal_message(ahead_of(pose)),
        '/plan/impassable': lambda: goal_message(ahead_of(pose)),
        '/goal_marker': lambda: goal_message(ahead_of(pose)),
        '/push': lambda: push_message(np.array([0.0, 1.0, 0.0]), 'base_link'),
        '/obstacles': lambda: obstacle_message(pose.x + 1.5, pose.y),
        '/cmd_vel': lambda: Twist(linear=Vector3(x=0.02), angular=Vector3(z=0.02)),
        '/plan': lambda: path_message(Plan((pose, ahead_of(pose))), 'map', Time()),
        '/height_map': lambda: height_map_message(_flat_around(pose), 'map', Time()),
    }
    if topic == '/joint_trajectory' and joints is not None:
        return _holding(joints)
    return makers[topic]() if topic in makers else None


def _flat_around(pose: Pose2D) -> HeightMap:
    corner = (round(pose.x - 1.0, 1), round(pose.y - 1.0, 1))
    return HeightMap(np.zeros((20, 20)), 0.1, corner)


def _holding(joints: JointState) -> JointTrajectory:
    """Write a trajectory that keeps joints where they are."""
    still = array('d', [0.0] * len(joints.name))
    points = [
        JointTrajectoryPoint(
            positions=joints.position, velocities=still, time_from_start=Duration(sec=seconds)
        )
        for seconds in (1, 2, 3)
    ]
    return JointTrajectory(joint_names=joints.name, points=points)


def _one_element(empty: Any, type_name: str) -> Any:
    element = type_name.split(',')[0]
    if isinstance(empty, array):
        return array(empty.typecode, [0])
    if '/' in element:
        package, name = element.split('/')
        return [example_of(class_of(f'{package}/msg/{name}'))]
    return [{'boolean': False, 'octet': b'\x00'}.get(element, 'x')]
