"""
Conversions between ROS messages and what the ceiling camera sees.
"""

from __future__ import annotations

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo

from quad_common.errors import InvalidMessage
from quad_common.errors.quoting import quoted
from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import (
    base_transform,
    checked_name,
    footprint_transform,
    pose_from_message,
    pose_message,
    pose_transform,
)
from quad_perception.picture.marker_poses import MarkerPose
from quad_perception.tracking.pose_fusion import PoseFusion

_FASTEST = 100.0
"""Largest velocity of a robot that is believed [m/s, rad/s]."""

_AXES = (0, 1, 5)
"""x, y and yaw among the six of a ROS covariance."""


def seen_pose_message(seen: MarkerPose, frame: str, stamp: Time) -> PoseWithCovarianceStamped:
    """
    Write where a picture shows the robot.

    Parameters
    ----------
    seen : MarkerPose
        The robot's base_link.
    frame : str
        Of the map.
    stamp : Time
        Of the picture.

    Returns
    -------
    geometry_msgs/PoseWithCovarianceStamped
        Height, roll and pitch are not known: 0, with a covariance that says so.
    """
    message = PoseWithCovarianceStamped()
    message.header.frame_id, message.header.stamp = frame, stamp
    message.pose.pose = pose_message(seen.pose)
    message.pose.covariance = _six(seen.covariance)
    return message


def is_same_lens(one: CameraInfo, other: CameraInfo) -> bool:
    """Return whether two messages say the same of a camera's lens and its pictures' size."""
    return bool(
        (one.width, one.height, one.distortion_model)
        == (other.width, other.height, other.distortion_model)
        and one.k.tolist() == other.k.tolist()
        and one.d == other.d
    )


def legs_pose(message: Odometry, map_frames: tuple[str, ...], topic: str) -> Pose2D:
    """
    Read where the legs have the robot, in a frame that a camera can correct.

    Parameters
    ----------
    message : nav_msgs/Odometry
        Of the legs.
    map_frames : tuple of str
        Names of the map's frame, in which it must not be.
    topic : str
        Where it comes from, for the error's sentence.

    Returns
    -------
    Pose2D
        In the odometry's own frame.

    Raises
    ------
    InvalidMessage
        If it is in the map's frame or in none, a name in it is none, or its twist is not finite.
    InvalidPose
        If its pose is none.
    """
    frame = checked_name(message.header.frame_id, topic)
    if frame in ('', *map_frames):
        raise InvalidMessage(
            topic,
            f"it is in frame {quoted(frame)}; it must be in one of its own, as 'odom' is",
        )
    checked_name(message.child_frame_id, topic)
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    twist = (linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
    if not all(abs(value) <= _FASTEST for value in twist):
        raise InvalidMessage(
            topic,
            f'its twist is {twist}; each number must be from {-_FASTEST:g} to {_FASTEST:g} '
            'm/s or rad/s',
        )
    return pose_from_message(message.pose.pose, 'odometry')


def fused_odometry(legs: Odometry, fusion: PoseFusion, frame: str) -> Odometry:
    """
    Bring an odometry of the legs onto the map.

    Parameters
    ----------
    legs : nav_msgs/Odometry
        The last one that the fusion took.
    fusion : PoseFusion
        That knows the robot's pose.
    frame : str
        Of the map.

    Returns
    -------
    nav_msgs/Odometry
        With the stamp, the twist, the height and the tilt of the legs' odometry.
    """
    pose = fusion.pose
    assert pose is not None
    message = Odometry()
    message.header.frame_id, message.header.stamp = frame, legs.header.stamp
    message.child_frame_id = legs.child_frame_id
    message.pose.pose = pose_message(pose)
    message.pose.pose.position.z = legs.pose.pose.position.z
    message.pose.covariance = _six(fusion.covariance)
    message.twist = legs.twist
    return message


def robot_transforms(
    legs: Odometry, correction: Pose2D | None, map_frame: str, footprint_frame: str
) -> list[TransformStamped]:
    """
    Write where the robot is, as REP-105 wants it.

    Parameters
    ----------
    legs : nav_msgs/Odometry
        Of the legs: odom -> base_link.
    correction : Pose2D, optional
        Of the camera, map -> odom; none while it does not know.
    map_frame : str
        Of the map.
    footprint_frame : str
        On the ground under the body.

    Returns
    -------
    list of geometry_msgs/TransformStamped
        With the stamp and the frames of the legs' odometry: map -> odom -> base_link -> footprint.
    """
    transforms = [base_transform(legs), footprint_transform(legs, footprint_frame)]
    if correction is not None:
        header = legs.header
        transforms.append(pose_transform(correction, map_frame, header.frame_id, header.stamp))
    return transforms


def _six(planar: NDArray[np.float64]) -> NDArray[np.float64]:
    """Make the covariance of six numbers out of that of x, y and yaw."""
    covariance = np.diag([1e6] * 6)
    covariance[np.ix_(_AXES, _AXES)] = planar
    return covariance.reshape(-1)
