"""
Conversions between ROS messages and the simulator's values.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Vector3
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from sensor_msgs.msg import Imu, JointState
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage
from visualization_msgs.msg import Marker, MarkerArray

from quad_common.errors import (
    InvalidMessage,
    InvalidPose,
    NoJointsNamed,
    ParameterError,
    PointMalformed,
    TooManyJoints,
    TooManyPoints,
)
from quad_common.errors.quoting import quoted
from quad_common.ros.pose_conversions import (
    checked_name,
    pose_from_message,
    pose_message,
    seconds_from_time,
)
from quad_common.trajectory.joint_trajectory import LONGEST_TRAJECTORY, JointTrajectory
from quad_common.vision.markers import Color
from quad_sim.engines.simulator import Observation
from quad_sim.obstacle_changes import ObstacleChange
from quad_sim.parameters import SimParameters
from quad_sim.world.world import Obstacle

_SIZES = (1e-3, 100.0)
"""Least and largest side of an obstacle [m]."""

_MOST_MARKERS = 1000
"""Largest number of markers in one message."""

_MOST_JOINTS = 1000
"""Of a trajectory; that none of them is missing or unknown is checked after it is read."""

MOST_OBSTACLE_BYTES = 1_000_000
"""Largest size of a message with obstacles; a marker has some three hundred [bytes]."""

_ROOM, _POINT_BYTES = 250_000, 450
"""Sizes of a message with a trajectory: of names, and of twelve joints' numbers [bytes]."""

_EXACT = 1e-12
"""Variance of what is known exactly: zero would mean unknown."""


def most_trajectory_bytes(longest: int) -> int:
    """Return the bytes that a message with a trajectory of so many points may have."""
    return _ROOM + _POINT_BYTES * longest


def trajectory_from_message(
    message: JointTrajectoryMessage, most_points: int = LONGEST_TRAJECTORY
) -> JointTrajectory:
    """
    Read a joint trajectory.

    Parameters
    ----------
    message : trajectory_msgs/JointTrajectory
        Positions, and velocities or none: then the joints rest at each point.
    most_points : int
        Points that it may have.

    Returns
    -------
    JointTrajectory
        Checked.

    Raises
    ------
    TrajectoryError
        If it is too long, sizes disagree, numbers are not finite, or times do not rise.
    """
    joints = len(message.joint_names)
    if joints == 0:
        raise NoJointsNamed()
    if joints > _MOST_JOINTS:
        raise TooManyJoints(joints, _MOST_JOINTS)
    if len(message.points) > most_points:
        raise TooManyPoints(len(message.points), most_points)
    for index, point in enumerate(message.points):
        if len(point.positions) != joints or len(point.velocities) not in (0, joints):
            raise PointMalformed(index, len(point.positions), len(point.velocities), joints)
    return JointTrajectory(
        joint_names=tuple(message.joint_names),
        stamp=seconds_from_time(message.header.stamp),
        times=np.array(
            [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in message.points]
        ),
        positions=np.array([p.positions for p in message.points]).reshape(-1, joints),
        velocities=np.array(
            [p.velocities if len(p.velocities) else [0.0] * joints for p in message.points]
        ).reshape(-1, joints),
    )


