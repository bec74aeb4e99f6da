"""
The services of ``gait_node``, and the emergency stop that others may ask for as well.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool
from std_srvs.srv import SetBool, Trigger

from quad_common.errors import QuadError
from quad_common.ros.ros_node import QuadNode
from quad_gait.behaviours.activity import Activity
from quad_gait.gait_topics import GaitTopics
from quad_gait.supervisor import Supervisor

Now = Callable[[], tuple[float | None, NDArray[np.float64] | None]]

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_EVERY_ONE = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""For what is said of the stop: what this node has said is told apart by its order."""

_ECHO_TIME = 2.0
"""Time within which others have said that they hold the joints, as they were told to [s]."""


class GaitServices:
    """
    The services of the gait: each wishes for something.

    Parameters
    ----------
    node : QuadNode
        The node.
    supervisor : Supervisor
        What decides.
    topics : GaitTopics
        What is published of it.
    now : callable
        Returns time [s] and joints, (12,) [rad], as they are now; None for what is not known.
    """

    def __init__(
        self, node: QuadNode[Any], supervisor: Supervisor, topics: GaitTopics, now: Now
    ) -> None:
        self._topics = topics
        node.create_service(Trigger, 'stand', partial(self._on_request, supervisor.stand))
        node.create_service(Trigger, 'sit', partial(self._on_request, supervisor.sit))
        node.create_service(Trigger, 'stop', partial(self._on_request, supervisor.stop))
        self._emergency_stop = EmergencyStop(node, supervisor, topics, now)

    def _on_request(
        self, request: Callable[[], str], _: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        """Stand, sit or stop."""
        try:
            response.message, response.success = request(), True
        except QuadError as error:
            response.message, response.success = str(error), False
        self._topics.publish_followed()
        return response


class EmergencyStop:
    """
    Freezes the robot when it is asked to, or when whoever moves the joints has stopped them.

    Parameters
    ----------
    node : QuadNode
        The node.
    supervisor : Supervisor
        What decides.
    topics : GaitTopics
        Where trajectories go.
    now : callable
        Returns time [s] and joints, (12,) [rad], as they are now; None for what is not known.
    """

    def __init__(
        self, node: QuadNode[Any], supervisor: Supervisor, topics: GaitTopics, now: Now
    ) -> None:
        self._node, self._now = node, now
        self._supervisor = supervisor
        self._topics = topics
        # What this node has said, and not heard yet; what is older is not heard any more.
        self._said: deque[bool] = deque(maxlen=_EVERY_ONE.depth)
        self._told_to_hold_at = -math.inf
        self._active = node.create_publisher(Bool, 'emergency_stop/active', _LATCHED)
        node.create_subscription(Bool, 'emergency_stop/active', self._on_active, _EVERY_ONE)
        node.create_subscription(Bool, 'emergency_stop/held', self._on_held, _LATCHED)
        node.create_service(SetBool, 'emergency_stop', self._on_request)

    def _on_request(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        """Freeze the robot at once, or release it."""
        response.success = True
        if request.data:
            self._freeze()
            response.message = 'all joints hold until the emergency stop is released'
        else:
            response.message = self._supervisor.release()
            self._tell(False)
        return response

    def _on_active(self, message: Bool) -> None:
        """Take over a stop that somebody else has published: it stops simulator and drivers."""
        if message.data in self._said:
            # Some of what was said may have been lost, but not its order.
            while self._said.popleft() != message.data:
                pass
        elif message.data:
            self._take_over()

    def _on_held(self, message: Bool) -> None:
        """Take over a stop of a gait node before this one, or of whoever moves the joints."""
        # What is said of this node's own stops comes late: it may be released by now.
        is_echo = time.monotonic() - self._told_to_hold_at < _ECHO_TIME
        if message.data and not is_echo:
            self._take_over()

    def _take_over(self) -> None:
        if self._supervisor.activity is not Activity.EMERGENCY_STOP:
            self._freeze()

    def _freeze(self) -> None:
        self._topics.publish_trajectory(self._supervisor.freeze(*self._now()), is_last=True)
        self._tell(True)

    def _tell(self, is_on: bool) -> None:
        """Say whether the emergency stop is on."""
        if is_on:
            self._told_to_hold_at = time.monotonic()
        self._said.append(is_on)
        self._active.publish(Bool(data=is_on))
        self._topics.publish_followed()
        self._node.update_status()
