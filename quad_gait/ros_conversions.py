"""
Conversions between ROS messages and the gait generator's values.
"""

from __future__ import annotations

from array import array

import numpy as np
from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Point32, PolygonStamped, Pose, Twist, TwistStamped
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from sensor_msgs.msg import Imu, JointState, PointCloud2, PointField
from std_msgs.msg import ColorRGBA
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage
from trajectory_msgs.msg import JointTrajectoryPoint
from visualization_msgs.msg import Marker, MarkerArray

from quad_common.errors import InvalidMessage
from quad_common.errors.quoting import quoted
from quad_common.planar_pose import Twist2D
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_common.ros.pose_conversions import (
    pose_message,
    seconds_from_time,
    time_from_seconds,
    unit_quaternion,
)
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.state.leg_odometry import LegOdometry
from quad_gait.state.measurement import ImuMotion
from quad_gait.state.readings.possible_steps import TURN_SPEED
from quad_gait.state.sensor_inputs import JointReadings

Array = NDArray[np.float64]

_FASTEST = 100.0
"""Largest velocity of a robot, commanded or measured [m/s, rad/s]."""

_MOST_JOINTS = 1000
"""Names in one message of joint states, of whatever robots."""

_MOST_FORCE = 500.0
"""Specific force that an accelerometer says, at most [m/s^2]."""

_NEGLIGIBLE = 1e-6
"""Slower than this is not at all [m/s, rad/s]."""


