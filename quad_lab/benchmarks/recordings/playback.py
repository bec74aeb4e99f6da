"""
Plays a recording as it says that it was published, to subscriptions like those of the nodes.
"""

from __future__ import annotations

import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import rclpy
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rosbags.rosbag2 import Reader

from quad_lab.recordings.recorded_topics import RECORDED, Delivery, RecordedTopic
from quad_lab.recordings.topic_listener import TopicListener

_CHUNK = 20
"""Messages that are sent at once: more would not fit into the buffers of what may be lost."""

_PATIENCE = 10.0
"""For subscriptions to be found [s]."""

_WAIT = 2.0
"""For what was sent to arrive [s]."""

Messages = Sequence[tuple[str, int, bytes]]
"""Topic, time [ns] and message (CDR)."""


@dataclass(frozen=True)
class Played:
    """What became of a topic."""

    sent: int
    """Number of its messages."""
    arrived: bool
    """Whether all of them arrived, as they were, in their order."""
    arrived_late: bool
    """Whether whoever subscribed at the end got what is kept for such; true if nothing is."""


def play(folder: Path) -> tuple[dict[str, Played], list[str]]:
    """
    Play a recording of a robot without a namespace.

    Parameters
    ----------
    folder : Path
        The recording.

    Returns
    -------
    tuple
        What became of each topic, by its name; and topics whose types are not installed.
    """
    named = {topic.in_namespace(''): topic for topic in RECORDED}
    reader: Any
    with Reader(folder) as reader:
        # Whoever recorded more than the table has would be told of it here.
        topics = {c.topic: named[c.topic] for c in reader.connections}
        qualities = {c.topic: _profile(c.ext.offered_qos_profiles[0]) for c in reader.connections}
        messages = [(c.topic, time, bytes(data)) for c, time, data in reader.messages()]
    untyped = sorted(name for name, topic in topics.items() if topic.message_type() is None)
    topics = {name: topic for name, topic in topics.items() if name not in untyped}
    sent = {name: [data for topic, _, data in messages if topic == name] for name in topics}
    latched = {n: t for n, t in topics.items() if t.delivery is Delivery.LATCHED}
    kept = {name: sent[name][-qualities[name].depth :] for name in latched}
    with _node('quadwalk_player') as player, _Ear('quadwalk_ear', topics) as ear:
        publishers = {
            name: player.create_publisher(topic.message_type(), name, qualities[name])
            for name, topic in topics.items()
        }
        _until(lambda: all(p.get_subscription_count() for p in publishers.values()), ear, _PATIENCE)
        _send([one for one in messages if one[0] in topics], publishers, topics, ear)
        with _Ear('quadwalk_late_ear', latched) as late:
            _until(lambda: late.heard == kept, late, _PATIENCE)
    played = {
        name: Played(
            len(sent[name]), ear.heard[name] == sent[name], late.heard[name] == kept.get(name, [])
        )
        for name in topics
    }
    return played, untyped


def _send(
    messages: Messages,
    publishers: Mapping[str, Any],
    topics: Mapping[str, RecordedTopic],
    ear: _Ear,
) -> None:
    """Send all messages, a few at a time; what does not arrive in time is lost, and not awaited."""
    lost = 0
    waiting: Counter[str] = Counter()
    for number, (name, _, data) in enumerate(messages, 1):
        publishers[name].publish(data)
        waiting[name] += 1
        # A subscription keeps no more of a topic than this, until they are taken.
        is_full = waiting[name] == _room(topics[name])
        if is_full or waiting.total() == _CHUNK or number == len(messages):
            awaited = number - lost
            _until(partial(ear.has_heard, awaited), ear, _WAIT)
            lost = number - ear.count
            waiting.clear()


def _room(topic: RecordedTopic) -> int:
    """Return how many messages of a topic wait for whoever subscribes to it."""
    return 1 if topic.delivery is Delivery.LATCHED else topic.depth


class _Ear:
    """Subscriptions, and what came."""

    def __init__(self, name: str, topics: Mapping[str, RecordedTopic]) -> None:
        self._node = _node(name)
        self._topics = topics
        self.heard: dict[str, list[bytes]] = defaultdict(list)
        """Messages by names of topics."""
        self.count = 0
        """Number of messages."""

    def has_heard(self, count: int) -> bool:
        """Return whether so many messages have come."""
        return self.count >= count

    def __enter__(self) -> _Ear:
        names = [(topic, name) for name, topic in self._topics.items()]
        self.listener = TopicListener(self._node.__enter__(), names, self._take)
        return self

    def __exit__(self, *ending: Any) -> None:
        self._node.__exit__(*ending)

    def _take(self, topic: RecordedTopic, data: bytes) -> None:
        self.heard[topic.in_namespace('')].append(data)
        self.count += 1


def _until(is_so: Callable[[], bool], ear: _Ear, patience: float) -> None:
    """Take messages until something is so, or for some time [s]."""
    deadline = time.monotonic() + patience
    ear.listener.take(is_last=True)
    while not is_so() and time.monotonic() < deadline:
        time.sleep(0.001)
        ear.listener.take(is_last=True)


@contextmanager
def _node(name: str) -> Iterator[Any]:
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node(name, context=context, start_parameter_services=False)
    try:
        yield node
    finally:
        node.destroy_node()
        context.try_shutdown()


def _profile(offered: Any) -> QoSProfile:
    """Read how a topic is to be published."""
    return QoSProfile(
        history=HistoryPolicy[offered.history.name],
        depth=offered.depth,
        reliability=ReliabilityPolicy[offered.reliability.name],
        durability=DurabilityPolicy[offered.durability.name],
    )
