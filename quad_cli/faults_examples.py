"""
Valid messages to begin with: of any type, with something in every sequence.
"""

from __future__ import annotations

from array import array
from typing import Any

from geometry_msgs.msg import PoseStamped
from visualization_msgs.msg import Marker, MarkerArray

from quad_cli.faults_graph import class_of
from quad_common.planar_pose import Pose2D
from quad_common.ros_conversions import pose_message

OBSTACLE_NAMESPACE = 'faults'
"""Of the obstacles that an attack puts up."""


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


def _one_element(empty: Any, type_name: str) -> Any:
    element = type_name.split(',')[0]
    if isinstance(empty, array):
        return array(empty.typecode, [0])
    if '/' in element:
        package, name = element.split('/')
        return [example_of(class_of(f'{package}/msg/{name}'))]
    return [{'boolean': False, 'octet': b'\x00'}.get(element, 'x')]
