"""
Records topics to an MCAP file that ``ros2 bag``, Foxglove and PlotJuggler read.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from quad_common.errors import MissingOptionalDependency, QuadError
from quad_common.process.end_signals import shielded

try:
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore
except ImportError:
    _CAN_RECORD = False
else:
    _CAN_RECORD = True


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

    Raises
    ------
    MissingOptionalDependency
        If the package rosbags is not installed.
    NoPlaceForRecording
        If the folder holds something else.
    """

    def __init__(self, folder: Path) -> None:
        if not _CAN_RECORD:
            raise MissingOptionalDependency('rosbags', 'pip install rosbags')
        _remove(folder)
        folder.parent.mkdir(parents=True, exist_ok=True)
        self.folder = folder
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

    def write(self, topic: str, message_type: type, data: bytes) -> None:
        """
        Add a message, stamped with the wall clock as ``ros2 bag record`` does.

        Parameters
        ----------
        topic : str
            Its topic, relative to the root namespace.
        message_type : type
            Its class.
        data : bytes
            The message as it was sent (CDR).
        """
        # A message that is cut off makes the file unreadable.
        with shielded():
            if topic not in self._connections:
                package = message_type.__module__.split('.')[0]
                name = f'{package}/msg/{message_type.__name__}'
                self._connections[topic] = self._writer.add_connection(
                    f'/{topic}', name, typestore=self._types
                )
            self._writer.write(self._connections[topic], time.time_ns(), data)


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
