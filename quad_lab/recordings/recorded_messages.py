"""
A recording in the place of a robot: hands on what was received up to any time.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from quad_common.errors import QuadError
from quad_lab.recordings.recording_reader import open_recording
from quad_lab.recordings.subscription import message_of

_STEP = 0.2
"""Time in which of what comes often one message is handed on, where much time passes [s]."""


class RecordedMessages:
    """
    The messages of one robot in memory, by topics.

    Parameters
    ----------
    folder : Path
        A recording, of ``quadwalk`` or of ``ros2 bag``.
    namespace : str
        Namespace of the robot; empty for none.

    Raises
    ------
    RecordingUnusable
        If it cannot be read, or holds nothing of that robot.
    """

    def __init__(self, folder: Path, namespace: str = '') -> None:
        self._times: dict[str, list[float]] = {}
        self._data: dict[str, list[bytes]] = {}
        with open_recording(folder, namespace) as messages:
            for topic, time, data in messages:
                self._times.setdefault(topic, []).append(time)
                self._data.setdefault(topic, []).append(data)
        self.start = min(times[0] for times in self._times.values())
        """Time of the first message [s]."""
        self.end = max(times[-1] for times in self._times.values())
        """Time of the last one [s]."""
        self.time = self.start
        """Time up to which messages were handed on [s]."""
        self._taken: list[_Topic] = []

    @property
    def topics(self) -> frozenset[str]:
        """Names of the topics, relative to the robot's namespace."""
        return frozenset(self._times)

    def all_of(self, topic: str, callback: Callable[[Any], None], kind: Any) -> None:
        """Have every message of a topic handed on."""
        self._subscribe(topic, callback, kind, is_sampled=False)

    def newest_of(self, topic: str, callback: Callable[[Any], None], kind: Any) -> None:
        """Have the newest message of a topic handed on at each step."""
        self._subscribe(topic, callback, kind, is_sampled=True)

    def first(self, topic: str, kind: Any) -> Any:
        """Return the first message of a topic, of a kind; None if there is none."""
        data = self._data.get(topic)
        return message_of(data[0], kind) if data else None

    def rewind(self) -> None:
        """Begin anew: nothing has been handed on."""
        self.time = self.start
        for topic in self._taken:
            topic.next = 0

    def go_on_to(self, time: float) -> list[QuadError]:
        """
        Hand on what came up to a time.

        Parameters
        ----------
        time : float
            Not before :attr:`time` [s].

        Returns
        -------
        list of QuadError
            Why messages could not be used.
        """
        problems: list[QuadError] = []
        while (following := min(self._following(), default=math.inf)) <= time:
            # Of years without a message nothing is to be handed on.
            self.time = min(max(self.time + _STEP, following), time)
            for topic in self._taken:
                problems += topic.hand_on(self.time)
        self.time = max(self.time, time)
        return problems

    def _following(self) -> Iterator[float]:
        """Return when the next message of each topic came up [s]."""
        return (topic.following for topic in self._taken if topic.following is not None)

    def _subscribe(
        self, topic: str, callback: Callable[[Any], None], kind: Any, is_sampled: bool
    ) -> None:
        if topic in self._times:
            taken = _Topic(self._times[topic], self._data[topic], callback, kind, is_sampled)
            self._taken.append(taken)


class _Topic:
    """Messages of one topic, and who takes them."""

    def __init__(
        self,
        times: list[float],
        data: list[bytes],
        callback: Callable[[Any], None],
        kind: Any,
        is_sampled: bool,
    ) -> None:
        self._times, self._data = times, data
        self._callback, self._kind = callback, kind
        self._is_sampled = is_sampled
        self.next = 0

    @property
    def following(self) -> float | None:
        """Time of the message that is handed on next [s]; None after the last one."""
        return self._times[self.next] if self.next < len(self._times) else None

    def hand_on(self, time: float) -> list[QuadError]:
        """Hand on what came up to a time [s]; return why messages could not be used."""
        end = bisect_right(self._times, time)
        first = max(self.next, end - 1) if self._is_sampled else self.next
        self.next = max(self.next, end)
        problems = []
        for index in range(first, end):
            try:
                self._callback(message_of(self._data[index], self._kind))
            except QuadError as error:
                problems.append(error)
        return problems
