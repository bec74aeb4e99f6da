"""
Records topics to an MCAP file that ``ros2 bag``, Foxglove and PlotJuggler read.
"""

from __future__ import annotations

import contextlib
import io
import json
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from quad_common.errors import FileUnusable, MissingOptionalDependency, QuadError
from quad_common.files.bounded_file import make_folder, reason_of
from quad_common.process.end_signals import shielded
from quad_lab.recordings.recorded_topics import Delivery, RecordedTopic

try:
    from rosbags.interfaces import (
        Qos,
        QosDurability,
        QosHistory,
        QosLiveliness,
        QosReliability,
        QosTime,
    )
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore
except ImportError:
    _CAN_RECORD = False
else:
    _CAN_RECORD = True


FACTS = 'quadwalk'
"""Key of what is kept beside the messages."""

_RESERVE_NAME = 'reserve'

_RESERVE = 2**21
"""Bytes that are held for a recording's last messages, its index and its metadata."""

_PARTS = ('metadata.yaml', 'metadata.yaml.tmp', '*.mcap', _RESERVE_NAME)
"""The files of a recording; one that was cut off by a kill has no metadata."""


@dataclass(eq=False, repr=False)
class NoPlaceForRecording(QuadError):
    """A recording cannot go where it is to go: something else is there."""

    folder: Path
    """Folder where it was to go."""
    other: Path
    """File or folder that is there."""

    def sentence(self) -> str:
        """Say what is in its place."""
        return (
            f'the recording cannot go to {self.folder}: {self.other} is no part of a recording, '
            'and is not removed; move it away, or choose another --output'
        )


@dataclass(eq=False, repr=False)
class RecordingNotWritten(QuadError):
    """A recording ended early: a message of it could not be written."""

    folder: Path
    """Folder of the recording."""
    reason: str
    """Reason, in the words of the system."""
    is_kept: bool
    """Whether it can be read, up to where it ended."""

    def sentence(self) -> str:
        """Say why, and what is left."""
        left = 'it can be read up to there' if self.is_kept else 'nothing of it is left'
        return f'the recording in {self.folder} ended, {left}: {self.reason}'


