"""
Conversions between ROS messages and plain values that more than one package needs.
"""

from __future__ import annotations

import math
from array import array

import numpy as np
from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Point, Pose, Quaternion, TransformStamped, Vector3
from nav_msgs.msg import OccupancyGrid as OccupancyGridMessage
from nav_msgs.msg import Odometry, Path
from numpy.typing import NDArray
from rosgraph_msgs.msg import Clock

from quad_common.errors import InvalidMessage, InvalidPose
from quad_common.errors.quoting import quoted
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import LONGEST_PLAN, Plan
from quad_common.planar_pose import Pose2D
from quad_common.rotations import matrix_from_unit_quaternion, yaw_from_quaternion
from quad_common.vision.camera import CameraModel

LARGEST_COORDINATE = 1e6
"""A position is no farther from its frame's origin, along each axis [m]."""

LONGEST_NAME = 200
"""Characters of the name of a frame, a joint or an obstacle."""

_ROOM, _POSE_BYTES = 10_000, 300
"""Sizes of a message with a plan: of its head, and of a pose with its frame's name [bytes]."""


def check_clock(message: Clock) -> None:
    """Raise InvalidMessage if simulated time is none that a stamp can hold."""
    seconds_from_time(message.clock, 'clock')


def seconds_from_time(stamp: Time, what: str = 'time stamp') -> float:
    """
    Convert a time stamp to seconds.

    Parameters
    ----------
    stamp : Time
        From 0 s on.
    what : str
        What it is, for the error's sentence.

    Returns
    -------
    float
        Seconds.

    Raises
    ------
    InvalidMessage
        If the seconds are negative, or the nanoseconds are a second or more.
    """
    if stamp.sec < 0 or stamp.nanosec >= 10**9:
        raise InvalidMessage(
            what,
            f'it is {stamp.sec} s and {stamp.nanosec} ns; it must be 0 s or more, and less '
            'than 1000000000 ns',
        )
    return float(stamp.sec + 1e-9 * stamp.nanosec)


def nanoseconds_from_time(stamp: Time) -> int:
    """Convert a time stamp to nanoseconds, to tell stamps apart exactly."""
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def time_from_seconds(seconds: float) -> Time:
    """
    Convert seconds to a time stamp, to the nanosecond.

    Parameters
    ----------
    seconds : float
        Before 2^31 s; times before 0 become 0, as trajectories that run already have them.

    Returns
    -------
    Time
        The stamp.

    Raises
    ------
    InvalidMessage
        If no stamp can hold them.
    """
    if not seconds < 2.0**31 - 1.0:
        raise InvalidMessage('time stamp', f'it would be {seconds:g} s; 2147483646 s are the most')
    nanoseconds = max(0, round(max(seconds, 0.0) * 1e9))
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
        If a number is not finite, the position is out of range, or the quaternion is no
        rotation.
    """
    x, y, _ = position_from_message(message.position, what)
    return Pose2D(x, y, yaw_from_quaternion(unit_quaternion(message.orientation, what)))


def checked_name(name: str, what: str) -> str:
    """
    Return the name of a frame, a joint or an obstacle.

    Parameters
    ----------
    name : str
        The name.
    what : str
        What it belongs to, for the error's sentence.

    Raises
    ------
    InvalidMessage
        If it is too long to be kept and sent on, or cannot be printed.
    """
    if len(name) > LONGEST_NAME or not name.isprintable():
        raise InvalidMessage(
            what,
            f'a name in it is {quoted(name, 60)}; {LONGEST_NAME} printable characters are the most',
        )
    return name


def position_from_message(position: Point, what: str) -> tuple[float, float, float]:
    """
    Read a position.

    Parameters
    ----------
    position : Point
        In any frame.
    what : str
        What is there, for the error's sentence.

    Returns
    -------
    tuple of float
        x, y and z [m].

    Raises
    ------
    InvalidPose
        If one is not finite, or farther than `LARGEST_COORDINATE` from the frame's origin.
    """
    numbers = (position.x, position.y, position.z)
    if not all(abs(number) <= LARGEST_COORDINATE for number in numbers):
        raise InvalidPose(
            what,
            f'its position is {numbers} m; each must be from {-LARGEST_COORDINATE:g} to '
            f'{LARGEST_COORDINATE:g} m',
        )
    return numbers


def unit_quaternion(q: Quaternion, what: str) -> tuple[float, float, float, float]:
    """
    Read a rotation.

    Parameters
    ----------
    q : Quaternion
        Of about length 1.
    what : str
        What is turned by it, for the error's sentence.

    Returns
    -------
    tuple of float
        x, y, z and w, of length 1.

    Raises
    ------
    InvalidPose
        If its length is not within 0.1 of 1.
    """
    # Squares of large components would overflow; hypot scales them.
    length = math.hypot(q.x, q.y, q.z, q.w)
    if not 0.9 < length < 1.1:
        raise InvalidPose(
            what,
            f'its quaternion xyzw {(q.x, q.y, q.z, q.w)} has length {length:.4g}; it must be 1',
        )
    return (q.x / length, q.y / length, q.z / length, q.w / length)


def orientation_from_odometry(message: Odometry) -> NDArray[np.float64]:
    """Return the body's orientation, a unit quaternion xyzw, shape (4,); or InvalidPose."""
    return np.array(unit_quaternion(message.pose.pose.orientation, 'odometry'))


