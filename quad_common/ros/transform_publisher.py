"""
Publishes transforms on ``/tf`` and ``/tf_static`` where tf2_msgs is installed.

As tf2 does, in whatever namespace the node is: robots in one tree differ by their frames' names.
"""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

try:
    from tf2_msgs.msg import TFMessage
except ImportError:
    TFMessage = None

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class TransformPublisher:
    """
    Transforms of a node; without tf2_msgs, or if they are not wanted, none are published.

    Parameters
    ----------
    node : Node
        The node.
    is_wanted : bool
        Whether to publish them.
    """

    def __init__(self, node: Node, is_wanted: bool) -> None:
        self._fixed: Any = None
        self._moving: Any = None
        if not is_wanted:
            return
        if TFMessage is None:
            node.get_logger().info('tf2_msgs is not installed: no transforms are published')
            return
        self._fixed = node.create_publisher(TFMessage, '/tf_static', _LATCHED)
        self._moving = node.create_publisher(TFMessage, '/tf', 100)

    @property
    def is_active(self) -> bool:
        """Whether transforms are published."""
        return self._moving is not None

    def publish(self, *transforms: TransformStamped) -> None:
        """Publish transforms that change with time."""
        if self._moving is not None:
            self._moving.publish(TFMessage(transforms=list(transforms)))

    def publish_static(self, *transforms: TransformStamped) -> None:
        """Publish the transforms that do not change, all of them at once."""
        if self._fixed is not None:
            self._fixed.publish(TFMessage(transforms=list(transforms)))
