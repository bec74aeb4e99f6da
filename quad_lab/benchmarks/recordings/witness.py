"""
Listens beside a recording, in a process of its own, to every topic by itself.

A recording takes what is frequent in batches; the witness does not, and writes nothing: what both
have received on two ways is what was published.
"""

from __future__ import annotations

import hashlib
import multiprocessing
import time
from collections import defaultdict
from collections.abc import Callable
from multiprocessing.connection import Connection

import rclpy

from quad_lab.recordings.recorded_topics import RECORDED, RecordedTopic
from quad_lab.recordings.topic_listener import TopicListener
from quad_lab.tools.workers import end_with_parent

_LOOK = 0.02
"""Time between two looks for orders [s]."""

_PATIENCE = 60.0
"""For an answer [s]."""

_QUIET = 3
"""Looks without a new message after which nothing more is under way."""


def digest(data: bytes) -> bytes:
    """Return what stands for a message (CDR)."""
    return hashlib.blake2b(data, digest_size=8).digest()


class Witness:
    """The process; use it in a ``with`` block, in the ROS domain of what it listens to."""

    def __init__(self) -> None:
        # Spawned: a fork would inherit threads of ROS in the middle of what they do.
        context = multiprocessing.get_context('spawn')
        self._pipe, other = context.Pipe()
        self._process = context.Process(target=_listen, args=(other,), daemon=True)

    def __enter__(self) -> Witness:
        self._process.start()
        self._answer()
        return self

    def __exit__(self, *ending: object) -> None:
        self._process.terminate()
        self._process.join()

    def wait_for_silence(self, go_on: Callable[[], None]) -> None:
        """Call something that takes a moment until nothing more comes."""
        quiet, before = 0, -1
        deadline = time.monotonic() + _PATIENCE
        while quiet < _QUIET and time.monotonic() < deadline:
            go_on()
            self._pipe.send('count')
            now = self._answer()
            quiet, before = (quiet + 1 if now == before else 0), now  # type: ignore[assignment]

    def heard(self) -> dict[str, list[bytes]]:
        """Return digests of what was received until now, by names of topics."""
        self._pipe.send('heard')
        answer: dict[str, list[bytes]] = self._answer()  # type: ignore[assignment]
        return answer

    def _answer(self) -> object:
        if not self._pipe.poll(_PATIENCE):
            raise TimeoutError('the witness does not answer')
        return self._pipe.recv()


def _listen(pipe: Connection) -> None:
    end_with_parent()
    heard: dict[str, list[bytes]] = defaultdict(list)

    def take(topic: RecordedTopic, data: bytes) -> None:
        heard[topic.name].append(digest(data))

    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node('quadwalk_witness', context=context)
    # What is published for subscribers only would be published for this one.
    topics = [(topic, topic.name) for topic in RECORDED if not topic.is_on_demand]
    listener = TopicListener(node, topics, take)
    pipe.send('ready')
    while True:
        listener.listen(_LOOK)
        if pipe.poll():
            is_count = pipe.recv() == 'count'
            pipe.send(sum(map(len, heard.values())) if is_count else dict(heard))
