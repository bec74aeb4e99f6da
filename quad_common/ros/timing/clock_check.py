"""
Whether a node's time is that of what it receives.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock

if TYPE_CHECKING:
    from builtin_interfaces.msg import Time
    from rclpy.node import Node
    from rclpy.subscription import Subscription

_STANDS_STILL = 0.9
"""Time on the wall clock after which simulated time stands still [s]."""

_FAR = 10.0
"""Difference of two clocks that is no delay and no clock set by hand [s]."""

_NEXT_LOOK = 10.0
"""Time between two looks at ``/clock`` of a node that does not use it [s]."""

_LONGEST_LOOK = 1.0
"""Time for which it then looks [s]."""

_CLOCK = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class ClockCheck:
    """
    Notices a clock that stands still, and a ``use_sim_time`` that does not fit the measurements.

    Parameters
    ----------
    node : rclpy.node.Node
        The node.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._seen = self._now()
        self._seen_at = time.monotonic()
        self._stamp: float | None = None
        self._difference = 0.0
        self._look: Subscription | None = None
        self._looked_at = -_NEXT_LOOK
        self._is_clocks = False

    def problem(self) -> str | None:
        """Say why simulated time does not advance; None if it does, or is not used."""
        if not self._is_simulated():
            return None
        now = self._now()
        if now != self._seen:
            self._seen = now
            self._seen_at = time.monotonic()
        elif now == 0:
            return (
                'no clock: use_sim_time is true and nothing was received on /clock; '
                'start a simulator, or set use_sim_time to false on a real robot'
            )
        elif time.monotonic() - self._seen_at > _STANDS_STILL:
            return f'stale clock: simulated time stands still at {now / 1e9:.2f} s'
        return None

    def take_stamp(self, stamp: Time) -> None:
        """Take note of the stamp of odometry or a picture."""
        self._stamp = _seconds(stamp)
        # To now, for a robot that falls silent has not another clock.
        self._difference = 0.0 if not self._stamp else self._stamp - self._now() / 1e9

    def note(self) -> str:
        """
        Say that ``use_sim_time`` does not fit the measurements; empty if it does.

        It is false and should be true only if ``/clock`` has the time of the measurements: robots
        of several simulators in one domain rightly do without it. To be asked once in a while.
        """
        difference = self._difference
        if abs(difference) < _FAR:
            self._end_look()
            return ''
        if self._is_simulated():
            return (
                f'use_sim_time is true, and odometry is stamped {abs(difference):.0f} s '
                f'{"after" if difference > 0 else "before"} the time of /clock: '
                'set it to false on a real robot'
            )
        self._look_again()
        if not self._is_clocks:
            return ''
        return (
            'use_sim_time is false, and odometry is stamped with the time of /clock: '
            'with a simulator set it to true'
        )

    def _is_simulated(self) -> bool:
        return bool(self._node.get_parameter('use_sim_time').value)

    def _now(self) -> int:
        return int(self._node.get_clock().now().nanoseconds)

    def _look_again(self) -> None:
        """Subscribe to ``/clock`` for a moment: it comes a hundred times a second."""
        now = time.monotonic()
        if self._look is not None:
            if now - self._looked_at > _LONGEST_LOOK:
                self._end_look()
        elif now - self._looked_at < _NEXT_LOOK:
            return
        elif self._node.count_publishers('/clock') > 0:
            self._looked_at = now
            self._look = self._node.create_subscription(Clock, '/clock', self._on_clock, _CLOCK)

    def _on_clock(self, message: Clock) -> None:
        self._is_clocks = abs(_seconds(message.clock) - (self._stamp or 0.0)) < _FAR

    def _end_look(self) -> None:
        if self._look is not None:
            self._node.destroy_subscription(self._look)
            self._look = None


def _seconds(stamp: Time) -> float:
    return float(stamp.sec + stamp.nanosec / 1e9)
