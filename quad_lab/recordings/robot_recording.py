"""
A recording of one robot: every message at the robot's time, and transforms of all its links.
"""

from __future__ import annotations

import contextlib
import struct
import time
from collections import deque
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType

from quad_common.errors import InvalidMessage, QuadError
from quad_lab.recordings.recorded_time import RecordedTime
from quad_lab.recordings.recorded_topics import (
    CLOCK,
    CORRECTIONS,
    DESCRIPTION,
    FIXED_TRANSFORMS,
    JOINT_STATES,
    ODOMETRY,
    SHARED_FIXED_TRANSFORMS,
    SHARED_TRANSFORMS,
    TRANSFORMS,
    RecordedTopic,
)
from quad_lab.recordings.recording import Recording
from quad_lab.recordings.robot_transforms import Made, Others, RobotTransforms
from quad_lab.recordings.shared_transforms import with_prefix

_CLOCK = struct.Struct('<iI')
"""Seconds and nanoseconds of a Clock, after the four bytes that say how numbers are written."""


MOST_KEPT = 2**26
"""Bytes of messages that are kept in memory where writing them must wait."""

_SHARED = (SHARED_TRANSFORMS, SHARED_FIXED_TRANSFORMS)

_MOST_EARLY = 100
"""Messages of fixed transforms that wait until the names of the robot's frames are known."""

_ALL_OTHERS = Others()

_Taken = tuple[RecordedTopic, bytes, float]
"""Topic, message (CDR), and when it was taken by the machine's clock [s]."""


class RobotRecording:
    """
    Takes a robot's messages as they come; use it in a ``with`` block.

    Where nobody publishes them, transforms of the links are added, so that RViz and Foxglove
    show the robot with nothing but the recording.

    Parameters
    ----------
    folder : Path
        Where it goes; see :class:`Recording`.
    namespace : str
        Namespace of the robot; empty for none.
    is_simulated : bool
        Whether the robot goes by ``/clock``: messages are recorded at that time then, as their
        stamps have it, and at the machine's time otherwise.
    others : Others
        What others publish.
    most_kept : int
        Bytes of messages that are kept in memory until the end. To write a message takes ten times
        as long as to keep it, and nodes beside it that go as fast as they can need the processor.
    """

    def __init__(
        self,
        folder: Path,
        namespace: str = '',
        is_simulated: bool = True,
        others: Others = _ALL_OTHERS,
        most_kept: int = 0,
    ) -> None:
        self._recording = Recording(folder, namespace)
        self._is_simulated = is_simulated
        self._time = RecordedTime(is_confirmed=is_simulated)
        self._waiting: list[_Taken] = []
        self._kept: deque[_Taken] = deque()
        self._kept_bytes, self._most_kept = 0, most_kept
        self._transforms = RobotTransforms(others)
        self._early: list[bytes] = []
        self._first_odometry: tuple[bytes, float] | None = None
        self._is_corrected = False

    @property
    def folder(self) -> Path:
        """Where it goes."""
        return self._recording.folder

    @property
    def counts(self) -> Mapping[str, int]:
        """Number of messages by full names of topics."""
        return self._recording.counts

    @property
    def remarks(self) -> Sequence[QuadError]:
        """What was odd about the clock, in the order of time."""
        return self._time.remarks

    def __enter__(self) -> RobotRecording:
        self._recording.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._write_kept(0)
        for taken in self._waiting:
            self._write(*taken)
        if self._first_odometry is not None and not self._is_corrected:
            odometry, received = self._first_odometry
            with contextlib.suppress(InvalidMessage):
                self._write_transforms(self._transforms.of_map(odometry), received)
        self._recording.__exit__(kind, error, trace)

    def take(self, topic: RecordedTopic, data: bytes) -> None:
        """Record a message (CDR)."""
        self._kept.append((topic, data, time.time()))
        self._kept_bytes += len(data)
        self._write_kept(self._most_kept)

    def _write_kept(self, most: int) -> None:
        """Write the oldest messages until no more than some bytes are kept."""
        while self._kept and (self._kept_bytes > most or most == 0):
            taken = self._kept.popleft()
            self._kept_bytes -= len(taken[1])
            self._time_and_write(taken)

    def _time_and_write(self, taken: _Taken) -> None:
        """Write a message once the robot's time is known."""
        topic, data, _ = taken
        if topic is CLOCK and self._is_simulated and len(data) >= 4 + _CLOCK.size:
            seconds, nanoseconds = _CLOCK.unpack_from(data, 4)
            # What no stamp can be is no time.
            if seconds >= 0 and nanoseconds < 10**9:
                self._time.follow(seconds + 1e-9 * nanoseconds)
        if self._is_simulated and not self._time.is_known:
            # What is latched comes before the clock does.
            self._waiting.append(taken)
            return
        waiting, self._waiting = self._waiting, []
        for earlier in (*waiting, taken):
            self._write(*earlier)

    def _write(self, topic: RecordedTopic, data: bytes, received: float) -> None:
        if not self._is_simulated:
            self._time.follow(received)
        # Readers sort by time: what came after something else is to stay behind it.
        now = self._time.next()
        if topic in _SHARED:
            self._write_shared(topic, data, now)
        else:
            self._recording.write(topic, data, now)
            self._add_transforms(topic, data, now)

    def _write_shared(self, topic: RecordedTopic, data: bytes, now: float) -> None:
        """Record, of the transforms of many robots, those of this one."""
        prefix = self._transforms.prefix
        if prefix is None:
            if topic is SHARED_FIXED_TRANSFORMS and len(self._early) < _MOST_EARLY:
                self._early.append(data)
            return
        with contextlib.suppress(InvalidMessage):
            # Frames without a prefix are any robot's.
            own = with_prefix(data, prefix) if prefix else None
            if own is not None:
                self._transforms.of_others(own)
                self._recording.write(topic, own, now)

    def note(self, facts: Mapping[str, object]) -> None:
        """Keep facts beside the messages; see :meth:`Recording.note`."""
        self._recording.note(facts)

    def _add_transforms(self, topic: RecordedTopic, data: bytes, now: float) -> None:
        """Record what follows from a message for those who draw the robot."""
        self._is_corrected |= topic is CORRECTIONS
        # What is no message, or no URDF, is recorded as it is: whoever plays it will say so.
        with contextlib.suppress(InvalidMessage):
            if topic is ODOMETRY:
                self._first_odometry = self._first_odometry or (data, now)
                self._write_transforms(self._transforms.of_odometry(data), now)
                self._write_early(now)
            elif topic is JOINT_STATES:
                self._write_transforms(self._transforms.of_joints(data), now)
            elif topic is DESCRIPTION:
                self._write_transforms(self._transforms.of_description(data), now)
            elif topic in (TRANSFORMS, FIXED_TRANSFORMS):
                self._transforms.of_others(data)

    def _write_early(self, now: float) -> None:
        """Record the fixed transforms that came before the names of the robot's frames did."""
        if self._early and self._transforms.prefix is not None:
            early, self._early = self._early, []
            for data in early:
                self._write_shared(SHARED_FIXED_TRANSFORMS, data, now)

    def _write_transforms(self, made: list[Made], now: float) -> None:
        for topic, data in made:
            self._recording.write(topic, data, now)
