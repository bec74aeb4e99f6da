"""
Conversions between ROS messages and what the ceiling camera sees.
"""

from __future__ import annotations

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from nav_msgs.msg import Odometry
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.ros_conversions import (
    base_transform,
    footprint_transform,
    pose_message,
    pose_transform,
)
from quad_perception.marker_poses import MarkerPose
from quad_perception.pose_fusion import PoseFusion

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
        With the stamp and the frames of the legs' odometry.
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
