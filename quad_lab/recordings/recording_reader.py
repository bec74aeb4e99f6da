"""
Reads recordings, of quadwalk or of ``ros2 bag``.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from quad_common.errors import FileUnusable, MissingOptionalDependency, QuadError
from quad_common.errors.quoting import clipped
from quad_common.files.bounded_file import is_file
from quad_common.files.yaml_document import read_yaml
from quad_lab.recordings.recorded_topics import CLOCK, RECORDED
from quad_lab.recordings.recording import FACTS

try:
    from rosbags.rosbag2 import Reader
except ImportError as error:
    raise MissingOptionalDependency('rosbags', 'pip install rosbags') from error

_METADATA = 'metadata.yaml'

_INFORMATION = 'rosbag2_bagfile_information'

_LARGEST_METADATA = 2**23
"""Bytes of the largest metadata that are read: some 700 for each topic and each publisher of it."""

_MOST_VALUES = 200_000
"""Keys and values of metadata: some 50 for each topic and each publisher of it."""

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


@contextlib.contextmanager
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
    # Within bounds, before a reader takes it that has none.
    _metadata_of(folder)
    with contextlib.ExitStack() as stack:
        with _said_of(folder):
            reader = stack.enter_context(Reader(folder))
            # Others' bags hold pictures too: what is not looked at is not read.
            names = {topic.in_namespace(namespace): topic for topic in RECORDED}
            connections = [
                connection
                for connection in reader.connections
                if connection.topic in names and connection.msgtype == names[connection.topic].kind
            ]
            if not any(c.msgcount for c in connections if c.topic != CLOCK.name):
                raise RecordingUnusable(folder, f'holds nothing of a robot {_below(namespace)}')

        def messages() -> Iterator[Message]:
            with _said_of(folder):
                for connection, time, data in reader.messages(connections):
                    yield names[connection.topic].name, time * 1e-9, bytes(data)

        # What the block raises is not the reader's.
        yield messages()


@contextlib.contextmanager
def _said_of(folder: Path) -> Iterator[None]:
    """Turn whatever a reader meets in a file that is damaged into a sentence."""
    try:
        yield
    except QuadError:
        raise
    except MemoryError as error:
        reason = 'it is damaged, or more than the memory holds'
        raise RecordingUnusable(folder, f'the recording cannot be read: {reason}') from error
    except Exception as error:
        reason = clipped(' '.join(str(error).split())) or type(error).__name__
        raise RecordingUnusable(folder, f'the recording cannot be read: {reason}') from error


def _metadata_of(folder: Path) -> dict[str, Any]:
    """Read the metadata; raise RecordingUnusable if they are none, or beyond bounds."""
    try:
        return read_yaml(
            folder / _METADATA, 'recording', _INFORMATION, _LARGEST_METADATA, _MOST_VALUES
        )
    except FileUnusable as error:
        raise RecordingUnusable(folder, f'its {_METADATA} {error.reason}') from error


def _below(namespace: str) -> str:
    return f'below /{namespace}' if namespace else 'without a namespace'


def facts_of(folder: Path) -> dict[str, Any]:
    """Return what quadwalk has kept beside the messages; empty for a recording by others."""
    bag = _metadata_of(folder).get(_INFORMATION)
    kept = bag.get('custom_data') if isinstance(bag, Mapping) else None
    if not isinstance(kept, Mapping):
        return {}
    try:
        facts = json.loads(kept.get(FACTS, '{}'))
    except (ValueError, TypeError):
        return {}
    return facts if isinstance(facts, dict) else {}
