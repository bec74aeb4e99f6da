"""
Takes all messages of a robot's topics, with as little of the machine's time as can be.

Whoever waits for each message wakes up thousands of times a second beside a fast simulation, and
takes the time from the nodes that it listens to. Messages wait in the middleware here, and are
taken many at a time.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import Any

from quad_lab.recordings.recorded_topics import RecordedTopic
from quad_lab.recordings.subscription import subscription_quality

_PERIOD = 0.02
"""Time between two looks for messages [s], on the machine's clock."""

_MOST = 2000
"""Messages of a topic that are taken at a look: a topic that is flooded must not keep others
waiting."""

OnMessage = Callable[[RecordedTopic, bytes], None]


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
        self._on_message = on_message
        self._subscriptions: list[tuple[RecordedTopic, Any]] = []
        self._held: list[tuple[int, RecordedTopic, bytes]] = []
        for topic, name in names:
            kind = topic.message_type()
            if kind is not None:
                subscription = node.create_subscription(
                    kind, name, lambda data: None, subscription_quality(topic), raw=True
                )
                self._subscriptions.append((topic, subscription))

    def listen(self, duration: float) -> None:
        """Handle what comes in for some time on the machine's clock [s]."""
        end = time.monotonic() + duration
        while (left := end - time.monotonic()) > 0.0:
            time.sleep(min(left, _PERIOD))
            self.take()

    def take(self) -> None:
        """Handle what has come in by now."""
        now = time.time_ns()
        waiting, self._held = self._held, []
        for topic, subscription in self._subscriptions:
            handle = subscription.handle
            with handle:
                for _ in range(_MOST):
                    taken = handle.take_message(subscription.msg_type, True)
                    if taken is None:
                        break
                    data, info = taken
                    message = info['received_timestamp'], topic, data
                    # Of a topic that was looked at earlier, something may have come before it.
                    (waiting if message[0] <= now else self._held).append(message)
        waiting.sort(key=_received)
        for _, topic, data in waiting:
            self._on_message(topic, data)


def _received(message: tuple[int, RecordedTopic, bytes]) -> int:
    return message[0]
