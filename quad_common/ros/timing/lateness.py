"""
Of a node that has fallen behind, only the newest message of each stream counts.

The EventsExecutor does what it is told in the order in which it was told, and does not forget: a
stream that comes faster than its callback is done makes a queue that grows for as long as that
lasts. Each of its entries takes a message that has just come, so nothing looks old, while a request
to stop waits behind all of them. Streams of sensors may lose messages; requests may not.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

_LATE = 0.1
"""Time that something waits for its turn, beyond which a node is late [s]."""

_PERIOD = 0.05
"""Time between two looks at how long that is [s]."""

_REST = 8.0
"""Time for which a stream rests in a late node, per time that its last message took: gait_node has
four streams, and so two thirds of its time are left for what waits."""


class Lateness:
    """
    Whether what a node is told waits for long until it is done.

    Parameters
    ----------
    clock : callable, optional
        Returns the time [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.clock = clock
        """Returns the time [s]."""
        self.left_out = 0
        """Number of readings that were left out."""
        self._asked_at: float | None = None
        self._answered_at = -_PERIOD

    @property
    def is_late(self) -> bool:
        """Whether what was put at the end of the queue a while ago has not had its turn."""
        return self._asked_at is not None and self.clock() - self._asked_at > _LATE

    def look(self, call_soon: Callable[[Callable[[], None]], object]) -> None:
        """
        Put something at the end of the queue, once in a while, and see when it has its turn.

        Parameters
        ----------
        call_soon : callable
            Has a callable called after all that waits already.
        """
        now = self.clock()
        if self._asked_at is None and now - self._answered_at >= _PERIOD:
            self._asked_at = now
            call_soon(self._answer)

    def _answer(self) -> None:
        self._asked_at, self._answered_at = None, self.clock()


class StreamCallback:
    """
    The callback of a stream: handed on is each message, of a late node the newest now and then.

    Parameters
    ----------
    callback : callable
        Takes a message.
    lateness : Lateness
        Of the node.
    """

    def __init__(self, callback: Callable[[Any], Any], lateness: Lateness) -> None:
        self._callback = callback
        self._lateness = lateness
        self._rests_until = -math.inf
        self.subscription: Any = None
        """Subscription that it is the callback of; None before it is made."""

    def __call__(self, message: Any) -> None:
        """Hand on a message, unless newer ones wait behind it and time is short."""
        if not self._lateness.is_late:
            self._callback(message)
            return
        began = self._lateness.clock()
        if began < self._rests_until:
            self._lateness.left_out += 1
            return
        try:
            self._callback(self._newest(message))
        finally:
            ended = self._lateness.clock()
            self._rests_until = ended + _REST * (ended - began)

    def _newest(self, message: Any) -> Any:
        subscription = self.subscription
        if subscription is None:
            return message
        with subscription.handle:
            # What comes meanwhile must not keep it here: no more than the queue holds.
            for _ in range(subscription.qos_profile.depth):
                taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
                if taken is None:
                    break
                self._lateness.left_out += 1
                message = taken[0]
        return message
