"""
Reads recordings, of quadwalk or of ``ros2 bag``.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from quad_common.errors import MissingOptionalDependency, QuadError
from quad_common.errors.quoting import clipped
from quad_common.files.bounded_file import is_file
from quad_common.files.yaml_document import read_yaml
from quad_lab.recordings.recorded_topics import CLOCK, RECORDED
from quad_lab.recordings.recording import FACTS

try:
    from rosbags.rosbag2 import Reader, ReaderError
except ImportError as error:
    raise MissingOptionalDependency('rosbags', 'pip install rosbags') from error

_METADATA = 'metadata.yaml'

Message = tuple[str, float, bytes]
"""Name of the topic, time [s] and message (CDR)."""


@dataclass(eq=False, repr=False)
class RecordingUnusable(QuadError):
    """A recording cannot be read, or does not hold what is wanted of it."""

    folder: Path
    """Folder of the recording."""
    reason: str
    """What is wrong with it."""

    def sentence(self) -> str:
        """Say what is wrong."""
        return f'{clipped(str(self.folder))}: {self.reason}'


@contextmanager
def open_recording(folder: Path, namespace: str = '') -> Iterator[Iterator[Message]]:
    """
    Open a recording for a ``with`` block.

    Parameters
    ----------
    folder : Path
        Folder of the recording.
    namespace : str
        Namespace of a robot; empty for none.

    Yields
    ------
    iterator of tuple
        Messages of the robot in their order, of the topics and types of
        :data:`~quad_lab.recordings.recorded_topics.RECORDED`.

    Raises
    ------
    RecordingUnusable
        If it cannot be read, or holds nothing of that robot.
    """
    if not is_file(folder / _METADATA):
        raise RecordingUnusable(folder, f'is no recording: it has no {_METADATA}')
    try:
        with Reader(folder) as reader:
            # Others' bags hold pictures too: what is not looked at is not read.
            names = {topic.in_namespace(namespace): topic for topic in RECORDED}
            connections = [
                connection
                for connection in reader.connections
                if connection.topic in names and connection.msgtype == names[connection.topic].kind
            ]
            if not any(c.msgcount for c in connections if c.topic != CLOCK.name):
                raise RecordingUnusable(folder, f'holds nothing of a robot {_below(namespace)}')
            yield (
                (names[connection.topic].name, time * 1e-9, bytes(data))
                for connection, time, data in reader.messages(connections)
            )
    # The reader raises whatever its parts meet in a file that is damaged.
    except (ReaderError, OSError, ValueError, LookupError, AssertionError, TypeError) as error:
        reason = str(error) or type(error).__name__
        raise RecordingUnusable(folder, f'the recording cannot be read: {reason}') from error


def _below(namespace: str) -> str:
    return f'below /{namespace}' if namespace else 'without a namespace'


def facts_of(folder: Path) -> dict[str, Any]:
    """Return what quadwalk has kept beside the messages; empty for a recording by others."""
    document = read_yaml(folder / _METADATA, 'recording', 'rosbag2_bagfile_information')
    bag = document.get('rosbag2_bagfile_information')
    kept = bag.get('custom_data') if isinstance(bag, Mapping) else None
    if not isinstance(kept, Mapping):
        return {}
    try:
        facts = json.loads(kept.get(FACTS, '{}'))
    except (ValueError, TypeError):
        return {}
    return facts if isinstance(facts, dict) else {}
