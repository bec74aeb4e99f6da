"""Messages of several topics are handed on in the order in which they came, and all of them."""

from __future__ import annotations

import time

import pytest

pytest.importorskip('rclpy')

import rclpy
from rclpy.serialization import deserialize_message
from std_msgs.msg import Float64

from quad_lab.recordings.recorded_topics import Delivery, RecordedTopic
from quad_lab.recordings.topic_listener import TopicListener
from quad_lab.topic_walk.node_processes import isolated_domain

pytestmark = pytest.mark.ros

TOPICS = [
    RecordedTopic('first', 'std_msgs/msg/Float64', Delivery.RELIABLE, 1000),
    RecordedTopic('second', 'std_msgs/msg/Float64', Delivery.RELIABLE, 1000),
    RecordedTopic('third', 'no_such_package/msg/Nothing', Delivery.RELIABLE),
]

LONGEST_WAIT = 30.0


def test_messages_come_in_their_order():
    got: list[tuple[str, float]] = []

    def take(topic: RecordedTopic, data: bytes) -> None:
        got.append((topic.name, deserialize_message(data, Float64).data))

    with isolated_domain():
        context = rclpy.Context()
        rclpy.init(context=context)
        node = rclpy.create_node('listener', context=context)
        talker = rclpy.create_node('talker', context=context)
        listener = TopicListener(node, [(topic, topic.name) for topic in TOPICS], take)
        publishers = [talker.create_publisher(Float64, t.name, 1000) for t in TOPICS[:2]]
        deadline = time.monotonic() + LONGEST_WAIT
        while not all(p.get_subscription_count() for p in publishers):
            assert time.monotonic() < deadline
            listener.listen(0.05)
        sent = []
        for number in range(300):
            # In turns of other lengths, so that no topic is always ahead.
            which = number // (1 + number % 3) % 2
            publishers[which].publish(Float64(data=float(number)))
            sent.append((TOPICS[which].name, float(number)))
            if number % 50 == 0:
                listener.take()
        while len(got) < len(sent):
            assert time.monotonic() < deadline
            listener.listen(0.05)
        talker.destroy_node()
        node.destroy_node()
        context.try_shutdown()
    assert sorted(got, key=lambda message: message[1]) == sent
    for name in ('first', 'second'):
        numbers = [number for topic, number in got if topic == name]
        assert numbers == sorted(numbers)
    # Two threads of the middleware receive two topics: neighbors may change places, no more.
    places = [number for _, number in got]
    assert max(abs(place - number) for place, number in enumerate(places)) < 20