def base_transform(odometry: Odometry) -> TransformStamped:
    """Write the pose of an odometry as a transform; InvalidPose if it is none."""
    transform = TransformStamped(header=odometry.header, child_frame_id=odometry.child_frame_id)
    pose = odometry.pose.pose
    x, y, z = position_from_message(pose.position, 'odometry')
    transform.transform.translation = Vector3(x=x, y=y, z=z)
    qx, qy, qz, qw = unit_quaternion(pose.orientation, 'odometry')
    transform.transform.rotation = Quaternion(x=qx, y=qy, z=qz, w=qw)
    return transform


def footprint_transform(odometry: Odometry, frame: str, ground: float = 0.0) -> TransformStamped:
    """
    Write where the body stands on the ground: its position and heading there (REP-120).

    Parameters
    ----------
    odometry : nav_msgs/Odometry
        Of the body.
    frame : str
        Of the footprint.
    ground : float
        Height of the ground below the body, in the odometry's frame [m].

    Returns
    -------
    geometry_msgs/TransformStamped
        From the body's own frame, in which the footprint, upright in the odometry's, is tilted
        the other way.

    Raises
    ------
    InvalidPose
        If the odometry is no pose.
    """
    transform = TransformStamped(child_frame_id=frame)
    transform.header.stamp = odometry.header.stamp
    transform.header.frame_id = odometry.child_frame_id
    pose = odometry.pose.pose
    height = position_from_message(pose.position, 'odometry')[2]
    x, y, z, w = unit_quaternion(pose.orientation, 'odometry')
    # The odometry's vertical in the body's frame.
    up = matrix_from_unit_quaternion((x, y, z, w))[2]
    down = [float(part) for part in (ground - height) * up]
    transform.transform.translation = Vector3(x=down[0], y=down[1], z=down[2])
    # The body's orientation undone, then its heading.
    turn = quaternion_from_yaw(yaw_from_quaternion((x, y, z, w)))
    transform.transform.rotation = Quaternion(
        x=-x * turn.w - y * turn.z,
        y=x * turn.z - y * turn.w,
        z=w * turn.z - z * turn.w,
        w=w * turn.w + z * turn.z,
    )
    return transform


def pose_transform(pose: Pose2D, parent: str, child: str, stamp: Time) -> TransformStamped:
    """Write where a frame is in another one."""
    transform = TransformStamped(child_frame_id=child)
    transform.header.frame_id = parent
    transform.header.stamp = stamp
    transform.transform.translation = Vector3(x=pose.x, y=pose.y, z=0.0)
    transform.transform.rotation = quaternion_from_yaw(pose.yaw)
    return transform


def camera_transform(model: CameraModel, parent: str, child: str, stamp: Time) -> TransformStamped:
    """Write where a camera is and how it looks."""
    transform = pose_transform(Pose2D(0.0, 0.0, 0.0), parent, child, stamp)
    x, y, z = (float(v) for v in model.position)
    transform.transform.translation = Vector3(x=x, y=y, z=z)
    # Imported late: only cameras need it.
    import cv2

    turn = cv2.Rodrigues(model.rotation)[0].reshape(3)
    angle = float(np.linalg.norm(turn))
    x, y, z = (float(v) for v in turn * (math.sin(angle / 2.0) / max(angle, 1e-12)))
    transform.transform.rotation = Quaternion(x=x, y=y, z=z, w=math.cos(angle / 2.0))
    return transform


def most_plan_bytes(longest: int = LONGEST_PLAN) -> int:
    """Return the bytes that a message with a plan of so many poses may have."""
    return _ROOM + _POSE_BYTES * longest


def plan_from_message(message: Path, longest: int = LONGEST_PLAN) -> Plan | None:
    """
    Read a plan.

    Parameters
    ----------
    message : Path
        Turning points; an empty path takes the plan back.
    longest : int
        Poses that it may have.

    Returns
    -------
    Plan or None
        None for an empty path.

    Raises
    ------
    InvalidMessage
        If it has more poses.
    InvalidPose
        If a pose is not valid.
    """
    if not message.poses:
        return None
    if len(message.poses) > longest:
        raise InvalidMessage(
            'plan', f'it has {len(message.poses)} poses; {longest} turning points are the most'
        )
    return Plan(
        tuple(
            pose_from_message(stamped.pose, f'pose {index} of the plan')
            for index, stamped in enumerate(message.poses)
        )
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


def duration_from_seconds(seconds: float) -> Duration:
    """Convert seconds to a duration, to the nanosecond; negative ones become 0."""
    time = time_from_seconds(seconds)
    return Duration(sec=time.sec, nanosec=time.nanosec)
