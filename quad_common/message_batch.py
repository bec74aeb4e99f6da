"""
Messages of several topics in one: what is published often reaches who keeps all of it in batches.

To send a message, and to wake up for it, costs more than what is in it. Whoever needs messages at
once subscribes to their topics; a recorder has time.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

from quad_common.errors import InvalidMessage

_CLOSED = struct.Struct('<q')
"""When the batch was closed [ns]; it comes first."""

_RECORD = struct.Struct('<HIq')
"""Index of the topic, number of bytes, and when it was published [ns]."""

_MOST_BYTES = 56_000
"""Bytes of a batch: one datagram of UDP holds it, and it is never taken apart."""

_PERIOD = 20_000_000
"""Time that a message waits for others at most [ns]."""


@dataclass(frozen=True)
class BatchedMessage:
    """A message that came in a batch."""

    topic: str
    """Full name of its topic."""
    age: int
    """Time from its publication to the end of its batch [ns]."""
    data: bytes
    """The message (CDR)."""


class MessageBatch:
    """
    Messages that wait to be sent together.

    Parameters
    ----------
    topics : tuple of str
        Full names of the topics, which messages refer to by their index.
    """

    def __init__(self, topics: tuple[str, ...]) -> None:
        self.topics = topics
        """Full names of the topics."""
        self._parts: list[bytes] = []
        self._size = 0
        self._since = 0

    def add(self, topic: int, data: bytes, now: int) -> None:
        """Add a message (CDR) of a topic, by its index, that was published at a time [ns]."""
        if not self._parts:
            self._since = now
        self._parts += (_RECORD.pack(topic, len(data), now), data)
        self._size += _RECORD.size + len(data)

    def is_due(self, now: int) -> bool:
        """Return whether it is to be sent at a time [ns]: it is large, or has waited."""
        return bool(self._parts) and (
            self._size > _MOST_BYTES or not 0 <= now - self._since < _PERIOD
        )

    def close(self, now: int) -> bytes:
        """Return what is sent at a time [ns], and begin the next batch."""
        parts, self._parts, self._size = self._parts, [], 0
        return _CLOSED.pack(now) + b''.join(parts)


def read_batch(topics: tuple[str, ...], data: bytes) -> Iterator[BatchedMessage]:
    """
    Take a batch apart.

    Parameters
    ----------
    topics : tuple of str
        Full names of its topics.
    data : bytes
        What :meth:`MessageBatch.close` has made.

    Yields
    ------
    BatchedMessage
        In the order in which they were published.

    Raises
    ------
    InvalidMessage
        If it is cut off, or of a topic that it does not name.
    """
    try:
        (closed,) = _CLOSED.unpack_from(data)
        place = _CLOSED.size
        while place < len(data):
            topic, length, published = _RECORD.unpack_from(data, place)
            place += _RECORD.size
            if place + length > len(data):
                raise InvalidMessage('batch', f'{length} bytes are announced, and it ends before')
            yield BatchedMessage(topics[topic], closed - published, data[place : place + length])
            place += length
    except struct.error as error:
        raise InvalidMessage('batch', 'it ends within the head of a message') from error
    except IndexError as error:
        raise InvalidMessage('batch', f'it names {len(topics)} topics, and not all') from error
