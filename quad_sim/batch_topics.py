"""
What ``sim_node`` publishes often, and once more in batches for whoever keeps all of it.
"""

from __future__ import annotations

import array
import time
from typing import Any, Protocol

from rclpy.serialization import serialize_message
from std_msgs.msg import MultiArrayDimension, MultiArrayLayout, UInt8MultiArray

from quad_common.message_batch import MessageBatch


class PublisherMaker(Protocol):
    """A node, or what makes publishers as one does."""

    def create_publisher(self, kind: Any, topic: str, qos: Any) -> Any:
        """Make a publisher; see rclpy's Node."""


class BatchTopics:
    """
    Publishes messages on their own topics, and in batches while somebody subscribes to those.

    Parameters
    ----------
    maker : PublisherMaker
        Node, or namespace of it, that makes their publisher.
    publishers : publishers of rclpy
        Those whose messages are in the batches.
    """

    def __init__(self, maker: PublisherMaker, *publishers: Any) -> None:
        # Nothing is lost while a recorder is busy for some seconds.
        self._publisher = maker.create_publisher(UInt8MultiArray, 'batches', 500)
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
        self.keep(publisher, data)

    def keep(self, publisher: Any, data: bytes) -> None:
        """Take note of a message that one of the publishers has published, as its bytes."""
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
