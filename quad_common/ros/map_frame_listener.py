"""
Receives odometry's frame in the map: the ROS side of :mod:`quad_common.frames.map_frame`.
"""

from __future__ import annotations

import time
from typing import Any

from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile

from quad_common.frames.frame_tree import FrameTransform
from quad_common.frames.map_frame import MapFrame
from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import checked_name, pose_from_message, seconds_from_time
from quad_common.ros.ros_node import QuadNode

try:
    from tf2_msgs.msg import TFMessage
except ImportError:
    TFMessage = None

_STATIC = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_MOST_BYTES = 500_000
"""Size of the largest message with transforms: 4000 of them."""

_PATIENCE = 5.0
"""Time without a transform after which the frames are said to coincide [s]."""


class MapFrameListener:
    """
    Subscribes to transforms for a node, and places its odometry on the map.

    Parameters
    ----------
    node : QuadNode
        The node; it calls :meth:`problem` about once a second.
    frame : MapFrame
        What composes the transforms.
    timeout : float
        A correction is old after so much time of odometry [s].
    """

    def __init__(self, node: QuadNode[Any], frame: MapFrame, timeout: float) -> None:
        self.frame = frame
        self._node = node
        self._timeout = timeout
        self._first_odometry_at: float | None = None
        self._has_said = False
        if TFMessage is not None:
            most = {'most_bytes': _MOST_BYTES}
            # As tf2's listeners, in whatever namespace the node is.
            node.create_subscription(TFMessage, '/tf', self._on_transforms, 100, **most)
            node.create_subscription(
                TFMessage, '/tf_static', self._on_static_transforms, _STATIC, **most
            )
        node.create_subscription(TransformStamped, 'map_to_odom', self._on_map_to_odom, 10)

    def locate(self, message: Odometry) -> tuple[Pose2D, Pose2D]:
        """
        Take an odometry; corrections that leap are logged.

        Parameters
        ----------
        message : nav_msgs/Odometry
            Of base_link.

        Returns
        -------
        tuple of Pose2D
            Pose of base_link in the map, and in odometry's own frame.

        Raises
        ------
        InvalidPose
            If the odometry is no pose; nothing changes.
        """
        odometry = pose_from_message(message.pose.pose, 'odometry')
        header = message.header
        stamp = seconds_from_time(header.stamp)
        pose = self.frame.locate(
            stamp, checked_name(header.frame_id, 'odometry').lstrip('/'), odometry
        )
        if self._first_odometry_at is None:
            self._first_odometry_at = time.monotonic()
        for remark in self.frame.take_remarks():
            self._node.get_logger().info(remark)
        return pose, odometry

    def problem(self) -> str:
        """
        Say whether corrections contradict one another or have grown old; empty if not.

        That none is published is logged once: then the frames coincide.
        """
        frame = self.frame
        if frame.doubt:
            return frame.doubt
        if frame.age > self._timeout:
            return (
                f"the last correction '{frame.name}' -> '{frame.odom_frame}' is {frame.age:.0f} s "
                f'old; it stays in force'
            )
        if frame.correction is None and not frame.is_in_map and not self._has_said:
            self._say_that_frames_coincide()
        return ''

    def _say_that_frames_coincide(self) -> None:
        """Log it once, when a localiser has had time enough to publish."""
        since = self._first_odometry_at
        if since is None or time.monotonic() - since < _PATIENCE:
            return
        self._has_said = True
        where = '/tf or map_to_odom' if TFMessage else 'map_to_odom (tf needs tf2_msgs)'
        self._node.get_logger().info(
            f"nothing publishes '{self.frame.name}' -> '{self.frame.odom_frame}' on {where}: "
            f'the frames are taken to coincide'
        )

    def _on_transforms(self, message: Any) -> None:
        self.frame.add([frame_transform(t) for t in message.transforms])

    def _on_static_transforms(self, message: Any) -> None:
        self.frame.add([frame_transform(t, is_static=True) for t in message.transforms])

    def _on_map_to_odom(self, message: TransformStamped) -> None:
        self.frame.add([frame_transform(message)])


def frame_transform(message: TransformStamped, is_static: bool = False) -> FrameTransform:
    """Read a transform as plain numbers; whether they make sense is said by who uses it."""
    move, turn = message.transform.translation, message.transform.rotation
    return FrameTransform(
        message.header.frame_id,
        message.child_frame_id,
        (move.x, move.y, move.z),
        (turn.x, turn.y, turn.z, turn.w),
        is_static,
    )
