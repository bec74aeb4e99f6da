"""A node that is told more than it can do still does what must not wait."""

from __future__ import annotations

import time

import pytest

pytest.importorskip('rclpy')

import rclpy
from nav_msgs.msg import Odometry
from rclpy.qos import qos_profile_sensor_data
from std_srvs.srv import SetBool

from quad_common.ros.guarded_node import GuardedNode
from quad_common.ros.run_node import make_executor

pytestmark = pytest.mark.ros

_WORK = 0.01
"""Time that the node takes for a reading [s]."""

_BEFORE = 60
"""Readings that come before the request."""


class SlowNode(GuardedNode):
    """Takes longer for a reading than it is until the next one."""

    def __init__(self, context):
        super().__init__('slow', context=context)
        self.seen = []
        self.is_stopped = False
        self.create_subscription(Odometry, 'odom', self._on_odometry, qos_profile_sensor_data)
        self.create_service(SetBool, 'emergency_stop', self._on_stop)

    def _on_odometry(self, message):
        self.seen.append(message.header.stamp.sec)
        time.sleep(_WORK)

    def _on_stop(self, _, response):
        self.is_stopped = True
        return response


@pytest.fixture
def context(domain):
    context = rclpy.Context()
    rclpy.init(context=context)
    yield context
    context.try_shutdown()


def test_an_emergency_stop_does_not_wait_behind_every_reading_that_came_before_it(context):
    node, outside = SlowNode(context), rclpy.create_node('outside', context=context)
    executor = make_executor(context)
    executor.add_node(node)
    publisher = outside.create_publisher(Odometry, 'odom', qos_profile_sensor_data)
    client = outside.create_client(SetBool, 'emergency_stop')
    sent = 0

    def publish():
        nonlocal sent
        sent += 1
        message = Odometry()
        message.header.stamp.sec = sent
        publisher.publish(message)

    end = time.monotonic() + 10.0
    while not (client.service_is_ready() and node.seen):
        assert time.monotonic() < end
        publish()
        node.turn(executor)
    node.seen.clear()
    for _ in range(_BEFORE):
        publish()
        time.sleep(0.001)
    client.call_async(SetBool.Request(data=True))
    # Whatever it does meanwhile, new readings come.
    while not node.is_stopped and len(node.seen) < 2 * _BEFORE:
        publish()
        node.turn(executor)
    assert node.is_stopped
    assert len(node.seen) < _BEFORE // 2, 'readings were worked off before the request'
    # What it knows from then on is new, and in order.
    known, first = len(node.seen), sent
    while len(node.seen) == known:
        publish()
        node.turn(executor)
    assert node.seen[-1] > first - qos_profile_sensor_data.depth
    assert node.seen == sorted(node.seen)
    executor.shutdown()
    node.destroy_node()
    outside.destroy_node()
