"""
Works the figures of walks out from a recording alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geometry_msgs.msg import PoseStamped

from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import pose_from_message
from quad_lab.recordings.recorded_topics import GOAL, GOAL_MARKER, TRUTH
from quad_lab.recordings.recording_reader import (
    Message,
    RecordingUnusable,
    facts_of,
    open_recording,
)
from quad_lab.recordings.subscription import message_of
from quad_lab.topic_walk.walk_notes import WalkNotes
from quad_lab.topic_walk.walk_record import WalkRecord


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
    with open_recording(folder, namespace) as messages:
        walks = _walks(list(messages))
    if not walks:
        where = f' below /{namespace}' if namespace else ''
        raise RecordingUnusable(folder, f'holds no goal{where}, and so no walk')
    facts = facts_of(folder)
    # They were kept when the last walk ended.
    walks[-1].problem = str(facts.get('problem', ''))
    wall_time = facts.get('wall_time')
    walks[-1].wall_time = wall_time if isinstance(wall_time, float) else 0.0
    return RecordedWalks(facts, walks)


def _walks(messages: list[Message]) -> list[WalkRecord]:
    names = {name for name, _, _ in messages}
    goal_topic = GOAL_MARKER if GOAL_MARKER.name in names else GOAL
    notes = WalkNotes(Pose2D(0.0, 0.0, 0.0), TRUTH.name in names)
    walks: list[WalkRecord] = []
    for name, _, data in messages:
        if name == goal_topic.name:
            goal = pose_from_message(message_of(data, PoseStamped).pose)
            notes.note_poses()
            notes = notes.for_goal(goal) if walks else notes
            notes.record.goal = goal
            notes.begin()
            walks.append(notes.record)
        else:
            notes.take(name, data)
    notes.note_poses()
    return walks
