"""
What ``sim_node`` publishes often, and once more in batches for whoever keeps all of it.
"""

from __future__ import annotations

import array
import time
from typing import Any

from rclpy.node import Node
from rclpy.serialization import serialize_message
from std_msgs.msg import MultiArrayDimension, MultiArrayLayout, UInt8MultiArray

from quad_common.message_batch import MessageBatch


class BatchTopics:
    """
    Publishes messages on their own topics, and in batches while somebody subscribes to those.

    Parameters
    ----------
    node : Node
        The node.
    publishers : publishers of rclpy
        Those whose messages are in the batches.
    """

    def __init__(self, node: Node, *publishers: Any) -> None:
        # Nothing is lost while a recorder is busy for some seconds.
        self._publisher = node.create_publisher(UInt8MultiArray, 'batches', 500)
        self._index = {publisher: index for index, publisher in enumerate(publishers)}
        self._batch = MessageBatch(tuple(publisher.topic_name for publisher in publishers))
        self.is_wanted = False
        """Whether somebody subscribes to the batches."""

    def publish(self, publisher: Any, message: Any) -> None:
        """Publish a message by one of the publishers."""
        if not self.is_wanted:
            publisher.publish(message)
            return
        # The middleware would do the same to it: it is done once.
        data = serialize_message(message)
        publisher.publish(data)
        self._batch.add(self._index[publisher], data, time.time_ns())

    def send(self) -> None:
        """Publish the batch if it is due, and look who subscribes to the next."""
        now = time.time_ns()
        if self._batch.is_due(now):
            labels = [MultiArrayDimension(label=name) for name in self._batch.topics]
            data = array.array('B', self._batch.close(now))
            layout = MultiArrayLayout(dim=labels)
            self._publisher.publish(UInt8MultiArray(layout=layout, data=data))
        self.is_wanted = self._publisher.get_subscription_count() > 0
        if not self.is_wanted:
            # Whoever subscribes next gets nothing that is old.
            self._batch.close(now)
