"""
How recorded topics are subscribed to, and their messages read; nothing here writes a file.
"""

from __future__ import annotations

from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from quad_common.errors import InvalidMessage
from quad_common.process.end_signals import shielded
from quad_lab.recordings.recorded_topics import Delivery, RecordedTopic

_DEPTH = 2000
"""Messages of a topic that wait while others are taken."""


def subscription_quality(topic: RecordedTopic) -> QoSProfile:
    """Return how a topic is subscribed to by whoever takes all of it: nothing may be lost."""
    is_sensor = topic.delivery is Delivery.SENSOR
    is_latched = topic.delivery is Delivery.LATCHED
    return QoSProfile(
        depth=topic.depth if is_latched else _DEPTH,
        reliability=ReliabilityPolicy.BEST_EFFORT if is_sensor else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE,
    )


def message_of(data: bytes, kind: Any) -> Any:
    """
    Take a message (CDR) apart.

    Parameters
    ----------
    data : bytes
        The message.
    kind : type
        Class of messages.

    Raises
    ------
    InvalidMessage
        If it is no such message.
    """
    # What a signal raises while the message's object is being made, rclpy turns into a TypeError.
    with shielded():
        try:
            return deserialize_message(data, kind)
        except Exception as error:
            # The middleware's own kind of error.
            raise InvalidMessage('message', f'its bytes are no {kind.__name__}') from error
