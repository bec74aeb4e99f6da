"""
Conversions between ROS messages and the simulator's values.
"""

from __future__ import annotations

import math
from array import array
from dataclasses import replace
from functools import lru_cache

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Vector3, WrenchStamped
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from sensor_msgs.msg import Imu, JointState
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage

from quad_common.errors import (
    InvalidMessage,
    NoJointsNamed,
    PointMalformed,
    TooManyJoints,
    TooManyPoints,
)
from quad_common.frames.frame_names import check_frame
from quad_common.robot.robot import Robot
from quad_common.ros.pose_conversions import (
    seconds_from_time,
)
from quad_common.rotations import matrix_from_quaternion
from quad_common.trajectory.joint_trajectory import LONGEST_TRAJECTORY, JointTrajectory
from quad_sim.engines.simulator import GRAVITY, Observation
from quad_sim.parameters import SimParameters

_MOST_JOINTS = 1000
"""Of a trajectory; that none of them is missing or unknown is checked after it is read."""

_ROOM, _POINT_BYTES = 250_000, 450
"""Sizes of a message with a trajectory: of names, and of twelve joints' numbers [bytes]."""

_MOST_WEIGHTS = 20.0
"""Largest force of a push, in weights of the robot."""

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


def push_message(force: NDArray[np.float64], frame: str) -> WrenchStamped:
    """Write a push with a force, shape (3,), along the axes of a frame [N]."""
    message = WrenchStamped()
    message.header.frame_id = frame
    _set(message.wrench.force, force)
    return message


def push_from_message(
    message: WrenchStamped, robot: Robot, observation: Observation, frames: tuple[str, ...]
) -> NDArray[np.float64]:
    """
    Read a push against the robot's body.

    Parameters
    ----------
    message : geometry_msgs/WrenchStamped
        A force; torques must be zero.
    robot : Robot
        Robot that is pushed.
    observation : Observation
        State of the robot now.
    frames : tuple of str
        Frame of the robot's body, then those that coincide with the world.

    Returns
    -------
    ndarray, shape (3,)
        Force against the body's center of mass, in the world's axes [N].

    Raises
    ------
    InvalidMessage
        If the frame is another one, it turns, or the force is no number or too large.
    """
    what = "message on 'push'"
    check_frame(what, message.header.frame_id, *frames)
    force, torque = (
        np.array([part.x, part.y, part.z]) for part in (message.wrench.force, message.wrench.torque)
    )
    most = _MOST_WEIGHTS * robot.mass * GRAVITY
    # Of numbers whose squares are too large, too; nan compares as false.
    if not (np.abs(force) <= most).all() or float(np.linalg.norm(force)) > most:
        raise InvalidMessage(
            what,
            f'its force is ({", ".join(f"{part:.4g}" for part in force)}) N; it must be at most '
            f'{most:.0f} N, {_MOST_WEIGHTS:g} times the weight of the robot',
        )
    if torque.any():
        raise InvalidMessage(
            what, "its torque is not zero; a push is a force through the body's center of mass"
        )
    if message.header.frame_id != frames[0]:
        return force
    in_world: NDArray[np.float64] = matrix_from_quaternion(observation.orientation) @ force
    return in_world


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
