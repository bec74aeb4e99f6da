"""Messages of several topics are handed on in the order in which they came, and all of them."""

from __future__ import annotations

import contextlib
import time

import pytest

pytest.importorskip('rclpy')

import rclpy
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import Float64, MultiArrayDimension, MultiArrayLayout, UInt8MultiArray

from quad_common.message_batch import MessageBatch
from quad_lab.recordings.recorded_topics import Delivery, RecordedTopic
from quad_lab.recordings.topic_listener import TopicListener
from quad_lab.topic_walk.node_processes import isolated_domain
from quad_sim.batch_topics import BatchTopics

pytestmark = pytest.mark.ros

TOPICS = [
    RecordedTopic('first', 'std_msgs/msg/Float64', Delivery.RELIABLE, 1000),
    RecordedTopic('second', 'std_msgs/msg/Float64', Delivery.RELIABLE, 1000),
    RecordedTopic('third', 'no_such_package/msg/Nothing', Delivery.RELIABLE),
]

LONGEST_WAIT = 30.0


class BatchSource:
    """A node that publishes one topic alone, and another one in batches, too."""

    def __init__(self, context):
        self.node = rclpy.create_node('source', context=context)
        self.alone = self.node.create_publisher(Float64, 'first', 1000)
        self.batched = self.node.create_publisher(Float64, 'second', 1000)
        self.batches = BatchTopics(self.node, self.batched)

    def wait_for_a_listener(self):
        deadline = time.monotonic() + LONGEST_WAIT
        while not (self.batches.is_wanted and self.alone.get_subscription_count()):
            assert time.monotonic() < deadline
            time.sleep(0.01)
            self.batches.send()


@contextlib.contextmanager
def source_and_listener(take):
    with isolated_domain():
        context = rclpy.Context()
        rclpy.init(context=context)
        source = BatchSource(context)
        node = rclpy.create_node('listener', namespace='', context=context)
        listener = TopicListener(node, [(TOPICS[0], 'first')], take)
        listener.take_batches('batches', [(TOPICS[1], 'second')])
        try:
            source.wait_for_a_listener()
            yield source, listener
        finally:
            source.node.destroy_node()
            node.destroy_node()
            context.try_shutdown()


def test_batched_messages_are_all_there_and_stand_where_they_were_published():
    got: list[float] = []

    def take(topic: RecordedTopic, data: bytes) -> None:
        number = deserialize_message(data, Float64).data
        assert topic is TOPICS[int(number) // 5 % 2]
        got.append(number)

    with source_and_listener(take) as (source, listener):
        for number in range(200):
            message = Float64(data=float(number))
            if number // 5 % 2:
                source.batches.publish(source.batched, message)
            else:
                source.alone.publish(message)
            source.batches.send()
            listener.take()
            # Longer than a message is on its way, shorter than a batch waits.
            time.sleep(0.003)
        deadline = time.monotonic() + LONGEST_WAIT
        while len(got) < 200:
            assert time.monotonic() < deadline
            source.batches.send()
            listener.listen(0.05)
    assert sorted(got) == [float(number) for number in range(200)]
    assert [n for n in got if n // 5 % 2] == sorted(n for n in got if n // 5 % 2)
    # A busy machine may bring one that is sent alone later than one of a batch.
    assert max(abs(place - number) for place, number in enumerate(got)) < 20


def test_a_message_that_waits_for_a_batch_is_not_lost_at_the_end():
    got: list[str] = []
    with source_and_listener(lambda topic, data: got.append(topic.name)) as (source, listener):
        source.alone.publish(Float64())
        deadline = time.monotonic() + LONGEST_WAIT
        while not (got or listener.waiting):
            assert time.monotonic() < deadline
            listener.take()
        listener.take(is_last=True)
    assert got == ['first']


def test_a_batch_that_is_damaged_ends_nothing():
    got: list[bytes] = []
    with source_and_listener(lambda topic, data: got.append(data)) as (source, listener):
        raw = source.node.create_publisher(UInt8MultiArray, 'batches', 10)
        deadline = time.monotonic() + LONGEST_WAIT
        while not raw.get_subscription_count():
            assert time.monotonic() < deadline
            time.sleep(0.01)
        raw.publish(UInt8MultiArray(data=bytes(11)))
        while not got:
            assert time.monotonic() < deadline
            source.batches.publish(source.batched, Float64())
            source.batches.send()
            listener.listen(0.05)
    assert set(got) == {serialize_message(Float64())}


def test_a_batch_that_is_long_on_its_way_stays_before_the_next_one():
    got: list[float] = []
    seconds = 1_000_000_000
    with source_and_listener(
        lambda topic, data: got.append(deserialize_message(data, Float64).data)
    ) as (source, listener):
        raw = source.node.create_publisher(UInt8MultiArray, 'batches', 10)
        deadline = time.monotonic() + LONGEST_WAIT
        while raw.get_subscription_count() < 1:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        # The second batch tells of what was published 5 to 8 s before it was closed.
        for first, closed in ((0, 4), (4, 16)):
            batch = MessageBatch((source.batched.topic_name,))
            for number in range(first, first + 4):
                batch.add(0, serialize_message(Float64(data=float(number))), number * seconds)
            layout = MultiArrayLayout(dim=[MultiArrayDimension(label=batch.topics[0])])
            raw.publish(UInt8MultiArray(layout=layout, data=batch.close(closed * seconds)))
        while len(got) < 8:
            assert time.monotonic() < deadline
            listener.listen(0.02)
    assert got == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]


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
