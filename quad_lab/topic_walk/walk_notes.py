"""
Takes a walk down, message by message: while it happens, or from a recording of it.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry, Path
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Float64
from visualization_msgs.msg import MarkerArray

from quad_common.errors import QuadError
from quad_common.errors.base import without_frames
from quad_common.planar_pose import Pose2D
from quad_common.ros.height_map_conversions import height_map_from_message
from quad_common.ros.pose_conversions import (
    plan_from_message,
    pose_from_message,
    seconds_from_time,
)
from quad_gait.behaviours.activity import Activity
from quad_lab.recordings.subscription import message_of
from quad_lab.topic_walk.walk_record import WalkRecord


class WalkNotes:
    """
    What the messages of a walk tell of it.

    Parameters
    ----------
    goal : Pose2D
        Where the robot is to go.
    by_truth : bool
        Whether the walk is judged by odom/truth, and not by odometry.
    """

    def __init__(self, goal: Pose2D, by_truth: bool = False) -> None:
        self.record = WalkRecord(goal)
        """What has been noted down."""
        self.statuses: dict[str, tuple[bytes, str, dict[str, str]]] = {}
        """Level, message and values of each node, as last received on diagnostics."""
        self.unusable: list[tuple[float, QuadError]] = []
        """When odometry was received that cannot be used [s], and why."""
        self._odometry: bytes | None = None
        self._known: tuple[float, Pose2D] | None = None
        # What came on the walk, how many plans there were when it did, and when that was.
        self._unread: list[tuple[bytes, int, float]] = []
        self.odometry_topic = 'odom/truth' if by_truth else 'odom'
        """Name of the topic that tells where the robot is."""
        self._has_begun = False
        self._began_at = 0.0
        self._spent_before = [0.0, 0.0]
        self._notes: dict[str, tuple[type, Callable[[Any], None]]] = {
            'plan': (Path, self._on_plan),
            'diagnostics': (DiagnosticArray, self._on_diagnostics),
            'footholds': (MarkerArray, self._on_footholds),
            'stability_margin': (Float64, self._on_margin),
            'height_map': (PointCloud2, self._on_height_map),
        }

    @property
    def topics(self) -> tuple[str, ...]:
        """Names of the topics that tell of the walk."""
        return (self.odometry_topic, *self._notes)

    @property
    def activity(self) -> Activity | None:
        """What the gait node says it does; None before it has said so."""
        said = self.statuses.get('gait_node', (b'', '', {}))[2].get('activity', '')
        return Activity(said) if said else None

    @property
    def time(self) -> float:
        """Time of the robot, as last received [s]."""
        return 0.0 if (known := self._last_known()) is None else known[0]

    @property
    def pose(self) -> Pose2D | None:
        """Where the robot is, as last received; None before anything was."""
        return None if (known := self._last_known()) is None else known[1]

    @property
    def walking_time(self) -> float:
        """Time of the robot since the goal was given [s]."""
        return self.time - self._began_at

    def begin(self) -> None:
        """Take notes from now on: the goal is given."""
        self._has_begun, self._began_at = True, self.time

    def note_poses(self) -> None:
        """
        Take down in the record where the robot was since the goal was given.

        It is called once the walk is over: reading all odometry takes a third of the time that
        observing does, and the nodes need the processors.
        """
        unread, self._unread = self._unread, []
        for data, plan_count, received in unread:
            try:
                self.record.note_pose(*_time_and_pose(data), plan_count)
            except QuadError as error:
                self.unusable.append((received, without_frames(error)))

    def for_goal(self, goal: Pose2D) -> WalkNotes:
        """Return notes of the next walk, which knows what this one knew last."""
        following = WalkNotes(goal, self.odometry_topic == 'odom/truth')
        following.statuses = dict(self.statuses)
        following._odometry, following._known = self._odometry, self._known
        following.record.height_map = self.record.height_map
        return following

    def take(self, topic: str, data: bytes, received: float = 0.0) -> None:
        """Take a message (CDR) of a topic, received at a time [s]; of others nothing is noted."""
        if topic == self.odometry_topic:
            self._odometry = data
            if self._has_begun and not self.record.has_arrived:
                self._unread.append((data, len(self.record.plans), received))
        elif topic in self._notes:
            kind, note = self._notes[topic]
            note(message_of(data, kind))

    def _last_known(self) -> tuple[float, Pose2D] | None:
        """Return time [s] and pose of the last odometry that was looked at and can be used."""
        if self._odometry is not None:
            with contextlib.suppress(QuadError):
                self._known = _time_and_pose(self._odometry)
            self._odometry = None
        return self._known

    def _on_plan(self, message: Path) -> None:
        plan = plan_from_message(message)
        if plan is not None and self._has_begun:
            self.record.plans.append(plan)

    def _on_height_map(self, message: PointCloud2) -> None:
        self.record.height_map = height_map_from_message(message, ('map',))

    def _on_footholds(self, message: MarkerArray) -> None:
        feet = [(m.pose.position.x, m.pose.position.y, m.pose.position.z) for m in message.markers]
        if feet and self._has_begun:
            self.record.footholds.append(np.array(feet))
            self.record.cycles += 1

    def _on_margin(self, message: Float64) -> None:
        self.record.least_margin = min(self.record.least_margin, message.data)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        record = self.record
        for status in message.status:
            # A robot's own namespace says nothing here.
            name = status.name.rpartition('/')[2]
            values = {pair.key: pair.value for pair in status.values}
            self.statuses[name] = (status.level, status.message, values)
            if name == 'sim_node' and self._has_begun:
                record.contacts = values.get('contacts', '')
                record.has_fallen = values.get('has_fallen') == 'True'
                record.late_trajectories = int(values.get('late_trajectories', 0))
            if name == 'sim_node':
                self._note_spent_time(values)
            if name == 'gait_node' and record.plans:
                record.has_arrived = record.has_arrived or values.get('activity') == 'arrived'

    def _note_spent_time(self, values: dict[str, str]) -> None:
        spent = [float(values.get(f'seconds_{what}', 0.0)) for what in ('in_physics', 'publishing')]
        if not self._has_begun:
            self._spent_before = spent
        self.record.seconds_in_physics = spent[0] - self._spent_before[0]
        self.record.seconds_publishing = spent[1] - self._spent_before[1]


def _time_and_pose(data: bytes) -> tuple[float, Pose2D]:
    """Read time [s] and pose of an odometry."""
    message = message_of(data, Odometry)
    return seconds_from_time(message.header.stamp), pose_from_message(message.pose.pose)
