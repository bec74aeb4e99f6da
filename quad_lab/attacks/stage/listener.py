"""
Subscribes to every topic that the nodes publish, and notes down what must never be published.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.qos import QoSProfile

from quad_common.errors import InvalidMessage, QuadError
from quad_common.robot.robot import Robot
from quad_common.ros.pose_conversions import seconds_from_time
from quad_lab.attacks.stage.checks import numbers_not_finite, texts_too_long
from quad_lab.attacks.stage.graph import Interface, outputs_of
from quad_lab.attacks.stage.limits import JointChecker, TrajectoryChecker
from quad_lab.attacks.stage.violations import (
    JOINTS_OUTSIDE,
    NOT_FINITE,
    OUTSIDE_LIMITS,
    TOO_LONG,
    UNREADABLE,
)
from quad_lab.recordings.subscription import message_of
from quad_sim.ros_conversions import trajectory_from_message

_DEPTH = 500
"""Messages that wait while the listener is busy."""

_WHILE = 10.0
"""Until all know that the robot stands elsewhere [s], simulated."""

_LONGEST_DECISION = 0.5
"""Simulated time between a decision and its trajectory's arrival here, at most [s]."""

_KEPT = 40
"""Examples of each kind of violation."""


class TopicListener:
    """
    Subscribes to what nodes publish, checks every message, and keeps the last of each topic.

    Parameters
    ----------
    node : rclpy.node.Node
        Whose subscriptions they are.
    robot : Robot
        Whose limits count.
    """

    def __init__(self, node: Any, robot: Robot) -> None:
        self._node = node
        self._subscribed: set[str] = set()
        self._own: set[int] = set()
        self._noted: set[tuple[str, str, str]] = set()
        self._names = robot.joint_names
        self._trajectories = TrajectoryChecker(robot)
        self._joints = JointChecker(robot)
        self.last: dict[str, Any] = {}
        """The last message of each topic that a node published itself."""
        self.statuses: dict[str, tuple[bytes, str, dict[str, str]]] = {}
        """Level, message and values of each node, as last received on diagnostics."""
        self.received_statuses = 0
        """Number of statuses that were received."""
        self.refusals: dict[str, list[str]] = {}
        """Every error that a node reported, by the node's name, since they were cleared."""
        self.alarms: dict[str, list[str]] = {}
        """Every sentence that came at level ERROR, by the node's name, since they were cleared."""
        self.time = 0.0
        """Simulated time, by the joints' stamps [s]."""
        self.counts: dict[str, int] = {}
        """How often each kind of violation was seen."""
        self.examples: dict[str, list[str]] = {}
        """Some violations of each kind."""
        self.context = ''
        """What goes on meanwhile: it is noted down with each violation."""

    def listen_to(self, nodes: Iterable[str]) -> None:
        """Subscribe to all that these nodes publish, as far as it is discovered by now."""
        for node in nodes:
            for topic in outputs_of(self._node, node):
                if topic.name not in self._subscribed and self._subscribe(topic):
                    self._subscribed.add(topic.name)

    def ignore(self, data: bytes) -> None:
        """Take a message, as it is sent, for one of the attack's own: it is not checked."""
        self._own.add(hash(data))

    def forget_robot(self) -> None:
        """Compare joints and trajectories with nothing for a while: the robot is put elsewhere."""
        self._trajectories.forget(self.time + _WHILE)
        self._joints.forget(self.time + _WHILE)

    def note(self, kind: str, what: str) -> None:
        """Note a violation down."""
        self.counts[kind] = self.counts.get(kind, 0) + 1
        examples = self.examples.setdefault(kind, [])
        # One that goes on is noted down once.
        is_new = (kind, what.split()[0], self.context) not in self._noted
        if is_new and len(examples) < _KEPT:
            self._noted.add((kind, what.split()[0], self.context))
            examples.append(f'{what} ({self.context})' if self.context else what)

    def _subscribe(self, topic: Interface) -> bool:
        """Subscribe to a topic; return whether its publisher is discovered."""
        offers = self._node.get_publishers_info_by_topic(topic.name)
        fitting = [o.qos_profile for o in offers if o.topic_type == topic.type_name]
        if not fitting:
            return False
        offered = fitting[0]
        qos = QoSProfile(
            depth=_DEPTH, reliability=offered.reliability, durability=offered.durability
        )
        callback = partial(self._on_bytes, topic)
        self._node.create_subscription(topic.type, topic.name, callback, qos, raw=True)
        return True

    def _on_bytes(self, topic: Interface, data: bytes) -> None:
        if hash(data) in self._own:
            return
        try:
            message = message_of(data, topic.type)
        except InvalidMessage as error:
            self.note(UNREADABLE, f'{topic}: {len(data)} bytes: {str(error.__cause__)[:200]}')
            return
        self.last[topic.name] = message
        for problem in numbers_not_finite(message):
            self.note(NOT_FINITE, f'{topic}: {problem}')
        for problem in texts_too_long(message):
            # The description of the robot is a whole file.
            if topic.name != '/robot_description':
                self.note(TOO_LONG, f'{topic}: {problem}')
        if topic.name == '/joint_trajectory':
            self._check_trajectory(message)
        elif topic.name == '/joint_states':
            self._check_joints(message)
        elif topic.type is DiagnosticArray:
            self._read_diagnostics(message)

    def _check_trajectory(self, message: Any) -> None:
        heartbeat = self.last.get('/gait/heartbeat')
        answered = -math.inf if heartbeat is None else seconds_from_time(heartbeat.stamp)
        earliest = max(answered, self.time - _LONGEST_DECISION)
        try:
            trajectory = trajectory_from_message(message)
            problems = self._trajectories.check(trajectory, self.time, earliest)
        except QuadError as error:
            problems = [str(error)]
        for problem in problems:
            self.note(OUTSIDE_LIMITS, problem)

    def _check_joints(self, message: Any) -> None:
        time = seconds_from_time(message.header.stamp)
        place = {name: index for index, name in enumerate(message.name)}
        if time < self.time:
            # A simulator begins at zero again.
            self.time = time
            self.forget_robot()
        self.time = time
        order = [place[name] for name in self._names]
        for problem in self._joints.check(time, np.array(message.position)[order]):
            self.note(JOINTS_OUTSIDE, problem)

    def _read_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            values = {pair.key: pair.value for pair in status.values}
            self.statuses[status.name] = (status.level, status.message, values)
            self.received_statuses += 1
            for key, value in values.items():
                if value in ('nan', 'inf', '-inf'):
                    self.note(NOT_FINITE, f'diagnostics of {status.name}: {key} is {value}')
            if status.level == DiagnosticStatus.ERROR:
                self.alarms.setdefault(status.name, []).append(status.message)
            if 'error' in values:
                self.refusals.setdefault(status.name, []).append(status.message)
