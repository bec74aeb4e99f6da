"""
Two ends of a round trip: a process that sends back what it receives, and one that calls it.
"""

from __future__ import annotations

import os
import sys
import threading
import time

import rclpy
from rclpy.qos import QoSProfile
from std_msgs.msg import String

from quad_common.network.transport import leave_shared_memory
from quad_common.ros.run_node import make_executor

_KIND = String
"""What is sent; no topic of a robot."""

_LONGEST_CALL = 2.0
"""Time after which a message counts as lost [s]."""

_TURN = 0.05
"""Longest time without a look at whether it is to end [s]."""


class _End:
    """
    A node that sends to one topic and listens to another; use it in a ``with`` block.

    Parameters
    ----------
    name : str
        Which of the two ends it is.
    send, listen : str
        Topics.
    """

    def __init__(self, name: str, send: str, listen: str) -> None:
        leave_shared_memory(os.environ)
        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self.node = rclpy.create_node(
            f'quadwalk_doctor_{name}', context=self.context, start_parameter_services=False
        )
        self.executor = make_executor(self.context)
        self.executor.add_node(self.node)
        self.publisher = self.node.create_publisher(_KIND, send, QoSProfile(depth=10))
        self.received: str | None = None
        self.node.create_subscription(_KIND, listen, self.take, QoSProfile(depth=10))

    def __enter__(self) -> _End:
        return self

    def __exit__(self, *ending: object) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.try_shutdown()

    def take(self, message: String) -> None:
        """Keep what was received."""
        self.received = message.data


class Caller(_End):
    """
    Sends messages, and times how long they take there and back.

    Parameters
    ----------
    trip : str
        What tells this round trip from others: letters, digits and underscores.
    """

    def __init__(self, trip: str) -> None:
        super().__init__('caller', _there(trip), _back(trip))

    def __enter__(self) -> Caller:
        return self

    def find(self, patience: float) -> bool:
        """Wait until a message comes back, for some time [s]; return whether one has."""
        end = time.monotonic() + patience
        while time.monotonic() < end:
            # The first ones may be sent before the way back is known.
            if self.publisher.get_subscription_count() and self._call(f'{time.monotonic()}', 0.5):
                return True
            self.executor.spin_once(timeout_sec=_TURN)
        return False

    def call(self, count: int) -> list[float]:
        """Return how long messages took there and back [s]; the first one that is lost ends it."""
        times = []
        for number in range(count):
            began = time.perf_counter()
            if not self._call(str(number), _LONGEST_CALL):
                break
            times.append(time.perf_counter() - began)
        return times

    def _call(self, text: str, patience: float) -> bool:
        self.publisher.publish(String(data=text))
        end = time.monotonic() + patience
        while self.received != text and time.monotonic() < end:
            self.executor.spin_once(timeout_sec=_TURN)
        return self.received == text


class _Echo(_End):
    """Sends back what it receives."""

    def __init__(self, trip: str) -> None:
        super().__init__('echo', _back(trip), _there(trip))

    def take(self, message: String) -> None:
        """Send it back."""
        self.publisher.publish(message)


def _there(trip: str) -> str:
    return f'quadwalk_doctor/{trip}/there'


def _back(trip: str) -> str:
    return f'quadwalk_doctor/{trip}/back'


def main() -> None:
    """Echo until nobody holds the other end of stdin any more."""
    is_over = threading.Event()

    def wait() -> None:
        sys.stdin.read()
        is_over.set()

    threading.Thread(target=wait, daemon=True).start()
    with _Echo(sys.argv[1]) as echo:
        while not is_over.is_set():
            echo.executor.spin_once(timeout_sec=_TURN)


if __name__ == '__main__':
    main()
