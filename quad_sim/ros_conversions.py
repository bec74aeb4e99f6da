"""
Conversions between ROS messages and the simulator's values.
"""

from __future__ import annotations

from array import array

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Quaternion, TransformStamped, Vector3
from nav_msgs.msg import OccupancyGrid as OccupancyGridMessage
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from sensor_msgs.msg import Imu, JointState
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage

from quad_common.errors import TrajectoryError
from quad_common.joint_trajectory import JointTrajectory
from quad_common.occupancy_grid import OccupancyGrid
from quad_common.ros_conversions import (
    pose_from_message,
    pose_message,
    quaternion_from_yaw,
    seconds_from_time,
)
from quad_sim.parameters import SimParameters
from quad_sim.simulator import Observation

_EXACT = 1e-12
"""Variance of what is known exactly: zero would mean unknown."""


def trajectory_from_message(message: JointTrajectoryMessage) -> JointTrajectory:
    """
    Read a joint trajectory.

    Parameters
    ----------
    message : trajectory_msgs/JointTrajectory
        Positions, and velocities or none: then the joints rest at each point.

    Returns
    -------
    JointTrajectory
        Checked.

    Raises
    ------
    TrajectoryError
        If sizes disagree, numbers are not finite, or times do not rise.
    """
    joints = len(message.joint_names)
    if joints == 0:
        raise TrajectoryError('the trajectory names no joints; it needs at least one')
    for index, point in enumerate(message.points):
        if len(point.positions) != joints or len(point.velocities) not in (0, joints):
            raise TrajectoryError(
                f'point {index} has {len(point.positions)} positions and '
                f'{len(point.velocities)} velocities for {joints} joints'
            )
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


def grid_message(grid: OccupancyGrid, frame: str, stamp: Time) -> OccupancyGridMessage:
    """Write an occupancy grid, without walking over its cells."""
    message = OccupancyGridMessage()
    message.header.frame_id = frame
    message.header.stamp = stamp
    message.info.resolution = float(grid.resolution)
    message.info.width = grid.width
    message.info.height = grid.height
    message.info.origin = pose_message(grid.origin)
    data = array('b')
    data.frombytes(np.ascontiguousarray(grid.cells).tobytes())
    message.data = data
    return message


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
    x, y, z = observation.position + p.odom_position_noise * noise[:3]
    position = message.pose.pose.position
    position.x, position.y, position.z = float(x), float(y), float(z)
    qx, qy, qz, qw = observation.orientation
    half = 0.5 * p.odom_yaw_noise * noise[3]
    # A small turn about the vertical, before the orientation.
    s, c = float(np.sin(half)), float(np.cos(half))
    message.pose.pose.orientation = Quaternion(
        x=float(c * qx - s * qy),
        y=float(c * qy + s * qx),
        z=float(c * qz + s * qw),
        w=float(c * qw - s * qz),
    )
    message.twist.twist.linear = _vector(observation.linear_velocity_base_in_base)
    message.twist.twist.angular = _vector(observation.angular_velocity_base_in_base)
    position_variance = max(p.odom_position_noise**2, _EXACT)
    yaw_variance = max(p.odom_yaw_noise**2, _EXACT)
    message.pose.covariance[0:21:7] = array('d', [position_variance] * 3)
    message.pose.covariance[21:36:7] = array('d', [_EXACT, _EXACT, yaw_variance])
    message.twist.covariance[0:36:7] = array('d', [_EXACT] * 6)
    return message


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
    x, y, z, w = (float(value) for value in observation.orientation)
    message.orientation = Quaternion(x=x, y=y, z=z, w=w)
    turning = observation.angular_velocity_base_in_base
    force = observation.specific_force_in_base
    message.angular_velocity = _vector(turning + p.gyroscope_noise * noise[0])
    message.linear_acceleration = _vector(force + p.accelerometer_noise * noise[1])
    message.orientation_covariance[0:9:4] = np.full(3, _EXACT)
    message.angular_velocity_covariance[0:9:4] = np.full(3, max(p.gyroscope_noise**2, _EXACT))
    message.linear_acceleration_covariance[0:9:4] = np.full(
        3, max(p.accelerometer_noise**2, _EXACT)
    )
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


def base_transform(odometry: Odometry) -> TransformStamped:
    """Write the same pose as a transform."""
    transform = TransformStamped(header=odometry.header, child_frame_id=odometry.child_frame_id)
    position = odometry.pose.pose.position
    transform.transform.translation = Vector3(x=position.x, y=position.y, z=position.z)
    transform.transform.rotation = odometry.pose.pose.orientation
    return transform


def footprint_transform(odometry: Odometry, frame: str) -> TransformStamped:
    """Write where the body stands on the ground: its position and heading there (REP-120)."""
    transform = TransformStamped(header=odometry.header, child_frame_id=frame)
    position = odometry.pose.pose.position
    transform.transform.translation = Vector3(x=position.x, y=position.y, z=0.0)
    transform.transform.rotation = quaternion_from_yaw(pose_from_message(odometry.pose.pose).yaw)
    return transform


def identity_transform(parent: str, child: str, stamp: Time) -> TransformStamped:
    """Write that two frames coincide."""
    transform = TransformStamped(child_frame_id=child)
    transform.header.frame_id = parent
    transform.header.stamp = stamp
    transform.transform.rotation = quaternion_from_yaw(0.0)
    return transform


def _vector(values: NDArray[np.float64]) -> Vector3:
    x, y, z = (float(value) for value in values)
    return Vector3(x=x, y=y, z=z)


def _doubles(values: NDArray[np.float64]) -> array[float]:
    return array('d', np.ascontiguousarray(values, dtype=float).tobytes())