def odometry_message(
    observation: Observation, parameters: SimParameters, noise: NDArray[np.float64], stamp: Time
) -> Odometry:
    """
    Write odometry: the truth, with the noise that its covariance states.

    Parameters
    ----------
    observation : Observation
        The robot's true state.
    parameters : SimParameters
        Frames and standard deviations.
    noise : ndarray, shape (4,)
        Standard normal numbers, for x, y, z and the heading.
    stamp : Time
        Of the observation.

    Returns
    -------
    nav_msgs/Odometry
        Pose in the odometry's frame, velocities in the body's.
    """
    p = parameters
    message = Odometry(child_frame_id=p.base_frame)
    message.header.frame_id = p.odom_frame
    message.header.stamp = stamp
    pose, twist = message.pose.pose, message.twist.twist
    _set(pose.position, observation.position + p.odom_position_noise * noise[:3])
    qx, qy, qz, qw = observation.orientation.tolist()
    half = 0.5 * p.odom_yaw_noise * float(noise[3])
    # A small turn about the vertical, before the orientation.
    s, c = math.sin(half), math.cos(half)
    q = pose.orientation
    q.x, q.y, q.z, q.w = c * qx - s * qy, c * qy + s * qx, c * qz + s * qw, c * qw - s * qz
    _set(twist.linear, observation.linear_velocity_base_in_base)
    _set(twist.angular, observation.angular_velocity_base_in_base)
    x, yaw = p.odom_position_noise, p.odom_yaw_noise
    message.pose.covariance = _covariance(x, x, x, 0.0, 0.0, yaw)
    message.twist.covariance = _covariance(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return message


def true_odometry_message(
    observation: Observation, parameters: SimParameters, stamp: Time
) -> Odometry:
    """Write the truth as an odometry in the map, whatever noise and drift are set."""
    exact = replace(
        parameters,
        odom_frame=parameters.map_frame,
        odom_position_noise=0.0,
        odom_yaw_noise=0.0,
    )
    return odometry_message(observation, exact, np.zeros(4), stamp)


def imu_message(
    observation: Observation, parameters: SimParameters, noise: NDArray[np.float64], stamp: Time
) -> Imu:
    """
    Write what an imu at base_link measures, with the noise that its covariance states.

    Parameters
    ----------
    observation : Observation
        The robot's true state.
    parameters : SimParameters
        Frames and standard deviations.
    noise : ndarray, shape (2, 3)
        Standard normal numbers, for the angular velocity and for the acceleration.
    stamp : Time
        Of the observation.

    Returns
    -------
    sensor_msgs/Imu
        In the body's axes.
    """
    p = parameters
    message = Imu()
    message.header.frame_id = p.base_frame
    message.header.stamp = stamp
    q = message.orientation
    q.x, q.y, q.z, q.w = observation.orientation.tolist()
    turning = observation.angular_velocity_base_in_base
    force = observation.specific_force_in_base
    _set(message.angular_velocity, turning + p.gyroscope_noise * noise[0])
    _set(message.linear_acceleration, force + p.accelerometer_noise * noise[1])
    message.orientation_covariance = _covariance(0.0, 0.0, 0.0)
    message.angular_velocity_covariance = _covariance(*[p.gyroscope_noise] * 3)
    message.linear_acceleration_covariance = _covariance(*[p.accelerometer_noise] * 3)
    return message


def joint_state_message(
    observation: Observation, joint_names: tuple[str, ...], stamp: Time
) -> JointState:
    """Write the joints' positions, velocities and efforts."""
    message = JointState(name=list(joint_names))
    message.header.stamp = stamp
    message.position = _doubles(observation.joint_positions)
    message.velocity = _doubles(observation.joint_velocities)
    message.effort = _doubles(observation.joint_efforts)
    return message


def obstacle_changes_from_message(
    message: MarkerArray, frames: tuple[str, ...]
) -> list[ObstacleChange]:
    """
    Read which obstacles come and go.

    Parameters
    ----------
    message : visualization_msgs/MarkerArray
        Cubes and cylinders that are added, moved or deleted. They stand on the floor: heights
        of their poses, and roll and pitch, are not used.
    frames : tuple of str
        In which poses may be given.

    Returns
    -------
    list of ObstacleChange
        In order; names are namespace and id.

    Raises
    ------
    InvalidMessage
        If there are too many, or a marker is something else.
    """
    if len(message.markers) > _MOST_MARKERS:
        raise InvalidMessage(
            "message on 'obstacles'",
            f'it has {len(message.markers)} markers; {_MOST_MARKERS} are the most',
        )
    return [_obstacle_change(marker, frames) for marker in message.markers]


def _obstacle_change(marker: Marker, frames: tuple[str, ...]) -> ObstacleChange:
    name = (marker.ns, marker.id)
    what = f"marker {quoted(marker.ns)} {marker.id} on 'obstacles'"
    checked_name(marker.ns, what)
    if marker.action == Marker.DELETEALL:
        return ObstacleChange(None, None)
    if marker.action == Marker.DELETE:
        return ObstacleChange(name, None)
    if marker.action != Marker.ADD:
        raise InvalidMessage(
            what, f'its action is {marker.action}; known are ADD 0, DELETE 2 and DELETEALL 3'
        )
    kinds = {Marker.CUBE: 'box', Marker.CYLINDER: 'cylinder'}
    if marker.type not in kinds:
        raise InvalidMessage(what, f'its type is {marker.type}; known are CUBE 1 and CYLINDER 3')
    check_frame(what, marker.header.frame_id, frames)
    color = marker.color
    parts = (color.r, color.g, color.b, color.a)
    if not all(0.0 <= part <= 1.0 for part in parts):
        raise InvalidMessage(what, f'its color r, g, b, a is {parts}; each must be from 0 to 1')
    red, green, blue = (round(255.0 * part) for part in parts[:3])
    size = marker.scale
    low, high = _SIZES
    if not all(low <= side <= high for side in (size.x, size.y, size.z)):
        raise InvalidMessage(
            what,
            f'it is ({size.x}, {size.y}, {size.z}) m large; each side must be from {low:g} '
            f'to {high:g} m',
        )
    try:
        pose = pose_from_message(marker.pose)
        obstacle = Obstacle(
            kinds[marker.type],
            pose,
            size.x,
            size.y,
            size.z,
            # A color that is not set is black and transparent.
            (red, green, blue) if any(parts) else None,
        )
    except (InvalidPose, ParameterError) as error:
        raise InvalidMessage(what, str(error)) from error
    return ObstacleChange(name, obstacle)


def obstacles_message(
    obstacles: Mapping[tuple[str, int], Obstacle], frame: str, color: Color
) -> MarkerArray:
    """
    Write which obstacles stand.

    Parameters
    ----------
    obstacles : mapping of tuple to Obstacle
        Obstacles by namespace and id.
    frame : str
        Frame of their poses.
    color : tuple of int
        Color of those without one: red, green and blue, 0 to 255.

    Returns
    -------
    visualization_msgs/MarkerArray
        Their markers, after one that takes away whatever was shown before.
    """
    markers = [Marker(action=Marker.DELETEALL)]
    kinds = {'box': Marker.CUBE, 'cylinder': Marker.CYLINDER}
    for (space, number), obstacle in obstacles.items():
        marker = Marker(ns=space, id=number, type=kinds[obstacle.kind], action=Marker.ADD)
        marker.header.frame_id = frame
        marker.pose = pose_message(obstacle.pose)
        marker.pose.position.z = 0.5 * obstacle.height
        _set(marker.scale, np.array([obstacle.length, obstacle.width, obstacle.height]))
        red, green, blue = (part / 255.0 for part in obstacle.color or color)
        marker.color.r, marker.color.g, marker.color.b, marker.color.a = red, green, blue, 1.0
        markers.append(marker)
    return MarkerArray(markers=markers)


def check_frame(what: str, frame: str, frames: tuple[str, ...]) -> None:
    """Raise InvalidMessage unless a frame is one of those that coincide with the world."""
    if frame not in frames:
        raise InvalidMessage(
            what, f'it is in frame {quoted(frame)}; give it in {quoted(frames[0])}'
        )


def _set(vector: Point | Vector3, values: NDArray[np.float64]) -> None:
    """Write x, y and z into a part of a message, without making another one."""
    vector.x, vector.y, vector.z = values.tolist()


@lru_cache(maxsize=16)
def _covariance(*deviations: float) -> NDArray[np.float64]:
    """Return the covariance, row by row, of numbers with these standard deviations; read only."""
    variances = [max(deviation**2, _EXACT) for deviation in deviations]
    covariance: NDArray[np.float64] = np.diag(variances).reshape(-1)
    covariance.setflags(write=False)
    return covariance


def _doubles(values: NDArray[np.float64]) -> array[float]:
    return array('d', np.ascontiguousarray(values, dtype=float).tobytes())
