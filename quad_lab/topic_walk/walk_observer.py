"""
Listens to the topics of a walk: notes down what happens, and records it if asked to.
"""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING, Any

import rclpy
from geometry_msgs.msg import PoseStamped
from rclpy.serialization import serialize_message

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import pose_from_message, pose_message
from quad_gait.behaviours.activity import Activity
from quad_lab.recordings.recorded_topics import (
    BATCHED,
    BATCHES,
    GOAL,
    GOAL_MARKER,
    RECORDED,
    RecordedTopic,
)
from quad_lab.recordings.subscription import subscription_quality
from quad_lab.recordings.topic_listener import TopicListener
from quad_lab.topic_walk.walk_notes import WalkNotes
from quad_lab.topic_walk.walk_record import WalkRecord

if TYPE_CHECKING:
    # It needs a package that is not everywhere.
    from quad_lab.recordings.robot_recording import RobotRecording


class WalkObserver:
    """
    A node of the command line: it publishes the goal and listens.

    Parameters
    ----------
    goal : Pose2D
        Where the robot is to go.
    recording : RobotRecording, optional
        Where every received message goes.
    by_marker : bool
        Whether the goal is given by a marker that a camera has to see.
    by_truth : bool
        Whether the walk is judged by odom/truth, and not by odometry.
    executor : rclpy.executors.Executor, optional
        What runs the callbacks, of the default context; if not given, messages are taken in
        :meth:`listen`.
    """

    def __init__(
        self,
        goal: Pose2D,
        recording: RobotRecording | None = None,
        by_marker: bool = False,
        by_truth: bool = False,
        executor: Any = None,
    ) -> None:
        self.notes = WalkNotes(goal, by_truth)
        """What has been taken down of the walk."""
        self.received = 0
        """Number of messages that were received."""
        self._recording = recording
        self._context = None if executor else rclpy.Context()
        if self._context is not None:
            rclpy.init(context=self._context)
        self._node = rclpy.create_node('quadwalk_cli', context=self._context)
        self._goal_topic = GOAL_MARKER if by_marker else GOAL
        if by_marker:
            self._goals = self._node.create_publisher(PoseStamped, 'goal_marker', 10)
        else:
            self._goals = self._node.create_publisher(PoseStamped, 'goal_pose', 10)
        topics = [topic for topic in RECORDED if self._wants(topic)]
        # The simulator publishes what a recording needs in batches; for less they do not pay.
        batched = BATCHED if recording is not None and executor is None else frozenset()
        alone = [(t, t.name) for t in topics if executor is None and t not in batched]
        self._listener = TopicListener(self._node, alone, self._take)
        if batched:
            self._listener.take_batches(BATCHES.name, [(t, t.name) for t in topics if t in batched])
        if executor is not None:
            executor.add_node(self._node)
            for topic in topics:
                self._call_back(topic)

    def __enter__(self) -> WalkObserver:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._node.destroy_node()
        if self._context is not None:
            self._context.try_shutdown()

    def listen(self, duration: float) -> None:
        """Handle what comes in for some time on the wall clock [s]."""
        self._listener.listen(duration)

    def planner_is_ready(self) -> bool:
        """Return whether a goal would be received and planned to at once."""
        message = self.statuses.get('planner_node', (b'', '', {}))[1]
        return message.startswith(('ready', 'plan')) and self._goals.get_subscription_count() > 0

    def has_found_gait(self) -> bool:
        """Return whether the gait node's footholds are received, from the first ones on."""
        return bool(self._node.count_publishers('footholds'))

    def give_goal(self) -> None:
        """Publish the goal, and take notes from now on."""
        message = PoseStamped(pose=pose_message(self.record.goal))
        message.header.frame_id = 'map'
        # As whoever receives it reads it: a recording tells the same to the last digit.
        self.record.goal = pose_from_message(message.pose)
        self.notes.begin()
        if self._recording is not None:
            # Before anything that follows from it.
            self._recording.take(self._goal_topic, serialize_message(message))
        self._goals.publish(message)

    def publisher(self, kind: Any, topic: str) -> Any:
        """Make a publisher of the observer's node, for what a walk is disturbed with."""
        return self._node.create_publisher(kind, topic, 10)

    def note_poses(self) -> None:
        """Take down where the robot was; see :meth:`WalkNotes.note_poses`."""
        self.notes.note_poses()

    @property
    def record(self) -> WalkRecord:
        """What has been noted down of the walk."""
        return self.notes.record

    @property
    def statuses(self) -> dict[str, tuple[bytes, str, dict[str, str]]]:
        """Level, message and values of each node, as last received on diagnostics."""
        return self.notes.statuses

    @property
    def time(self) -> float:
        """Simulated time, as last received [s]."""
        return self.notes.time

    @property
    def pose(self) -> Pose2D | None:
        """Where the robot is, as last received."""
        return self.notes.pose

    @property
    def walking_time(self) -> float:
        """Simulated time since the goal was given [s]."""
        return self.notes.walking_time

    @property
    def activity(self) -> Activity | None:
        """What the gait node says it does; None before it has said so."""
        return self.notes.activity

    @property
    def distance_left(self) -> float:
        """How far it is to the goal, as the gait node says [m]."""
        return float(self.statuses.get('gait_node', (b'', '', {}))[2].get('distance_left', 0.0))

    @property
    def plan(self) -> Plan | None:
        """The plan in force."""
        return self.record.plans[-1] if self.record.plans else None

    def _wants(self, topic: RecordedTopic) -> bool:
        """Return whether a topic is noted or recorded."""
        is_recorded = self._recording is not None and not topic.is_on_demand
        return topic.name in self.notes.topics or (is_recorded and topic is not self._goal_topic)

    def _call_back(self, topic: RecordedTopic) -> None:
        """Let the executor take messages as bytes: recorded as they are, and read if need be."""
        kind = topic.message_type()
        if kind is not None:
            self._node.create_subscription(
                kind,
                topic.name,
                lambda data: self._take(topic, data),
                subscription_quality(topic),
                raw=True,
            )

    def _take(self, topic: RecordedTopic, data: bytes) -> None:
        self.received += 1
        if self._recording is not None:
            self._recording.take(topic, data)
        self.notes.take(topic.name, data)
