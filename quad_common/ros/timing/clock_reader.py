"""
Reads simulated time when it is asked for, and not each time that it comes.

It comes a hundred times a second of simulation. To call each node for each of these messages took
five hundredths of all that is computed where simulated time goes as fast as it can.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.time_source import TimeSource
from rosgraph_msgs.msg import Clock


class ClockReader:
    """A node's subscription to ``/clock`` that rclpy makes for its clock; no executor calls it."""

    def __init__(self) -> None:
        self._subscription: Any = None

    @staticmethod
    def is_wanted_for(msg_type: Any, callback: Callable[[Any], Any]) -> bool:
        """Return whether a subscription sets the node's clock: rclpy's own does."""
        return msg_type is Clock and isinstance(getattr(callback, '__self__', None), TimeSource)

    def take(self, subscription: Any) -> None:
        """Read this subscription of rclpy from now on."""
        self._subscription = subscription

    def forget(self, subscription: Any) -> None:
        """Read it no longer if it is this one, as it is destroyed."""
        if subscription is self._subscription:
            self._subscription = None

    def is_read(self, subscription: Any) -> bool:
        """Return whether a subscription is the one that is read here."""
        return subscription is self._subscription

    def read(self) -> None:
        """Set the clock to the newest time that has come, if one has."""
        subscription = self._subscription
        if subscription is None:
            return
        with subscription.handle:
            taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
        if taken is not None:
            subscription.callback(taken[0])
