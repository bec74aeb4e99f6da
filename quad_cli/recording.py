"""
Records topics to an MCAP file that ``ros2 bag``, Foxglove and PlotJuggler read.
"""

from __future__ import annotations

import shutil
import time
from pathlib import Path
from types import TracebackType
from typing import Any

from quad_common.errors import MissingOptionalDependency

try:
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore
except ImportError:
    _CAN_RECORD = False
else:
    _CAN_RECORD = True


class Recording:
    """
    A recording; use it in a ``with`` block.

    Parameters
    ----------
    folder : Path
        Where it goes; a recording that is there already is replaced.

    Raises
    ------
    MissingOptionalDependency
        If the package rosbags is not installed.
    """

    def __init__(self, folder: Path) -> None:
        if not _CAN_RECORD:
            raise MissingOptionalDependency('rosbags', 'pip install rosbags')
        if (folder / 'metadata.yaml').is_file():
            shutil.rmtree(folder)
        folder.parent.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self._types = get_typestore(Stores.ROS2_JAZZY)
        self._writer: Any = Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP)
        self._connections: dict[str, Any] = {}

    def __enter__(self) -> Recording:
        self._writer.open()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._writer.close()

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
