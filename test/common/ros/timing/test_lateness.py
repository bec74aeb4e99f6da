"""When a node is late, and what then counts of a stream."""

import pytest

pytest.importorskip('rclpy')

from rclpy.qos import QoSProfile, qos_profile_sensor_data

from quad_common.ros.guarded_node import is_stream
from quad_common.ros.timing.lateness import Lateness, StreamCallback


class Queue:
    """What a node is told, done when the test says so."""

    def __init__(self):
        self.now = 0.0
        self.waiting = []
        self.lateness = Lateness(lambda: self.now)

    def look(self, after):
        self.now += after
        self.lateness.look(self.waiting.append)

    def work_off(self):
        while self.waiting:
            self.waiting.pop(0)()


class Subscription:
    """A subscription with messages that wait, its own handle as well."""

    msg_type, raw = int, False

    def __init__(self, *waiting, depth=5):
        self.handle = self
        self.waiting = list(waiting)
        self.qos_profile = QoSProfile(depth=depth)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None

    def take_message(self, kind, raw):
        return (self.waiting.pop(0), None) if self.waiting else None


def received_of(subscription, lateness, message):
    received = []
    callback = StreamCallback(received.append, lateness)
    callback.subscription = subscription
    callback(message)
    return received


def test_a_node_that_does_at_once_what_it_is_told_is_never_late():
    queue = Queue()
    for _ in range(100):
        queue.look(after=0.03)
        queue.work_off()
        assert not queue.lateness.is_late


def test_a_node_is_late_while_what_waits_does_so_for_more_than_a_tenth_of_a_second():
    queue = Queue()
    queue.look(after=1.0)
    queue.look(after=0.09)
    assert not queue.lateness.is_late
    queue.look(after=0.02)
    assert queue.lateness.is_late
    queue.work_off()
    assert not queue.lateness.is_late


def test_only_one_thing_waits_at_a_time_and_it_is_asked_seldom():
    queue = Queue()
    for _ in range(1000):
        queue.look(after=0.001)
        assert len(queue.waiting) <= 1
    asked = 0
    for _ in range(1000):
        queue.look(after=0.001)
        asked += len(queue.waiting)
        queue.work_off()
    assert asked <= 21


@pytest.mark.parametrize('is_late', [False, True])
def test_of_a_stream_the_newest_message_counts_once_the_node_is_late_and_else_each(is_late):
    queue = Queue()
    queue.look(after=1.0)
    queue.now += 1.0 if is_late else 0.0
    subscription = Subscription(2, 3, 4)
    assert received_of(subscription, queue.lateness, 1) == ([4] if is_late else [1])
    assert subscription.waiting == ([] if is_late else [2, 3, 4])
    assert queue.lateness.left_out == (3 if is_late else 0)


def test_a_stream_that_never_ends_keeps_nobody_longer_than_its_queue_is_long():
    queue = Queue()
    queue.look(after=1.0)
    queue.now += 1.0
    subscription = Subscription(*range(100), depth=5)
    assert received_of(subscription, queue.lateness, -1) == [4]


def test_a_late_node_has_most_of_its_time_for_what_is_no_stream():
    queue = Queue()
    queue.look(after=1.0)
    queue.now += 1.0
    taken = []

    def take(message):
        taken.append(queue.now)
        queue.now += 0.01

    callback = StreamCallback(take, queue.lateness)
    for number in range(100):
        callback(number)
        queue.now += 0.001
    assert len(taken) == 2
    assert taken[1] - taken[0] > 0.08


def test_a_stream_that_raises_rests_too():
    queue = Queue()
    queue.look(after=1.0)
    queue.now += 1.0
    calls = []

    def fail(message):
        calls.append(message)
        queue.now += 0.01
        raise ValueError(message)

    callback = StreamCallback(fail, queue.lateness)
    with pytest.raises(ValueError):
        callback(1)
    callback(2)
    assert calls == [1]


def test_only_what_may_be_lost_is_a_stream():
    assert is_stream(qos_profile_sensor_data)
    assert not is_stream(QoSProfile(depth=10))
    assert not is_stream(10)
