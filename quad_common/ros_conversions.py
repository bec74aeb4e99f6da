"""
Conversions between ROS messages and plain values that more than one package needs.
"""

from __future__ import annotations

import math

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Pose, Quaternion
from nav_msgs.msg import Odometry, Path

from quad_common.errors import InvalidPose
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D


def seconds_from_time(stamp: Time) -> float:
    """Convert a time stamp to seconds."""
    return float(stamp.sec + 1e-9 * stamp.nanosec)


def time_from_seconds(seconds: float) -> Time:
    """Convert seconds to a time stamp, to the nanosecond."""
    nanoseconds = max(0, round(seconds * 1e9))
    return Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


def quaternion_from_yaw(yaw: float) -> Quaternion:
    """Convert a heading [rad] to a quaternion."""
    return Quaternion(x=0.0, y=0.0, z=math.sin(yaw / 2.0), w=math.cos(yaw / 2.0))


def pose_message(pose: Pose2D) -> Pose:
    """Convert a planar pose to a message on the ground."""
    message = Pose(orientation=quaternion_from_yaw(pose.yaw))
    message.position.x = float(pose.x)
    message.position.y = float(pose.y)
    return message


def pose_from_message(message: Pose, what: str = 'pose') -> Pose2D:
    """
    Read position and heading of a pose.

    Parameters
    ----------
    message : Pose
        Any pose; its height, roll and pitch are ignored.
    what : str
        What it is, for the error's sentence.

    Returns
    -------
    Pose2D
        Position and heading.

    Raises
    ------
    InvalidPose
        If a number is not finite, or the quaternion is no rotation.
    """
    q = message.orientation
    numbers = (message.position.x, message.position.y, q.x, q.y, q.z, q.w)
    if not all(map(math.isfinite, numbers)):
        raise InvalidPose(what, f'x, y and the quaternion xyzw are {numbers}')
    norm = math.sqrt(q.x**2 + q.y**2 + q.z**2 + q.w**2)
    if not 0.9 < norm < 1.1:
        raise InvalidPose(what, f'its quaternion has length {norm:.3f}; it must be 1')
    yaw = math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y**2 + q.z**2))
    return Pose2D(message.position.x, message.position.y, yaw)


def tilt_from_odometry(message: Odometry) -> float:
    """Return the angle between the body's z axis and the vertical [rad]."""
    q = message.pose.pose.orientation
    return math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (q.x**2 + q.y**2))))


def plan_from_message(message: Path) -> Plan | None:
    """
    Read a plan.

    Parameters
    ----------
    message : Path
        Turning points; an empty path takes the plan back.

    Returns
    -------
    Plan or None
        None for an empty path.

    Raises
    ------
    InvalidPose
        If a pose is not valid.
    """
    if not message.poses:
        return None
    return Plan(
        tuple(
            pose_from_message(stamped.pose, f'pose {index} of the plan')
            for index, stamped in enumerate(message.poses)
        )
    )
