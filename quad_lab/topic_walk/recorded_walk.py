"""
Works the figures of walks out from a recording alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geometry_msgs.msg import PoseStamped

from quad_common.errors import InvalidMessage, MessagesLeftOut, QuadError
from quad_common.errors.base import without_frames
from quad_common.errors.quoting import clipped
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
    left_out: tuple[MessagesLeftOut, ...] = ()
    """Messages that cannot be used, by topics."""


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
    reading = _Reading()
    with open_recording(folder, namespace) as messages:
        walks = reading.walks(list(messages))
    if not walks:
        where = f' below /{namespace}' if namespace else ''
        left_out = reading.left_out.get(reading.goal_topic)
        why = '' if left_out is None else f': {left_out}'
        raise RecordingUnusable(folder, f'holds no goal{where}, and so no walk{why}')
    facts = facts_of(folder)
    # They were kept when the last walk ended.
    walks[-1].problem = str(facts.get('problem', ''))
    wall_time = facts.get('wall_time')
    walks[-1].wall_time = wall_time if isinstance(wall_time, float) else 0.0
    return RecordedWalks(facts, walks, tuple(reading.left_out.values()))


class _Reading:
    """Takes the walks out of a recording, and leaves out what nodes would leave out."""

    def __init__(self) -> None:
        self.left_out: dict[str, MessagesLeftOut] = {}
        self.goal_topic = GOAL.name
        self._start = 0.0

    def walks(self, messages: list[Message]) -> list[WalkRecord]:
        """Return a record for each goal that can be used."""
        names = {name for name, _, _ in messages}
        self.goal_topic = GOAL_MARKER.name if GOAL_MARKER.name in names else GOAL.name
        self._start = messages[0][1] if messages else 0.0
        notes = WalkNotes(Pose2D(0.0, 0.0, 0.0), TRUTH.name in names)
        walks: list[WalkRecord] = []
        for name, time, data in messages:
            try:
                if name != self.goal_topic:
                    notes.take(name, data, time)
                    continue
                goal = pose_from_message(message_of(data, PoseStamped).pose)
            except QuadError as error:
                self._leave_out(name, time, error)
            except ValueError as error:
                # Diagnostics of others may have any words where numbers are.
                self._leave_out(name, time, InvalidMessage(name, clipped(str(error))))
            else:
                self._note_poses(notes)
                notes = notes.for_goal(goal) if walks else notes
                notes.record.goal = goal
                notes.begin()
                walks.append(notes.record)
        self._note_poses(notes)
        return walks

    def _note_poses(self, notes: WalkNotes) -> None:
        notes.note_poses()
        for time, problem in notes.unusable:
            self._leave_out(notes.odometry_topic, time, problem)
        notes.unusable.clear()

    def _leave_out(self, topic: str, time: float, problem: QuadError) -> None:
        if topic in self.left_out:
            self.left_out[topic].count += 1
        else:
            problem = without_frames(problem)
            self.left_out[topic] = MessagesLeftOut(topic, 1, time - self._start, problem)
