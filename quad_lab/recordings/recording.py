"""
Records topics to an MCAP file that ``ros2 bag``, Foxglove and PlotJuggler read.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from quad_common.errors import MissingOptionalDependency, QuadError
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

_PARTS = ('metadata.yaml', '*.mcap')
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


class Recording:
    """
    A recording; use it in a ``with`` block.

    It is complete whatever ends the block; nothing is left of one without messages.

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
    """

    def __init__(self, folder: Path, namespace: str = '') -> None:
        if not _CAN_RECORD:
            raise MissingOptionalDependency('rosbags', 'pip install rosbags')
        _remove(folder)
        folder.parent.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        """Where it goes."""
        self.counts: dict[str, int] = {}
        """Number of messages by full names of topics."""
        self._namespace = namespace
        self._types = get_typestore(Stores.ROS2_JAZZY)
        self._writer: Any = Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP)
        self._connections: dict[str, Any] = {}

    def __enter__(self) -> Recording:
        with shielded():
            self._writer.open()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with shielded():
            self._writer.close()
            if not self._connections:
                # Its duration would be less than nothing.
                _remove(self.folder)

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
        """
        name = topic.in_namespace(self._namespace)
        # A message that is cut off makes the file unreadable.
        with shielded():
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

    def note(self, facts: Mapping[str, object]) -> None:
        """Keep facts beside the messages, as JSON holds them; later ones replace them."""
        with shielded():
            self._writer.set_custom_data(FACTS, json.dumps(dict(facts)))


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
