"""
Conversions between ROS messages and what is shown or asked for.
"""

from __future__ import annotations

import math

import numpy as np
from geometry_msgs.msg import PolygonStamped, PoseStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from sensor_msgs.msg import JointState
from visualization_msgs.msg import Marker, MarkerArray

from quad_common.errors import InvalidMessage
from quad_common.errors.quoting import clipped
from quad_common.planar_pose import Pose2D, Twist2D
from quad_common.ros.pose_conversions import (
    pose_from_message,
    pose_message,
    position_from_message,
    unit_quaternion,
)
from quad_common.status import Level
from quad_view.scene.commands import PutObstacle
from quad_view.scene.robot_model import product
from quad_view.scene.words import Said

Array = NDArray[np.float64]
Obstacles = dict[tuple[str, int], tuple[str, Pose2D, tuple[float, float, float]]]

_MOST = 10_000
"""Names, corners or markers in one message that are shown."""

OWN = 'viewer'
"""Namespace of the obstacles that are put from the page."""


def joints_from_message(message: JointState) -> dict[str, float]:
    """
    Read the positions of all joints.

    Parameters
    ----------
    message : sensor_msgs/JointState
        Of any robot.

    Returns
    -------
    dict of str to float
        Positions by name [rad or m].

    Raises
    ------
    InvalidMessage
        If there are not as many numbers as names, too many, or they are not finite.
    """
    names, positions = message.name, np.asarray(message.position, dtype=float)
    if len(names) != len(positions) or len(names) > _MOST or not np.isfinite(positions).all():
        raise InvalidMessage(
            'joint state',
            f'it has {len(positions)} positions for {len(names)} names; all must be finite',
        )
    return {name: float(value) for name, value in zip(names, positions, strict=True)}


def body_on_map(message: Odometry, planar: Pose2D, odometry: Pose2D) -> tuple[Array, Array]:
    """
    Place a body on the map as odometry has it in its own frame.

    Parameters
    ----------
    message : nav_msgs/Odometry
        Of base_link.
    planar : Pose2D
        base_link on the map.
    odometry : Pose2D
        base_link in odometry's frame.

    Returns
    -------
    tuple of ndarray
        Position, shape (3,) [m], and orientation, a quaternion xyzw: height, roll and pitch are
        odometry's.
    """
    _, _, z = position_from_message(message.pose.pose.position, 'odometry')
    half = 0.5 * (planar.yaw - odometry.yaw)
    turn = np.array([0.0, 0.0, math.sin(half), math.cos(half)])
    body = np.array(unit_quaternion(message.pose.pose.orientation, 'odometry'))
    return np.array([planar.x, planar.y, z]), product(turn, body)


def velocity_from_message(message: Odometry) -> tuple[float, float, float]:
    """Return forward and left velocity [m/s], and rate of turning [rad/s]."""
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    return float(linear.x), float(linear.y), float(angular.z)


def boundary_from_markers(message: MarkerArray) -> tuple[Array, ...]:
    """Return the lines around inflated obstacles of ``plan_markers``, each of shape (n, 2) [m]."""
    lines = []
    for marker in message.markers[:_MOST]:
        if marker.ns == 'safety_boundary' and marker.action == Marker.ADD:
            line = np.array([(point.x, point.y) for point in marker.points]).reshape(-1, 2)
            if np.isfinite(line).all() and len(line) > 1:
                lines.append(line)
    return tuple(lines)


def footholds_from_markers(message: MarkerArray) -> Array:
    """Return the next footholds, shape (n, 3) [m]."""
    points = [
        position_from_message(marker.pose.position, 'foothold')
        for marker in message.markers[:_MOST]
        if marker.action == Marker.ADD
    ]
    return np.array(points).reshape(-1, 3)


def corners_from_polygon(message: PolygonStamped) -> Array:
    """Return the corners of a polygon in its frame, shape (n, 2) [m]; InvalidMessage if not so."""
    corners = np.array(
        [(point.x, point.y) for point in message.polygon.points[:_MOST]], dtype=float
    )
    if not np.isfinite(corners).all():
        raise InvalidMessage('support polygon', 'its corners are not finite')
    return corners.reshape(-1, 2)


def obstacles_from_markers(message: MarkerArray) -> Obstacles:
    """
    Read which obstacles stand in a simulation.

    Parameters
    ----------
    message : visualization_msgs/MarkerArray
        Of ``obstacles/present``.

    Returns
    -------
    dict
        Kind, pose and size [m] by name.

    Raises
    ------
    InvalidMessage
        If one has no place or no size.
    """
    kinds = {Marker.CUBE: 'box', Marker.CYLINDER: 'cylinder'}
    obstacles = {}
    for marker in message.markers[:_MOST]:
        if marker.action == Marker.ADD and marker.type in kinds:
            size = (marker.scale.x, marker.scale.y, marker.scale.z)
            if not all(0.0 < side <= 100.0 for side in size):
                raise InvalidMessage('obstacle', f'it is {size} m large')
            pose = pose_from_message(marker.pose, 'obstacle')
            obstacles[marker.ns, marker.id] = kinds[marker.type], pose, size
    return obstacles


def obstacle_message(command: PutObstacle, number: int, frame: str) -> MarkerArray:
    """Write an obstacle that is put into the simulation."""
    marker = Marker(ns=OWN, id=number, type=Marker.CUBE, action=Marker.ADD)
    marker.header.frame_id = frame
    marker.pose = pose_message(command.place)
    marker.scale.x, marker.scale.y, marker.scale.z = command.size
    return MarkerArray(markers=[marker])


def no_obstacles_message() -> MarkerArray:
    """Write that all obstacles are taken away."""
    return MarkerArray(markers=[Marker(action=Marker.DELETEALL)])


def goal_message(goal: Pose2D, frame: str) -> PoseStamped:
    """Write a goal."""
    message = PoseStamped(pose=pose_message(goal))
    message.header.frame_id = frame
    return message


def twist_message(twist: Twist2D, is_stamped: bool) -> Twist | TwistStamped:
    """Write a velocity."""
    message = TwistStamped() if is_stamped else Twist()
    velocity = message.twist if is_stamped else message
    velocity.linear.x, velocity.linear.y = float(twist.forward), float(twist.left)
    velocity.angular.z = float(twist.turn)
    return message


def option_request(name: str, value: str) -> SetParameters.Request:
    """Write the request that sets a text parameter."""
    wanted = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=value)
    return SetParameters.Request(parameters=[Parameter(name=name, value=wanted)])


def said_by(status: object, at: float) -> Said:
    """Read a status of ``diagnostics`` that was received at a time [s]."""
    level = getattr(status, 'level', b'\x03')
    number = level[0] if isinstance(level, bytes) else int(level)
    values = {pair.key: pair.value for pair in getattr(status, 'values', ())}
    return Said(Level(min(number, 3)), clipped(getattr(status, 'message', '')), values, at)
