"""Nodes of one process have met when each receives what the others publish."""

from __future__ import annotations

import contextlib
import itertools

import pytest

pytest.importorskip('nav_msgs')

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String

from quad_common.ros.run_node import make_executor
from quad_lab.topic_walk import composed_nodes
from quad_lab.topic_walk.composed_nodes import ComposedNodes
from quad_lab.topic_walk.node_processes import isolated_domain

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

MOST_BEATS = 200


class Observer:
    """What is told of a walk, as far as the nodes need it."""

    received = 0


def restless(node):
    """Give a node a timer that fails a test that waits until nothing is called any more."""
    beats = itertools.count()

    def beat():
        assert next(beats) < MOST_BEATS

    node.create_timer(0.1, beat)


@contextlib.contextmanager
def composed_with(*names):
    with isolated_domain(), ComposedNodes() as nodes:
        others = [rclpy.create_node(name) for name in names]
        for node in others:
            nodes.executor.add_node(node)
        try:
            yield nodes, *others
        finally:
            for node in others:
                node.destroy_node()


def test_they_meet_though_a_timer_never_rests():
    with composed_with('talker', 'listener') as (nodes, talker, listener):
        got = []
        latched = talker.create_publisher(String, 'latched', LATCHED)
        latched.publish(String(data='words'))
        listener.create_subscription(String, 'latched', lambda m: got.append(m.data), LATCHED)
        restless(talker)
        nodes.tell(Observer())
        assert got == ['words']
        assert latched.get_subscription_count() == 1


def test_those_that_do_not_fit_are_not_waited_for():
    with composed_with('talker', 'listener') as (nodes, talker, listener):
        publisher = talker.create_publisher(String, 'latched', QoSProfile(depth=1))
        listener.create_subscription(String, 'latched', lambda message: None, LATCHED)
        restless(talker)
        nodes.tell(Observer())
        assert publisher.get_subscription_count() == 0


@pytest.mark.parametrize('make', [make_executor, SingleThreadedExecutor])
def test_what_comes_behind_much_that_nobody_counts_is_waited_for(monkeypatch, make):
    monkeypatch.setattr(composed_nodes, 'make_executor', make)
    # As each clock does, by the timers that it sets: a simulation over MuJoCo ran ahead of its
    # camera and of all who listened to odometry.
    with composed_with('talker', 'listener') as (nodes, talker, listener):
        observer = Observer()

        def count(_):
            observer.received += 1

        topics = [f'uncounted_{k}' for k in range(8)]
        publishers = [talker.create_publisher(String, topic, 10) for topic in (*topics, 'counted')]
        for topic in topics:
            listener.create_subscription(String, topic, lambda message: None, 10)
        listener.create_subscription(String, 'counted', count, 10)
        nodes.tell(observer)
        for k in range(20):
            for publisher in publishers:
                publisher.publish(String(data='words'))
            nodes._drain()
            assert observer.received == k + 1
