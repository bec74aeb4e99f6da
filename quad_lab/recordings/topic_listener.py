"""
Takes all messages of a robot's topics, with as little of the machine's time as can be.

Whoever waits for each message wakes up thousands of times a second beside a fast simulation, and
takes the time from the nodes that it listens to. Messages wait in the middleware here, and are
taken many at a time. Those that a simulator publishes in batches do not even arrive one by one.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterable
from typing import Any

from std_msgs.msg import UInt8MultiArray

from quad_common.errors import InvalidMessage
from quad_common.message_batch import read_batch
from quad_lab.recordings.recorded_topics import BATCHES, RecordedTopic
from quad_lab.recordings.subscription import message_of, subscription_quality

_PERIOD = 0.02
"""Time between two looks for messages [s], on the machine's clock."""

_MOST = 2000
"""Messages of a topic that are taken at a look: a topic that is flooded must not keep others
waiting."""

_LONGEST_HOLD = 100_000_000
"""Time for which messages wait for a batch with what was published before them, at most [ns]."""

OnMessage = Callable[[RecordedTopic, bytes], None]

_Received = tuple[int, RecordedTopic, bytes]
"""When it was received [ns], of which topic, the message (CDR)."""


class TopicListener:
    """
    Subscriptions of a node that no executor runs.

    Parameters
    ----------
    node : rclpy.node.Node
        Whose subscriptions they become; it must be in no executor.
    names : iterable of (RecordedTopic, str)
        Topics, and their names as the node subscribes to them; what has no type here is left out.
    on_message : callable
        Called with topic and message (CDR), in the order in which messages were received.
    """

    def __init__(
        self, node: Any, names: Iterable[tuple[RecordedTopic, str]], on_message: OnMessage
    ) -> None:
        self._node = node
        self._on_message = on_message
        self._subscriptions: list[tuple[RecordedTopic, Any]] = []
        self._held: list[_Received] = []
        self._batches: Any = None
        self._batched: dict[str, RecordedTopic] = {}
        self._complete_up_to = 0
        self._last_batched = 0
        for topic, name in names:
            kind = topic.message_type()
            if kind is not None:
                subscription = node.create_subscription(
                    kind, name, lambda data: None, subscription_quality(topic), raw=True
                )
                self._subscriptions.append((topic, subscription))

    def take_batches(self, name: str, names: Iterable[tuple[RecordedTopic, str]]) -> None:
        """
        Subscribe to batches of messages, too.

        Parameters
        ----------
        name : str
            Topic of the batches.
        names : iterable of (RecordedTopic, str)
            Topics that are taken from them, none of which is subscribed to, and their names.
        """
        resolve = self._node.resolve_topic_name
        self._batched = {resolve(name): topic for topic, name in names}
        self._batches = self._node.create_subscription(
            BATCHES.message_type(), name, lambda data: None, subscription_quality(BATCHES), raw=True
        )

    @property
    def waiting(self) -> int:
        """Number of messages that wait for what was published before them."""
        return len(self._held)

    def listen(self, duration: float) -> None:
        """Handle what comes in for some time on the machine's clock [s]."""
        end = time.monotonic() + duration
        while (left := end - time.monotonic()) > 0.0:
            time.sleep(min(left, _PERIOD))
            self.take()

    def take(self, is_last: bool = False) -> None:
        """Handle what has come in by now; at the last time also what waits for its turn."""
        now = time.time_ns()
        messages, self._held = self._held, []
        for topic, subscription in self._subscriptions:
            messages += (
                (info['received_timestamp'], topic, data) for data, info in _new(subscription)
            )
        if self._batches is not None:
            for data, info in _new(self._batches):
                messages += self._batched_messages(data, info['received_timestamp'])
            # What comes in a batch was published before what came while the batch was filled.
            now = max(self._complete_up_to, now - _LONGEST_HOLD)
        messages.sort(key=_received)
        for number, (received, topic, data) in enumerate(messages):
            # Of a topic that was looked at earlier, something may have come before it.
            if received > now and not is_last:
                self._held = messages[number:]
                break
            self._on_message(topic, data)

    def _batched_messages(self, data: bytes, received: int) -> list[_Received]:
        """
        Return the messages of a batch as if each had come when it was published.

        A batch may be on its way for longer than the next one: none of the next one's messages
        comes before it for that.
        """
        self._complete_up_to = received
        messages: list[_Received] = []
        # Of a batch that is damaged, what comes before the damage is good.
        with contextlib.suppress(InvalidMessage):
            batch = message_of(data, UInt8MultiArray)
            topics = tuple(dimension.label for dimension in batch.layout.dim)
            for message in read_batch(topics, bytes(batch.data)):
                topic = self._batched.get(message.topic)
                if topic is not None:
                    published = received - message.age
                    self._last_batched = min(max(self._last_batched, published), received)
                    messages.append((self._last_batched, topic, message.data))
        return messages


def _new(subscription: Any) -> list[tuple[bytes, dict[str, int]]]:
    """Take the messages that wait, with what is known of each."""
    messages: list[tuple[bytes, dict[str, int]]] = []
    with (handle := subscription.handle):
        while len(messages) < _MOST:
            taken = handle.take_message(subscription.msg_type, True)
            if taken is None:
                break
            messages.append(taken)
    return messages


def _received(message: _Received) -> int:
    return message[0]
