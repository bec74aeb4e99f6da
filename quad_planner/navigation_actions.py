"""
Navigation as Nav2's actions: what ``planner_node`` serves where nav2_msgs is installed.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from rclpy.clock import Clock
from rclpy.clock_type import ClockType

from quad_common.planar_pose import Pose2D
from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_common.ros.goal_actions import GoalAction, GoalPort
from quad_common.ros.pose_conversions import duration_from_seconds, pose_message
from quad_common.ros.ros_node import QuadNode
from quad_planner.navigation.navigator import Navigator
from quad_planner.navigation.robot_report import RobotReport
from quad_planner.parameters import PlannerParameters
from quad_planner.ros_conversions import goals_of
from quad_planner.session.planning_session import PlanningSession

try:
    from nav2_msgs.action import NavigateThroughPoses, NavigateToPose
except ImportError:
    NavigateThroughPoses = NavigateToPose = None

IS_INSTALLED = NavigateToPose is not None
"""Whether there are Nav2's actions."""

_MOST_BYTES = 1_000_000
"""Size of the largest message with statuses that is looked at."""

_PERIOD = 0.1
"""Time between two looks at a task, and two feedbacks, on the wall clock [s]."""


class NavigationActions:
    """
    Navigation to poses as Nav2's navigator serves it; a newer goal of either action preempts.

    Parameters
    ----------
    node : QuadNode
        The node.
    session : PlanningSession
        Its session.
    pace : callable
        Returns the gait's pace, or None where it is not known.
    """

    def __init__(
        self,
        node: QuadNode[PlannerParameters],
        session: PlanningSession,
        pace: Callable[[], WalkingTimeModel | None],
    ) -> None:
        self._node = node
        self._session = session
        self._pace = pace
        self._navigator = navigator = Navigator(session, node.parameters.navigator_options)
        to_pose = GoalPort(self._check, partial(self._begin, 0), navigator.cancel)
        through = GoalPort(self._check, partial(self._begin, 1), navigator.cancel)
        self._actions = (
            GoalAction(node, NavigateToPose, 'navigate_to_pose', to_pose),
            GoalAction(node, NavigateThroughPoses, 'navigate_through_poses', through),
        )
        node.create_subscription(
            DiagnosticArray, 'diagnostics', self._on_diagnostics, 10, most_bytes=_MOST_BYTES
        )
        self._began = node.get_clock().now()
        self._timer = node.create_timer(
            _PERIOD, self._on_timer, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )
        self._timer.cancel()

    def take_parameters(self, parameters: PlannerParameters) -> None:
        """Go on under other conditions."""
        self._navigator.options = parameters.navigator_options

    def _check(self, request: Any) -> None:
        """Refuse what cannot be gone to by a QuadError."""
        self._node.check_active()
        goals_of(request)

    def _begin(self, index: int, request: Any) -> None:
        self._actions[1 - index].preempt()
        self._began = self._node.get_clock().now()
        self._timer.reset()
        self._navigator.begin(goals_of(request))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            values = {pair.key: pair.value for pair in status.values}
            if 'activity' in values:
                self._navigator.take_report(RobotReport(values['activity'], status.message))

    def _on_timer(self) -> None:
        clock = self._node.get_clock().now().nanoseconds * 1e-9
        result = self._navigator.update(time.monotonic(), clock)
        for action in self._actions:
            if action.is_active and result is not None:
                action.finish(result)
            elif action.is_active and self._session.pose is not None:
                action.report(self._feedback(action, self._session.pose))
        if not self._navigator.is_active:
            self._timer.cancel()

    def _feedback(self, action: GoalAction, pose: Pose2D) -> Any:
        progress = self._navigator.progress(pose, self._pace())
        now = self._node.get_clock().now()
        here = PoseStamped(pose=pose_message(pose))
        here.header.frame_id = self._session.map.frame.name
        here.header.stamp = now.to_msg()
        feedback = action.type.Feedback(
            current_pose=here,
            navigation_time=duration_from_seconds((now - self._began).nanoseconds * 1e-9),
            estimated_time_remaining=duration_from_seconds(progress.time_left),
            number_of_recoveries=progress.recoveries,
            distance_remaining=progress.distance,
        )
        if hasattr(feedback, 'number_of_poses_remaining'):
            feedback.number_of_poses_remaining = progress.poses_left
        return feedback