def trajectory_message(trajectory: JointTrajectory) -> JointTrajectoryMessage:
    """
    Write a joint trajectory.

    Parameters
    ----------
    trajectory : JointTrajectory
        Positions and velocities.

    Returns
    -------
    trajectory_msgs/JointTrajectory
        As joint_trajectory_controller takes it.
    """
    message = JointTrajectoryMessage(joint_names=list(trajectory.joint_names))
    message.header.stamp = time_from_seconds(trajectory.stamp)
    nanoseconds = np.rint(trajectory.times * 1e9).astype(np.int64)
    message.points = [
        JointTrajectoryPoint(
            positions=array('d', positions.tobytes()),
            velocities=array('d', velocities.tobytes()),
            time_from_start=Duration(sec=int(t // 10**9), nanosec=int(t % 10**9)),
        )
        for t, positions, velocities in zip(
            nanoseconds, trajectory.positions, trajectory.velocities
        )
    ]
    return message


def joints_from_message(message: JointState, robot: Robot) -> JointReadings:
    """
    Read the robot's joints from a message with any joints in any order.

    Parameters
    ----------
    message : sensor_msgs/JointState
        At least all of the robot's joints.
    robot : Robot
        The robot.

    Returns
    -------
    JointReadings
        What the message says of the robot's joints.

    Raises
    ------
    InvalidMessage
        If a joint of the robot is missing or named twice, there are not as many numbers as names,
        or they are not finite. Velocities and efforts that are all NaN count as left out, as
        joint_state_broadcaster says those that a drive does not measure.
    """
    names = tuple(message.name)
    if len(names) > _MOST_JOINTS:
        raise InvalidMessage(
            'joint state', f'it names {len(names)} joints; {_MOST_JOINTS} are the most'
        )
    order = None if names == robot.joint_names else _order(names, robot.joint_names)
    readings: list[Array | None] = []
    for what, numbers in (
        ('positions', message.position),
        ('velocities', message.velocity),
        ('efforts', message.effort),
    ):
        if len(numbers) != len(names) and (what == 'positions' or len(numbers)):
            raise InvalidMessage(
                'joint state', f'it has {len(numbers)} {what} for {len(names)} names'
            )
        values = np.array(numbers, dtype=float)
        if len(values) and order is not None:
            values = values[order]
        if not np.isfinite(values).all():
            if what == 'positions' or not np.isnan(values).all():
                raise InvalidMessage('joint state', f'its {what} are not finite')
            values = values[:0]
        readings.append(values if len(values) else None)
    positions, velocities, efforts = readings
    assert positions is not None
    time = seconds_from_time(message.header.stamp) or None
    return JointReadings(positions, velocities, efforts, time)


def _order(names: tuple[str, ...], wanted: tuple[str, ...]) -> list[int]:
    """Return the places of wanted joints among the names of a message; each must be there once."""
    place = {name: index for index, name in enumerate(names)}
    missing = [name for name in wanted if name not in place]
    if missing:
        raise InvalidMessage(
            'joint state',
            f'{quoted(missing[0])} is missing, {len(missing)} of the {len(wanted)} joints of the '
            f'robot: one message must name them all',
        )
    if len(place) < len(names):
        for name in wanted:
            if names.count(name) > 1:
                raise InvalidMessage('joint state', f'it names {quoted(name)} more than once')
    return [place[name] for name in wanted]


def twist_from_message(message: Twist | TwistStamped) -> Twist2D:
    """
    Read a velocity in the plane.

    Parameters
    ----------
    message : geometry_msgs/Twist or geometry_msgs/TwistStamped
        Along the body's own axes.

    Returns
    -------
    Twist2D
        The velocity.

    Raises
    ------
    InvalidMessage
        If a number is not finite or absurd, or asks for what a walking robot cannot do: to
        rise, to roll or to pitch.
    """
    velocity = message.twist if isinstance(message, TwistStamped) else message
    linear, angular = velocity.linear, velocity.angular
    twist = Twist2D(float(linear.x), float(linear.y), float(angular.z))
    rest = (linear.z, angular.x, angular.y)
    if not twist.is_finite() or not np.all(np.isfinite(rest)):
        raise InvalidMessage(
            'cmd_vel',
            f'its numbers are not finite: linear {linear.x:g}, {linear.y:g}, {linear.z:g} m/s, '
            f'angular {angular.x:g}, {angular.y:g}, {angular.z:g} rad/s',
        )
    if not max(abs(twist.forward), abs(twist.left), abs(twist.turn)) <= _FASTEST:
        raise InvalidMessage(
            'cmd_vel',
            f'linear x and y are {linear.x:g} and {linear.y:g} m/s, angular z is {angular.z:g} '
            f'rad/s; each must be from {-_FASTEST:g} to {_FASTEST:g}',
        )
    if any(abs(value) > _NEGLIGIBLE for value in rest):
        raise InvalidMessage(
            'cmd_vel',
            f'linear z, angular x and angular y are {rest}; a walking robot follows linear x '
            f'and y, and angular z, only',
        )
    return twist


def imu_from_message(message: Imu) -> tuple[Array | None, float | None]:
    """
    Read an imu's orientation and yaw rate.

    Parameters
    ----------
    message : sensor_msgs/Imu
        A first covariance of -1 says that the imu does not measure the quantity.

    Returns
    -------
    tuple of ndarray (4,) or None, and float or None
        Unit quaternion xyzw, and rate about the body's z axis [rad/s].

    Raises
    ------
    InvalidMessage
        If the angular velocity is not finite or absurd.
    InvalidPose
        If the quaternion is no rotation.
    """
    q, rate = message.orientation, message.angular_velocity.z
    orientation: Array | None = None
    if message.orientation_covariance[0] != -1.0:
        orientation = np.array(unit_quaternion(q, 'orientation of the imu'))
    has_rate = message.angular_velocity_covariance[0] != -1.0
    if has_rate and not abs(rate) <= _FASTEST:
        raise InvalidMessage(
            'imu',
            f'its angular velocity about z is {rate:g} rad/s; it must be from {-_FASTEST:g} '
            f'to {_FASTEST:g}',
        )
    return orientation, float(rate) if has_rate else None


def imu_motion_from_message(message: Imu) -> ImuMotion | None:
    """
    Read how the body moves by an imu.

    Parameters
    ----------
    message : sensor_msgs/Imu
        A first covariance of -1 says that the imu does not measure the quantity.

    Returns
    -------
    ImuMotion or None
        None without an angular velocity that makes sense.
    """
    if message.angular_velocity_covariance[0] == -1.0:
        return None
    w, a = message.angular_velocity, message.linear_acceleration
    rates, force = np.array([w.x, w.y, w.z]), np.array([a.x, a.y, a.z])
    if not (np.abs(rates) <= TURN_SPEED).all():
        return None
    has_force = message.linear_acceleration_covariance[0] != -1.0
    has_force = has_force and bool((np.abs(force) <= _MOST_FORCE).all())
    return ImuMotion(rates, force if has_force else None)


def leg_odometry_message(odometry: LegOdometry, frame: str, stamp: Time) -> Odometry:
    """Write what leg odometry has found, as the pose of base_link."""
    message = Odometry(child_frame_id='base_link')
    message.header.frame_id = frame
    message.header.stamp = stamp
    message.pose.pose = pose_message(odometry.pose)
    message.pose.pose.position.z = float(odometry.height)
    covariance = np.zeros((6, 6))
    planar = np.ix_((0, 1, 5), (0, 1, 5))
    covariance[planar] = odometry.covariance
    message.pose.covariance = covariance.reshape(-1)
    vx, vy, wz = odometry.twist
    message.twist.twist.linear.x, message.twist.twist.linear.y = float(vx), float(vy)
    message.twist.twist.angular.z = float(wz)
    return message


def polygon_message(corners: Array, frame: str, stamp: Time) -> PolygonStamped:
    """Write a support polygon, corners of shape (n, 2) [m]."""
    message = PolygonStamped()
    message.header.frame_id = frame
    message.header.stamp = stamp
    message.polygon.points = [Point32(x=float(x), y=float(y)) for x, y in corners]
    return message


def point_cloud_message(points: Array, frame: str, stamp: Time) -> PointCloud2:
    """Write points as a cloud that is not organized, shape (n, 3) [m]."""
    message = PointCloud2(height=1, width=len(points), is_bigendian=False, is_dense=True)
    message.header.frame_id = frame
    message.header.stamp = stamp
    message.fields = [
        PointField(name=name, offset=4 * index, datatype=PointField.FLOAT32, count=1)
        for index, name in enumerate('xyz')
    ]
    message.point_step, message.row_step = 12, 12 * len(points)
    message.data = array('B', points.astype('<f4').tobytes())
    return message


def foothold_markers(footholds: Array, frame: str, stamp: Time) -> MarkerArray:
    """Draw the next footholds, shape (4, 3) [m], one marker a leg."""
    markers = []
    for index, (leg, (x, y, z)) in enumerate(zip(LEGS, footholds)):
        marker = Marker(ns='footholds', id=index, type=Marker.SPHERE, action=Marker.ADD, text=leg)
        marker.header.frame_id = frame
        marker.header.stamp = stamp
        marker.pose = Pose()
        marker.pose.position.x, marker.pose.position.y = float(x), float(y)
        marker.pose.position.z = float(z)
        marker.pose.orientation.w = 1.0
        marker.scale.x = marker.scale.y = marker.scale.z = 0.04
        marker.color = ColorRGBA(r=0.1, g=0.7, b=0.2, a=1.0)
        markers.append(marker)
    return MarkerArray(markers=markers)
