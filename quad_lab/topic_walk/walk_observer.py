"""
Listens to the topics of a walk: notes down what happens, and records it if asked to.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from types import TracebackType
from typing import Any

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState, PointCloud2
from std_msgs.msg import Float64
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import MarkerArray

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.ros.height_map_conversions import height_map_from_message
from quad_common.ros.pose_conversions import (
    plan_from_message,
    pose_from_message,
    pose_message,
    seconds_from_time,
)
from quad_common.ros.run_node import make_executor
from quad_gait.behaviours.activity import Activity
from quad_lab.topic_walk.recording import Recording
from quad_lab.topic_walk.walk_record import WalkRecord

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_OFTEN = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
"""
Of what comes with each measurement, many times faster than in real time: none is lost in a short
pause, and none is acknowledged, which takes both ends as long as the message itself.
"""


class WalkObserver:
    """
    A node of the command line: it publishes the goal and listens.

    Parameters
    ----------
    goal : Pose2D
        Where the robot is to go.
    recording : Recording, optional
        Where every received message goes.
    by_marker : bool
        Whether the goal is given by a marker that a camera has to see.
    by_truth : bool
        Whether the walk is judged by odom/truth, and not by odometry.
    executor : rclpy.executors.Executor, optional
        What runs the callbacks, of the default context; one of its own if not given.
    """

    def __init__(
        self,
        goal: Pose2D,
        recording: Recording | None = None,
        by_marker: bool = False,
        by_truth: bool = False,
        executor: Any = None,
    ) -> None:
        self.record = WalkRecord(goal)
        self.statuses: dict[str, tuple[bytes, str, dict[str, str]]] = {}
        """Level, message and values of each node, as last received on diagnostics."""
        self.received = 0
        """Number of messages that were received."""
        self._recording = recording
        self._goal_given = False
        self._goal_given_at = 0.0
        self._odometry: bytes | None = None
        # What came on the walk, and how many plans there were when it did.
        self._unread: list[tuple[bytes, int]] = []
        self._spent_before = [0.0, 0.0]
        self._context = None if executor else rclpy.Context()
        if self._context is not None:
            rclpy.init(context=self._context)
        self._node = rclpy.create_node('quadwalk_cli', context=self._context)
        self._executor = executor or make_executor(self._context)
        self._executor.add_node(self._node)
        if by_marker:
            self._goals = self._node.create_publisher(PoseStamped, 'goal_marker', 10)
        else:
            self._goals = self._node.create_publisher(PoseStamped, 'goal_pose', 10)
        if by_truth:
            self._listen(Odometry, 'odom/truth', _OFTEN, self._keep_odometry, as_bytes=True)
        else:
            self._listen(Odometry, 'odom', _OFTEN, self._keep_odometry, as_bytes=True)
        self._listen(Path, 'plan', _LATCHED, self._on_plan)
        self._listen(DiagnosticArray, 'diagnostics', 10, self._on_diagnostics)
        self._listen(MarkerArray, 'footholds', 10, self._on_footholds)
        self._listen(Float64, 'stability_margin', _OFTEN, self._on_margin)
        self._listen(PointCloud2, 'height_map', _LATCHED, self._on_height_map)
        if recording is not None:
            self._listen(OccupancyGrid, 'map', _LATCHED, None)
            self._listen(JointState, 'joint_states', _OFTEN, None)
            self._listen(JointTrajectory, 'joint_trajectory', 10, None)
            self._listen(PoseStamped, 'goal_pose', 10, None)

    def __enter__(self) -> WalkObserver:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._context is not None:
            self._executor.shutdown()
        self._node.destroy_node()
        if self._context is not None:
            self._context.try_shutdown()

    def listen(self, duration: float) -> None:
        """Handle what comes in for some time on the wall clock [s]."""
        end = time.monotonic() + duration
        while True:
            left = end - time.monotonic()
            if left <= 0.0:
                return
            self._executor.spin_once(timeout_sec=left)

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
        self._goal_given, self._goal_given_at = True, self.time
        self._goals.publish(message)

    def note_poses(self) -> None:
        """
        Take down in the record where the robot was since the goal was given.

        It is called once the walk is over: reading all odometry takes a third of the time that
        observing does, and the nodes need the processors.
        """
        unread, self._unread = self._unread, []
        for data, plan_count in unread:
            self.record.note_pose(*_time_and_pose(data), plan_count)

    @property
    def time(self) -> float:
        """Simulated time, as last received [s]."""
        return 0.0 if self._odometry is None else _time_and_pose(self._odometry)[0]

    @property
    def pose(self) -> Pose2D | None:
        """Pose of base_link, as last received; None before any was."""
        return None if self._odometry is None else _time_and_pose(self._odometry)[1]

    @property
    def walking_time(self) -> float:
        """Simulated time since the goal was given [s]."""
        return self.time - self._goal_given_at

    @property
    def activity(self) -> Activity | None:
        """What the gait node says it does; None before it has said so."""
        said = self.statuses.get('gait_node', (b'', '', {}))[2].get('activity', '')
        return Activity(said) if said else None

    @property
    def distance_left(self) -> float:
        """How far it is to the goal, as the gait node says [m]."""
        return float(self.statuses.get('gait_node', (b'', '', {}))[2].get('distance_left', 0.0))

    @property
    def plan(self) -> Plan | None:
        """The plan in force."""
        return self.record.plans[-1] if self.record.plans else None

    def _listen(
        self,
        kind: type,
        topic: str,
        qos: Any,
        callback: Callable[[Any], None] | None,
        as_bytes: bool = False,
    ) -> None:
        """Take messages as bytes: they are recorded as they are, and read if need be."""

        def on_bytes(data: bytes) -> None:
            self.received += 1
            if self._recording is not None:
                self._recording.write(topic, kind, data)
            if callback is not None:
                callback(data if as_bytes else deserialize_message(data, kind))

        self._node.create_subscription(kind, topic, on_bytes, qos, raw=True)

    def _keep_odometry(self, data: bytes) -> None:
        self._odometry = data
        if self._goal_given and not self.record.has_arrived:
            self._unread.append((data, len(self.record.plans)))

    def _on_plan(self, message: Path) -> None:
        plan = plan_from_message(message)
        if plan is not None and self._goal_given:
            self.record.plans.append(plan)

    def _on_height_map(self, message: PointCloud2) -> None:
        self.record.height_map = height_map_from_message(message, ('map',))

    def _on_footholds(self, message: MarkerArray) -> None:
        feet = [(m.pose.position.x, m.pose.position.y, m.pose.position.z) for m in message.markers]
        if feet and self._goal_given:
            self.record.footholds.append(np.array(feet))
            self.record.cycles += 1

    def _on_margin(self, message: Float64) -> None:
        self.record.least_margin = min(self.record.least_margin, message.data)

    def _note_spent_time(self, values: dict[str, str]) -> None:
        spent = [float(values.get(f'seconds_{what}', 0.0)) for what in ('in_physics', 'publishing')]
        if not self._goal_given:
            self._spent_before = spent
        self.record.seconds_in_physics = spent[0] - self._spent_before[0]
        self.record.seconds_publishing = spent[1] - self._spent_before[1]

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        record = self.record
        for status in message.status:
            values = {pair.key: pair.value for pair in status.values}
            self.statuses[status.name] = (status.level, status.message, values)
            if status.name == 'sim_node' and self._goal_given:
                record.contacts = values.get('contacts', '')
                record.has_fallen = values.get('has_fallen') == 'True'
                record.late_trajectories = int(values.get('late_trajectories', 0))
            if status.name == 'sim_node':
                self._note_spent_time(values)
            if status.name == 'gait_node' and record.plans:
                record.has_arrived = record.has_arrived or values.get('activity') == 'arrived'


def _time_and_pose(data: bytes) -> tuple[float, Pose2D]:
    """Read time [s] and pose of an odometry."""
    message = deserialize_message(data, Odometry)
    return seconds_from_time(message.header.stamp), pose_from_message(message.pose.pose)