class Recording:
    """
    A recording; use it in a ``with`` block.

    It is complete whatever ends the block; nothing is left of one without messages. Where the disk
    is full, it is complete up to there: room for its last part is held from the beginning on.

    Parameters
    ----------
    folder : Path
        Where it goes; a recording that is there already is replaced, and so is what a
        kill has left of one.
    namespace : str
        Namespace of the robot; empty for none.

    Raises
    ------
    MissingOptionalDependency
        If the package rosbags is not installed.
    NoPlaceForRecording
        If the folder holds something else.
    FileUnusable
        If there is no room for it.
    """

    def __init__(self, folder: Path, namespace: str = '') -> None:
        if not _CAN_RECORD:
            raise MissingOptionalDependency('rosbags', 'pip install rosbags')
        _remove(folder)
        make_folder(folder.parent)
        self.folder = folder
        """Where it goes."""
        self.counts: dict[str, int] = {}
        """Number of messages by full names of topics."""
        self._namespace = namespace
        self._types = get_typestore(Stores.ROS2_JAZZY)
        self._writer: Any = Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP)
        self._connections: dict[str, Any] = {}
        self._reserve = folder / _RESERVE_NAME
        self._is_over = False

    def __enter__(self) -> Recording:
        with shielded():
            try:
                self._writer.open()
                self._reserve.write_bytes(bytes(_RESERVE))
            except OSError as error:
                self._discard()
                reason = f'cannot be written: {reason_of(error)}'
                raise FileUnusable('recording', self.folder, reason) from error
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with shielded():
            if self._is_over:
                return
            self._is_over = True
            self._reserve.unlink(missing_ok=True)
            if not self._connections:
                # Its duration would be less than nothing.
                self._discard()
                return
            self._whole = _Written.of(self._writer)
            try:
                self._writer.close()
            except OSError as problem:
                raise self._end_early(problem) from problem

    def write(self, topic: RecordedTopic, data: bytes, time: float) -> None:
        """
        Add a message.

        Parameters
        ----------
        topic : RecordedTopic
            Its topic.
        data : bytes
            The message as it was sent (CDR).
        time : float
            When it was received, by the clock that the robot goes by [s].

        Raises
        ------
        RecordingNotWritten
            If it cannot be written; the recording is over then, and takes nothing more.
        """
        if self._is_over:
            return
        # A message that is cut off makes the file unreadable.
        with shielded():
            self._whole = _Written.of(self._writer)
            try:
                self._add(topic, data, time)
            except OSError as error:
                raise self._end_early(error) from error

    def note(self, facts: Mapping[str, object]) -> None:
        """Keep facts beside the messages, as JSON holds them; later ones replace them."""
        if not self._is_over:
            with shielded():
                self._writer.set_custom_data(FACTS, json.dumps(dict(facts)))

    def _add(self, topic: RecordedTopic, data: bytes, time: float) -> None:
        name = topic.in_namespace(self._namespace)
        if name not in self._connections:
            self._connections[name] = self._writer.add_connection(
                name,
                topic.kind,
                typestore=self._types,
                offered_qos_profiles=[_quality_of_service(topic)],
            )
            self.counts[name] = 0
        self._writer.write(self._connections[name], round(time * 1e9), data)
        self.counts[name] += 1

    def _end_early(self, error: OSError) -> RecordingNotWritten:
        """End the recording where something could not be written; return what is to be said."""
        self._is_over = True
        is_kept = True
        try:
            self._reserve.unlink(missing_ok=True)
            self._whole.finish(self._writer)
        except (OSError, AssertionError):
            is_kept = False
            self._discard()
        return RecordingNotWritten(self.folder, reason_of(error), is_kept)

    def _discard(self) -> None:
        """Leave nothing of it."""
        with contextlib.suppress(OSError):
            self._writer.abort()
        with contextlib.suppress(OSError, NoPlaceForRecording):
            _remove(self.folder)


@dataclass(frozen=True)
class _Written:
    """How far a writer's file is whole."""

    size: int
    """Size of the file [bytes]."""
    chunks: int
    """Number of groups of messages in it."""

    @classmethod
    def of(cls, writer: Any) -> _Written:
        return cls(writer.storage.bio.tell(), len(writer.storage.chunks))

    def finish(self, writer: Any) -> None:
        """Cut the file off where it is whole, and close it: with what waits, or without."""
        try:
            self._cut_off(writer)
            writer.close()
        except OSError:
            self._cut_off(writer)
            waiting = writer.storage.chunk
            writer.storage.chunk = type(waiting)(2**63 - 1, 0, io.BytesIO(), defaultdict(list))
            writer.close()

    def _cut_off(self, writer: Any) -> None:
        file = writer.storage.bio
        file.seek(self.size)
        file.truncate()
        del writer.storage.chunks[self.chunks :]


def _quality_of_service(topic: RecordedTopic) -> Any:
    """Say how a topic is published, in the terms of recordings."""
    unlimited = QosTime(2147483647, 4294967295)
    is_latched = topic.delivery is Delivery.LATCHED
    is_sensor = topic.delivery is Delivery.SENSOR
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=topic.depth,
        reliability=QosReliability.BEST_EFFORT if is_sensor else QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if is_latched else QosDurability.VOLATILE,
        deadline=unlimited,
        lifespan=unlimited,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=unlimited,
        avoid_ros_namespace_conventions=False,
    )


def can_record() -> bool:
    """Return whether the package that writes recordings is installed."""
    return _CAN_RECORD


def _remove(folder: Path) -> None:
    """Remove a recording, whole or not, and nothing else."""
    if not folder.is_dir():
        if folder.exists() or folder.is_symlink():
            raise NoPlaceForRecording(folder, folder)
        return
    parts = {path for pattern in _PARTS for path in folder.glob(pattern)}
    for path in sorted(folder.iterdir()):
        if path not in parts or not path.is_file():
            raise NoPlaceForRecording(folder, path)
    for path in parts:
        path.unlink()
    folder.rmdir()
