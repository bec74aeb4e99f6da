"""
Works the figures of walks out from a recording alone.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geometry_msgs.msg import PoseStamped
from rclpy.serialization import deserialize_message

from quad_common.errors import MissingOptionalDependency, QuadError
from quad_common.files.yaml_document import read_yaml
from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import pose_from_message
from quad_lab.recordings.recorded_topics import GOAL, GOAL_MARKER, TRUTH
from quad_lab.recordings.recording import FACTS
from quad_lab.topic_walk.walk_notes import WalkNotes
from quad_lab.topic_walk.walk_record import WalkRecord

try:
    from rosbags.rosbag2 import Reader, ReaderError
except ImportError as error:
    raise MissingOptionalDependency('rosbags', 'pip install rosbags') from error


@dataclass(eq=False, repr=False)
class RecordingUnusable(QuadError):
    """A recording cannot be read, or holds no walk."""

    folder: Path
    """Folder of the recording."""
    reason: str
    """What is wrong with it."""

    def sentence(self) -> str:
        """Say what is wrong."""
        return f'{self.folder}: {self.reason}'


@dataclass(frozen=True)
class RecordedWalks:
    """What a recording holds."""

    facts: dict[str, Any]
    """What was kept beside the messages: robot, map; empty of a recording by others."""
    walks: list[WalkRecord]
    """A record for each goal, in their order."""


def read_walks(folder: Path, namespace: str = '') -> RecordedWalks:
    """
    Read the walks of one robot.

    Parameters
    ----------
    folder : Path
        A recording, of ``quadwalk`` or of ``ros2 bag``.
    namespace : str
        Namespace of the robot; empty for none.

    Returns
    -------
    RecordedWalks
        With the same figures as while it was recorded.

    Raises
    ------
    RecordingUnusable
        If it cannot be read, or holds no goal.
    """
    if not (folder / 'metadata.yaml').is_file():
        raise RecordingUnusable(folder, 'is no recording: it has no metadata.yaml')
    try:
        with Reader(folder) as reader:
            facts = _facts(folder)
            walks = _walks(reader, f'/{namespace}/' if namespace else '/')
    except QuadError:
        raise
    except (ReaderError, OSError, ValueError, KeyError, AssertionError) as error:
        reason = str(error) or type(error).__name__
        raise RecordingUnusable(folder, f'the recording cannot be read: {reason}') from error
    if not walks:
        where = f' below /{namespace}' if namespace else ''
        raise RecordingUnusable(folder, f'holds no goal{where}, and so no walk')
    # They were kept when the last walk ended.
    walks[-1].problem = str(facts.get('problem', ''))
    walks[-1].wall_time = float(facts.get('wall_time', 0.0))
    return RecordedWalks(facts, walks)


def _facts(folder: Path) -> dict[str, Any]:
    """Return what quadwalk has kept beside the messages."""
    document = read_yaml(folder / 'metadata.yaml', 'recording', 'rosbag2_bagfile_information')
    bag = document.get('rosbag2_bagfile_information')
    kept = bag.get('custom_data') if isinstance(bag, Mapping) else None
    facts = json.loads(kept.get(FACTS, '{}')) if isinstance(kept, Mapping) else {}
    return facts if isinstance(facts, dict) else {}


def _walks(reader: Any, prefix: str) -> list[WalkRecord]:
    names = {topic.removeprefix(prefix) for topic in reader.topics if topic.startswith(prefix)}
    goal_topic = GOAL_MARKER if GOAL_MARKER.name in names else GOAL
    by_truth = TRUTH.name in names
    notes = WalkNotes(Pose2D(0.0, 0.0, 0.0), by_truth)
    walks: list[WalkRecord] = []
    for name, data in _messages(reader, prefix):
        if name == goal_topic.name:
            goal = pose_from_message(deserialize_message(data, PoseStamped).pose)
            notes = notes.for_goal(goal) if walks else notes
            notes.record.goal = goal
            notes.begin()
            walks.append(notes.record)
        else:
            notes.take(name, data)
    return walks


def _messages(reader: Any, prefix: str) -> Iterator[tuple[str, bytes]]:
    """Give names, relative to the robot's namespace, and messages in their order."""
    for connection, _, data in reader.messages():
        if connection.topic.startswith(prefix):
            yield connection.topic.removeprefix(prefix), bytes(data)
